//! `KHR_materials_sheen`: fibres that stand on the surface (Conty Estevez & Kulla 2017, "Production Friendly Microfacet
//! Sheen BRDF"), f = color D/(4 µ_o µ_i (1 + Λ(µ_o) + Λ(µ_i))).
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `distribution` | D = (2 + 1/r) sin^(1/r) θ_h/(2π) | fibres of roughness r |
//! | `lambda` | Λ | the paper's fit to the masking of fibres |
//! | `albedo` | E(µ) | share reflected by white fibres, tabulated by quadrature |
//!
//! The published table of E (Dassault Systèmes, Enterprise PBR, §6.2.3) is what the tests hold this quadrature against.

use super::top::{self, TopTable, mix};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::OnceLock;

/// Smaller roughnesses reflect nothing but at the very horizon.
const LEAST_ROUGHNESS: f32 = 0.05;
const SLICES: usize = 24;

/// Fibres at one point.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    color: Vec3,
    roughness: f32,
}

fn slice(j: usize) -> &'static TopTable {
    static ALL: [OnceLock<TopTable>; SLICES] = [const { OnceLock::new() }; SLICES];
    ALL[j].get_or_init(|| {
        let r = LEAST_ROUGHNESS.max(j as f32 / (SLICES - 1) as f32);
        TopTable::new(|mu| albedo(mu.max(1e-3), r))
    })
}

/// ∫ D/(4 µ_o (1 + Λ_o + Λ_i)) dω_i, by the midpoint rule.
fn albedo(mu: f32, r: f32) -> f32 {
    const POLAR: usize = 48;
    const AZIMUTH: usize = 24;
    let o = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let mut sum = 0.0;
    for a in 0..POLAR {
        let theta = FRAC_PI_2 * (a as f32 + 0.5) / POLAR as f32;
        let (sin, cos) = theta.sin_cos();
        for b in 0..AZIMUTH {
            let phi = 0.5 * TAU * (b as f32 + 0.5) / AZIMUTH as f32;
            let i = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
            sum += value(o, i, r) * sin;
        }
    }
    sum * FRAC_PI_2 / POLAR as f32 * TAU / AZIMUTH as f32
}

fn distribution(h: Vec3, r: f32) -> f32 {
    let sin = (h.x * h.x + h.y * h.y).max(0.0).sqrt();
    (2.0 + 1.0 / r) * sin.powf(1.0 / r) / TAU
}

fn lambda(mu: f32, r: f32) -> f32 {
    let t = (1.0 - r) * (1.0 - r);
    let (a, b) = (mix(21.5473, 25.3245, t), mix(3.82987, 3.32435, t));
    let (c, d, e) = (mix(0.19823, 0.16801, t), mix(-1.97760, -1.27393, t), mix(-4.32054, -4.85967, t));
    let l = |x: f32| a / (1.0 + b * x.powf(c)) + d * x + e;
    if mu < 0.5 { l(mu).exp() } else { (2.0 * l(0.5) - l(1.0 - mu)).exp() }
}

/// f·cos θ_i of white fibres.
fn value(o: Vec3, i: Vec3, r: f32) -> f32 {
    let h = (o + i).normalize_or(Vec3::Z);
    distribution(h, r) / (4.0 * o.z.max(1e-3) * (1.0 + lambda(o.z, r) + lambda(i.z, r)))
}

impl Sheen {
    /// Fibres of a linear colour in \[0, 1\] and a roughness in \[0, 1\].
    pub fn new(color: Vec3, roughness: f32) -> Self {
        Self { color: color.clamp(Vec3::ZERO, Vec3::ONE), roughness: roughness.clamp(LEAST_ROUGHNESS, 1.0) }
    }

    fn table(&self, get: impl Fn(&TopTable) -> f32) -> f32 {
        let (j, t) = top::slice(self.roughness, SLICES);
        mix(get(slice(j)), get(slice(j + 1)), t)
    }

    /// E of the strongest channel.
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        self.color.max_element() * self.table(|t| t.albedo(mu))
    }

    /// R at a cosine, of the strongest channel, on a base of which the share `lambertian` is Lambertian and the rest a metal
    /// of width `alpha`.
    pub(super) fn residue(&self, mu: f32, lambertian: f32, alpha: f32) -> f32 {
        self.color.max_element() * self.table(|t| t.base_residue(mu, lambertian, alpha))
    }

    /// f·cos θ_i, both directions above the surface.
    pub(super) fn eval(&self, o: Vec3, i: Vec3) -> Vec3 {
        self.color * value(o, i, self.roughness)
    }

    /// A direction uniform over the hemisphere, whose density is 1/2π: fibres reflect at grazing angles.
    pub(super) fn sample(u: Vec2) -> Vec3 {
        let r = ((1.0 - u.x) * (1.0 + u.x)).max(0.0).sqrt();
        let (sin, cos) = (TAU * u.y).sin_cos();
        Vec3::new(r * cos, r * sin, u.x)
    }
}

#[cfg(test)]
#[path = "sheen_tests.rs"]
mod tests;
