//! Display formats (`.png`, `.jpg`): exposure, tone map, sRGB encoding, 8 bits.
//!
//! A picture with alpha holds premultiplied radiance. PNG stores straight alpha, so colours are divided by alpha
//! *before* tone mapping; JPEG has no alpha and shows the picture over black.

use super::tonemap::encode_srgb;
use super::write::{count_non_finite, finite_or_zero};
use super::{Picture, WriteError, WriteOptions, WriteReport};
use glam::Vec3;
use std::io::Write;

/// Quality of written JPEGs, 1–100.
const JPEG_QUALITY: u8 = 95;

pub(super) fn encode_png(
    out: &mut dyn Write,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let failed = |e: png::EncodingError| match e {
        png::EncodingError::IoError(e) => WriteError::Io(e),
        e => WriteError::Encoding(e.to_string()),
    };
    let mut encoder = png::Encoder::new(out, picture.width, picture.height);
    let color = if picture.alpha.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb };
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (name, value) in &options.attributes {
        encoder.add_itxt_chunk(name.clone(), value.clone()).map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&quantise(picture, options, true)).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(WriteReport { non_finite: count_non_finite(picture), clamped_to_half: 0 })
}

pub(super) fn encode_jpeg(
    out: &mut dyn Write,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    image::codecs::jpeg::JpegEncoder::new_with_quality(out, JPEG_QUALITY)
        .encode(
            &quantise(picture, options, false),
            picture.width,
            picture.height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(|e| match e {
            image::ImageError::IoError(e) => WriteError::Io(e),
            e => WriteError::Encoding(e.to_string()),
        })?;
    Ok(WriteReport { non_finite: count_non_finite(picture), clamped_to_half: 0 })
}

/// The picture as 8 bit sRGB, three numbers a pixel, or four with straight alpha where the picture has alpha and
/// `keep_alpha` is set.
fn quantise(picture: &Picture, options: &WriteOptions, keep_alpha: bool) -> Vec<u8> {
    let gain = options.exposure.exp2();
    let encode = |radiance: Vec3| -> [u8; 3] {
        let radiance = Vec3::from_array(radiance.to_array().map(finite_or_zero)) * gain;
        options.tone_map.apply(radiance).to_array().map(|c| to_byte(encode_srgb(c)))
    };
    match picture.alpha.as_ref().filter(|_| keep_alpha) {
        None => picture.pixels.iter().flat_map(|&p| encode(p)).collect(),
        Some(alpha) => (picture.pixels.iter().zip(alpha))
            .flat_map(|(&p, &a)| {
                let a = finite_or_zero(a).clamp(0.0, 1.0);
                let [r, g, b] = encode(if a > 0.0 { p / a } else { Vec3::ZERO });
                [r, g, b, to_byte(a)]
            })
            .collect(),
    }
}

/// The nearest of 256 steps.
fn to_byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
