//! `EXT_texture_webp`: textures as WebP images, lossy or lossless; the first frame of animated ones.

use std::io::Cursor;

use image_webp::WebPDecoder;

use super::Extension;
use crate::asset::{AssetError, ImageSource, Json, Limits, Loader};
use crate::scene::{ImageData, ImagePixels};

pub(super) struct TextureWebp;

/// Whether a file is WebP.
fn is_webp(bytes: &[u8]) -> bool {
    bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP")
}

impl Extension for TextureWebp {
    fn name(&self) -> &str {
        "EXT_texture_webp"
    }

    fn texture_source(&self, _: &mut Loader<'_>, own: &Json<'_>) -> Result<Option<ImageSource>, AssetError> {
        Ok(own.usize("source")?.map(ImageSource::from))
    }

    fn image_bytes(&self, bytes: &[u8]) -> Option<u64> {
        let decoder = is_webp(bytes).then(|| WebPDecoder::new(Cursor::new(bytes)).ok())??;
        let (width, height) = decoder.dimensions();
        Some(4 * u64::from(width) * u64::from(height))
    }

    fn decode_image(&self, bytes: &[u8], _: usize, limits: &Limits) -> Option<Result<ImageData, String>> {
        is_webp(bytes).then(|| decode(bytes, limits))
    }
}

fn decode(bytes: &[u8], limits: &Limits) -> Result<ImageData, String> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    let limit = usize::try_from(limits.image_bytes).unwrap_or(usize::MAX);
    decoder.set_memory_limit(limit);
    let size = decoder.output_buffer_size().filter(|&size| size <= limit).ok_or("the image is too large")?;
    let mut pixels = vec![0; size];
    decoder.read_image(&mut pixels).map_err(|e| e.to_string())?;
    if !decoder.has_alpha() {
        pixels = pixels.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
    }
    Ok(ImageData { name: String::new(), width, height, pixels: ImagePixels::Rgba8(pixels) })
}
