//! Figures: line plots ([`Plot`]), contact sheets ([`Sheet`]) and false colours ([`false_color`]), as RGB pictures.
//!
//! Pure data in, a [`Raster`] out; the same data gives the same pixels. Shapes are anti-aliased by `tiny-skia`, text
//! is set in DejaVu Sans, which comes with the program, so no font is looked for on the machine.

mod axis;
mod canvas;
pub mod false_color;
mod grid;
mod plot;
mod series;
mod sheet;
mod text;

pub use axis::{Axis, Scale};
pub use plot::{Layout, Plot};
pub use series::{Point, Series, Style};
pub use sheet::{Arrangement, Cell, ColorBar, Sheet, SheetLayout};

use super::WriteError;
use super::atomic::write_atomically;
use super::tonemap::encode_srgb;
use glam::Vec3;
use std::io::Write;
use std::path::Path;

/// Pixels in the largest figure that is drawn.
pub const MAX_PIXELS: u64 = 1 << 28;

/// An 8 bit sRGB colour.
pub type Rgb = [u8; 3];

/// Colours that people with any kind of colour vision can tell apart: Okabe & Ito, *Color Universal Design* (2008).
/// Their yellow is darkened, since it is hardly seen on white; their black is [`REFERENCE`].
pub const PALETTE: [Rgb; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [160, 148, 20],
];

/// The colour for what everything else is compared with.
pub const REFERENCE: Rgb = [0, 0, 0];

/// Why a figure could not be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FigureError {
    /// The size is zero or too large, see [`MAX_PIXELS`], or leaves no room for what has to be in it.
    #[error("a figure of {width} × {height} pixels cannot be drawn")]
    Size {
        /// Pixels in a row.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// The pixels are not as many as the size asks for.
    #[error("{found} values where {expected} belong")]
    Length {
        /// How many there should be.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// An axis was given a range that it cannot show.
    #[error("the axis `{axis}` cannot go from {} to {}", range[0], range[1])]
    Range {
        /// Title of the axis.
        axis: String,
        /// Its first and last value.
        range: [f64; 2],
    },
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rect {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// The first column to the right of it.
    pub fn right(&self) -> u32 {
        self.x + self.width
    }

    /// The first row below it.
    pub fn bottom(&self) -> u32 {
        self.y + self.height
    }
}

/// A display-encoded (sRGB, 8 bit) picture, row 0 at the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Raster {
    /// A picture of display-encoded pixels: three bytes each, row by row.
    pub fn from_rgb(width: u32, height: u32, rgb: Vec<u8>) -> Result<Self, FigureError> {
        let pixels = check_size(width.into(), height.into())?;
        check_length(3 * pixels, rgb.len())?;
        Ok(Self { width, height, rgb })
    }

    /// A picture of linear radiance. `tone_map` (exposure and [`ToneMap::apply`](super::ToneMap::apply), say) gives
    /// linear display light, which is clipped to \[0, 1\] and encoded. NaN becomes 0.
    pub fn from_linear(
        width: u32,
        height: u32,
        linear: &[Vec3],
        tone_map: impl Fn(Vec3) -> Vec3,
    ) -> Result<Self, FigureError> {
        check_length(check_size(width.into(), height.into())?, linear.len())?;
        let encode = |p: &Vec3| tone_map(*p).to_array().map(|c| to_byte(encode_srgb(c.clamp(0.0, 1.0))));
        Ok(Self { width, height, rgb: linear.iter().flat_map(encode).collect() })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Three bytes a pixel, row by row.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// The pixel in column `x` of row `y`, if there is one.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let inside = x < self.width && y < self.height;
        inside.then(|| self.rgb.as_chunks().0[y as usize * self.width as usize + x as usize])
    }

    /// Writes a PNG with an `sRGB` chunk and `attributes` as text, complete or not at all.
    pub fn write_png(&self, path: &Path, attributes: &[(String, String)]) -> Result<(), WriteError> {
        write_atomically(path, |out| self.encode(out, attributes))
    }

    /// The bytes of such a PNG.
    pub fn encode_png(&self, attributes: &[(String, String)]) -> Result<Vec<u8>, WriteError> {
        let mut bytes = Vec::new();
        self.encode(&mut bytes, attributes)?;
        Ok(bytes)
    }

    fn encode(&self, out: &mut dyn Write, attributes: &[(String, String)]) -> Result<(), WriteError> {
        let failed = |e: png::EncodingError| match e {
            png::EncodingError::IoError(e) => WriteError::Io(e),
            e => WriteError::Encoding(e.to_string()),
        };
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (name, value) in attributes {
            encoder.add_itxt_chunk(name.clone(), value.clone()).map_err(failed)?;
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&self.rgb).map_err(failed)?;
        writer.finish().map_err(failed)
    }
}

/// The number of pixels, if a figure of that size can be drawn.
fn check_size(width: u64, height: u64) -> Result<u64, FigureError> {
    match width.checked_mul(height) {
        Some(pixels @ 1..=MAX_PIXELS) => Ok(pixels),
        _ => Err(FigureError::Size { width, height }),
    }
}

fn check_length(expected: u64, found: usize) -> Result<(), FigureError> {
    let found = found as u64;
    if found == expected { Ok(()) } else { Err(FigureError::Length { expected, found }) }
}

/// The nearest of 256 steps; NaN is 0.
fn to_byte(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests;
