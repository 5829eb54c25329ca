//! Pixels that lie in memory as they are: integers of 8 and 16 bits, floats of 16 and 32, and two packed kinds.
//!
//! Formats by their numbers in Vulkan. A missing channel is 0, missing alpha 1, as graphics hardware has it.

use crate::scene::ImagePixels;
use exr::prelude::f16;

/// How the numbers of a pixel are stored.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    U8,
    U16,
    F16,
    F32,
    /// Three mantissas of nine bits and one exponent (`E5B9G9R9_UFLOAT_PACK32`).
    SharedExponent,
    /// Floats of 11, 11 and 10 bits without sign (`B10G11R11_UFLOAT_PACK32`).
    SmallFloats,
}

/// The kind, the number of channels and whether red and blue are swapped.
fn layout(format: u32) -> Option<(Kind, usize, bool)> {
    Some(match format {
        9 | 15 => (Kind::U8, 1, false),
        16 | 22 => (Kind::U8, 2, false),
        23 | 29 => (Kind::U8, 3, false),
        30 | 36 => (Kind::U8, 3, true),
        37 | 43 | 51 | 57 => (Kind::U8, 4, false),
        44 | 50 => (Kind::U8, 4, true),
        70 => (Kind::U16, 1, false),
        77 => (Kind::U16, 2, false),
        84 => (Kind::U16, 3, false),
        91 => (Kind::U16, 4, false),
        76 => (Kind::F16, 1, false),
        83 => (Kind::F16, 2, false),
        90 => (Kind::F16, 3, false),
        97 => (Kind::F16, 4, false),
        100 => (Kind::F32, 1, false),
        103 => (Kind::F32, 2, false),
        106 => (Kind::F32, 3, false),
        109 => (Kind::F32, 4, false),
        122 => (Kind::SmallFloats, 3, false),
        123 => (Kind::SharedExponent, 3, false),
        _ => return None,
    })
}

/// Unpacks an image.
pub(super) fn unpack(format: u32, width: usize, height: usize, data: &[u8]) -> Result<ImagePixels, String> {
    let (kind, channels, swapped) =
        layout(format).ok_or_else(|| format!("pixels of Vulkan's format {format} are not supported"))?;
    let pixel = match kind {
        Kind::U8 => channels,
        Kind::U16 | Kind::F16 => 2 * channels,
        Kind::F32 => 4 * channels,
        Kind::SharedExponent | Kind::SmallFloats => 4,
    };
    let data = data.get(..pixel * width * height).ok_or("the image has too few bytes")?;
    let pixels = data.chunks_exact(pixel);
    Ok(match kind {
        Kind::U8 => ImagePixels::Rgba8(gather(pixels, channels, swapped, u8::MAX, |p, k| p[k])),
        Kind::U16 => ImagePixels::Rgba16(gather(pixels, channels, swapped, u16::MAX, half_word)),
        Kind::F16 => {
            let number = |p: &[u8], k: usize| f16::from_bits(half_word(p, k)).to_f32();
            ImagePixels::Rgba32F(gather(pixels, channels, swapped, 1.0, number))
        }
        Kind::F32 => {
            let number = |p: &[u8], k: usize| f32::from_bits(word(&p[4 * k..]));
            ImagePixels::Rgba32F(gather(pixels, channels, swapped, 1.0, number))
        }
        Kind::SharedExponent => {
            ImagePixels::Rgba32F(gather(pixels, 3, false, 1.0, |p, k| shared_exponent(word(p), k)))
        }
        Kind::SmallFloats => {
            ImagePixels::Rgba32F(gather(pixels, 3, false, 1.0, |p, k| small_float(word(p), k)))
        }
    })
}

fn gather<'p, T: Copy + Default>(
    pixels: impl Iterator<Item = &'p [u8]>,
    channels: usize,
    swapped: bool,
    one: T,
    number: impl Fn(&[u8], usize) -> T,
) -> Vec<T> {
    let rgba = |p: &[u8]| -> [T; 4] {
        std::array::from_fn(|k| match k {
            0 | 2 if swapped => number(p, 2 - k),
            k if k < channels => number(p, k),
            3 => one,
            _ => T::default(),
        })
    };
    pixels.flat_map(rgba).collect()
}

fn half_word(pixel: &[u8], k: usize) -> u16 {
    u16::from_le_bytes([pixel[2 * k], pixel[2 * k + 1]])
}

fn word(pixel: &[u8]) -> u32 {
    u32::from_le_bytes([pixel[0], pixel[1], pixel[2], pixel[3]])
}

fn shared_exponent(word: u32, k: usize) -> f32 {
    let mantissa = word >> (9 * k) & 0x1ff;
    mantissa as f32 * 2_f32.powi((word >> 27) as i32 - 24)
}

/// A float of five bits of exponent and no sign is one of 16 bits whose mantissa is cut.
fn small_float(word: u32, k: usize) -> f32 {
    let bits = match k {
        0 => (word & 0x7ff) << 4,
        1 => (word >> 11 & 0x7ff) << 4,
        _ => (word >> 22) << 5,
    };
    f16::from_bits(bits as u16).to_f32()
}
