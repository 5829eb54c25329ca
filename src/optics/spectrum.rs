//! One wavelength for a path: how it is drawn, what colour it is, and what index of refraction it meets.
//!
//! Light that a dispersive boundary refracts goes another way for each wavelength. A path has three colours until it is
//! refracted by one; then it draws a wavelength λ with density p(λ), weighs its throughput by w(λ) = r(λ)/p(λ), and keeps λ
//! (KHR_materials_dispersion; the index is its Cauchy formula). r(λ) is the response of linear Rec. 709 to λ, so that
//! ∫ r dλ is white, (1, 1, 1): colour matching functions as sums of Gaussians (Wyman, Sloan & Shirley 2013), turned to
//! Rec. 709, negative parts cut off (spectral colours are outside of the gamut; the three numbers of a path cannot be
//! negative), each channel scaled to 1. p = (r_R + r_G + r_B)/3, so the channels of w always add up to 3.

use glam::{Mat3, Vec3};
use std::sync::OnceLock;

/// The visible range, nanometres.
pub const RANGE: (f32, f32) = (380.0, 720.0);
const BINS: usize = 170;

/// Wavelengths to choose from where each has tables of its own.
pub const STRATA: usize = 16;

struct Table {
    response: [Vec3; BINS],
    /// Probability of bins up to each.
    cumulative: [f32; BINS],
    /// The mean weight of the strata's middles.
    strata_mean: Vec3,
}

fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let width = (RANGE.1 - RANGE.0) / BINS as f32;
        let mut response: [Vec3; BINS] =
            std::array::from_fn(|i| rec709(RANGE.0 + (i as f32 + 0.5) * width).max(Vec3::ZERO));
        let mean = response.iter().sum::<Vec3>() / BINS as f32;
        let mut sum = 0.0;
        let mut cumulative = [0.0; BINS];
        for (r, c) in response.iter_mut().zip(&mut cumulative) {
            *r /= mean;
            sum += r.element_sum() / (3.0 * BINS as f32);
            *c = sum;
        }
        let mut table = Table { response, cumulative, strata_mean: Vec3::ONE };
        let middles = (0..STRATA).map(|k| draw_from(&table, (k as f32 + 0.5) / STRATA as f32).1);
        table.strata_mean = middles.sum::<Vec3>() / STRATA as f32;
        table
    })
}

/// Linear Rec. 709 of monochromatic light, up to a common scale.
fn rec709(nm: f32) -> Vec3 {
    let g = |mean: f32, below: f32, above: f32| {
        let t = (nm - mean) / if nm < mean { below } else { above };
        (-0.5 * t * t).exp()
    };
    let x = 1.056 * g(599.8, 37.9, 31.0) + 0.362 * g(442.0, 16.0, 26.7) - 0.065 * g(501.1, 20.4, 26.2);
    let y = 0.821 * g(568.8, 46.9, 40.5) + 0.286 * g(530.9, 16.3, 31.1);
    let z = 1.217 * g(437.0, 11.8, 36.0) + 0.681 * g(459.0, 26.0, 13.8);
    let to_rec709 = Mat3::from_cols(
        Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
        Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
    );
    to_rec709 * Vec3::new(x, y, z)
}

fn draw_from(table: &Table, u: f32) -> (f32, Vec3) {
    let i = table.cumulative.partition_point(|&c| c <= u).min(BINS - 1);
    let before = if i == 0 { 0.0 } else { table.cumulative[i - 1] };
    let inside = ((u - before) / (table.cumulative[i] - before).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let r = table.response[i];
    let nm = RANGE.0 + (i as f32 + inside) * (RANGE.1 - RANGE.0) / BINS as f32;
    (nm, r * (3.0 / r.element_sum()))
}

/// A wavelength in nanometres and the weight of a path that keeps it; `u` in \[0, 1).
pub fn draw(u: f32) -> (f32, Vec3) {
    draw_from(table(), u)
}

/// As [`draw`], one of [`STRATA`] wavelengths.
pub fn draw_stratum(u: f32) -> (f32, Vec3) {
    let k = (u * STRATA as f32).floor();
    let (nm, weight) = draw((k + 0.5) / STRATA as f32);
    (nm, weight / table().strata_mean)
}

/// Average over all wavelengths, by channel, of a number that depends on the wavelength, and its average over draws.
pub fn average(f: impl Fn(f32) -> f32) -> (Vec3, f32) {
    let (mut colored, mut plain) = (Vec3::ZERO, 0.0);
    for k in 0..STRATA {
        let (nm, weight) = draw_stratum((k as f32 + 0.5) / STRATA as f32);
        let value = f(nm) / STRATA as f32;
        colored += weight * value;
        plain += value;
    }
    (colored, plain)
}

/// Index of refraction at `nm` nanometres, for the index `ior` at 587.6 nm and `dispersion` = 20 over the Abbe number.
pub fn index(ior: f32, dispersion: f32, nm: f32) -> f32 {
    (ior + (ior - 1.0) * dispersion / 20.0 * (523_655.0 / (nm * nm) - 1.5168)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition: V = (n_d − 1)/(n_F − n_C) at Fraunhofer's lines.
    #[test]
    fn the_index_has_the_abbe_number() {
        for (ior, abbe) in [(1.5f32, 60.0f32), (2.42, 55.0), (1.33, 20.0)] {
            let n = |nm| f64::from(index(ior, 20.0 / abbe, nm));
            let v = (n(587.6) - 1.0) / (n(486.1) - n(656.3));
            assert!((v / f64::from(abbe) - 1.0).abs() < 1e-3, "{ior} {abbe}: {v}");
            assert!((n(587.6) - f64::from(ior)).abs() < 1e-4);
        }
        assert_eq!(index(1.5, 0.0, 400.0), 1.5);
    }

    #[test]
    fn wavelengths_add_up_to_white() {
        const N: usize = 20_000;
        let mut sum = Vec3::ZERO;
        for i in 0..N {
            let (nm, weight) = draw((i as f32 + 0.5) / N as f32);
            assert!((RANGE.0..=RANGE.1).contains(&nm) && weight.min_element() >= 0.0);
            assert!((weight.element_sum() - 3.0).abs() < 1e-4);
            sum += weight / N as f32;
        }
        assert!((sum - Vec3::ONE).abs().max_element() < 1e-3, "{sum}");
        let strata: Vec3 = (0..STRATA).map(|k| draw_stratum((k as f32 + 0.5) / STRATA as f32).1).sum();
        assert!((strata / STRATA as f32 - Vec3::ONE).abs().max_element() < 1e-5, "{strata}");
        assert!((average(|_| 0.3).0 - Vec3::splat(0.3)).abs().max_element() < 1e-5);
    }

    /// Names of colours: blue, green and red light are what they are called.
    #[test]
    fn colours_are_in_order() {
        let strongest = |nm: f32| {
            rec709(nm)
                .to_array()
                .iter()
                .enumerate()
                .fold((0, f32::MIN), |best, (i, &v)| if v > best.1 { (i, v) } else { best })
                .0
        };
        assert_eq!([strongest(450.0), strongest(535.0), strongest(630.0)], [2, 1, 0]);
    }
}
