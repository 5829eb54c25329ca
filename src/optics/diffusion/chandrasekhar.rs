//! Chandrasekhar's H function: the exact reflection of a half space that scatters isotropically behind an index-matched
//! boundary (Chandrasekhar, "Radiative Transfer", 1960).
//!
//! H(µ) = exp(−µ/π ∫₀^{π/2} ln(1 − α t cot t)/(cos²t + µ² sin²t) dt) for the single-scattering albedo α in \[0, 1\].

use super::quadrature;
use std::f64::consts::{FRAC_PI_2, PI};

/// H(µ) ≥ 1 for the single-scattering `albedo` in \[0, 1\] and the cosine `mu` in \[0, 1\]; within 1e-12.
pub fn h(albedo: f64, mu: f64) -> f64 {
    let integral = quadrature::unit_interval(|x, rest| {
        let (t, complement) = (FRAC_PI_2 * x, FRAC_PI_2 * rest);
        let (cos, sin) = (complement.sin(), t.sin());
        let absorbed = (1.0 - albedo) + albedo * one_minus_t_cot_t(t, cos, sin);
        absorbed.ln() / (cos * cos + mu * mu * sin * sin) * FRAC_PI_2
    });
    (-mu / PI * integral).exp()
}

/// Share of light from the direction of cosine `mu` that is reflected: 1 − √(1 − α) H(µ), in \[0, 1\].
pub fn directional_albedo(albedo: f64, mu: f64) -> f64 {
    1.0 - (1.0 - albedo).sqrt() * h(albedo, mu)
}

/// Share of diffuse light that is reflected: 1 − 2√(1 − α) ∫₀¹ H µ dµ, in \[0, 1\].
pub fn spherical_albedo(albedo: f64) -> f64 {
    let moment = quadrature::unit_interval(|mu, _| mu * h(albedo, mu));
    1.0 - 2.0 * (1.0 - albedo).sqrt() * moment
}

/// BRDF of the half space, 1/sr: α/(4π) H(µ)H(µ₀)/(µ + µ₀), for the cosines of incidence and exit.
pub fn brdf(albedo: f64, mu0: f64, mu: f64) -> f64 {
    albedo / (4.0 * PI) * h(albedo, mu0) * h(albedo, mu) / (mu0 + mu)
}

/// 1 − t cot t, by its series t²/3 + t⁴/45 + 2t⁶/945 + t⁸/4725 + … where the difference would cancel.
fn one_minus_t_cot_t(t: f64, cos: f64, sin: f64) -> f64 {
    if t > 0.1 {
        return 1.0 - t * cos / sin;
    }
    let t2 = t * t;
    t2 * (1.0 / 3.0 + t2 * (1.0 / 45.0 + t2 * (2.0 / 945.0 + t2 * (1.0 / 4725.0 + t2 * (2.0 / 93555.0)))))
}
