//! Reading OpenEXR and Radiance pictures that this or other programs wrote.

mod blocks;
mod exr;
mod primaries;
mod radiance;

use super::Picture;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Most bytes of a file.
const MOST_BYTES: u64 = 4 << 30;

/// Why a picture could not be read. The messages do not name the file.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened.
    #[error("{0}")]
    Open(#[from] std::io::Error),
    /// More pixels than the caller wants.
    #[error("{width} × {height} pixels are more than {most}")]
    TooLarge {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// The limit.
        most: usize,
    },
    /// The file is broken, empty or of another kind.
    #[error("{0}")]
    Decode(String),
    /// No part has `R`, `G` and `B`, or `Y`, at full resolution.
    #[error("no layer of it has the channels R, G and B, or Y; it has {channels}")]
    NoColour {
        /// The channels there are.
        channels: String,
    },
}

impl ReadError {
    fn memory(width: usize, height: usize) -> Self {
        Self::Decode(format!("there is not enough memory for {width} × {height} pixels"))
    }
}

/// Holds a size against the most pixels that are wanted.
fn check_size(width: usize, height: usize, most: usize) -> Result<(), ReadError> {
    match width.checked_mul(height) {
        Some(0) => Err(ReadError::Decode("it has no pixels".to_owned())),
        Some(n) if n <= most && width.max(height) <= i32::MAX as usize => Ok(()),
        _ => Err(ReadError::TooLarge { width, height, most }),
    }
}

/// Reads the picture of an OpenEXR file, as [`decode`] does.
///
/// # Errors
/// Where the file cannot be read, is broken, has more pixels than `most`, or has no colour.
pub fn read_exr(path: &Path, most: usize) -> Result<Picture, ReadError> {
    exr::decode(&read_bytes(path)?, most)
}

/// Reads an OpenEXR or Radiance picture, which its first bytes tell apart.
///
/// Of an OpenEXR file, `R`, `G` and `B` of any sample type: plain ones, or those of the layer that is called `Combined` or
/// what else pictures are called, or of the only layer that has them; else `Y`, with `RY` and `BY` where they are there. Alpha
/// is left out. The picture is the display window; what the data window leaves open is black. Neither window may have more than
/// `most` pixels, which is looked at before any is decoded. Colours of other primaries are converted to Rec. 709.
///
/// # Errors
/// Where the bytes are broken or of neither kind, have more pixels than `most`, or no colour.
pub fn decode(bytes: &[u8], most: usize) -> Result<Picture, ReadError> {
    if bytes.starts_with(b"#?") {
        return radiance::decode(bytes, most);
    }
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        return exr::decode(bytes, most);
    }
    Err(ReadError::Decode(
        "it is neither OpenEXR nor Radiance, which begins with `#?RADIANCE` or `#?RGBE`".to_owned(),
    ))
}

/// The bytes of a file.
///
/// # Errors
/// Where it cannot be read or is too large for any picture.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(ReadError::Decode("the file has more than 4 GiB".to_owned()));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::{WriteOptions, write};
    use super::*;
    use glam::Vec3 as Rgb;

    #[test]
    fn what_was_written_is_read_up_to_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let pixels = (0..6).map(|i| Rgb::new(i as f32, 0.5 * i as f32, 0.25)).collect();
        let picture = Picture { width: 3, height: 2, pixels, ..Picture::default() };
        write(&path, &picture, &WriteOptions::default()).unwrap();
        let found = read_exr(&path, 6).unwrap();
        assert_eq!((found.width, found.height, found.pixels), (3, 2, picture.pixels));
        assert!(matches!(read_exr(&path, 5), Err(ReadError::TooLarge { width: 3, height: 2, most: 5 })));
    }

    #[test]
    fn other_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, b"no picture").unwrap();
        assert!(matches!(read_exr(&path, 9), Err(ReadError::Decode(_))));
        assert!(matches!(read_exr(&folder.path().join("b.exr"), 9), Err(ReadError::Open(_))));
        assert!(matches!(decode(b"no picture", 9), Err(ReadError::Decode(_))));
    }
}
