//! Image files: told apart by their first bytes, measured before they are decoded.
//!
//! glTF wants colour-space chunks ignored (§3.8.3), so numbers come out as they are stored. 16-bit PNGs keep their
//! 16 bits, everything else becomes 8-bit RGBA.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits as DecoderLimits};

use super::Limits;
use crate::extension::Registry;
use crate::scene::{ImageData, ImagePixels};

/// Bytes a decoder may use for each byte of the decoded image that is allowed.
const DECODER_OVERHEAD: u64 = 2;

/// The format of a PNG or JPEG file.
fn format(bytes: &[u8]) -> Option<ImageFormat> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some(ImageFormat::Png)
    } else if bytes.starts_with(b"\xFF\xD8\xFF") {
        Some(ImageFormat::Jpeg)
    } else {
        None
    }
}

/// The media type of an image, as far as its first bytes tell.
pub(crate) fn mime(bytes: &[u8]) -> Option<&'static str> {
    match format(bytes) {
        Some(ImageFormat::Png) => Some("image/png"),
        Some(_) => Some("image/jpeg"),
        None if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Some("image/webp"),
        None if bytes.starts_with(b"\xABKTX 20\xBB\r\n\x1a\n") => Some("image/ktx2"),
        None if bytes.starts_with(b"GIF8") => Some("image/gif"),
        None if bytes.starts_with(b"DDS ") => Some("image/vnd-ms.dds"),
        None if matches!(bytes.get(4..12), Some(b"ftypavif" | b"ftypavis")) => Some("image/avif"),
        None => None,
    }
}

/// Bytes that an image file will take once decoded, from its header alone.
pub(crate) fn decoded_bytes(bytes: &[u8], registry: &Registry) -> Option<u64> {
    let Some(format) = format(bytes) else { return registry.iter().find_map(|e| e.image_bytes(bytes)) };
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let wide = color.bytes_per_pixel() > color.channel_count();
    Some(u64::from(width) * u64::from(height) * if wide { 8 } else { 4 })
}

/// Decodes an image file, with the help of extensions where it is neither PNG nor JPEG.
pub(crate) fn decode(
    bytes: &[u8],
    layer: usize,
    registry: &Registry,
    limits: &Limits,
) -> Result<ImageData, String> {
    let Some(format) = format(bytes) else {
        return match registry.iter().find_map(|e| e.decode_image(bytes, layer, limits)) {
            Some(result) => result.and_then(consistent),
            None => Err(match mime(bytes) {
                Some(mime) => format!("{mime} is not supported"),
                None => "it is neither PNG nor JPEG".to_owned(),
            }),
        };
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut decoder_limits = DecoderLimits::default();
    decoder_limits.max_alloc = Some(limits.image_bytes.saturating_mul(DECODER_OVERHEAD));
    reader.limits(decoder_limits);
    let image = reader.decode().map_err(|e| e.to_string())?;
    let (width, height) = (image.width(), image.height());
    let pixels = match image {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => ImagePixels::Rgba16(image.into_rgba16().into_raw()),
        _ => ImagePixels::Rgba8(image.into_rgba8().into_raw()),
    };
    consistent(ImageData { name: String::new(), width, height, pixels })
}

/// The same image, if it has as many pixels as it says.
fn consistent(image: ImageData) -> Result<ImageData, String> {
    let numbers = match &image.pixels {
        ImagePixels::Rgba8(p) => p.len(),
        ImagePixels::Rgba16(p) => p.len(),
        ImagePixels::Rgba32F(p) => p.len(),
    };
    let expected = (image.width as usize).checked_mul(image.height as usize).and_then(|n| n.checked_mul(4));
    if expected != Some(numbers) || numbers == 0 {
        return Err(format!("{} × {} pixels, but {numbers} numbers", image.width, image.height));
    }
    Ok(image)
}
