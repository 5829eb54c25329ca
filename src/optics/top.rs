//! What a layer on top of a surface does to the light that meets it, in numbers that depend on one cosine.
//!
//! A layer reflects the share E(µ). The rest passes straight on, meets the base, and has to pass again: a share
//! min(1 − E(µ_o), 1 − E(µ_i)) of what the base reflects from o to i gets out, the largest that is reciprocal and leaves
//! no direction with more than 1 − E (KHR_materials_sheen layers so). It falls short of 1 − E(µ_o) by what a base that
//! reflects the density e_b sends to directions in which the layer holds back more,
//!
//! ```text
//! R(µ_o) = ∫ e_b(o, i) (E(µ_i) − E(µ_o))⁺ dω_i,
//! ```
//!
//! light that is thrown back to the base and comes out at last: layered surfaces return it by the lobe R(µ_o) R(µ_i) µ_i/(π R̄),
//! R̄ = ∫ 2µ R dµ, like Kulla & Conty 2017 what is lost by masking. Nothing comes back from a mirror, whose µ_i is µ_o; for a
//! Lambertian base, and E that falls with µ, R(µ) = ∫₀^µ 2t E(t) dt − µ² E(µ) =: R_L(µ); for a GGX metal R is computed
//! once for each pair of roughnesses ([`facet_residue`]).

use super::ggx;
use super::reflectance::NODES;
use super::reflection_tables::Reflection;
use glam::{Vec2, Vec3};
use std::sync::OnceLock;

/// Cells of a table over the cosine.
const CELLS: usize = 64;

/// Cells over the cosine, and slices over the roughness, of the residue of metals.
const FACET_CELLS: usize = 16;
const FACET_SLICES: usize = 12;

/// E, and R_L, of a layer of one roughness.
pub(super) struct TopTable {
    albedo: [f32; CELLS + 1],
    residue: [f32; CELLS + 1],
    facets: [OnceLock<[f32; FACET_CELLS + 1]>; FACET_SLICES],
}

impl TopTable {
    /// Tabulates `albedo`, a function of the cosine.
    pub(super) fn new(mut albedo: impl FnMut(f32) -> f32) -> Self {
        let mu = |i: usize| i as f32 / CELLS as f32;
        let albedo: [f32; CELLS + 1] = std::array::from_fn(|i| albedo(mu(i)).max(0.0));
        let mut cumulative = 0.0;
        let mut residue = [0.0; CELLS + 1];
        let cell = |f: &[f32; CELLS + 1], i: usize| {
            let (a, b) = (mu(i - 1), mu(i));
            (b - a) * (2.0 * f[i - 1] * a + f[i - 1] * b + f[i] * a + 2.0 * f[i] * b) / 3.0
        };
        for i in 1..=CELLS {
            cumulative += cell(&albedo, i);
            residue[i] = (cumulative - mu(i) * mu(i) * albedo[i]).max(0.0);
        }
        let facets = [const { OnceLock::new() }; FACET_SLICES];
        Self { albedo, residue, facets }
    }

    #[inline]
    fn read(values: &[f32; CELLS + 1], mu: f32) -> f32 {
        let x = mu.clamp(0.0, 1.0) * CELLS as f32;
        let i = (x as usize).min(CELLS - 1);
        values[i] + (x - i as f32) * (values[i + 1] - values[i])
    }

    /// E(µ).
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        Self::read(&self.albedo, mu)
    }

    /// R_L(µ).
    fn residue(&self, mu: f32) -> f32 {
        Self::read(&self.residue, mu)
    }

    /// R(µ) of a base of which the share `lambertian` is Lambertian and the rest a GGX metal of width `alpha`.
    pub(super) fn base_residue(&self, mu: f32, lambertian: f32, alpha: f32) -> f32 {
        let facets = if lambertian < 1.0 { self.facet_residue(alpha, mu) } else { 0.0 };
        mix(facets, self.residue(mu), lambertian)
    }

    /// R(µ) of a GGX metal of width `alpha` below the layer.
    pub(super) fn facet_residue(&self, alpha: f32, mu: f32) -> f32 {
        let (j, t) = slice(alpha, FACET_SLICES);
        let x = mu.clamp(0.0, 1.0) * FACET_CELLS as f32;
        let i = (x as usize).min(FACET_CELLS - 1);
        let at = |j: usize| {
            let width = j as f32 / (FACET_SLICES - 1) as f32;
            let values = self.facets[j].get_or_init(|| {
                std::array::from_fn(|i| facet_residue(self, width, (i as f32 / FACET_CELLS as f32).max(5e-3)))
            });
            mix(values[i], values[i + 1], x - i as f32)
        };
        mix(at(j), at(j + 1), t)
    }
}

/// Where among `count` even slices of \[0, 1\] a parameter is: the slice, and the weight of the next.
#[inline]
pub(super) fn slice(parameter: f32, count: usize) -> (usize, f32) {
    let x = parameter.clamp(0.0, 1.0) * (count - 1) as f32;
    let j = (x as usize).min(count - 2);
    (j, x - j as f32)
}

#[inline]
pub(super) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// R(µ) of a white GGX metal, what it reflects several times included, by the midpoint rule over visible normals.
fn facet_residue(layer: &TopTable, alpha: f32, mu: f32) -> f32 {
    const STEPS: usize = 24;
    if alpha < super::boundary_tables::MIN_ROUGH_ALPHA {
        return 0.0;
    }
    let o = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let held = layer.albedo(mu);
    let more = |mu: f32| (layer.albedo(mu) - held).max(0.0);
    let mut single = 0.0;
    for a in 0..STEPS {
        for b in 0..STEPS {
            let u = Vec2::new(a as f32 + 0.5, b as f32 + 0.5) / STEPS as f32;
            let h = ggx::sample_visible(o, alpha, u);
            let i = 2.0 * o.dot(h) * h - o;
            if i.z > 0.0 {
                single += ggx::masking(i, alpha) * more(i.z);
            }
        }
    }
    let reflection = Reflection::at(alpha);
    let lost = |mu| reflection.directional(mu).lost;
    let again: f32 = NODES.iter().map(|&(t, w)| 2.0 * t * w * lost(t) * more(t)).sum();
    single / (STEPS * STEPS) as f32 + lost(mu) * again / reflection.lost_average.max(1e-6)
}
