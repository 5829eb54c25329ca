//! The Henyey–Greenstein phase function (Henyey & Greenstein 1941).
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `g` | g | mean cosine of the deflection: positive scatters forward |
//! | `cos` | cos θ | between the directions of propagation before and after; 1 is straight on |
//!
//! p(cos θ) = (1 − g²) / (4π (1 + g² − 2g cos θ)^{3/2}), per steradian. The usual inverse of its distribution divides by
//! g and subtracts nearly equal numbers; with s = 2ξ − 1 it factors into
//!
//! 1 − cos θ = (1 − g)² (1 − s)(2 + g(1 + s)) / (2 (1 + gs)²),
//! 1 + cos θ = (1 + g)² (1 + s)(2 − g(1 − s)) / (2 (1 + gs)²),
//!
//! products of non-negative numbers for every g in (−1, 1), 0 included.

use crate::sampling::fast_math;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Henyey–Greenstein with mean cosine `g`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    /// Mean cosine of the deflection, in (−1, 1).
    pub g: f32,
}

impl HenyeyGreenstein {
    /// Density per steradian at deflection cosine `cos`; also the density of [`HenyeyGreenstein::sample`].
    #[inline]
    pub fn eval(&self, cos: f32) -> f32 {
        self.density(1.0 - cos, 1.0 + cos)
    }

    /// Density per steradian of a deflection from unit propagation direction `before` to `after`. More accurate near
    /// the forward and backward peaks than a cosine can be.
    #[inline]
    pub fn eval_directions(&self, before: Vec3, after: Vec3) -> f32 {
        self.density(0.5 * (after - before).length_squared(), 0.5 * (after + before).length_squared())
    }

    #[inline]
    fn density(&self, one_minus_cos: f32, one_plus_cos: f32) -> f32 {
        let g = self.g;
        let d = if g >= 0.0 {
            (1.0 - g) * (1.0 - g) + 2.0 * g * one_minus_cos
        } else {
            (1.0 + g) * (1.0 + g) - 2.0 * g * one_plus_cos
        };
        0.25 * FRAC_1_PI * (1.0 - g) * (1.0 + g) / (d * d.sqrt())
    }

    /// (1 − cos, 1 + cos) of the deflection whose distribution function is `xi` in \[0, 1\].
    #[inline]
    fn invert(&self, xi: f32) -> (f32, f32) {
        let g = self.g;
        // 1 + gs, summed so that nothing cancels.
        let d = if g >= 0.0 { (1.0 - g) + 2.0 * g * xi } else { (1.0 + g) - 2.0 * g * (1.0 - xi) };
        let scale = 2.0 / (d * d);
        let (below, above) = ((1.0 - g) * (1.0 - g), (1.0 + g) * (1.0 + g));
        (below * (1.0 - xi) * (1.0 + g * xi) * scale, above * xi * (1.0 - g * (1.0 - xi)) * scale)
    }

    /// The deflection cosine whose distribution function is `xi`: 0 gives −1, 1 gives 1.
    #[inline]
    pub fn sample_cos(&self, xi: f32) -> f32 {
        let (minus, plus) = self.invert(xi);
        if minus < plus { 1.0 - minus } else { plus - 1.0 }
    }

    /// Cosine and sine of the deflection whose distribution function is `xi`.
    #[inline(always)]
    pub fn deflection(&self, xi: f32) -> (f32, f32) {
        let (minus, plus) = self.invert(xi);
        let cos = if minus < plus { 1.0 - minus } else { plus - 1.0 };
        (cos, (minus * plus).max(0.0).sqrt())
    }

