//! Images: a [`Film`] that samples are added to, the [`Picture`] of linear radiance that it is developed to, tone mapping,
//! and the files that both are written to.
//!
//! This room knows nothing but images. The tracer exposes a film; [`write()`] puts a picture into a file whose format
//! follows from the extension ([`Format`]), complete or not at all.
//!
//! Linear formats (`.exr`, `.hdr`) hold radiance as it is; display formats (`.png`, `.jpg`) hold
//! exposure → [`ToneMap`] → sRGB encoding.

pub mod atomic;
pub mod compare;
pub mod composite;
mod display;
mod exr;
pub mod figure;
mod format;
mod hdr;
mod layer;
mod raw;
mod read;
mod store;
pub mod tonemap;
mod write;

pub use format::{Format, UnknownFormat};
pub use layer::{Averaging, FilmLayer};
pub use raw::{Film, MergeError, Window};
pub use read::{ReadError, decode, read_bytes, read_exr};
pub use store::LoadError;
pub use tonemap::ToneMap;
pub use write::{WriteError, WriteOptions, WriteReport, write};

use glam::Vec3;

/// A finished image: the mean radiance of every pixel, row 0 at the top.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear Rec. 709 radiance (premultiplied by alpha where there is one), `width * height`, row by row.
    pub pixels: Vec<Vec3>,
    /// Coverage in \[0, 1\], as long as `pixels`.
    pub alpha: Option<Vec<f32>>,
    /// Further channels, stored by formats that can (EXR).
    pub layers: Vec<Layer>,
}

/// A named group of further channels, as EXR's `name.channel`.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// Layer name, for example `albedo`.
    pub name: String,
    /// Its channels.
    pub channels: Vec<Channel>,
}

/// One number a pixel.
#[derive(Clone, Debug, Default)]
pub struct Channel {
    /// Channel name, for example `R` or `Z`.
    pub name: String,
    /// Values, `width * height`, row by row from the top.
    pub values: Vec<f32>,
}

impl Picture {
    /// A black picture of that size without alpha or layers.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![Vec3::ZERO; pixel_count(width, height)], ..Self::default() }
    }

    /// Mean of each channel over the finite pixels; zero for an empty picture. Summed in double precision in pixel
    /// order, so it is reproducible.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in self.pixels.iter().filter(|p| p.is_finite()) {
            for (s, c) in sum.iter_mut().zip(pixel.to_array()) {
                *s += f64::from(c);
            }
        }
        let n = self.pixels.len().max(1) as f64;
        sum.map(|s| s / n)
    }

    /// Whether every vector is as long as `width * height`; the name of the first that is not, otherwise.
    fn check(&self) -> Result<(), String> {
        let n = pixel_count(self.width, self.height);
        let wrong = |what: &str, len: usize| Err(format!("{what} has {len} values where {n} belong"));
        if n == 0 {
            return Err(format!("an image of {} × {} pixels", self.width, self.height));
        }
        if self.pixels.len() != n {
            return wrong("the beauty", self.pixels.len());
        }
        if let Some(alpha) = self.alpha.as_ref().filter(|alpha| alpha.len() != n) {
            return wrong("alpha", alpha.len());
        }
        for layer in &self.layers {
            if let Some(c) = layer.channels.iter().find(|c| c.values.len() != n) {
                return wrong(&format!("layer {}.{}", layer.name, c.name), c.values.len());
            }
        }
        Ok(())
    }
}

fn pixel_count(width: u32, height: u32) -> usize {
    width as usize * height as usize
}

#[cfg(test)]
mod tests;
