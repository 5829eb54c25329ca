//! Textures at lower resolutions, for look-ups that stand for an area: image pyramids (Williams 1983, "Pyramidal
//! Parametrics").
//!
//! Each level halves the one before and is the exact mean over the area of its texels, in linear light, also where a side
//! is odd. Level 0 is the image itself and not stored again. 8 and 16 bit images keep 16 linear bits a channel, which is
//! finer than the steps of 8 bit sRGB everywhere; a pyramid takes two thirds of the memory of an 8 bit image.

use super::description::{ImageData, ImagePixels};
use glam::Vec4;
use rayon::prelude::*;

/// Levels 1 and up.
#[derive(Clone, Debug)]
pub struct Pyramid {
    levels: Vec<Level>,
}

/// An image of linear values.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub width: u32,
    pub height: u32,
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    /// 0 … 65535 for 0 … 1.
    Unorm(Vec<[u16; 4]>),
    Float(Vec<Vec4>),
}

impl Level {
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        let at = y as usize * self.width as usize + x as usize;
        match &self.texels {
            Texels::Unorm(t) => Vec4::from(t[at].map(f32::from)) * (1.0 / 65535.0),
            Texels::Float(t) => t[at],
        }
    }
}

impl Pyramid {
    /// Bytes of the pyramid of an image.
    pub(super) fn bytes_of(image: &ImageData) -> u64 {
        let texel = match image.pixels {
            ImagePixels::Rgba8(_) | ImagePixels::Rgba16(_) => size_of::<[u16; 4]>(),
            ImagePixels::Rgba32F(_) => size_of::<Vec4>(),
        };
        let (mut width, mut height, mut texels) = (image.width.max(1), image.height.max(1), 0);
        while width.max(height) > 1 {
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            texels += u64::from(width) * u64::from(height);
        }
        texels.saturating_mul(texel as u64)
    }

    /// From the texels of an image, which are finite; `float`: they may be outside of \[0, 1\].
    pub fn new(width: u32, height: u32, float: bool, texel: impl Fn(u32, u32) -> Vec4 + Sync) -> Self {
        let mut levels = Vec::new();
        if width.max(height) > 1 {
            levels.push(halve(width, height, float, texel));
        }
        while let Some(last) = levels.last().filter(|l: &&Level| l.width.max(l.height) > 1) {
            levels.push(halve(last.width, last.height, float, |x, y| last.texel(x, y)));
        }
        Self { levels }
    }

    /// Level `i` ≥ 1, or the last; `None` for images of one texel.
    #[inline]
    pub(super) fn level(&self, i: usize) -> Option<&Level> {
        self.levels.get(i.saturating_sub(1)).or(self.levels.last())
    }
}

/// Which texels of a row of `from` a texel of a row of `to` covers, and how much of it each: two, or three where `from`
/// is odd.
fn covered(from: u32, to: u32) -> Vec<(u32, [f32; 3])> {
    let step = f64::from(from) / f64::from(to);
    let share = |i: u32| {
        let (low, high) = (f64::from(i) * step, f64::from(i + 1) * step);
        let first = (low.floor() as u32).min(from - 1);
        let overlap = |k: u32| {
            let left = f64::from(first + k);
            ((high.min(left + 1.0) - low.max(left)).max(0.0) / step) as f32
        };
        (first, [overlap(0), overlap(1), overlap(2)])
    };
    (0..to).map(share).collect()
}

fn halve(width: u32, height: u32, float: bool, texel: impl Fn(u32, u32) -> Vec4 + Sync) -> Level {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let (columns, rows) = (covered(width, w), covered(height, h));
    let mean = |&(y, down): &(u32, [f32; 3]), &(x, across): &(u32, [f32; 3])| {
        let mut sum = Vec4::ZERO;
        for (j, b) in (0..).zip(down).filter(|(j, b)| *b > 0.0 && y + j < height) {
            for (i, a) in (0..).zip(across).filter(|(i, a)| *a > 0.0 && x + i < width) {
                sum += texel(x + i, y + j) * (a * b);
            }
        }
        sum
    };
    let count = w as usize * h as usize;
    let texels = if float {
        let mut texels = vec![Vec4::ZERO; count];
        texels.par_chunks_mut(columns.len()).zip(&rows).for_each(|(out, row)| {
            out.iter_mut().zip(&columns).for_each(|(out, column)| *out = mean(row, column));
        });
        Texels::Float(texels)
    } else {
        let round = |v: f32| (v.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
        let mut texels = vec![[0; 4]; count];
        texels.par_chunks_mut(columns.len()).zip(&rows).for_each(|(out, row)| {
            out.iter_mut()
                .zip(&columns)
                .for_each(|(out, column)| *out = mean(row, column).to_array().map(round));
        });
        Texels::Unorm(texels)
    };
    Level { width: w, height: h, texels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_keeps_the_mean() {
        for (w, h) in [(1, 1), (2, 2), (7, 5), (64, 3), (1, 9), (255, 17)] {
            let texel = |x: u32, y: u32| Vec4::splat(((x * 7919 + y * 104_729) % 251) as f32 / 251.0);
            let sum: f32 = (0..h).flat_map(|y| (0..w).map(move |x| texel(x, y).x)).sum();
            let mean = sum / (w * h) as f32;
            for float in [false, true] {
                let pyramid = Pyramid::new(w, h, float, texel);
                for level in &pyramid.levels {
                    let sum: f32 = (0..level.height)
                        .flat_map(|y| (0..level.width).map(move |x| level.texel(x, y).x))
                        .sum();
                    let of_level = sum / (level.width * level.height) as f32;
                    // Rounding to 16 bits, once a level.
                    assert!((of_level - mean).abs() < 8.0 / 65535.0, "{w} × {h}: {of_level} is not {mean}");
                }
                let last = pyramid.level(99).map(|l| (l.width, l.height));
                assert_eq!(last, (w * h > 1).then_some((1, 1)));
            }
        }
    }

    #[test]
    fn odd_sides_share_their_middle_texel() {
        // 0, 3, 6 in a row: one texel, 3.
        let three = Pyramid::new(3, 1, true, |x, _| Vec4::splat(3.0 * x as f32));
        assert_eq!(three.level(1).unwrap().texel(0, 0), Vec4::splat(3.0));
        // Five texels to two: (0 + 1 + 2/2)/2.5 and (2/2 + 3 + 4)/2.5.
        let five = Pyramid::new(5, 1, true, |x, _| Vec4::splat(x as f32));
        let level = five.level(1).unwrap();
        assert!((level.texel(0, 0).x - 0.8).abs() < 1e-6 && (level.texel(1, 0).x - 3.2).abs() < 1e-6);
    }
}
