//! Single-scattering albedo from the colour of a surface, in double precision: what [`crate::optics::albedo`] computes,
//! the exact root of its forward fit, and the remapping of Chiang, Kutz & Burley 2016.

use super::{Coefficients, ScaleFit};

/// van de Hulst's similarity parameter s in \[0, 1\] of the multi-scatter albedo `rho` in \[0, 1\]:
/// 4.09712 + 4.20863ρ − √(9.59217 + 41.6808ρ + 17.7126ρ²) (Kulla & Conty 2017). The printed constants are rounded:
/// s(1) = −5e-6.
pub fn similarity(rho: f64) -> f64 {
    4.09712 + 4.20863 * rho - (9.59217 + 41.6808 * rho + 17.7126 * rho * rho).sqrt()
}

/// The root in \[0, 1\] of ρ = (1 − s)(1 − 0.139s)/(1 + 1.17s), without rounded constants.
pub fn similarity_exact(rho: f64) -> f64 {
    let (b, c) = (1.139 + 1.17 * rho, 1.0 - rho);
    2.0 * c / (b + (b * b - 0.556 * c).sqrt())
}

/// Single-scattering albedo (1 − s²)/(1 − g s²) for the similarity parameter `s` and mean cosine `g`.
pub fn single_from_similarity(s: f64, g: f64) -> f64 {
    (1.0 - s) * (1.0 + s) / (1.0 - g * s * s)
}

/// Multi-scatter albedo (1 − s)(1 − 0.139s)/(1 + 1.17s) of the single-scattering `albedo` in \[0, 1\] for mean cosine
/// `g`, s = √((1 − α)/(1 − gα)) (van de Hulst 1980); within 0.002 of the exact spherical albedo.
pub fn multiple_from_single(albedo: f64, g: f64) -> f64 {
    let s = ((1.0 - albedo) / (1.0 - g * albedo)).max(0.0).sqrt();
    (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)
}

/// The isotropic, index-matched medium whose surface has the albedo `albedo` in \[0, 1\] and whose profile has the
/// length `d` in m: α = 1 − e^{−5.09406A + 2.61188A² − 4.31805A³}, σt = 1/(s d) with s of [`ScaleFit::DiffuseMfp`]
/// (Chiang, Kutz & Burley, "Practical and Controllable Subsurface Scattering for Production Path Tracing", 2016).
pub fn chiang(albedo: f64, d: f64) -> Coefficients {
    let exponent = albedo * (-5.09406 + albedo * (2.61188 - albedo * 4.31805));
    let sigma_t = 1.0 / (d * ScaleFit::DiffuseMfp.scale(albedo));
    Coefficients {
        sigma_a: sigma_t * exponent.exp(),
        sigma_s: -sigma_t * exponent.exp_m1(),
        g: 0.0,
        eta: 1.0,
    }
}
