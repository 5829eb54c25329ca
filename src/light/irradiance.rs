//! How bright an environment is for a surface that faces one way, nine numbers for all ways: irradiance in spherical
//! harmonics up to order 2 (Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance environment maps").
//! An estimate, for weighing choices: off by some per cent where light comes from all around, more under a small sun.

use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The estimate is at least this share of the mean irradiance.
const LEAST: f32 = 0.05;

/// The irradiance of an environment, channel mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Irradiance {
    coefficients: [f32; 9],
    least: f32,
}

/// The real spherical harmonics up to order 2, without their constants, in the order of [`NORMS`].
fn basis(d: Vec3) -> [f32; 9] {
    [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y]
}

/// Squares of the constants of [`basis`], times the cosine lobe's π, 2π/3 and π/4.
const NORMS: [f64; 9] = {
    let (order1, order2) = (3.0 / (4.0 * PI) * 2.0 * PI / 3.0, PI / 4.0);
    let (cross, axial, planar) = (15.0 / (4.0 * PI), 5.0 / (16.0 * PI), 15.0 / (16.0 * PI));
    [
        0.25,
        order1,
        order1,
        order1,
        cross * order2,
        cross * order2,
        axial * order2,
        cross * order2,
        planar * order2,
    ]
};

impl Irradiance {
    /// From equally many directions in each row: `at(row, column)` is a unit direction and its radiance (channel mean)
    /// times solid angle.
    fn new(width: usize, height: usize, at: impl Fn(usize, usize) -> (Vec3, f32) + Sync) -> Self {
        let row = |y: usize| {
            let mut sums = [0.0f64; 9];
            for x in 0..width {
                let (direction, power) = at(y, x);
                for (sum, b) in sums.iter_mut().zip(basis(direction)) {
                    *sum += f64::from(b * power);
                }
            }
            sums
        };
        // Summed in order, so that the threads do not matter.
        let rows: Vec<[f64; 9]> = (0..height).into_par_iter().map(row).collect();
        let mut sums = [0.0; 9];
        for row in rows {
            sums.iter_mut().zip(row).for_each(|(sum, r)| *sum += r);
        }
        let coefficients: [f32; 9] = std::array::from_fn(|i| (sums[i] * NORMS[i]) as f32);
        Self { coefficients, least: LEAST * coefficients[0] }
    }

    /// Of an equirectangular map: `turn` from map to world, `radiance` (channel mean) by texel, row by row.
    pub fn of_map(
        width: usize,
        height: usize,
        turn: impl Fn(Vec3) -> Vec3 + Sync,
        radiance: impl Fn(usize) -> f32 + Sync,
    ) -> Self {
        use std::f32::consts::{PI, TAU};
        Self::new(width, height, |y, x| {
            let (sin, cos) = (PI * (y as f32 + 0.5) / height as f32).sin_cos();
            let (sin_phi, cos_phi) = (TAU * ((x as f32 + 0.5) / width as f32 - 0.5)).sin_cos();
            let solid_angle = TAU * PI * sin / (width as f32 * height as f32);
            (turn(Vec3::new(sin * cos_phi, cos, sin * sin_phi)), radiance(y * width + x) * solid_angle)
        })
    }

    /// For a surface with that unit normal.
    #[inline]
    pub fn towards(&self, normal: Vec3) -> f32 {
        let sum: f32 = basis(normal).iter().zip(self.coefficients).map(|(b, c)| b * c).sum();
        sum.max(self.least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radiance 1 + d.y over a sphere of equal-area bands: E(n) = π + 2π/3 n.y exactly.
    #[test]
    fn linear_radiance_has_its_irradiance() {
        const ROWS: usize = 200;
        const COLUMNS: usize = 200;
        let at = |row: usize, column: usize| {
            let y = 1.0 - 2.0 * (row as f32 + 0.5) / ROWS as f32;
            let (sin, cos) = (std::f32::consts::TAU * (column as f32 + 0.5) / COLUMNS as f32).sin_cos();
            let ring = (1.0 - y * y).sqrt();
            let solid_angle = 4.0 * std::f32::consts::PI / (ROWS * COLUMNS) as f32;
            (Vec3::new(ring * cos, y, ring * sin), (1.0 + y) * solid_angle)
        };
        let e = Irradiance::new(COLUMNS, ROWS, at);
        for n in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.8, 0.0)]
        {
            let exact = std::f32::consts::PI * (1.0 + 2.0 / 3.0 * n.y);
            assert!((e.towards(n) - exact).abs() < 1e-3 * exact, "{n}: {} for {exact}", e.towards(n));
        }
    }

    /// Light from one direction: the cosine to second order, 1/4 + c/2 + 5/16 (3c² − 1)/2.
    #[test]
    fn a_sun_is_a_smooth_cosine() {
        let sun = Vec3::new(0.48, 0.6, 0.64);
        let e = Irradiance::new(1, 1, |_, _| (sun, 1.0));
        for n in [sun, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.0, 0.6, -0.8), -sun] {
            let c = n.dot(sun);
            let exact = 0.25 + 0.5 * c + 5.0 / 32.0 * (3.0 * c * c - 1.0);
            assert!((e.towards(n) - exact.max(LEAST * 0.25)).abs() < 1e-5, "{n}: {}", e.towards(n));
        }
    }
}
