//! What is still being exposed: for each pixel how many samples it has, and sums over them.
//!
//! **Idea.** Sums can be continued and added up, means cannot. A picture of 64 samples and one of the next 64 make that of
//! 128 by adding counts and sums, on this machine or on another, today or tomorrow; what is shown is made of them at the
//! end ([`Film::develop`]). Sums of squares beside them tell how noisy each pixel still is. All sums are in double
//! precision and grow sample by sample, so that a picture that is exposed in several goes has the bits of one that is not.
//!
//! Beside the light there are layers, of numbers that every sample has; each says how it is averaged ([`Averaging`]).

use super::composite;
use super::layer::{Averaging, FilmLayer};
use super::{Channel, Layer, Picture};
use glam::DVec3;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Two films that have not the same size, or not the same layers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Of other sizes.
    #[error("a film of {} × {} pixels cannot be added to one of {} × {}", theirs.0, theirs.1, ours.0, ours.1)]
    Size {
        /// Width and height of the film that is added to.
        ours: (u32, u32),
        /// Of the film that is added.
        theirs: (u32, u32),
    },
    /// With other layers.
    #[error("a film with the layers {theirs} cannot be added to one with {ours}")]
    Layers {
        /// Names of the layers of the film that is added to.
        ours: String,
        /// Of the film that is added.
        theirs: String,
    },
    /// A pixel would have more than 2³² − 1 samples.
    #[error("the films have more samples a pixel than can be counted")]
    Count,
}

/// Sums over the samples of each pixel, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    layers: Vec<FilmLayer>,
    pub(super) counts: Vec<u32>,
    /// Of the radiance of samples.
    pub(super) sums: Vec<DVec3>,
    /// Of its squares, channel by channel.
    pub(super) squares: Vec<DVec3>,
    /// Of all channels of all layers, pixel by pixel.
    pub(super) values: Vec<f64>,
}

impl Film {
    /// An unexposed film of that size.
    pub fn new(width: u32, height: u32, layers: Vec<FilmLayer>) -> Self {
        let n = width as usize * height as usize;
        let channels: usize = layers.iter().map(|layer| layer.channels.len()).sum();
        Self {
            width,
            height,
            layers,
            counts: vec![0; n],
            sums: vec![DVec3::ZERO; n],
            squares: vec![DVec3::ZERO; n],
            values: vec![0.0; n * channels],
        }
    }

    /// Bytes of a pixel on a film with that many channels in layers.
    pub fn pixel_bytes(channels: usize) -> u64 {
        (size_of::<u32>() + 2 * size_of::<DVec3>() + channels * size_of::<f64>()) as u64
    }

