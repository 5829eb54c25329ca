//! The GGX (Trowbridge–Reitz) microsurface: distribution of normals, Smith masking, and visible-normal sampling.
//!
//! | name | symbol | source |
//! | --- | --- | --- |
//! | `alpha` | α | roughness²; Walter et al. 2007 eq. 33 |
//! | [`distribution`] | D(h) | Walter et al. 2007 eq. 33 |
//! | [`masking`] | G1(w) | Walter et al. 2007 eq. 34, Smith |
//! | [`sample_visible`] | h ~ D_w(h) = G1(w) D(h) (w·h) / cos θ_w | Dupuy & Benyoub 2023, spherical caps |
//!
//! All directions are in the local frame, +z the macroscopic normal. Masking takes |z|, so it serves both sides.
//! Squared sines are taken from x² + y², which keeps its digits where 1 − z² does not.

use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Density D(h) of microfacet normals, per steradian and unit macroscopic area.
#[inline]
pub fn distribution(h: Vec3, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let e = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
    1.0 / (PI * a2 * e * e)
}

/// Smith masking G1 in \[0, 1\]: the visible fraction of the microfacets that face `w`.
#[inline]
pub fn masking(w: Vec3, alpha: f32) -> f32 {
    2.0 * w.z.abs() * masking_over_two_cos(w, alpha)
}

/// G1(w) / (2 |cos θ_w|), which stays finite at grazing directions.
#[inline]
pub fn masking_over_two_cos(w: Vec3, alpha: f32) -> f32 {
    let z = w.z.abs();
    1.0 / (z + (z * z + alpha * alpha * (w.x * w.x + w.y * w.y)).sqrt())
}

/// A microfacet normal seen from `w` (`w.z` ≥ 0), with density G1(w) D(h) (w·h) / cos θ_w; `u` in \[0, 1)².
#[inline]
pub fn sample_visible(w: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    let w_std = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
    let v = u.y * (1.0 + w_std.z);
    let z = 1.0 - v;
    let r = (v * (2.0 - v)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (2.0 * PI * u.x).sin_cos();
    let h = Vec3::new(r * cos_phi + w_std.x, r * sin_phi + w_std.y, z + w_std.z);
    Vec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0)).normalize_or(Vec3::Z)
}

/// Density of [`sample_visible`], per steradian, for `h` with `w·h` > 0.
#[inline]
pub fn visible_pdf(w: Vec3, h: Vec3, alpha: f32) -> f32 {
    2.0 * masking_over_two_cos(w, alpha) * distribution(h, alpha) * w.dot(h).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walter et al. 2007 eq. 4: the projected area of the microfacets is the macroscopic one.
    #[test]
    fn projected_area_is_one() {
        for alpha in [0.01f64, 0.1, 0.5, 1.0] {
            let n = 100_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(n);
                    let tan = alpha * t / (1.0 - t);
                    let cos = 1.0 / (1.0 + tan * tan).sqrt();
                    let h = Vec3::new((tan * cos) as f32, 0.0, cos as f32);
                    let dtheta = alpha / (1.0 - t).powi(2) * cos * cos / f64::from(n);
                    f64::from(distribution(h, alpha as f32))
                        * cos
                        * tan
                        * cos
                        * dtheta
                        * std::f64::consts::TAU
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "alpha {alpha}: {sum}");
        }
    }

    /// The mean of (1/cos θ_h) over visible normals is known: E\[cos θ_w / (G1 w·h)\] estimates ∫D over facing facets;
    /// here the sampler and the density are compared on a grid of the unit square by their Jacobian.
    #[test]
    fn visible_normals_follow_their_density() {
        for (theta, alpha) in [(0.1f32, 0.3f32), (1.2, 0.3), (1.55, 0.05), (0.7, 1.0)] {
            let w = Vec3::new(theta.sin(), 0.0, theta.cos());
            for i in 0..20 {
                let u = Vec2::new(0.05 + 0.043 * i as f32, 0.93 - 0.041 * i as f32);
                let d = 2e-3;
                let du = sample_visible(w, alpha, u + Vec2::new(d, 0.0))
                    - sample_visible(w, alpha, u - Vec2::new(d, 0.0));
                let dv = sample_visible(w, alpha, u + Vec2::new(0.0, d))
                    - sample_visible(w, alpha, u - Vec2::new(0.0, d));
                let area = du.cross(dv).length() / (4.0 * d * d);
                let product = area * visible_pdf(w, sample_visible(w, alpha, u), alpha);
                assert!((product - 1.0).abs() < 0.02, "theta {theta}, alpha {alpha}, u {u}: {product}");
            }
        }
    }
}
