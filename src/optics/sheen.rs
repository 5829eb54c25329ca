//! `KHR_materials_sheen`: fibres that stand on the surface (Conty Estevez & Kulla 2017, "Production Friendly Microfacet
//! Sheen BRDF"), f = color D/(4 µ_o µ_i (1 + Λ(µ_o) + Λ(µ_i))).
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `alpha` | α = `sheenRoughness`² | how far fibres lean |
//! | `distribution` | D = (2 + 1/α) sin^(1/α) θ_h/(2π) | directions of fibres |
//! | `lambda` | Λ | the paper's fit to the masking of fibres |
//! | `raw` | E₀(µ) | share reflected by white fibres, tabulated by quadrature |
//! | `albedo` | E(µ) | the same, of the fibres that are rendered |
//!
//! The fit is poor for fibres that stand upright: near the horizon E₀ reaches 1.1 at roughness 0.2 and 4 at 0.05. So that
//! no energy is made, the lobe is divided by max(1, E₀(µ_o), E₀(µ_i)), which is reciprocal.

use super::base::Spread;
use super::top::{self, TopTable, mix};
use super::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::OnceLock;

/// Smaller roughnesses reflect at the horizon only: fibres of this one 0.03 % at 17° above it.
const LEAST_ROUGHNESS: f32 = 0.05;
/// Roughnesses of the tables, geometric: the height of the fibres' lobe goes with a power of it.
const SLICES: usize = 40;

/// Fibres at one point.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    color: Vec3,
    roughness: f32,
}

/// What fibres of one roughness reflect: by the paper's lobe, and by that which conserves energy.
struct Slice {
    raw: TopTable,
    kept: TopTable,
}

fn slice(j: usize) -> &'static Slice {
    static ALL: [OnceLock<Slice>; SLICES] = [const { OnceLock::new() }; SLICES];
    ALL[j].get_or_init(|| {
        let roughness = LEAST_ROUGHNESS.powf(1.0 - j as f32 / (SLICES - 1) as f32);
        let alpha = roughness * roughness;
        let raw = TopTable::new(|mu| albedo(mu, |o, i| value(o, i, alpha)));
        let held = |mu| raw.albedo(mu).max(1.0);
        let kept =
            TopTable::new(|mu| albedo(mu, |o, i| value(o, i, alpha) / held(o.z).max(held(i.z))).min(1.0));
        Slice { raw, kept }
    })
}

/// ∫ f cos θ_i dω_i by the midpoint rule, of a lobe `f_cos` that is even in the azimuth.
fn albedo(mu: f32, f_cos: impl Fn(Vec3, Vec3) -> f32) -> f32 {
    const POLAR: usize = 96;
    const AZIMUTH: usize = 32;
    let mu = mu.max(LEAST_COSINE);
    let o = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let mut sum = 0.0;
    for a in 0..POLAR {
        let theta = FRAC_PI_2 * (a as f32 + 0.5) / POLAR as f32;
        let (sin, cos) = theta.sin_cos();
        for b in 0..AZIMUTH {
            let phi = 0.5 * TAU * (b as f32 + 0.5) / AZIMUTH as f32;
            let i = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
            sum += f_cos(o, i) * sin;
        }
    }
    sum * FRAC_PI_2 / POLAR as f32 * TAU / AZIMUTH as f32
}

/// Directions nearer to the horizon are taken to be here, where the lobe is finite.
const LEAST_COSINE: f32 = 1e-3;

fn distribution(h: Vec3, alpha: f32) -> f32 {
    let sin = (h.x * h.x + h.y * h.y).max(0.0).sqrt();
    (2.0 + 1.0 / alpha) * sin.powf(1.0 / alpha) / TAU
}

fn lambda(mu: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let (a, b) = (mix(21.5473, 25.3245, t), mix(3.82987, 3.32435, t));
    let (c, d, e) = (mix(0.19823, 0.16801, t), mix(-1.97760, -1.27393, t), mix(-4.32054, -4.85967, t));
    let l = |x: f32| a / (1.0 + b * x.powf(c)) + d * x + e;
    if mu < 0.5 { l(mu).exp() } else { (2.0 * l(0.5) - l(1.0 - mu)).exp() }
}

/// f·cos θ_i of white fibres, as the paper has them.
fn value(o: Vec3, i: Vec3, alpha: f32) -> f32 {
    let h = (o + i).normalize_or(Vec3::Z);
    let seen = 1.0 + lambda(o.z, alpha) + lambda(i.z, alpha);
    distribution(h, alpha) / (4.0 * o.z.max(LEAST_COSINE) * seen)
}

impl Sheen {
    /// Fibres of a linear colour in \[0, 1\] and a roughness (α is its square) in \[0, 1\].
    pub fn new(color: Vec3, roughness: f32) -> Self {
        Self { color: color.clamp(Vec3::ZERO, Vec3::ONE), roughness: roughness.clamp(LEAST_ROUGHNESS, 1.0) }
    }

    fn table(&self, get: impl Fn(&Slice) -> f32) -> f32 {
        let (j, t) = top::slice(1.0 - self.roughness.ln() / LEAST_ROUGHNESS.ln(), SLICES);
        mix(get(slice(j)), get(slice(j + 1)), t)
    }

    /// E of the strongest channel.
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        self.color.max_element() * self.table(|s| s.kept.albedo(mu))
    }

    /// R, of the strongest channel, of a base that spreads light so, for a direction turned to its facets.
    pub(super) fn residue(&self, w: Vec3, spread: &Spread) -> f32 {
        self.color.max_element() * self.table(|s| s.kept.base_residue(w, spread))
    }

    /// f·cos θ_i, both directions above the surface.
    pub(super) fn eval(&self, o: Vec3, i: Vec3) -> Vec3 {
        let held = self.table(|s| s.raw.albedo(o.z).max(s.raw.albedo(i.z)));
        self.color * (value(o, i, self.roughness * self.roughness) / held.max(1.0))
    }

    /// A direction uniform over the hemisphere, whose density is 1/2π: fibres reflect at grazing angles.
    pub(super) fn sample(u: Vec2) -> Vec3 {
        warp::uniform_hemisphere(u)
    }
}

#[cfg(test)]
#[path = "sheen_tests.rs"]
mod tests;
