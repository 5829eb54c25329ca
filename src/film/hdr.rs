//! Radiance RGBE (`.hdr`): linear, about 1 % precision, no alpha, no attributes. Negative channels become 0.

use super::write::{count_non_finite, finite_or_zero};
use super::{Picture, WriteError, WriteReport};
use std::io::Write;

pub(super) fn encode(out: &mut dyn Write, picture: &Picture) -> Result<WriteReport, WriteError> {
    let pixels: Vec<image::Rgb<f32>> =
        picture.pixels.iter().map(|p| image::Rgb(p.to_array().map(|c| finite_or_zero(c).max(0.0)))).collect();
    image::codecs::hdr::HdrEncoder::new(out)
        .encode(&pixels, picture.width as usize, picture.height as usize)
        .map_err(|e| WriteError::Encoding(e.to_string()))?;
    Ok(WriteReport { non_finite: count_non_finite(picture), clamped_to_half: 0 })
}
