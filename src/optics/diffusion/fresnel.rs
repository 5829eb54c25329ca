//! Fresnel's equations in double precision, and the reflectance of diffuse light with its published fits.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `cos_i` | c | cosine of incidence, in \[0, 1\] |
//! | `eta` | η | see each function: beyond over this side, or the reverse for diffuse light |
//!
//! The single-precision twins with the same form are in [`crate::optics::fresnel`].

use super::moments::Moments;
use glam::DVec3;

/// Exact unpolarised reflectance in \[0, 1\] at cosine `cos_i`; `eta` > 0 is the index beyond over this side. 1 under
/// total internal reflection.
pub fn dielectric(cos_i: f64, eta: f64) -> f64 {
    let excess = (eta - 1.0) * (eta + 1.0);
    let g2 = excess + cos_i * cos_i;
    if g2 <= 0.0 { 1.0 } else { reflectance(cos_i, g2.sqrt(), eta) }
}

/// [`dielectric`] where g = η cos θ_t ≥ 0 is known: accurate up to the critical angle.
pub(super) fn reflectance(cos_i: f64, g: f64, eta: f64) -> f64 {
    let (eta2, excess) = (eta * eta, (eta - 1.0) * (eta + 1.0));
    let (sum_s, sum_p) = (cos_i + g, eta2 * cos_i + g);
    let r_s = if sum_s > 0.0 { excess / (sum_s * sum_s) } else { 1.0 };
    let r_p = if sum_p > 0.0 { excess * ((eta2 + 1.0) * cos_i * cos_i - 1.0) / (sum_p * sum_p) } else { 1.0 };
    (0.5 * (r_s * r_s + r_p * r_p)).min(1.0)
}

/// Transmitted share 1 − R of the power, in \[0, 1\]; arguments as [`dielectric`].
pub fn transmittance(cos_i: f64, eta: f64) -> f64 {
    1.0 - dielectric(cos_i, eta)
}

/// Cosine beyond the interface, √(1 − (1 − c²)/η²), for incidence at `cos_i`; `None` under total internal reflection.
pub fn refracted_cosine(cos_i: f64, eta: f64) -> Option<f64> {
    let g2 = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    (g2 > 0.0).then(|| g2.sqrt() / eta)
}

/// Direction of propagation beyond the surface of unit normal `n` for light that arrives along −`w`, `w` a unit vector
/// with n·w ≥ 0: −w/η + n(c/η − cos θ_t). `None` under total internal reflection.
pub fn refract(w: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let cos_i = w.dot(n);
    let g2 = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    (g2 > 0.0).then(|| ((1.0 - eta) * (1.0 + eta) / (cos_i + g2.sqrt()) * n - w) / eta)
}

/// Diffuse reflectance F_dr = 2∫R µ dµ in \[0, 1\] for isotropic radiance on the side of relative index `eta` (this side
/// over beyond: above 1 inside a denser medium). Quadrature, 1e-13.
pub fn diffuse_reflectance(eta: f64) -> f64 {
    2.0 * Moments::exact(eta).c1
}

/// The rational fits of [`diffuse_reflectance`]: above 1 that of Jensen et al. 2001 §2.3,
/// −1.440/η² + 0.710/η + 0.668 + 0.0636η, within 0.0013 of the integral for η in \[1.02, 2.2\]; below 1 that of Egan &
/// Hilgeman 1979, −0.4399 + 0.7099/η − 0.3319/η² + 0.0636/η³, within 0.0012 for η in \[0.5, 1\]. 0 at 1.
pub fn diffuse_reflectance_fit(eta: f64) -> f64 {
    let v = 1.0 / eta;
    if eta > 1.0 {
        -1.440 * v * v + 0.710 * v + 0.668 + 0.0636 * eta
    } else if eta < 1.0 {
        -0.4399 + v * (0.7099 + v * (-0.3319 + v * 0.0636))
    } else {
        0.0
    }
}

/// Boundary coefficient A = (1 + F_dr)/(1 − F_dr) ≥ 1 of the diffuse reflectance `f_dr` in \[0, 1).
pub fn boundary_coefficient(f_dr: f64) -> f64 {
    (1.0 + f_dr) / (1.0 - f_dr)
}
