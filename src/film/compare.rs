//! How far is a picture from its reference, and how much of that is noise?
//!
//! Both are rendered as two independent halves, A and B of the picture P = (A + B)/2, R₁ and R₂ of the reference
//! R = (R₁ + R₂)/2. With the weight w = 1/(S² + ε), S the reference smoothed by a Gaussian that leaves out the pixel
//! itself, ε = 1 % of the squared mean of R, means over pixels and channels of
//!
//! | code | formula | estimates |
//! | --- | --- | --- |
//! | `rel_mse` | w (P − R)² | everything below together |
//! | `bias` | w (A − R₁)(B − R₂) | squared bias: independent noise has mean 0, and so has its product |
//! | `noise` | w (A − B)²/4 | variance of P |
//! | `reference_noise` | w (R₁ − R₂)²/4 | variance of R |
//!
//! `bias` may come out below zero where there is none. A weight from R itself would depend on the same noise: it is large
//! where both R₁ and R₂ happen to be dark, and a noisy picture without bias would seem to have one. The thousandth of
//! the pixels where w ((A − R₁)² + (B − R₂)²) is largest, fireflies mostly, is left out of all four; this does not depend
//! on the sign of the product.

use super::{Film, Picture};
use glam::DVec3;

/// ε over the squared mean of the reference.
const DARK: f64 = 0.01;
/// Standard deviation of the Gaussian in pixels, and where it is cut off.
const BLUR: f64 = 1.5;
const BLUR_RADIUS: isize = 6;
/// Share of the pixels that is left out.
const LEFT_OUT: f64 = 0.001;

/// Two independent renders of one picture, of equally many samples.
#[derive(Clone, Debug)]
pub struct Halves {
    halves: [Film; 2],
}

/// Films of different sizes were compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pictures of different sizes cannot be compared")]
pub struct DifferentSizes;

/// A measured number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The estimate.
    pub value: f64,
    /// Its standard error, pixels taken for independent.
    pub standard_error: f64,
}

/// What a comparison finds; relative squared errors are dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Relative mean squared error of the picture.
    pub rel_mse: f64,
    /// The part of it that more samples would not remove.
    pub bias: Measured,
    /// The part that is the picture's noise.
    pub noise: f64,
    /// The noise that a thousandth of the pixels exceeds: fireflies that more samples do not tame keep it from falling as
    /// fast as [`Comparison::noise`] does.
    pub noise_p999: f64,
    /// The part that is the reference's noise.
    pub reference_noise: f64,
    /// Mean of the picture over that of the reference, each channel; NaN where the reference is black.
    pub mean_ratio: [Measured; 3],
}

impl Halves {
    /// Of two films of one size.
    pub fn new(a: Film, b: Film) -> Result<Self, DifferentSizes> {
        if (a.width(), a.height()) != (b.width(), b.height()) {
            return Err(DifferentSizes);
        }
        Ok(Self { halves: [a, b] })
    }

    /// The picture: what both films have together.
    pub fn mean(&self) -> Picture {
        let [a, b] = &self.halves;
        let mut whole = a.clone();
        // They have one size; those with other layers or too many samples are shown by the first.
        let _ = whole.merge(b);
        whole.develop()
    }

    /// Both means of each pixel.
    fn pixels(&self) -> impl Iterator<Item = [DVec3; 2]> {
        let [a, b] = &self.halves;
        (0..a.counts().len()).map(|i| [a.mean(i), b.mean(i)])
    }

    /// Mean of each channel with its variance.
    fn moments(&self) -> [DVec3; 2] {
        let n = self.halves[0].counts().len().max(1) as f64;
        let sum = self.pixels().fold([DVec3::ZERO; 2], |[mean, variance], [a, b]| {
            [mean + 0.5 * (a + b), variance + 0.25 * (a - b) * (a - b)]
        });
        [sum[0] / n, sum[1] / (n * n)]
    }

