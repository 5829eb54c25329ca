//! Reading Radiance pictures (`.hdr`, `.pic`).
//!
//! The format is that of "The RADIANCE Picture File Format" (Ward, in `filefmts` of Radiance): a line `#?…`, lines of
//! information, an empty line, the resolution with its order of rows and columns, and then scan lines, which are flat, run-length
//! encoded the old way (a pixel 1 1 1 repeats the one before) or the new way (each component by itself). Pixels are RGBE
//! or XYZE. `EXPOSURE` and `COLORCORR` have been multiplied into the pixels and are divided out again; `PRIMARIES` other than
//! those of Rec. 709 are converted.

use super::super::Picture;
use super::ReadError;
use super::primaries::{Primaries, xyz_to_rec_709};
use glam::{DMat3, DVec3};

/// Most bytes of the information before the resolution: histories of commands are long, but not this long.
const MOST_HEADER: usize = 1 << 20;

/// Lengths of scan lines that may be encoded the new way.
const NEW_LENGTHS: std::ops::Range<usize> = 8..0x8000;

/// What the header says about the pixels.
struct Header {
    /// What takes the numbers of a pixel to linear Rec. 709, if not nothing.
    matrix: Option<DMat3>,
    /// What the pixels are to be multiplied by.
    scale: DVec3,
    layout: Layout,
}

/// The order of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    width: usize,
    height: usize,
    /// Whether scan lines are columns.
    columns: bool,
    /// Whether X runs to the left.
    left: bool,
    /// Whether Y runs up.
    up: bool,
}

impl Layout {
    /// Pixels of a scan line.
    fn length(self) -> usize {
        if self.columns { self.height } else { self.width }
    }

    /// The place in the file of the pixel at column `x`, row `y` from the top.
    fn index(self, x: usize, y: usize) -> usize {
        let x = if self.left { self.width - 1 - x } else { x };
        let y = if self.up { self.height - 1 - y } else { y };
        if self.columns { x * self.height + y } else { y * self.width + x }
    }
}

fn broken(message: impl Into<String>) -> ReadError {
    ReadError::Decode(message.into())
}

/// Reads a picture of at most `most` pixels.
pub(super) fn decode(bytes: &[u8], most: usize) -> Result<Picture, ReadError> {
    let mut rest = bytes;
    let header = header(&mut rest, most)?;
    let layout = header.layout;
    let (count, length) = (layout.width * layout.height, layout.length());
    // Grows with what the file has, so that a header alone takes no memory.
    let mut stored: Vec<[u8; 4]> = Vec::new();
    while stored.len() < count {
        let line = stored.len() / length;
        scan_line(&mut rest, length, &mut stored)
            .map_err(|what| broken(format!("{what} in scan line {} of {}", line + 1, count / length)))?;
    }
    let powers: Vec<f64> = (0..=255).map(|e| if e == 0 { 0.0 } else { f64::from(e - 136).exp2() }).collect();
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| ReadError::memory(layout.width, layout.height))?;
    for y in 0..layout.height {
        for x in 0..layout.width {
            let [a, b, c, exponent] = stored[layout.index(x, y)];
            let stored = DVec3::new(f64::from(a), f64::from(b), f64::from(c));
            let mut color = stored * powers[usize::from(exponent)] * header.scale;
            if let Some(matrix) = header.matrix {
                color = (matrix * color).max(DVec3::ZERO);
            }
            pixels.push(color.as_vec3());
        }
    }
    Ok(Picture { width: layout.width as u32, height: layout.height as u32, pixels, ..Picture::default() })
}

/// Takes the next line, without its end.
fn line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().position(|&b| b == b'\n')?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    Some(line.strip_suffix(b"\r").unwrap_or(line))
}

/// The numbers of a line of information.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut words = text.split_ascii_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|n: &f64| n.is_finite())?;
    }
    Some(numbers)
}

