//! KTX 2.0 textures: `KHR_texture_basisu` (ETC1S and UASTC), and every other format in the same container by
//! `KHR_texture_ktx` (also one layer of an array), `EXT_texture_astc` or a plain `source`.
//!
//! Only the largest level is read, since textures are not filtered by level. [`basisu`] transcodes what Basis Universal
//! wrote, `bcdec_rs` and `texture2ddecoder` unpack blocks of graphics hardware; all are kept from panicking the program,
//! and everything is measured from the header first.

mod blocks;
mod container;
mod plain;

use super::Extension;
use crate::asset::{AssetError, ImageSource, Json, Limits, Loader, guarded};
use crate::scene::{ImageData, ImagePixels};
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use container::Container;

/// Colour models of the data format descriptor that [`basisu`] reads.
const ETC1S: u8 = 163;
const UASTC: u8 = 166;

/// One of the extensions that name a KTX 2.0 image.
pub(super) struct TextureKtx(pub &'static str);

impl Extension for TextureKtx {
    fn name(&self) -> &str {
        self.0
    }

    fn texture_source(&self, _: &mut Loader<'_>, own: &Json<'_>) -> Result<Option<ImageSource>, AssetError> {
        let Some(image) = own.usize("source")? else { return Ok(None) };
        Ok(Some(ImageSource { image, layer: own.usize("layer")?.unwrap_or(0) }))
    }

    fn image_bytes(&self, bytes: &[u8]) -> Option<u64> {
        Some(Container::new(bytes)?.ok()?.decoded_bytes())
    }

    fn decode_image(&self, bytes: &[u8], layer: usize, limits: &Limits) -> Option<Result<ImageData, String>> {
        let container = Container::new(bytes)?;
        Some(guarded(|| decode(&container?, bytes, layer, limits)))
    }
}

fn decode(
    container: &Container<'_>,
    bytes: &[u8],
    layer: usize,
    limits: &Limits,
) -> Result<ImageData, String> {
    let Container { width, height, .. } = *container;
    let inflated = container.inflated.max(container.decoded_bytes());
    if inflated > limits.image_bytes {
        return Err(format!("{inflated} bytes are more than the limit `image_bytes` allows"));
    }
    if layer >= container.layers {
        return Err(format!("there is no layer {layer}, only {}", container.layers));
    }
    let mut pixels = match container.model {
        ETC1S | UASTC if container.format == 0 => ImagePixels::Rgba8(transcode(bytes, layer)?),
        _ => {
            let level = container.level()?;
            let size = level.len() / (container.layers * container.faces);
            let image = level.get(layer * container.faces * size..).and_then(|rest| rest.get(..size));
            let image = image.ok_or("the level is too short")?;
            match blocks::unpack(container.format, width, height, image) {
                Some(result) => result?,
                None => plain::unpack(container.format, width, height, image)?,
            }
        }
    };
    if let Some(swizzle) = container.swizzle() {
        match &mut pixels {
            ImagePixels::Rgba8(p) => swizzled(p, swizzle, u8::MAX),
            ImagePixels::Rgba16(p) => swizzled(p, swizzle, u16::MAX),
            ImagePixels::Rgba32F(p) => swizzled(p, swizzle, 1.0),
        }
    }
    if container.is_upside_down() {
        match &mut pixels {
            ImagePixels::Rgba8(p) => turn_over(p, width),
            ImagePixels::Rgba16(p) => turn_over(p, width),
            ImagePixels::Rgba32F(p) => turn_over(p, width),
        }
    }
    Ok(ImageData { name: String::new(), width: width as u32, height: height as u32, pixels })
}

fn transcode(bytes: &[u8], layer: usize) -> Result<Vec<u8>, String> {
    let transcoder = Transcoder::new(bytes).map_err(|e| format!("{e:?}"))?;
    let layer = u32::try_from(layer).map_err(|e| e.to_string())?;
    transcoder
        .transcode_image(0, layer, 0, TargetFormat::Rgba32, DecodeFlags::NONE)
        .map_err(|e| format!("{e:?}"))
}

/// Puts channels where `KTXswizzle` says: `r`, `g`, `b`, `a`, `0` or `1`.
fn swizzled<T: Copy + Default>(pixels: &mut [T], swizzle: [u8; 4], one: T) {
    for pixel in pixels.as_chunks_mut::<4>().0 {
        let old = *pixel;
        *pixel = swizzle.map(|c| match c {
            b'r' => old[0],
            b'g' => old[1],
            b'b' => old[2],
            b'a' => old[3],
            b'1' => one,
            _ => T::default(),
        });
    }
}

fn turn_over<T: Copy>(pixels: &mut Vec<T>, width: usize) {
    *pixels = pixels.chunks(4 * width).rev().flatten().copied().collect();
}

#[cfg(test)]
mod tests;