    /// Compares with a reference.
    pub fn compare(&self, reference: &Self) -> Result<Comparison, DifferentSizes> {
        let size = |h: &Self| (h.halves[0].width(), h.halves[0].height());
        if size(self) != size(reference) {
            return Err(DifferentSizes);
        }
        let [mean, variance] = self.moments();
        let [reference_mean, reference_variance] = reference.moments();
        let level = reference_mean.element_sum() / 3.0;
        let dark = DARK * level * level;
        let both = self.pixels().zip(reference.pixels());
        let mut terms: Vec<Terms> = both
            .zip(smoothed(&reference.mean()))
            .map(|((picture, reference), level)| Terms::of(picture, reference, level * level + dark))
            .collect();
        terms.sort_by(|a, b| a.noise.total_cmp(&b.noise));
        let exceeded = ((terms.len() as f64 * (1.0 - LEFT_OUT)) as usize).min(terms.len().saturating_sub(1));
        let noise_p999 = terms.get(exceeded).map_or(0.0, |t| t.noise);
        terms.sort_by(|a, b| a.worst.total_cmp(&b.worst));
        let left_out = ((terms.len() as f64 * LEFT_OUT).round() as usize).max(1);
        terms.truncate(terms.len().saturating_sub(left_out).max(1));

        let n = terms.len().max(1) as f64;
        let average = |of: fn(&Terms) -> f64| terms.iter().map(of).sum::<f64>() / n;
        let bias = average(|t| t.bias);
        let spread = terms.iter().map(|t| (t.bias - bias).powi(2)).sum::<f64>();
        let ratio = |c: usize| {
            let value = mean[c] / reference_mean[c];
            let relative = |mean: f64, variance: f64| variance / (mean * mean);
            let squared = relative(mean[c], variance[c]) + relative(reference_mean[c], reference_variance[c]);
            let error = if mean[c] == 0.0 { 0.0 } else { value * squared.sqrt() };
            Measured { value: if reference_mean[c] == 0.0 { f64::NAN } else { value }, standard_error: error }
        };
        Ok(Comparison {
            rel_mse: average(|t| t.rel_mse),
            bias: Measured { value: bias, standard_error: (spread / (n * (n - 1.0).max(1.0))).sqrt() },
            noise: average(|t| t.noise),
            noise_p999,
            reference_noise: average(|t| t.reference_noise),
            mean_ratio: [0, 1, 2].map(ratio),
        })
    }
}

/// Every pixel from its neighbours; its own value where there is none.
fn smoothed(picture: &Picture) -> Vec<DVec3> {
    let weights: Vec<f64> = (0..=BLUR_RADIUS).map(|i| (-0.5 * (i as f64 / BLUR).powi(2)).exp()).collect();
    let (width, height) = (picture.width as isize, picture.height as isize);
    let blur = |from: &[(DVec3, f64)], [dx, dy]: [isize; 2]| -> Vec<(DVec3, f64)> {
        let at = |x: isize, y: isize| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            inside.then(|| from[(y * width + x) as usize])
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let sum = |(x, y): (isize, isize)| {
            let near = (-BLUR_RADIUS..=BLUR_RADIUS).filter_map(|i| {
                let (value, weight) = at(x + i * dx, y + i * dy)?;
                let w = weights[i.unsigned_abs()];
                Some((w * value, w * weight))
            });
            near.fold((DVec3::ZERO, 0.0), |(value, weight), (v, w)| (value + v, weight + w))
        };
        places.map(sum).collect()
    };
    let own: Vec<(DVec3, f64)> = picture.pixels.iter().map(|p| (p.as_dvec3(), 1.0)).collect();
    let all = blur(&blur(&own, [1, 0]), [0, 1]);
    // The weight of the pixel itself is 1 in both directions.
    let others = |((value, weight), (own, _)): (&(DVec3, f64), &(DVec3, f64))| {
        if *weight > 1.0 { ((*value - *own) / (weight - 1.0)).max(DVec3::ZERO) } else { *own }
    };
    all.iter().zip(&own).map(others).collect()
}

/// The four terms of one pixel, means of its channels.
struct Terms {
    /// What pixels are left out by.
    worst: f64,
    rel_mse: f64,
    bias: f64,
    noise: f64,
    reference_noise: f64,
}

