//! Fresnel reflection: the exact dielectric equations, Schlick's approximation as glTF writes it, and their
//! hemispherical averages.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `cos_i` | c | cosine of incidence, ≥ 0 |
//! | `eta` | η | index beyond the interface over index on the side the light comes from |
//! | `g` | g = η cos θ_t | from Snell's law g² = η² − 1 + c²; total internal reflection where g² ≤ 0 |
//!
//! Written with g the differences of nearly equal numbers, which ruin the textbook form at η ≈ 1, disappear:
//! c − g = (1 − η²)/(c + g), so r_s = (1 − η²)/(c + g)² and
//! r_p = (η² − 1)((η² + 1)c² − 1)/(η² c + g)², both accurate relative to themselves for every η.

use glam::Vec3;

/// What happens at a smooth interface for one direction of incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Unpolarised reflectance in \[0, 1\]; the transmitted power is the rest.
    pub reflectance: f32,
    /// η cos θ_t, 0 under total internal reflection.
    pub g: f32,
}

/// Exact unpolarised reflectance for incidence at cosine `cos_i` in \[0, 1\], `eta` > 0 beyond over this side, with
/// the refracted cosine as a by-product.
#[inline]
pub fn interface(cos_i: f32, eta: f32) -> Interface {
    let eta2m1 = (eta - 1.0) * (eta + 1.0);
    let g2 = eta2m1 + cos_i * cos_i;
    if g2 <= 0.0 {
        return Interface { reflectance: 1.0, g: 0.0 };
    }
    let g = g2.sqrt();
    Interface { reflectance: reflectance(cos_i, g, eta), g }
}

/// Reflectance where both c and g are known; more accurate near the critical angle, where g² is a small difference.
#[inline]
pub(super) fn reflectance(cos_i: f32, g: f32, eta: f32) -> f32 {
    let eta2m1 = (eta - 1.0) * (eta + 1.0);
    let eta2 = eta * eta;
    let sum_s = cos_i + g;
    let sum_p = eta2 * cos_i + g;
    let r_s = eta2m1 / (sum_s * sum_s);
    let r_p = eta2m1 * ((eta2 + 1.0) * cos_i * cos_i - 1.0) / (sum_p * sum_p);
    (0.5 * (r_s * r_s + r_p * r_p)).min(1.0)
}

/// Exact unpolarised reflectance of a dielectric; 1 under total internal reflection.
#[inline]
pub fn dielectric(cos_i: f32, eta: f32) -> f32 {
    interface(cos_i, eta).reflectance
}

/// The direction on the other side for `w` (unit, pointing away from the surface) and a unit normal `n` with
/// `w·n` = `cos_i` ≥ 0: it points away from the surface, on the side of −n. `None` under total internal reflection.
#[inline]
pub fn refract(w: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cos_i = w.dot(n);
    let eta2m1 = (eta - 1.0) * (eta + 1.0);
    let g2 = eta2m1 + cos_i * cos_i;
    (g2 > 0.0).then(|| refract_with(w, n, cos_i, g2.sqrt(), eta))
}

/// [`refract`] where the cosine and g = η cos θ_t are known.
#[inline]
pub(super) fn refract_with(w: Vec3, n: Vec3, cos_i: f32, g: f32, eta: f32) -> Vec3 {
    let c_minus_g = (1.0 - eta) * (1.0 + eta) / (cos_i + g);
    (c_minus_g * n - w) / eta
}

