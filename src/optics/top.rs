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
//! light that is thrown back to the base and comes out at last: layered surfaces return it by the lobe R(µ_o) R(µ_i)
//! µ_i/(π R̄), R̄ = ∫ R µ dω/π, like Kulla & Conty 2017 what is lost by masking. Nothing comes back from a mirror,
//! whose µ_i is µ_o; for a Lambertian base, and E that falls with µ, R(µ) = ∫₀^µ 2t (E(t) − E(µ)) dt =: R_L(µ). Below a
//! dielectric's coat light leaves with 1 − p (1 − µ)⁵ in the place of 1, which takes R_S, the same integral weighed by
//! (1 − t)⁵. For a GGX metal R is computed once for each pair of widths, by the direction ([`facet_residue`]).

use super::anisotropic::Facets;
use super::base::Spread;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::facet_reflection::FacetReflection;
use super::fresnel::{SCHLICK_AVERAGE, schlick_weight};
use super::reflectance::NODES;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Cells of a table over the cosine; nodes are squares, since layers change most near the horizon.
const CELLS: usize = 64;

/// Cells over the cosine and over a quarter of the azimuth, and slices over each width, of the residue of metals.
const FACET_CELLS: usize = 20;
const FACET_AZIMUTHS: usize = 8;
const FACET_SLICES: usize = 17;
/// R of metals of one pair of widths.
type FacetResidue = [[f32; FACET_AZIMUTHS + 1]; FACET_CELLS + 1];

/// Azimuths of a midpoint rule for a quarter of a turn, where averages are taken.
pub(super) const QUARTER: [f32; 4] = [0.196_349_54, 0.589_048_6, 0.981_747_7, 1.374_446_8];

/// E, R_L and R_S of a layer of one roughness.
pub(super) struct TopTable {
    albedo: [f32; CELLS + 1],
    residue: [f32; CELLS + 1],
    schlick: [f32; CELLS + 1],
    facets: [[OnceLock<Box<FacetResidue>>; FACET_SLICES]; FACET_SLICES],
}

impl TopTable {
    /// Tabulates `albedo`, a function of the cosine.
    pub(super) fn new(mut albedo: impl FnMut(f32) -> f32) -> Self {
        let mu = |i: usize| (i as f32 / CELLS as f32).powi(2);
        let albedo: [f32; CELLS + 1] = std::array::from_fn(|i| albedo(mu(i)).max(0.0));
        let more = |weight: &dyn Fn(f32) -> f32| -> [f32; CELLS + 1] {
            // ∫₀^µ 2t w dt and ∫₀^µ 2t w E dt, E linear in each cell.
            let (mut base, mut held) = (0.0, 0.0);
            std::array::from_fn(|i| {
                if i > 0 {
                    let width = mu(i) - mu(i - 1);
                    for (x, w) in NODES {
                        let t = mu(i - 1) + width * x;
                        let part = 2.0 * t * w * width * weight(t);
                        base += part;
                        held += part * mix(albedo[i - 1], albedo[i], x);
                    }
                }
                (held - base * albedo[i]).max(0.0)
            })
        };
        let (residue, schlick) = (more(&|_| 1.0), more(&schlick_weight));
        let facets = [const { [const { OnceLock::new() }; FACET_SLICES] }; FACET_SLICES];
        Self { albedo, residue, schlick, facets }
    }

    #[inline]
    fn read(values: &[f32; CELLS + 1], mu: f32) -> f32 {
        let (i, t) = square_cell(mu, CELLS);
        values[i] + t * (values[i + 1] - values[i])
    }

