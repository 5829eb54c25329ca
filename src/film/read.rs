//! Reading OpenEXR pictures that this or other programs wrote.

use super::Film;
use ::exr::prelude::*;
use glam::Vec3 as Rgb;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

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
    /// The file is broken, empty or no OpenEXR file.
    #[error("{0}")]
    Decode(String),
    /// No part has `R`, `G` and `B`, or `Y`, at full resolution.
    #[error("no part of it has the channels R, G, B or Y")]
    NoColour,
}

impl From<::exr::error::Error> for ReadError {
    fn from(error: ::exr::error::Error) -> Self {
        Self::Decode(error.to_string())
    }
}

/// Reads `R`, `G` and `B` of the first part of an OpenEXR file that has them, any sample type; `Y` alone is grey, alpha and
/// everything else is left out. No part may have more than `most` pixels, which is looked at before any is decoded.
pub fn read_exr(path: &Path, most: usize) -> std::result::Result<Film, ReadError> {
    let file = File::open(path)?;
    for header in MetaData::read_from_buffered(BufReader::new(&file), false)?.headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        match width.checked_mul(height) {
            Some(0) => return Err(ReadError::Decode("it has no pixels".to_owned())),
            Some(n) if n <= most => {}
            _ => return Err(ReadError::TooLarge { width, height, most }),
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(BufReader::new(File::open(path)?))?;
    for layer in &image.layer_data {
        let channel = |name: &str| {
            (layer.channel_data.list.iter())
                .find(|c| c.name.eq(name) && c.sampling == Vec2(1, 1))
                .map(|c| c.sample_data.values_as_f32())
        };
        let pixels = match (channel("R"), channel("G"), channel("B"), channel("Y")) {
            (Some(r), Some(g), Some(b), _) => r.zip(g).zip(b).map(|((r, g), b)| Rgb::new(r, g, b)).collect(),
            (None, None, None, Some(y)) => y.map(Rgb::splat).collect(),
            _ => continue,
        };
        let (width, height) = (layer.size.width() as u32, layer.size.height() as u32);
        return Ok(Film { width, height, pixels, ..Film::default() });
    }
    Err(ReadError::NoColour)
}

#[cfg(test)]
mod tests {
    use super::super::{WriteOptions, write};
    use super::*;

    #[test]
    fn what_was_written_is_read_up_to_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let pixels = (0..6).map(|i| Rgb::new(i as f32, 0.5 * i as f32, 0.25)).collect();
        let film = Film { width: 3, height: 2, pixels, ..Film::default() };
        write(&path, &film, &WriteOptions::default()).unwrap();
        let found = read_exr(&path, 6).unwrap();
        assert_eq!((found.width, found.height, found.pixels), (3, 2, film.pixels));
        assert!(matches!(read_exr(&path, 5), Err(ReadError::TooLarge { width: 3, height: 2, most: 5 })));
    }

    #[test]
    fn other_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, b"no picture").unwrap();
        assert!(matches!(read_exr(&path, 9), Err(ReadError::Decode(_))));
        assert!(matches!(read_exr(&folder.path().join("b.exr"), 9), Err(ReadError::Open(_))));
    }
}
