//! Environment images: `.hdr` and `.exr` files as [`EnvironmentDescription::Map`].
//!
//! Equirectangular, row 0 at the top. Radiance must be finite and not negative: infinite texels become the largest half
//! float, those that are negative or no number become 0, and both are counted. Which channels are read,
//! [`film::decode`](crate::film::decode) says.

use crate::film::{Picture, ReadError, decode, read_bytes};
use crate::scene::EnvironmentDescription;
use glam::Vec3;
use std::path::{Path, PathBuf};

/// The largest number of texels that is read: 16384 × 8192, 1.5 GB as floats.
pub const MAX_ENVIRONMENT_TEXELS: usize = 1 << 27;

/// An environment image and what was wrong with it.
#[derive(Clone, Debug)]
pub struct LoadedEnvironment {
    /// The map, with scale 1 and rotation 0.
    pub environment: EnvironmentDescription,
    /// Texels with an infinite channel, which became [`LARGEST_HALF`], or a negative or NaN one, which became 0.
    pub replaced_texels: usize,
    /// Whether the image is twice as wide as high, as an equirectangular map should be.
    pub is_two_to_one: bool,
}

/// Why an environment image could not be read.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// The file could not be opened.
    #[error("cannot open the environment {}: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Neither `.hdr` nor `.exr`.
    #[error("cannot read the environment {}: the formats known are .hdr and .exr", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file is broken or not what its extension says.
    #[error("cannot read the environment {}: {message}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// More than [`MAX_ENVIRONMENT_TEXELS`].
    #[error(
        "the environment {} has {width} × {height} texels; at most {MAX_ENVIRONMENT_TEXELS} are read \
         (16384 × 8192): scale it down", path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Texels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// What infinite texels become: the largest half float. Suns that a file of half floats cannot hold are infinite in it.
pub const LARGEST_HALF: f32 = 65504.0;

/// Reads an equirectangular `.hdr` or `.exr` image; which of both it is, its first bytes tell.
///
/// # Errors
/// Where the file cannot be read, is neither, is broken or too large, or has no colour.
pub fn load_environment(path: &Path) -> Result<LoadedEnvironment, EnvironmentError> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    if !matches!(extension.as_deref(), Some("hdr" | "exr")) {
        return Err(EnvironmentError::UnknownFormat { path: path.to_owned() });
    }
    read_bytes(path).and_then(|bytes| decode_environment(&bytes, MAX_ENVIRONMENT_TEXELS)).map_err(|e| match e
    {
        ReadError::Open(source) => EnvironmentError::Open { path: path.to_owned(), source },
        ReadError::TooLarge { width, height, .. } => {
            EnvironmentError::TooLarge { path: path.to_owned(), width, height }
        }
        ReadError::Decode(_) | ReadError::NoColour { .. } => {
            EnvironmentError::Decode { path: path.to_owned(), message: e.to_string() }
        }
    })
}