fn header(rest: &mut &[u8], most: usize) -> Result<Header, ReadError> {
    const UNENDED: &str = "the header has no end";
    let start = rest.len();
    if !rest.starts_with(b"#?") {
        return Err(broken("no Radiance picture: it does not begin with `#?RADIANCE` or `#?RGBE`"));
    }
    let (mut is_xyz, mut divisor, mut primaries) = (false, DVec3::ONE, None);
    loop {
        let line = line(rest).ok_or_else(|| broken(UNENDED))?;
        if start - rest.len() > MOST_HEADER {
            return Err(broken(UNENDED));
        }
        if line.is_empty() {
            break;
        }
        let text = String::from_utf8_lossy(line);
        let Some((key, value)) = text.split_once('=') else { continue };
        let factor = |factor: DVec3| if factor.min_element() > 0.0 { factor } else { DVec3::ONE };
        match key {
            "FORMAT" => match value.trim() {
                "32-bit_rle_rgbe" => is_xyz = false,
                "32-bit_rle_xyze" => is_xyz = true,
                other => {
                    let other: String = other.chars().take(40).flat_map(char::escape_debug).collect();
                    return Err(broken(format!(
                        "its format is `{other}`; 32-bit_rle_rgbe and 32-bit_rle_xyze are known"
                    )));
                }
            },
            "EXPOSURE" => divisor *= factor(numbers(value).map_or(DVec3::ONE, |[e]| DVec3::splat(e))),
            "COLORCORR" => divisor *= factor(numbers(value).map_or(DVec3::ONE, DVec3::from_array)),
            "PRIMARIES" => {
                primaries = numbers(value).map(|[rx, ry, gx, gy, bx, by, wx, wy]| Primaries {
                    red: [rx, ry],
                    green: [gx, gy],
                    blue: [bx, by],
                    white: [wx, wy],
                });
            }
            _ => {}
        }
    }
    let line = line(rest).ok_or_else(|| broken(UNENDED))?;
    let layout = layout(&String::from_utf8_lossy(line), most)?;
    let matrix = if is_xyz { xyz_to_rec_709() } else { primaries.and_then(Primaries::to_rec_709) };
    let scale = divisor.recip();
    Ok(Header { matrix, scale: if scale.is_finite() { scale } else { DVec3::ONE }, layout })
}

/// Reads a resolution such as `-Y 512 +X 1024`: the first axis counts scan lines, the second the pixels of one.
fn layout(text: &str, most: usize) -> Result<Layout, ReadError> {
    let shown: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    let wrong =
        || broken(format!("its resolution is `{shown}` where something like `-Y 512 +X 1024` is expected"));
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let [first, lines, second, length] = words[..] else { return Err(wrong()) };
    let count = |word: &str| word.parse::<u32>().map(|n| n as usize).map_err(|_| wrong());
    let (lines, length) = (count(lines)?, count(length)?);
    let (x, y, columns) = match (first, second) {
        ("-Y" | "+Y", "+X" | "-X") => (second, first, false),
        ("+X" | "-X", "-Y" | "+Y") => (first, second, true),
        _ => return Err(wrong()),
    };
    let (width, height) = if columns { (lines, length) } else { (length, lines) };
    super::check_size(width, height, most)?;
    Ok(Layout { width, height, columns, left: x == "-X", up: y == "+Y" })
}

const ENDS: &str = "the file ends";

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], &'static str> {
    let (bytes, after) = rest.split_first_chunk::<N>().ok_or(ENDS)?;
    *rest = after;
    Ok(*bytes)
}

/// Appends the `length` pixels of a scan line.
fn scan_line(rest: &mut &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    if NEW_LENGTHS.contains(&length)
        && let [2, 2, high @ 0..0x80, low, ..] = **rest
    {
        if usize::from(u16::from_be_bytes([high, low])) != length {
            return Err("a length other than that of the header");
        }
        *rest = &rest[4..];
        return new_scan_line(rest, length, pixels);
    }
    old_scan_line(rest, length, pixels)
}

/// Each component by itself: a count above 128 repeats a byte, one up to 128 is followed by as many bytes.
fn new_scan_line(rest: &mut &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    const LONG: &str = "a run beyond the end of the line";
    let start = pixels.len();
    // Four components need a run each, of 127 pixels at most.
    if rest.len() < 8 * length.div_ceil(127) {
        return Err(ENDS);
    }
    pixels.resize(start + length, [0; 4]);
    let line = &mut pixels[start..];
    for component in 0..4 {
        let mut x = 0;
        while x < length {
            let [count] = take(rest)?;
            if count > 128 {
                let [value] = take(rest)?;
                let run = line.get_mut(x..x + usize::from(count - 128)).ok_or(LONG)?;
                run.iter_mut().for_each(|pixel| pixel[component] = value);
                x += run.len();
            } else {
                let run = line.get_mut(x..x + usize::from(count)).ok_or(LONG)?;
                let values = rest.split_off(..run.len()).filter(|v| !v.is_empty()).ok_or(ENDS)?;
                run.iter_mut().zip(values).for_each(|(pixel, &value)| pixel[component] = value);
                x += run.len();
            }
        }
    }
    Ok(())
}

/// Whole pixels; 1 1 1 n repeats the one before n times, and the next such multiplies its n by 256.
fn old_scan_line(rest: &mut &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    let start = pixels.len();
    let mut shift = 0;
    while pixels.len() - start < length {
        let pixel: [u8; 4] = take(rest)?;
        if let [1, 1, 1, count] = pixel {
            let previous = pixels.last().copied().filter(|_| pixels.len() > start);
            let previous = previous.ok_or("a run without a pixel before it")?;
            let count = usize::from(count).checked_shl(shift).unwrap_or(usize::MAX);
            if count > length - (pixels.len() - start) {
                return Err("a run beyond the end of the line");
            }
            pixels.resize(pixels.len() + count, previous);
            shift = (shift + 8).min(32);
        } else {
            pixels.push(pixel);
            shift = 0;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