    /// E(µ).
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        Self::read(&self.albedo, mu)
    }

    /// R of a base that spreads light so, for the direction `w`, turned to its facets.
    pub(super) fn base_residue(&self, w: Vec3, spread: &Spread) -> f32 {
        let diffuse = if spread.diffuse > 0.0 {
            let p = spread.grazing;
            let all = Self::read(&self.residue, w.z) - p * Self::read(&self.schlick, w.z);
            spread.diffuse * all / (1.0 - p * SCHLICK_AVERAGE)
        } else {
            0.0
        };
        let specular = 1.0 - spread.diffuse;
        diffuse + if specular > 0.0 { specular * self.facet_residue(spread.facets.alpha, w) } else { 0.0 }
    }

    /// R of a GGX metal of these widths below the layer.
    fn facet_residue(&self, alpha: Vec2, w: Vec3) -> f32 {
        let (i, s) = square_cell(w.z, FACET_CELLS);
        let y = w.y.abs().atan2(w.x.abs()) / FRAC_PI_2 * FACET_AZIMUTHS as f32;
        let k = (y as usize).min(FACET_AZIMUTHS - 1);
        let t = y - k as f32;
        let of = |along: usize, across: usize| {
            let width = |j: usize| (j as f32 / (FACET_SLICES - 1) as f32).powi(2);
            let r = self.facets[along][across]
                .get_or_init(|| Box::new(facet_residues(self, Vec2::new(width(along), width(across)))));
            mix(mix(r[i][k], r[i][k + 1], t), mix(r[i + 1][k], r[i + 1][k + 1], t), s)
        };
        let [(a, s), (b, t)] = [alpha.x, alpha.y].map(|alpha| square_cell(alpha, FACET_SLICES - 1));
        if alpha.x == alpha.y {
            return mix(of(a, a), of(a + 1, a + 1), s);
        }
        mix(mix(of(a, b), of(a, b + 1), t), mix(of(a + 1, b), of(a + 1, b + 1), t), s)
    }
}

/// Where among `count` even slices of \[0, 1\] a parameter is: the slice, and the weight of the next.
#[inline]
pub(super) fn slice(parameter: f32, count: usize) -> (usize, f32) {
    let x = parameter.clamp(0.0, 1.0) * (count - 1) as f32;
    let j = (x as usize).min(count - 2);
    (j, x - j as f32)
}

/// Where among the squares of `cells` + 1 even numbers from 0 to 1 a number is: the cell, and the place in it.
#[inline]
fn square_cell(x: f32, cells: usize) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0);
    let i = ((x.sqrt() * cells as f32) as usize).min(cells - 1);
    let (from, to) = (i as f32, (i + 1) as f32);
    let x = x * (cells * cells) as f32;
    (i, ((x - from * from) / (to * to - from * from)).clamp(0.0, 1.0))
}

#[inline]
pub(super) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

fn facet_residues(layer: &TopTable, alpha: Vec2) -> FacetResidue {
    let facets = Facets { alpha, tangent: Vec2::X };
    let reflection = FacetReflection::new(
        &Facets { alpha: alpha.max(Vec2::splat(MIN_ROUGH_ALPHA)), tangent: Vec2::X },
        false,
    );
    let smooth = alpha.max_element() < MIN_ROUGH_ALPHA;
    std::array::from_fn(|i| {
        let mu = (i as f32 / FACET_CELLS as f32).powi(2).max(1e-3);
        let mut row = [0.0; FACET_AZIMUTHS + 1];
        for k in 0..=FACET_AZIMUTHS {
            row[k] = if smooth {
                0.0
            } else if k > 0 && alpha.x == alpha.y {
                row[0]
            } else {
                let w = towards(mu, FRAC_PI_2 * k as f32 / FACET_AZIMUTHS as f32);
                facet_residue(layer, &facets, &reflection, w)
            };
        }
        row
    })
}

/// The direction of a cosine and an azimuth.
pub(super) fn towards(mu: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), mu)
}

/// R of a white GGX metal, what it reflects several times included, by the midpoint rule over visible normals.
fn facet_residue(layer: &TopTable, facets: &Facets, reflection: &FacetReflection, o: Vec3) -> f32 {
    const STEPS: usize = 24;
    let held = layer.albedo(o.z);
    let more = |mu: f32| (layer.albedo(mu) - held).max(0.0);
    let mut single = 0.0;
    for a in 0..STEPS {
        for b in 0..STEPS {
            let u = Vec2::new(a as f32 + 0.5, b as f32 + 0.5) / STEPS as f32;
            let h = facets.sample_visible(o, u);
            let i = 2.0 * o.dot(h) * h - o;
            if i.z > 0.0 {
                single += facets.masking(i) * more(i.z);
            }
        }
    }
    let lost = |w| reflection.towards(w).plain.lost;
    let around =
        |mu: f32| QUARTER.iter().map(|&phi| lost(towards(mu, phi))).sum::<f32>() / QUARTER.len() as f32;
    let again: f32 = NODES.iter().map(|&(t, w)| 2.0 * t * w * around(t) * more(t)).sum();
    single / (STEPS * STEPS) as f32 + lost(o) * again / reflection.average().lost.max(1e-6)
}