impl Terms {
    fn of([a, b]: [DVec3; 2], [r1, r2]: [DVec3; 2], scale: DVec3) -> Self {
        // Where all is black nothing is to be weighed.
        let mean = |v: DVec3| {
            let weighed = DVec3::select(scale.cmpgt(DVec3::ZERO), v / scale, DVec3::ZERO);
            weighed.element_sum() / 3.0
        };
        let (d1, d2) = (a - r1, b - r2);
        let error = 0.5 * (d1 + d2);
        Self {
            worst: mean(d1 * d1 + d2 * d2),
            rel_mse: mean(error * error),
            bias: mean(d1 * d2),
            noise: mean(0.25 * (a - b) * (a - b)),
            reference_noise: mean(0.25 * (r1 - r2) * (r1 - r2)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::SmallRng;
    use glam::Vec3;

    const WIDTH: u32 = 200;

    /// A half whose pixels are `value` with noise of standard deviation `sigma`, and `hot` pixels far above.
    fn noisy(value: impl Fn(usize) -> f32, sigma: f32, hot: usize, seed: u64) -> Film {
        let mut rng = SmallRng::new(seed);
        // Uniform numbers of unit variance.
        let mut noise = || (rng.f32() - 0.5) * 12f32.sqrt() * sigma;
        let mut picture = Picture::new(WIDTH, WIDTH);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = Vec3::splat(value(i)) + Vec3::new(noise(), noise(), noise());
        }
        picture.pixels[..hot].fill(Vec3::splat(1e4));
        Film::of_picture(&picture, 1)
    }

    fn halves(value: impl Fn(usize) -> f32 + Copy, sigma: f32, seed: u64) -> Halves {
        Halves::new(noisy(value, sigma, 0, seed), noisy(value, sigma, 0, seed + 1)).unwrap()
    }

    fn z(measured: Measured, truth: f64) -> f64 {
        (measured.value - truth) / measured.standard_error
    }

    #[test]
    fn bias_and_noise_are_told_apart() {
        let reference = halves(|_| 1.0, 0.02, 1);
        let picture = halves(|i| if i % 2 == 0 { 1.3 } else { 0.9 }, 0.4, 11);
        let found = picture.compare(&reference).unwrap();
        let weight = 1.0 / 1.01;
        let close = |found: f64, truth: f64| assert!((found - truth).abs() < 0.03 * truth, "{found} {truth}");
        close(found.bias.value, 0.05 * weight);
        close(found.noise, 0.08 * weight);
        close(found.reference_noise, 0.000_2 * weight);
        close(found.rel_mse, found.bias.value + found.noise + found.reference_noise);
        for ratio in found.mean_ratio {
            assert!(z(ratio, 1.1).abs() < 4.0 && ratio.standard_error < 0.002, "{ratio:?}");
        }
    }

    #[test]
    fn pictures_without_bias_have_none() {
        for seed in 0..10 {
            let (reference, picture) =
                (halves(|_| 1.0, 0.1, 40 * seed), halves(|_| 1.0, 0.3, 40 * seed + 20));
            let found = picture.compare(&reference).unwrap();
            assert!(z(found.bias, 0.0).abs() < 4.0, "{found:?}");
            assert!(found.bias.standard_error < 0.01 * found.noise, "{found:?}");
        }
        // A reference as noisy as the picture, bright samples being rare: its deviations are large and not symmetric.
        let rare = |seed| {
            let mut picture = noisy(|_| 0.1, 0.0, 0, seed).develop();
            let mut rng = SmallRng::new(seed);
            picture
                .pixels
                .iter_mut()
                .for_each(|p| *p += Vec3::splat(if rng.f32() < 0.1 { 9.0 } else { 0.0 }));
            Film::of_picture(&picture, 1)
        };
        for seed in 0..10 {
            let [reference, picture] =
                [100, 200].map(|s| Halves::new(rare(s + 2 * seed), rare(s + 2 * seed + 1)).unwrap());
            let found = picture.compare(&reference).unwrap();
            assert!(z(found.bias, 0.0).abs() < 4.0, "{found:?}");
        }
        let same = halves(|_| 1.0, 0.0, 3);
        let found = same.compare(&same).unwrap();
        assert_eq!((found.rel_mse, found.bias.value, found.noise), (0.0, 0.0, 0.0));
    }

    #[test]
    fn a_thousandth_of_fireflies_is_left_out_and_not_more() {
        let reference = halves(|_| 1.0, 0.0, 1);
        let with = |hot| Halves::new(noisy(|_| 1.0, 0.1, hot, 5), noisy(|_| 1.0, 0.1, 0, 6)).unwrap();
        assert!(with(40).compare(&reference).unwrap().rel_mse < 0.01);
        assert!(with(60).compare(&reference).unwrap().rel_mse > 1.0);
    }

    #[test]
    fn odd_pictures_are_answered() {
        let picture = |width| Film::of_picture(&Picture::new(width, 1), 1);
        assert_eq!(Halves::new(picture(1), picture(2)).unwrap_err(), DifferentSizes);
        let black = Halves::new(picture(2), picture(2)).unwrap();
        assert_eq!(black.compare(&Halves::new(picture(3), picture(3)).unwrap()), Err(DifferentSizes));
        let found = black.compare(&black).unwrap();
        assert_eq!((found.rel_mse, found.bias.value), (0.0, 0.0));
        assert!(found.mean_ratio[0].value.is_nan());
    }
}
