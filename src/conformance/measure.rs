//! Means of regions with standard errors, from independent renders of one picture.
//!
//! Batch b gives pixel p the value v_bp. Batches are independent, so the variance of a pixel's mean is s_p²/B with
//! s_p² = Σ_b (v_bp − v̄_p)²/(B − 1). Pixels are independent, too, hence that of a region's mean is Σ_p s_p²/(B P²). For a
//! few hundred pixels this is known to some per cent even from two batches, unlike the scatter of two means. Pixels that
//! are not independent (a denoiser, a filter wider than a pixel) make the standard error too small.

use super::Region;
use crate::film::Film;

/// A mean with its standard error, three channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Mean radiance; NaN where a pixel is not finite.
    pub mean: [f64; 3],
    /// Its standard error; `None` from a single batch.
    pub standard_error: Option<[f64; 3]>,
}

/// The mean of a region over all batches, which have one size that holds the region.
pub fn measure(batches: &[Film], region: Region) -> Estimate {
    let [x, y, w, h] = region.map(|v| v as usize);
    let count = (batches.len() * w * h).max(1) as f64;
    let mut mean = [0.0; 3];
    let mut squares = [0.0; 3];
    for row in y..y + h {
        for column in x..x + w {
            for c in 0..3 {
                let values = || batches.iter().map(|film| film.mean(row * film.width() as usize + column)[c]);
                let sum: f64 = values().sum();
                let own = sum / batches.len().max(1) as f64;
                mean[c] += sum;
                squares[c] += values().map(|v| (v - own) * (v - own)).sum::<f64>();
            }
        }
    }
    let standard_error = (batches.len() > 1).then(|| {
        let (b, pixels) = (batches.len() as f64, (w * h) as f64);
        squares.map(|s| (s / ((b - 1.0) * b)).sqrt() / pixels)
    });
    Estimate { mean: mean.map(|sum| sum / count), standard_error }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;
    use glam::Vec3;

    fn picture(seed: u64) -> Picture {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u32 << 24) as f32
        };
        let pixels = (0..16 * 16).map(|i| Vec3::new(i as f32 + random(), random(), 3.0)).collect();
        Picture { width: 16, height: 16, pixels, ..Picture::default() }
    }

    fn film(picture: &Picture) -> Film {
        Film::of_picture(picture, 1)
    }

    /// Uniform noise on [0, 1) has a variance of 1/12, whatever differs from pixel to pixel.
    #[test]
    fn the_standard_error_is_that_of_the_noise() {
        let batches: Vec<Film> = (1..=4).map(|seed| film(&picture(seed))).collect();
        let found = measure(&batches, [0, 0, 16, 16]);
        let error = found.standard_error.expect("four batches");
        let expected = (1.0 / 12.0 / (4.0 * 256.0f64)).sqrt();
        // 768 degrees of freedom know a standard error to 2.6 %: four times that.
        for value in &error[..2] {
            assert!((value / expected - 1.0).abs() < 0.1, "{value} {expected}");
        }
        assert_eq!(error[2], 0.0);
        assert!((found.mean[1] - 0.5).abs() < 4.0 * expected, "{:?}", found.mean);
        assert_eq!(found.mean[2], 3.0);
    }

    #[test]
    fn a_region_is_its_own_pixels_only() {
        let mut picture = picture(1);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            let inside = (2..5).contains(&(i % 16)) && (7..9).contains(&(i / 16));
            *pixel = if inside { Vec3::ONE } else { Vec3::splat(f32::NAN) };
        }
        assert_eq!(measure(&[film(&picture)], [2, 7, 3, 2]).mean, [1.0; 3]);
        assert!(measure(&[film(&picture)], [2, 7, 3, 3]).mean[0].is_nan());
    }

    #[test]
    fn one_batch_has_no_standard_error() {
        assert_eq!(measure(&[film(&picture(3))], [0, 0, 4, 4]).standard_error, None);
    }
}