    /// A new unit direction of propagation after one along the unit vector `before`, and its density; `u` in
    /// \[0, 1)².
    #[inline]
    pub fn sample(&self, before: Vec3, u: Vec2) -> (Vec3, f32) {
        let (minus, plus) = self.invert(u.x);
        let cos = if minus < plus { 1.0 - minus } else { plus - 1.0 };
        let sin = (minus * plus).max(0.0).sqrt();
        let (sin_phi, cos_phi) = fast_math::sin_cos_turns(u.y - 0.5);
        let (x, y) = before.any_orthonormal_pair();
        let after = (x * (sin * cos_phi) + y * (sin * sin_phi) + before * cos).normalize();
        (after, self.density(minus, plus))
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::Rng;
    use super::*;

    #[test]
    fn density_matches_high_precision_values() {
        for (g, cos, pdf, _) in HG_ORACLE {
            let p = f64::from(HenyeyGreenstein { g: g as f32 }.eval(cos as f32));
            assert!((p / pdf - 1.0).abs() < 2e-4, "g {g}, cos {cos}: {p} for {pdf}");
        }
    }

    #[test]
    fn inverse_matches_high_precision_values() {
        for (g, xi, cos) in HG_SAMPLE_ORACLE {
            let c = f64::from(HenyeyGreenstein { g: g as f32 }.sample_cos(xi as f32));
            assert!(
                (c - cos).abs() < 3e-6 * (1.0 + 1.0 / (1.0 - f64::abs(g))),
                "g {g}, xi {xi}: {c} for {cos}"
            );
        }
    }

    /// g is the mean cosine, and the returned density is that of the returned direction.
    #[test]
    fn samples_have_mean_cosine_g_and_report_their_density() {
        let mut rng = Rng::new(11);
        let before = Vec3::new(0.48, -0.6, 0.64);
        for g in [-0.99f32, -0.5, -1e-4, 0.0, 1e-6, 0.3, 0.9, 0.999] {
            let p = HenyeyGreenstein { g };
            let n = 40_000;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for _ in 0..n {
                let (after, pdf) = p.sample(before, rng.vec2());
                let cos = f64::from(after.dot(before));
                sum += cos;
                squares += cos * cos;
                let again = p.eval_directions(before, after);
                assert!((again / pdf - 1.0).abs() < 2e-2, "g {g}: {again} for {pdf}");
                assert!((after.length() - 1.0).abs() < 1e-6);
            }
            let mean = sum / f64::from(n);
            let sd = ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
            assert!(((mean - f64::from(g)) / sd).abs() < 4.0, "g {g}: {mean} ± {sd}");
        }
    }

    /// (g, cos, density, distribution function) from the table of closed forms "Henyey-Greenstein phase function".
    const HG_ORACLE: [(f64, f64, f64, f64); 34] = [
        (-0.9, -1.0, 15.119719593730064, 0.0),
        (-0.9, -0.6, 0.02424149762375313, 0.9320121224040844),
        (-0.9, -0.2, 0.00865947840631246, 0.9678964379321634),
        (-0.9, 0.0, 0.006209060257965819, 0.9770967290072435),
        (-0.9, 0.35, 0.003966970742298093, 0.9879805355909715),
        (-0.9, 1.0, 0.0022043620926855303, 1.0),
        (-0.5, -0.6, 0.11388889110556046, 0.5697394905809366),
        (-0.5, 0.0, 0.04270575260503062, 0.8291796067500631),
        (-0.5, 0.8, 0.020333896459182228, 0.9761772781728163),
        (-0.1, -1.0, 0.10806817123523757, 0.0),
        (-0.1, -0.2, 0.08246463274180987, 0.4740364825885857),
        (-0.1, 0.35, 0.07019233622268185, 0.7368602791855874),
        (-0.1, 1.0, 0.05918985486888669, 1.0),
        (0.0, -0.6, 0.07957747154594767, 0.2),
        (0.0, 0.0, 0.07957747154594767, 0.5),
        (0.0, 0.8, 0.07957747154594767, 0.9),
        (0.001, -1.0, 0.07933913646234057, 0.0),
        (0.001, -0.2, 0.07952955014872043, 0.3992802403357061),
        (0.001, 0.35, 0.07966090182644167, 0.6743414912428839),
        (0.001, 1.0, 0.07981660240570261, 1.0),
        (0.3, -0.6, 0.04147434394602284, 0.09285644444838953),
        (0.3, 0.0, 0.0636343747723979, 0.28603653258541295),
        (0.3, 0.8, 0.15199761581015855, 0.775226012315589),
        (0.7, -1.0, 0.008260637184700452, 0.0),
        (0.7, -0.2, 0.017234568422073476, 0.05952819591531624),
        (0.7, 0.35, 0.04058451048843332, 0.15000000000000002),
        (0.7, 1.0, 1.5031300180901221, 1.0),
        (0.9, -0.6, 0.0030774922844962454, 0.006535947712418299),
        (0.9, 0.0, 0.006209060257965819, 0.02290327099275644),
        (0.9, 0.8, 0.06718017809595107, 0.11797670882232157),
        (0.99, -1.0, 0.0002009481365267234, 0.0),
        (0.99, -0.2, 0.00043236062993170447, 0.001469614051468576),
        (0.99, 0.35, 0.0010844880651069196, 0.0038084345557495938),
        (0.99, 1.0, 1583.5916837643558, 1.0),
    ];

    /// (g, ξ, cos) from "Henyey-Greenstein inverse cdf".
    const HG_SAMPLE_ORACLE: [(f64, f64, f64); 36] = [
        (-0.9, 0.0, -1.0),
        (-0.9, 0.1, -0.9987763656030286),
        (-0.9, 0.5, -0.9855),
        (-0.9, 0.999999, 0.9999278019493512),
        (-0.5, 0.0, -1.0),
        (-0.5, 0.1, -0.9630102040816326),
        (-0.5, 0.5, -0.6875),
        (-0.5, 0.999999, 0.9999910000269997),
        (-0.1, 0.0, -1.0),
        (-0.1, 0.1, -0.8486111111111111),
        (-0.1, 0.5, -0.14950000000000002),
        (-0.1, 0.999999, 0.9999973111120073),
        (0.0, 0.0, -1.0),
        (0.0, 0.1, -0.8),
        (0.0, 0.5, 0.0),
        (0.0, 0.999999, 0.9999979999999999),
        (0.001, 0.0, -1.0),
        (0.001, 0.1, -0.7994594236037349),
        (0.001, 0.5, 0.0014999995),
        (0.001, 0.999999, 0.999998005992002),
        (0.3, 0.0, -1.0),
        (0.3, 0.1, -0.5728185595567867),
        (0.3, 0.5, 0.4365),
        (0.3, 0.999999, 0.9999992461533243),
        (0.7, 0.0, -1.0),
        (0.7, 0.1, 0.10464876033057843),
        (0.7, 0.5, 0.8785),
        (0.7, 0.999999, 0.9999998941175162),
        (0.9, 0.0, -1.0),
        (0.9, 0.1, 0.7497448979591838),
        (0.9, 0.5, 0.9855),
        (0.9, 0.999999, 0.9999999894736693),
        (0.99, 0.0, -1.0),
        (0.99, 0.1, 0.9954276072485208),
        (0.99, 0.5, 0.9998505),
        (0.99, 0.999999, 0.9999999998994973),
    ];
}