    /// A film on which each pixel of a finished picture counts as `samples` samples of its mean; without layers, and
    /// without anything to tell noise from.
    pub fn of_picture(picture: &Picture, samples: u32) -> Self {
        let mut film = Self::new(picture.width, picture.height, Vec::new());
        film.counts.fill(samples);
        for (sum, pixel) in film.sums.iter_mut().zip(&picture.pixels) {
            *sum = pixel.as_dvec3() * f64::from(samples);
        }
        film
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Its layers.
    pub fn layers(&self) -> &[FilmLayer] {
        &self.layers
    }

    /// Samples of each pixel, row by row.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// The samples that every pixel has at least.
    pub fn least_count(&self) -> u32 {
        self.counts.iter().copied().min().unwrap_or(0)
    }

    /// Channels of all layers together.
    fn stride(&self) -> usize {
        self.layers.iter().map(|layer| layer.channels.len()).sum()
    }

    /// Adds a sample to a pixel: its radiance, and the numbers of all layers one after the other.
    #[inline]
    pub fn add(&mut self, pixel: usize, radiance: DVec3, values: &[f32]) {
        self.counts[pixel] += 1;
        self.sums[pixel] += radiance;
        self.squares[pixel] += radiance * radiance;
        let at = pixel * values.len();
        for (sum, value) in self.values[at..].iter_mut().zip(values) {
            *sum += f64::from(*value);
        }
    }

    /// Mean radiance of a pixel; 0 without samples.
    pub fn mean(&self, pixel: usize) -> DVec3 {
        self.sums[pixel] / f64::from(self.counts[pixel].max(1))
    }

    /// Standard error of that mean, each channel; infinite with fewer than two samples.
    pub fn standard_error(&self, pixel: usize) -> DVec3 {
        let n = f64::from(self.counts[pixel]);
        if n < 2.0 {
            return DVec3::INFINITY;
        }
        let mean = self.sums[pixel] / n;
        let variance = (self.squares[pixel] / n - mean * mean).max(DVec3::ZERO);
        (variance / (n - 1.0)).powf(0.5)
    }

    /// Adds the samples of another film.
    ///
    /// # Errors
    /// Other sizes, other layers, more samples than can be counted; then this film is as it was.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if (self.width, self.height) != (other.width, other.height) {
            let size = |film: &Self| (film.width, film.height);
            return Err(MergeError::Size { ours: size(self), theirs: size(other) });
        }
        if self.layers != other.layers {
            let names = |film: &Self| {
                let names: Vec<&str> = film.layers.iter().map(|layer| layer.name.as_str()).collect();
                format!("[{}]", names.join(", "))
            };
            return Err(MergeError::Layers { ours: names(self), theirs: names(other) });
        }
        let both = || self.counts.iter().zip(&other.counts);
        if both().any(|(a, b)| a.checked_add(*b).is_none()) {
            return Err(MergeError::Count);
        }
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += *b);
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += *b);
        self.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += b);
        Ok(())
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        self.sums.fill(DVec3::ZERO);
        self.squares.fill(DVec3::ZERO);
        self.values.fill(0.0);
    }

    /// A copy of the pixels in a window, which must lie within.
    pub fn part(&self, window: Window) -> Self {
        let mut part = Self::new(window.width, window.height, self.layers.clone());
        let stride = self.stride();
        for (own, whole) in part.rows(self, window) {
            part.counts[own..][..window.width as usize]
                .copy_from_slice(&self.counts[whole..][..window.width as usize]);
            part.sums[own..][..window.width as usize]
                .copy_from_slice(&self.sums[whole..][..window.width as usize]);
            part.squares[own..][..window.width as usize]
                .copy_from_slice(&self.squares[whole..][..window.width as usize]);
            let n = window.width as usize * stride;
            part.values[own * stride..][..n].copy_from_slice(&self.values[whole * stride..][..n]);
        }
        part
    }

    /// Replaces the pixels in a window, which must lie within, by those of `part`, which must be of its size and have the
    /// same layers.
    pub fn set_part(&mut self, window: Window, part: &Self) {
        let stride = self.stride();
        let width = window.width as usize;
        for (own, whole) in part.rows(self, window) {
            self.counts[whole..][..width].copy_from_slice(&part.counts[own..][..width]);
            self.sums[whole..][..width].copy_from_slice(&part.sums[own..][..width]);
            self.squares[whole..][..width].copy_from_slice(&part.squares[own..][..width]);
            let n = width * stride;
            self.values[whole * stride..][..n].copy_from_slice(&part.values[own * stride..][..n]);
        }
    }

    /// Where the rows of a part begin, in it and in the whole.
    fn rows(&self, whole: &Self, window: Window) -> impl Iterator<Item = (usize, usize)> + use<> {
        let across = whole.width as usize;
        (0..window.height as usize).map(move |row| {
            (row * window.width as usize, (window.y as usize + row) * across + window.x as usize)
        })
    }

    /// The picture so far. Pixels without samples are black.
    pub fn develop(&self) -> Picture {
        let mut picture = Picture::new(self.width, self.height);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = self.mean(i).as_vec3();
        }
        let stride = self.stride();
        let mut at = 0;
        for layer in &self.layers {
            let n = layer.channels.len();
            if let Some(shown) = match layer.averaging {
                Averaging::Samples => Some(n),
                Averaging::Weight => Some(n.saturating_sub(1)),
                Averaging::Hidden => None,
            } {
                let value = |pixel: usize, channel: usize| {
                    let sums = &self.values[pixel * stride + at..][..n];
                    let by = match layer.averaging {
                        Averaging::Weight => sums[n - 1],
                        _ => f64::from(self.counts[pixel]),
                    };
                    if by > 0.0 { (sums[channel] / by) as f32 } else { 0.0 }
                };
                let channel = |c: usize| Channel {
                    name: layer.channels[c].clone(),
                    values: (0..self.counts.len()).map(|pixel| value(pixel, c)).collect(),
                };
                picture
                    .layers
                    .push(Layer { name: layer.name.clone(), channels: (0..shown).map(channel).collect() });
            }
            at += n;
        }
        composite::finish(self, &mut picture);
        picture
    }

    /// The sums of a layer at a pixel.
    pub(super) fn layer_sums<'a>(&'a self, name: &str) -> Option<impl Fn(usize) -> &'a [f64] + use<'a>> {
        let stride = self.stride();
        let index = self.layers.iter().position(|layer| layer.name == name)?;
        let at: usize = self.layers[..index].iter().map(|layer| layer.channels.len()).sum();
        let n = self.layers[index].channels.len();
        Some(move |pixel: usize| &self.values[pixel * stride + at..][..n])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers() -> Vec<FilmLayer> {
        vec![
            FilmLayer::new("light", &["R", "G"], Averaging::Samples),
            FilmLayer::new("depth", &["Z", "weight"], Averaging::Weight),
        ]
    }

    /// Sample `i` of a pixel, whatever.
    fn sample(pixel: usize, i: u32) -> (DVec3, [f32; 4]) {
        let x = f64::from(i * 7 % 5) + pixel as f64 / 3.0;
        let weight = if i.is_multiple_of(2) { 0.5 } else { 0.0 };
        (DVec3::new(x, 0.1 * x, 1.0 / (1.0 + x)), [x as f32, -1.0, weight * i as f32, weight])
    }

    fn exposed(samples: std::ops::Range<u32>) -> Film {
        let mut film = Film::new(3, 2, layers());
        for i in samples {
            for pixel in 0..6 {
                let (radiance, values) = sample(pixel, i);
                film.add(pixel, radiance, &values);
            }
        }
        film
    }

    #[test]
    fn a_film_that_is_exposed_twice_or_merged_is_that_of_all_samples() {
        let whole = exposed(0..12);
        for cut in [0, 1, 5, 12] {
            let (mut first, second) = (exposed(0..cut), exposed(cut..12));
            first.merge(&second).unwrap();
            assert_eq!(first.counts, whole.counts);
            for (a, b) in first.sums.iter().zip(&whole.sums) {
                assert!((*a - *b).abs().max_element() < 1e-12);
            }
            for (a, b) in first.values.iter().zip(&whole.values) {
                assert!((a - b).abs() < 1e-12);
            }
            let (a, b) = (first.develop(), whole.develop());
            assert!((a.pixels[4] - b.pixels[4]).abs().max_element() < 1e-6);
        }
        let picture = whole.develop();
        let xs: Vec<f64> = (0..12).map(|i| sample(4, i).0.x).collect();
        let mean = xs.iter().sum::<f64>() / 12.0;
        assert!((f64::from(picture.pixels[4].x) - mean).abs() < 1e-6);
        let variance = xs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 11.0;
        assert!((whole.standard_error(4).x - (variance / 12.0).sqrt()).abs() < 1e-12);
        // Mean of the even ones of 0 to 11, of which the odd ones have no weight.
        assert_eq!(picture.layers[1].channels.len(), 1);
        assert!((picture.layers[1].channels[0].values[3] - 5.0).abs() < 1e-6);
        assert_eq!(picture.layers[0].channels[1].values[0], -1.0);
        assert_eq!(Film::new(3, 2, layers()).standard_error(0), DVec3::INFINITY);
    }

    #[test]
    fn parts_are_cut_out_and_put_back() {
        let whole = exposed(0..4);
        let window = Window { x: 1, y: 0, width: 2, height: 2 };
        let mut part = whole.part(window);
        assert_eq!((part.sums[0], part.sums[2]), (whole.sums[1], whole.sums[4]));
        let mut copy = whole.clone();
        copy.set_part(window, &part);
        assert_eq!(copy, whole);
        part.add(3, DVec3::ONE, &[1.0; 4]);
        copy.set_part(window, &part);
        assert_eq!(copy.counts, [4, 4, 4, 4, 4, 5]);
        assert_eq!(copy.least_count(), 4);
        copy.clear();
        assert_eq!(copy, Film::new(3, 2, layers()));
    }

    #[test]
    fn what_does_not_fit_is_not_added() {
        let mut film = exposed(0..2);
        let before = film.clone();
        let other = Film::new(2, 3, layers());
        assert!(matches!(film.merge(&other), Err(MergeError::Size { theirs: (2, 3), .. })));
        let error = film.merge(&Film::new(3, 2, Vec::new())).unwrap_err();
        assert_eq!(error.to_string(), "a film with the layers [] cannot be added to one with [light, depth]");
        let mut full = exposed(0..1);
        full.counts[5] = u32::MAX;
        assert_eq!(film.merge(&full), Err(MergeError::Count));
        assert_eq!(film, before);
    }
}