/// Reflectance at normal incidence of an interface of relative index `eta`.
#[inline]
pub fn f0_from_eta(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// The weight (1 − cos)⁵ of Schlick's approximation F = f0 + (f90 − f0)(1 − cos)⁵.
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// ∫₀¹ 2µ (1 − µ)⁵ dµ: the hemispherical average of [`schlick_weight`].
pub const SCHLICK_AVERAGE: f32 = 1.0 / 21.0;

/// Below this distance from 1 the closed form of [`diffuse_reflectance`] loses digits and its tangent is used.
const NEAR_MATCHED: f64 = 2e-4;

/// Hemispherical average F_dr = ∫₀¹ 2µ F(µ) dµ for diffuse light that meets an interface of relative index `eta`
/// (beyond over this side).
///
/// Closed form of Walsh (1926; also Duderstadt & Hamilton, Egan & Hilgeman) for η > 1, continued to η < 1 by
/// 1 − F_dr(1/η) = (1 − F_dr(η))/η², which is the equilibrium of isotropic radiance on both sides.
pub fn diffuse_reflectance(eta: f32) -> f32 {
    let eta = f64::from(eta);
    if eta < 1.0 {
        return (1.0 - (1.0 - diffuse_reflectance_entering(1.0 / eta)) * eta * eta) as f32;
    }
    diffuse_reflectance_entering(eta) as f32
}

fn diffuse_reflectance_entering(n: f64) -> f64 {
    let (n2, n4) = (n * n, n.powi(4));
    if n - 1.0 < NEAR_MATCHED {
        return (n - 1.0) / 3.0;
    }
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of the high-precision table of closed forms, "Unpolarised dielectric Fresnel reflectance".
    #[test]
    fn reflectance_matches_high_precision_values() {
        for (c, n_i, n_t, r) in FRESNEL_ORACLE {
            let f = dielectric(c as f32, (n_t / n_i) as f32);
            assert!((f64::from(f) - r).abs() < 2e-6, "cos {c}, {n_i} -> {n_t}: {f} for {r}");
        }
    }

    /// "Diffuse Fresnel reflectance F_dr(eta)"; there eta is this side over the other side.
    #[test]
    fn diffuse_reflectance_matches_high_precision_values() {
        for (n_here_over_there, f_dr) in [
            (1.0, 0.0),
            (1.05, 0.10556521453540356),
            (1.1, 0.19434492343212995),
            (1.3, 0.44445670127690284),
            (1.5, 0.5963457597077116),
            (2.4, 0.8628786982657025),
            (0.9523809523809523, 0.013885649025282347),
            (0.6666666666666666, 0.09177795934235122),
            (0.4166666666666667, 0.2101813020104467),
        ] {
            let f = diffuse_reflectance((1.0f64 / n_here_over_there) as f32);
            assert!((f64::from(f) - f_dr).abs() < 2e-6, "{n_here_over_there}: {f} for {f_dr}");
        }
    }

    #[test]
    fn diffuse_reflectance_is_the_average_of_the_reflectance() {
        for eta in [0.4f32, 0.7, 0.95, 0.99999, 1.0, 1.0001, 1.0004, 1.01, 1.33, 1.5, 2.5] {
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let s = (f64::from(i) + 0.5) / f64::from(n);
                    f64::from(dielectric((s * s) as f32, eta)) * 4.0 * s.powi(3)
                })
                .sum();
            let average = sum / f64::from(n);
            let f = f64::from(diffuse_reflectance(eta));
            assert!((f - average).abs() < 1e-5, "eta {eta}: {f} for {average}");
        }
    }

    #[test]
    fn refraction_matches_high_precision_values() {
        let w = Vec3::new(0.469_846_3, 0.171_010_07, 0.866_025_4);
        let t = refract(w, Vec3::Z, 1.33).unwrap();
        let expected = Vec3::new(-0.353_267_9, -0.128_579, -0.926_644);
        assert!((t - expected).length() < 1e-6, "{t}");
        assert_eq!(refract(Vec3::new(0.8, 0.0, 0.6), Vec3::Z, 1.0 / 1.5), None);
    }

    /// At η = 1 + 1e-6 the reflectance at normal incidence is 2.5e-13, far below the rounding of 1.
    #[test]
    fn near_matched_reflectance_keeps_its_digits() {
        let eta = 1.0 + 8.0 * f32::EPSILON;
        let exact = f64::from(eta - 1.0).powi(2) / (f64::from(eta) + 1.0).powi(2);
        assert!((f64::from(dielectric(1.0, eta)) / exact - 1.0).abs() < 1e-5);
        assert_eq!(dielectric(0.3, 1.0), 0.0);
    }

    const FRESNEL_ORACLE: [(f64, f64, f64, f64); 27] = [
        (1.0, 1.0, 1.33, 0.020059312199524774),
        (0.7, 1.0, 1.33, 0.028035517758145955),
        (0.1, 1.0, 1.33, 0.5389897578919998),
        (1.0, 1.0, 1.5, 0.04),
        (0.7, 1.0, 1.5, 0.050916935590777444),
        (0.1, 1.0, 1.5, 0.5715925203424492),
        (1.0, 1.5, 1.0, 0.04),
        (0.7, 1.5, 1.0, 1.0),
        (0.5, 1.5, 1.0, 1.0),
        (0.3, 1.5, 1.0, 1.0),
        (0.1, 1.5, 1.0, 1.0),
        (0.01, 1.5, 1.0, 1.0),
        (0.0, 1.5, 1.0, 1.0),
        (1.0, 1.33, 1.0, 0.020059312199524774),
        (0.7, 1.33, 1.0, 0.15586345067153737),
        (0.5, 1.33, 1.0, 1.0),
        (0.3, 1.33, 1.0, 1.0),
        (0.1, 1.33, 1.0, 1.0),
        (0.01, 1.33, 1.0, 1.0),
        (0.0, 1.33, 1.0, 1.0),
        (1.0, 1.0, 1.0, 0.0),
        (0.7, 1.0, 1.0, 0.0),
        (0.1, 1.0, 1.0, 0.0),
        (0.0, 1.0, 1.0, 1.0),
        (1.0, 1.0, 2.4, 0.1695501730103806),
        (0.7, 1.0, 2.4, 0.17938942540396338),
        (0.1, 1.0, 2.4, 0.5859887033252834),
    ];
}