/// Reads the bytes of an equirectangular `.hdr` or `.exr` image of at most `most` texels.
///
/// # Errors
/// Where the bytes are neither, are broken or too many, or have no colour.
pub fn decode_environment(bytes: &[u8], most: usize) -> Result<LoadedEnvironment, ReadError> {
    let Picture { width, height, mut pixels, .. } = decode(bytes, most)?;
    let (width, height) = (width as usize, height as usize);
    let mut replaced_texels = 0;
    for pixel in &mut pixels {
        let clean = pixel.to_array().map(|c| match c {
            f32::INFINITY => LARGEST_HALF,
            c if c >= 0.0 => c,
            _ => 0.0,
        });
        if clean != pixel.to_array() {
            *pixel = Vec3::from_array(clean);
            replaced_texels += 1;
        }
    }
    Ok(LoadedEnvironment {
        environment: EnvironmentDescription::Map { width, height, pixels, scale: Vec3::ONE, rotation: 0.0 },
        replaced_texels,
        is_two_to_one: width == 2 * height,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Layer, Picture, WriteOptions, write};

    fn picture(width: u32, height: u32) -> Picture {
        let mut picture = Picture::new(width, height);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = Vec3::new(i as f32, 0.5, 100.0 / (1.0 + i as f32));
        }
        picture
    }

    fn texels(loaded: LoadedEnvironment) -> (usize, usize, Vec<Vec3>) {
        match loaded.environment {
            EnvironmentDescription::Map { width, height, pixels, .. } => (width, height, pixels),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn exr_of_either_precision_and_hdr_are_read_row_by_row() {
        let folder = tempfile::tempdir().unwrap();
        let mut picture = picture(8, 4);
        picture.alpha = Some(vec![0.0; 32]);
        picture.layers = vec![Layer {
            name: "depth".to_owned(),
            channels: vec![Channel { name: "Z".to_owned(), values: vec![1.0; 32] }],
        }];
        for (name, float, tolerance) in
            [("a.exr", true, 0.0), ("b.exr", false, 1e-3), ("c.HDR", true, 1.0 / 128.0)]
        {
            let path = folder.path().join(name);
            write(&path, &picture, &WriteOptions { float, ..Default::default() }).unwrap();
            let loaded = load_environment(&path).unwrap();
            assert!(loaded.is_two_to_one && loaded.replaced_texels == 0);
            let (width, height, pixels) = texels(loaded);
            assert_eq!((width, height), (8, 4));
            for (read, expected) in pixels.iter().zip(&picture.pixels) {
                let error = (*read - *expected).abs().max_element();
                assert!(error <= tolerance * expected.max_element(), "{name}: {read} {expected}");
            }
        }
    }

    #[test]
    fn negative_texels_become_black_and_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut picture = picture(3, 3);
        picture.pixels[2] = Vec3::new(-1.0, 2.0, -0.5);
        write(&path, &picture, &WriteOptions { float: true, ..Default::default() }).unwrap();
        let loaded = load_environment(&path).unwrap();
        assert!(!loaded.is_two_to_one);
        assert_eq!(loaded.replaced_texels, 1);
        assert_eq!(texels(loaded).2[2], Vec3::new(0.0, 2.0, 0.0));
    }

    #[test]
    fn infinite_texels_become_the_largest_half_and_others_black() {
        use ::exr::prelude::*;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let of = |values: [f32; 4]| FlatSamples::F32(values.to_vec());
        let channels = [
            AnyChannel::new("R", of([f32::INFINITY, f32::NAN, f32::NEG_INFINITY, 1e9])),
            AnyChannel::new("G", of([1.0, 2.0, 3.0, 4.0])),
            AnyChannel::new("B", of([1.0, f32::INFINITY, 3.0, 4.0])),
        ];
        let image = Image::from_channels((4, 1), AnyChannels::sort(channels.into_iter().collect()));
        image.write().to_file(&path).unwrap();
        let loaded = load_environment(&path).unwrap();
        assert_eq!(loaded.replaced_texels, 3);
        let expected = [[65504.0, 1.0, 1.0], [0.0, 2.0, 65504.0], [0.0, 3.0, 3.0], [1e9, 4.0, 4.0]];
        assert_eq!(texels(loaded).2, expected.map(Vec3::from_array));
    }

    #[test]
    fn first_bytes_count_and_not_the_extension() {
        let folder = tempfile::tempdir().unwrap();
        let (exr, hdr) = (folder.path().join("a.exr"), folder.path().join("a.hdr"));
        write(&exr, &picture(4, 2), &WriteOptions { float: true, ..Default::default() }).unwrap();
        std::fs::rename(&exr, &hdr).unwrap();
        assert_eq!(texels(load_environment(&hdr).unwrap()).2, picture(4, 2).pixels);
    }

    #[test]
    fn grey_exr_is_read_from_its_luminance() {
        use ::exr::prelude::*;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("y.exr");
        let luminance = AnyChannel::new("Y", FlatSamples::U32(vec![1, 2]));
        Image::from_channels((2, 1), AnyChannels::sort(smallvec(luminance))).write().to_file(&path).unwrap();
        assert_eq!(texels(load_environment(&path).unwrap()).2, [Vec3::ONE, Vec3::splat(2.0)]);
    }

    fn smallvec<T>(value: T) -> ::exr::prelude::SmallVec<[T; 4]> {
        let mut list = ::exr::prelude::SmallVec::new();
        list.push(value);
        list
    }

    #[test]
    fn broken_missing_and_unknown_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.exr", "a.hdr"] {
            let path = folder.path().join(name);
            assert!(matches!(load_environment(&path), Err(EnvironmentError::Open { .. })));
            for garbage in
                [&b""[..], b"not an image", b"\x76\x2f\x31\x01\x02\0\0\0\0", b"#?RADIANCE\n\n-Y 9 +X 9\n"]
            {
                std::fs::write(&path, garbage).unwrap();
                let error = load_environment(&path).unwrap_err();
                assert!(matches!(error, EnvironmentError::Decode { .. }), "{error}");
                assert!(error.to_string().contains(name));
            }
        }
        let huge = folder.path().join("huge.hdr");
        std::fs::write(&huge, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n").unwrap();
        let error = load_environment(&huge).unwrap_err();
        assert!(matches!(error, EnvironmentError::TooLarge { .. }), "{error}");
        let error = load_environment(Path::new("sky.jpg")).unwrap_err();
        assert!(error.to_string().contains(".hdr and .exr"), "{error}");
    }
}
