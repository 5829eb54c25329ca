//! Reading pictures that other programs wrote, and references.

use crate::film::Film;
use ::exr::prelude::*;
use glam::Vec3 as Rgb;
use std::path::Path;

/// More pixels than this are no picture of a case.
const MAX_PIXELS: usize = 1 << 22;

/// Reads `R`, `G` and `B` of the first part of an OpenEXR file that has them; any sample type, linear radiance. The error
/// says what is wrong, without the file's name.
pub fn read_exr(path: &Path) -> std::result::Result<Film, String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .map_err(|e| e.to_string())?;
    for layer in &image.layer_data {
        let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name.eq(name));
        let (Some(r), Some(g), Some(b)) = (channel("R"), channel("G"), channel("B")) else { continue };
        let (width, height) = (layer.size.width(), layer.size.height());
        if width.saturating_mul(height) > MAX_PIXELS {
            return Err(format!("{width} × {height} pixels are too many"));
        }
        let mut values = [r, g, b].map(|c| c.sample_data.values_as_f32());
        let [r, g, b] = &mut values;
        let pixels: Vec<Rgb> = r.zip(g).zip(b).map(|((r, g), b)| Rgb::new(r, g, b)).collect();
        if pixels.len() != width * height {
            return Err("its channels are of different sizes".to_owned());
        }
        return Ok(Film { width: width as u32, height: height as u32, pixels, ..Film::default() });
    }
    Err("it has no channels R, G and B".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{WriteOptions, write};

    #[test]
    fn what_was_written_is_read() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.exr");
        let pixels = (0..6).map(|i| Rgb::new(i as f32, 0.5 * i as f32, 0.25)).collect();
        let film = Film { width: 3, height: 2, pixels, ..Film::default() };
        write(&path, &film, &WriteOptions::default()).expect("written");
        let found = read_exr(&path).expect("read");
        assert_eq!((found.width, found.height, found.pixels), (3, 2, film.pixels));
    }

    #[test]
    fn other_files_are_errors() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.exr");
        std::fs::write(&path, b"no picture").expect("written");
        assert!(read_exr(&path).is_err());
        assert!(read_exr(&folder.path().join("b.exr")).is_err());
    }
}
