//! Measured luminaires: the file format IES LM-63 (`.ies`) in its versions of 1986, 1991, 1995, 2002 and 2019.
//!
//! A header of free text ends with the line `TILT=`; from there on the file is numbers, wherever its lines break:
//!
//! ```text
//! lamps, lumens per lamp, multiplier, vertical angles, horizontal angles, photometry (1 C, 2 B, 3 A), unit of lengths,
//! width, length, height,
//! ballast factor, ballast-lamp photometric factor, input watts,
//! the vertical angles, the horizontal angles, candela for each of these
//! ```
//!
//! Candela are multiplied by the multiplier and both factors. The second factor is one up to 1995 only: in 2002 the field is
//! kept for the future, in 2019 it says how the file was made. What the tilt of a lamp does to its light is read past.
//!
//! As described by Ashdown, *Parsing the IESNA LM-63 photometric data file*, 1998, and in EXT_lights_ies.

use crate::scene::{PhotometricWeb, Photometry, WebError};

/// Larger files are no measurement of a luminaire.
const MOST_BYTES: usize = 16 << 20;
/// Angles of one kind: every tenth of a degree around a circle.
const MOST_ANGLES: usize = 3601;
/// Of what is quoted.
const LONGEST_WORD: usize = 40;

/// Why bytes are no LM-63 file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Lm63Error {
    /// More bytes than any luminaire needs.
    #[error("it has {bytes} bytes, and no more than {MOST_BYTES} are read")]
    Size {
        /// How many there are.
        bytes: usize,
    },
    /// Nothing says where the numbers begin.
    #[error("it has no line `TILT=`, so it is no IES LM-63 file")]
    NoTilt,
    /// The file ends too soon.
    #[error("it ends where {what} is expected")]
    End {
        /// What is missing.
        what: &'static str,
    },
    /// A word where a number should be.
    #[error("line {line}: `{word}` where {what} is expected")]
    Number {
        /// Counted from 1.
        line: usize,
        /// As it is written, shortened.
        word: String,
        /// What should be there.
        what: &'static str,
    },
    /// A number that makes no sense there.
    #[error("line {line}: {value} is no {what}")]
    Value {
        /// Counted from 1.
        line: usize,
        /// As it was read.
        value: f64,
        /// What it should be.
        what: &'static str,
    },
    /// Angles or candela that make no web.
    #[error(transparent)]
    Web(#[from] WebError),
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Lm63 {
    /// Candela by direction, everything multiplied in.
    pub web: PhotometricWeb,
    /// What is odd about it, for warnings.
    pub oddities: Vec<String>,
    /// Whether it says how its light depends on the tilt of the lamp, which is not used.
    pub tilts: bool,
}

impl Lm63 {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it is too large, ends too soon, or holds something else than a table of candela.
    pub fn read(bytes: &[u8]) -> Result<Self, Lm63Error> {
        if bytes.len() > MOST_BYTES {
            return Err(Lm63Error::Size { bytes: bytes.len() });
        }
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_start_matches('\u{feff}');
        let header = text.lines().enumerate().find_map(|(i, line)| Some((i, tilt(line)?)));
        let (tilt_line, tilt) = header.ok_or(Lm63Error::NoTilt)?;
        let first = text.lines().next().unwrap_or_default().to_ascii_uppercase();
        let has_photometric_factor = !["LM-63-2002", "LM-63-2019"].iter().any(|v| first.contains(v));
        let rest = text.lines().enumerate().skip(tilt_line + 1);
        let words = rest.flat_map(|(i, line)| {
            line.split(|c: char| c.is_whitespace() || c == ',')
                .filter(|word| !word.is_empty())
                .map(move |word| (i + 1, word))
        });
        let mut numbers = Numbers(words);
        let tilts = !tilt.eq_ignore_ascii_case("NONE");
        if tilt.eq_ignore_ascii_case("INCLUDE") {
            numbers.next("the geometry of the lamp")?;
            for _ in 0..2 * numbers.count("number of tilt angles")? {
                numbers.next("a tilt angle or factor")?;
            }
        }
        Self::table(&mut numbers, has_photometric_factor, tilts)
    }

    fn table<'t>(
        numbers: &mut Numbers<impl Iterator<Item = (usize, &'t str)>>,
        has_photometric_factor: bool,
        tilts: bool,
    ) -> Result<Self, Lm63Error> {
        let mut oddities = Vec::new();
        numbers.next("the number of lamps")?;
        numbers.next("the lumens of a lamp")?;
        let mut multiplier = numbers.factor("the candela multiplier", &mut oddities)?;
        let vertical = numbers.count("number of vertical angles")?;
        let horizontal = numbers.count("number of horizontal angles")?;
        let photometry = match numbers.next("the photometric type")? {
            (_, 1.0) => Photometry::C,
            (_, 2.0) => Photometry::B,
            (_, 3.0) => Photometry::A,
            (line, value) => {
                return Err(Lm63Error::Value { line, value, what: "photometric type: 1, 2 or 3" });
            }
        };
        for what in ["the unit of lengths", "the width", "the length", "the height"] {
            numbers.next(what)?;
        }
        multiplier *= numbers.factor("the ballast factor", &mut oddities)?;
        if has_photometric_factor {
            multiplier *= numbers.factor("the ballast-lamp photometric factor", &mut oddities)?;
        } else {
            numbers.next("the field for the future, or the kind of file,")?;
        }
        numbers.next("the input watts")?;
        let vertical = numbers.list(vertical, "a vertical angle")?;
        let horizontal = numbers.list(horizontal, "a horizontal angle")?;
        let mut candela = numbers.list(vertical.len() * horizontal.len(), "a candela value")?;
        let mut negative = 0;
        for value in &mut candela {
            negative += usize::from(*value < 0.0);
            *value = value.max(0.0) * multiplier;
        }
        if negative > 0 {
            oddities.push(format!("{negative} candela values are below 0 and count as 0"));
        }
        let single = |values: Vec<f64>| values.into_iter().map(|v| v as f32).collect::<Vec<f32>>();
        let web = PhotometricWeb::new(photometry, single(vertical), single(horizontal), &single(candela))?;
        Ok(Self { web, oddities, tilts })
    }
}

/// What follows `TILT=` if a line begins so.
fn tilt(line: &str) -> Option<&str> {
    let (key, value) = line.split_once('=')?;
    key.trim().eq_ignore_ascii_case("TILT").then(|| value.trim())
}

/// The numbers of a file, with the lines that they are on.
struct Numbers<W>(W);

impl<'t, W: Iterator<Item = (usize, &'t str)>> Numbers<W> {
    fn next(&mut self, what: &'static str) -> Result<(usize, f64), Lm63Error> {
        let (line, word) = self.0.next().ok_or(Lm63Error::End { what })?;
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((line, value)),
            _ => {
                let word = word.chars().take(LONGEST_WORD).collect();
                Err(Lm63Error::Number { line, word, what })
            }
        }
    }

    /// A number of things, at least one.
    fn count(&mut self, what: &'static str) -> Result<usize, Lm63Error> {
        let (line, value) = self.next(what)?;
        if value.fract() == 0.0 && (1.0..=MOST_ANGLES as f64).contains(&value) {
            Ok(value as usize)
        } else {
            Err(Lm63Error::Value { line, value, what })
        }
    }

    /// Something that candela are multiplied by. Zero would leave nothing of a light that was measured.
    fn factor(&mut self, what: &'static str, oddities: &mut Vec<String>) -> Result<f64, Lm63Error> {
        let (line, value) = self.next(what)?;
        if value < 0.0 {
            return Err(Lm63Error::Value { line, value, what });
        }
        if value == 0.0 {
            oddities.push(format!("{what} is 0 and counts as 1"));
            return Ok(1.0);
        }
        Ok(value)
    }

    /// So many numbers. No room is made for what is only promised.
    fn list(&mut self, count: usize, what: &'static str) -> Result<Vec<f64>, Lm63Error> {
        let mut values = Vec::new();
        for _ in 0..count {
            values.push(self.next(what)?.1);
        }
        Ok(values)
    }
}

#[cfg(test)]
#[path = "tests/lm63.rs"]
mod tests;
