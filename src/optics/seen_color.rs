//! From the colour one wants to see to the medium that shows it, with the boundary accounted for.
//!
//! The *seen colour* C of a half space is what it shows under uniform light, viewed straight on, without the reflection of
//! its surface, over what a white medium would show there: of the light that crosses the surface along the normal, the share
//! that comes out again. It is what OpenPBR defines `subsurface_color` to mean, and what the base colour of an opaque
//! dielectric is in glTF: C = 1 is white whatever the index, and the whole surface shows F + (1 − F) C.
//!
//! The multi-scatter albedo ρ of the Khronos drafts leaves the boundary out. Under an index of 1.5 most of the light that
//! arrives from inside is turned back, so ρ = 0.5 shows C = 0.25. Here C comes from
//! [`half_space_color`](super::diffusion::discrete_ordinates), and is inverted by regula falsi (Illinois) in van de Hulst's
//! s, in which 1 − C is nearly linear.

use super::diffusion::discrete_ordinates::{HalfSpace, half_space_color};

/// Change of s at which the inversion ends, relative to s, and most of its steps.
const CONVERGED: f64 = 1e-10;
const MOST_STEPS: usize = 60;

/// The seen colour, in \[0, 1\], of a medium of single-scattering `albedo` in \[0, 1\] and mean cosine `g` in (−1, 1) behind
/// a smooth boundary of relative index `eta` ≥ 1.
pub fn seen_color(albedo: f64, g: f64, eta: f64) -> f64 {
    half_space_color(albedo, g, eta).normal
}

/// σs/σt and σa/σt of the medium that shows the colour `color` in \[0, 1\] (clamped), for mean cosine `g` in (−1, 1) and
/// relative index `eta` ≥ 1. Each is accurate where it is small.
pub fn shares_of_seen_color(color: f64, g: f64, eta: f64) -> [f64; 2] {
    let half_space = HalfSpace::new(g, eta);
    let color = color.clamp(0.0, 1.0);
    let absorbed = |s: f64| s * s * (1.0 - g) / (1.0 - g * s * s);
    let excess = |s: f64| half_space.color(absorbed(s)).normal - color;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut at_low, mut at_high) = (1.0 - color, -color);
    for _ in 0..MOST_STEPS {
        if at_low <= 0.0 || at_high >= 0.0 || high - low <= CONVERGED * high {
            break;
        }
        let s = low + (high - low) * at_low / (at_low - at_high);
        let value = excess(s);
        if value > 0.0 {
            (low, at_low) = (s, value);
            at_high *= 0.5;
        } else {
            (high, at_high) = (s, value);
            at_low *= 0.5;
        }
        if value.abs() < CONVERGED {
            (low, high) = (s, s);
        }
    }
    let s = if at_low <= 0.0 {
        low
    } else if at_high >= 0.0 {
        high
    } else {
        0.5 * (low + high)
    };
    let share = absorbed(s);
    [1.0 - share, share]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_come_back() {
        for (g, eta) in [(0.0, 1.0), (0.0, 1.5), (-0.5, 1.33), (0.9, 1.6)] {
            for color in [0.0, 0.02, 0.4, 0.9, 0.99, 1.0] {
                let [scattered, absorbed] = shares_of_seen_color(color, g, eta);
                assert!((scattered + absorbed - 1.0).abs() < 1e-12);
                let back = seen_color(scattered, g, eta);
                assert!((back - color).abs() < 1e-7, "{color} {g} {eta}: {back} by {scattered}");
            }
        }
    }

    /// What the specification of the extension says: ρ = 0.5 is seen as about 0.25 under an index of 1.5. Its figure adds
    /// the reflection at the surface and takes diffuse light.
    #[test]
    fn a_multi_scatter_albedo_of_one_half_is_seen_as_a_quarter() {
        let albedo = crate::optics::diffusion::inversion::single_from_similarity(
            crate::optics::diffusion::inversion::similarity(0.5),
            0.0,
        );
        println!("{:?}", half_space_color(albedo, 0.0, 1.5));
        assert!((seen_color(albedo, 0.0, 1.5) - 0.247).abs() < 0.001, "{}", seen_color(albedo, 0.0, 1.5));
        assert!((seen_color(albedo, 0.0, 1.0) - 0.5).abs() < 0.07, "{}", seen_color(albedo, 0.0, 1.0));
    }
}
