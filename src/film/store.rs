//! Films as files: every count and every sum to the bit, so that a film that was saved goes on as if it had not been.
//!
//! | bytes | what |
//! | --- | --- |
//! | 8 | `NEPHFILM` |
//! | 4 | version, 1 |
//! | 4 | length of the header |
//! | | header: JSON with `width`, `height`, `layers` and whatever the writer adds as `record` |
//! | 4 a pixel | counts, `u32` |
//! | 24 a pixel | sums of radiance, three `f64` |
//! | 24 a pixel | sums of its squares |
//! | 8 a pixel and channel | sums of the layers, pixel by pixel |
//! | 4 | CRC-32 of all of this |
//!
//! All numbers are little-endian.

use super::atomic::write_atomically;
use super::layer::FilmLayer;
use super::raw::Film;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"NEPHFILM";
const VERSION: u32 = 1;
/// Longest header that is read, bytes.
const LONGEST_HEADER: usize = 1 << 24;

/// Why a film could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be opened or read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is something else, was cut off, or was changed.
    #[error("is no film: {0}")]
    Broken(String),
    /// A film of a later program.
    #[error("is a film of version {0}; this program reads version {VERSION}")]
    Version(u32),
}

#[derive(Serialize, Deserialize)]
struct Header {
    width: u32,
    height: u32,
    layers: Vec<FilmLayer>,
    record: serde_json::Value,
}

/// A checksum of all that passes.
struct Summed<W> {
    inner: W,
    crc: crc32fast::Hasher,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.crc.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl Film {
    /// Writes the film to a file, complete or not at all, with a `record` of what it is a film of.
    ///
    /// # Errors
    /// What the system says.
    pub fn save(&self, path: &Path, record: &serde_json::Value) -> io::Result<()> {
        write_atomically(path, |out| self.write_to(out, record))
    }

    /// Writes the film.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_to(&self, out: &mut dyn Write, record: &serde_json::Value) -> io::Result<()> {
        let mut out =
            Summed { inner: io::BufWriter::with_capacity(1 << 16, out), crc: crc32fast::Hasher::new() };
        let header = Header {
            width: self.width(),
            height: self.height(),
            layers: self.layers().to_vec(),
            record: record.clone(),
        };
        let header = serde_json::to_vec(&header)?;
        out.write_all(MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&(header.len() as u32).to_le_bytes())?;
        out.write_all(&header)?;
        for count in &self.counts {
            out.write_all(&count.to_le_bytes())?;
        }
        let vectors = self.sums.iter().chain(&self.squares).flat_map(|v| v.to_array());
        for number in vectors.chain(self.values.iter().copied()) {
            out.write_all(&number.to_le_bytes())?;
        }
        let crc = out.crc.clone().finalize();
        out.write_all(&crc.to_le_bytes())?;
        out.flush()
    }

    /// Reads a film from a file, and the record that was saved with it.
    ///
    /// # Errors
    /// Files that cannot be read or are no films; a film that was cut off or changed anywhere.
    pub fn load(path: &Path) -> Result<(Self, serde_json::Value), LoadError> {
        Self::read(&std::fs::read(path)?)
    }

    /// Reads a film from bytes, and the record that was saved with it.
    ///
    /// # Errors
    /// Those of [`Film::load`].
    pub fn read(bytes: &[u8]) -> Result<(Self, serde_json::Value), LoadError> {
        let broken = |why: &str| LoadError::Broken(why.to_owned());
        let cut_off = || broken("it is cut off");
        let mut rest = bytes;
        let mut take = |n: usize| rest.split_off(..n).ok_or_else(cut_off);
        if take(8)? != MAGIC {
            return Err(broken("it does not begin as one"));
        }
        let mut number = || take(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let version = number()?;
        if version != VERSION {
            return Err(LoadError::Version(version));
        }
        let length = number()? as usize;
        if length > LONGEST_HEADER {
            return Err(broken("its header is too long"));
        }
        let header: Header = serde_json::from_slice(take(length)?)
            .map_err(|e| LoadError::Broken(format!("its header: {e}")))?;
        let Header { width, height, layers, record } = header;
        let channels: usize = layers.iter().map(|layer| layer.channels.len()).sum();
        let pixels = u64::from(width) * u64::from(height);
        let needed = pixels.checked_mul(Self::pixel_bytes(channels)).and_then(|n| n.checked_add(4));
        // Before anything is allocated: a header can ask for anything.
        if needed != Some(rest.len() as u64) {
            return Err(broken(&format!("{width} × {height} pixels do not have its length")));
        }
        let (body, crc) = bytes.split_at(bytes.len() - 4);
        if crc32fast::hash(body).to_le_bytes() != crc {
            return Err(broken("its checksum is another: it was changed"));
        }
        let mut film = Self::new(width, height, layers);
        let (counts, mut numbers) = rest[..rest.len() - 4].split_at(4 * film.counts.len());
        for (count, bytes) in film.counts.iter_mut().zip(counts.as_chunks::<4>().0) {
            *count = u32::from_le_bytes(*bytes);
        }
        let mut next = || {
            let bytes = numbers.split_off(..8).unwrap_or(&[0; 8]);
            f64::from_le_bytes(bytes.try_into().unwrap_or_default())
        };
        for v in film.sums.iter_mut().chain(&mut film.squares) {
            *v = DVec3::new(next(), next(), next());
        }
        for v in &mut film.values {
            *v = next();
        }
        Ok((film, record))
    }
}

#[cfg(test)]
mod tests {
    use super::super::layer::Averaging;
    use super::*;
    use serde_json::json;

    fn film() -> Film {
        let layer = FilmLayer::new("depth", &["Z", "weight"], Averaging::Weight);
        let mut film = Film::new(5, 3, vec![layer]);
        for i in 0..15 {
            for _ in 0..=i {
                film.add(i, DVec3::new(0.1, 1e300, -0.0) * (i as f64 + 0.7), &[1.0, 0.3]);
            }
        }
        film
    }

    #[test]
    fn a_film_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.film");
        let record = json!({"seed": 3, "of": "ä"});
        film().save(&path, &record).unwrap();
        let (found, said) = Film::load(&path).unwrap();
        assert_eq!(found, film());
        let bits =
            |film: &Film| film.sums.iter().flat_map(|v| v.to_array()).map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&film()));
        assert_eq!(said, record);
        assert!(matches!(Film::load(&folder.path().join("b")), Err(LoadError::Io(_))));
    }

    #[test]
    fn broken_films_are_refused() {
        let mut bytes = Vec::new();
        film().write_to(&mut bytes, &json!(null)).unwrap();
        assert!(Film::read(&bytes).is_ok());
        for length in 0..bytes.len() {
            assert!(Film::read(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            assert!(Film::read(&changed).is_err(), "byte {at}");
        }
        bytes.push(0);
        assert!(Film::read(&bytes).is_err());
        let text = r#"{"width":4294967295,"height":4294967295,"layers":[],"record":null}"#;
        let mut vast = [&MAGIC[..], &1_u32.to_le_bytes(), &(text.len() as u32).to_le_bytes()].concat();
        vast.extend(text.as_bytes());
        assert!(Film::read(&vast).unwrap_err().to_string().contains("do not have its length"));
        let later = [&MAGIC[..], &2_u32.to_le_bytes()].concat();
        assert!(matches!(Film::read(&later), Err(LoadError::Version(2))));
    }
}
