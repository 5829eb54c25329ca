//! The albedo a dense medium shows, and the single-scattering albedo behind it.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `rho` | ρ | multi-scatter albedo: share of diffuse light a semi-infinite, index-matched medium returns |
//! | `rho_ss` | ρ_ss = σs/σt | single-scattering albedo |
//! | `s` | s | van de Hulst's similarity parameter √((1 − ρ_ss)/(1 − g ρ_ss)) |
//!
//! Forward: ρ = (1 − s)(1 − 0.139 s)/(1 + 1.17 s), van de Hulst 1980; within 0.002 of the exact spherical albedo. Back:
//! Kulla & Conty 2017, as KHR_materials_scatter and OpenPBR print it,
//! s = 4.09712 + 4.20863 ρ − √(9.59217 + 41.6808 ρ + 17.7126 ρ²), ρ_ss = (1 − s²)/(1 − g s²). The printed constants are
//! rounded: ρ = 0 gives ρ_ss = 6e-6 and ρ = 1 gives 1 − 3e-11. KHR_materials_volume_scatter takes g = 0 always.

use glam::Vec3;

/// Single-scattering albedo of the multi-scatter albedo `rho` in \[0, 1\] (clamped) for mean cosine `g`.
pub fn single_from_multiple(rho: f32, g: f32) -> f32 {
    let s2 = similarity(rho);
    ((1.0 - s2) / (1.0 - f64::from(g) * s2)).clamp(0.0, 1.0) as f32
}

/// 1 − ρ_ss for the same arguments as [`single_from_multiple`], accurate where ρ_ss rounds to 1: absorption is this
/// times extinction.
pub fn absorbed_from_multiple(rho: f32, g: f32) -> f32 {
    let s2 = similarity(rho);
    let g = f64::from(g);
    (s2 * (1.0 - g) / (1.0 - g * s2)).clamp(0.0, 1.0) as f32
}

/// s² of the printed fit.
fn similarity(rho: f32) -> f64 {
    // In f64: near ρ = 1 the root cancels all but five digits of its neighbours.
    let rho = f64::from(rho.clamp(0.0, 1.0));
    let s = 4.09712 + 4.20863 * rho - (9.59217 + 41.6808 * rho + 17.7126 * rho * rho).sqrt();
    s * s
}

/// Multi-scatter albedo of the single-scattering albedo `rho_ss` in \[0, 1\] (clamped) for mean cosine `g`.
pub fn multiple_from_single(rho_ss: f32, g: f32) -> f32 {
    let (a, g) = (f64::from(rho_ss.clamp(0.0, 1.0)), f64::from(g));
    let s = ((1.0 - a) / (1.0 - g * a)).max(0.0).sqrt();
    ((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)) as f32
}

/// [`single_from_multiple`] for each channel.
pub fn single_from_multiple_rgb(rho: Vec3, g: f32) -> Vec3 {
    rho.map(|c| single_from_multiple(c, g))
}

/// [`multiple_from_single`] for each channel.
pub fn multiple_from_single_rgb(rho_ss: Vec3, g: f32) -> Vec3 {
    rho_ss.map(|c| multiple_from_single(c, g))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (ρ, g, ρ_ss) from the table of closed forms "Multi-scatter albedo -> single-scatter albedo".
    const INVERSION: [(f64, f64, f64); 9] = [
        (0.05, -0.5, 0.1571008677020195),
        (0.05, 0.0, 0.21848890339937685),
        (0.05, 0.8, 0.5829617889933236),
        (0.5, -0.5, 0.8731625921223022),
        (0.5, 0.0, 0.9117088547474039),
        (0.5, 0.8, 0.9809997262025274),
        (0.99, -0.5, 0.9999716311040537),
        (0.99, 0.0, 0.9999810872238577),
        (0.99, 0.8, 0.9999962173875397),
    ];

    /// (ρ_ss, g, ρ) from "van de Hulst forward albedo fit".
    const FORWARD: [(f64, f64, f64); 6] = [
        (0.1, 0.0, 0.021114018725037355),
        (0.5, 0.0, 0.14453194209500128),
        (0.8, 0.0, 0.3403427867359278),
        (0.9, 0.0, 0.4771700896854276),
        (0.99, 0.0, 0.7945299910474485),
        (0.999, 0.0, 0.9297221927241734),
    ];

    #[test]
    fn inversion_matches_high_precision_values() {
        for (rho, g, expected) in INVERSION {
            let got = f64::from(single_from_multiple(rho as f32, g as f32));
            assert!((got - expected).abs() < 1e-6, "{rho} {g}: {got} for {expected}");
        }
    }

    #[test]
    fn forward_matches_high_precision_values() {
        for (rho_ss, g, expected) in FORWARD {
            let got = f64::from(multiple_from_single(rho_ss as f32, g as f32));
            assert!((got - expected).abs() < 1e-6, "{rho_ss} {g}: {got} for {expected}");
        }
    }

    /// The constants of the inverse are rounded, which costs 1e-5.
    #[test]
    fn there_and_back() {
        for g in [-0.5, 0.0, 0.8] {
            for i in 0..=20 {
                let rho = i as f32 / 20.0;
                let back = multiple_from_single(single_from_multiple(rho, g), g);
                assert!((back - rho).abs() < 2e-5, "{rho} {g}: {back}");
            }
        }
    }
}
