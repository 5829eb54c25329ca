//! What single scattering loses at a rough boundary whose facets have two widths, or a reflectance of their own, and how it
//! comes back: equations (6) to (8) of `docs/boundary.md` with directions in the place of cosines.
//!
//! Let G_r(h) and G_t(h) be the shares of reflected and refracted light that facets of normal h do not mask. A direction
//! loses, E over the normals that it sees and F' the reflectance of facets, 1 where nothing can cross,
//!
//! ```text
//! L = E[F' (1 − G_r) + (1 − F') (1 − G_t)] = E[1 − G_t] + E[F' (G_t − G_r)],
//! ```
//!
//! which is linear in F'. With F' = a + b F + rest, F the exact reflectance of the bare boundary and the rest a sum
//! of hat functions of the cosine outside, L is a sum of numbers that do not depend on the treatment, and tabulated.

use super::anisotropic::{self, Facets};
use super::boundary_tables::{self, SECOND_BOUNCE_ALPHA};
use super::facet_tables::{At, FacetTables, HATS, VISIBLE, hat, visible_normals};
use super::fresnel::{self, Interface};
use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::FRAC_1_PI;
use std::sync::{Mutex, PoisonError};

/// The loss for F' = 0, the factors of a and b, those of what is masked after reflection, and those of hats.
const NUMBERS: usize = 5 + HATS;

/// F' = a + b F + rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Treatment {
    pub(super) a: Vec3,
    pub(super) b: Vec3,
    /// Values at the nodes of the hats.
    pub(super) rest: Option<[Vec3; HATS]>,
}

/// Losses of one boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Losses {
    treatment: Treatment,
    /// For the rarer and for the denser side.
    sides: [At<NUMBERS>; 2],
    /// A.
    total: [Vec3; 2],
    /// Share of what is lost that leaves on the other side.
    transmitted: [Vec3; 2],
}

/// For light from the rarer and from the denser side, kept for the life of the process.
fn tables(eta: f32) -> &'static [FacetTables<NUMBERS>; 2] {
    static ALL: Mutex<Option<HashMap<u32, &'static [FacetTables<NUMBERS>; 2]>>> = Mutex::new(None);
    let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
    all.get_or_insert_default()
        .entry(eta.to_bits())
        .or_insert_with(|| Box::leak(Box::new([FacetTables::new(eta), FacetTables::new(1.0 / eta)])))
}

impl Losses {
    /// Of rough facets at a boundary of index `eta`, either side over the other.
    pub(super) fn new(eta: f32, facets: &Facets, treatment: Treatment) -> Self {
        let eta = boundary_tables::rounded(eta);
        let kappa = boundary_tables::correlation(eta);
        let [rare, dense] = tables(eta);
        let sides = [
            rare.at(facets, |facets, w| numbers(facets, w, eta, kappa)),
            dense.at(facets, |facets, w| numbers(facets, w, 1.0 / eta, kappa)),
        ];
        let total = [0, 1].map(|side| treatment.loss(&sides[side].average).max(Vec3::ZERO));
        let mut losses = Self { treatment, sides, total, transmitted: [Vec3::ZERO; 2] };
        let (eta2, alpha) = (eta * eta, facets.mean_width(anisotropic::REFLECTED));
        // A rest has no table of its own here, where only shares of a share depend on it.
        let rest = treatment.rest_average();
        let masked = &sides[0].average;
        let reflected = (treatment.a + rest) * masked[3] + treatment.b * masked[4];
        let outside = treatment.a + rest + treatment.b * fresnel::diffuse_reflectance(eta);
        let outside = outside.clamp(Vec3::ZERO, Vec3::ONE);
        let stays = reflected * outside.powf(alpha / (alpha + SECOND_BOUNCE_ALPHA));
        let exchange = (total[0] - stays).clamp(Vec3::ZERO, total[0].min(eta2 * total[1]));
        let share = |total: Vec3| (exchange / total.max(Vec3::splat(f32::MIN_POSITIVE))).min(Vec3::ONE);
        losses.transmitted = [share(total[0]), share(eta2 * total[1])];
        losses
    }

    /// L of a turned direction that sees one side.
    pub(super) fn lost(&self, side: usize, w: Vec3) -> Vec3 {
        self.treatment.loss(&self.sides[side].towards(w)).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// The mean over channels of A.
    pub(super) fn average(&self, side: usize) -> f32 {
        self.total[side].element_sum() * (1.0 / 3.0)
    }

    /// The mean share of what is lost on a side that leaves on the other.
    pub(super) fn crossing(&self, side: usize) -> f32 {
        self.transmitted[side].element_sum() * (1.0 / 3.0)
    }

    /// Energy per steradian that comes back to the turned direction `i` (below: on the other side) of the share `lost` of
    /// light from the side `here`.
    pub(super) fn again(&self, here: usize, lost: Vec3, i: Vec3) -> Vec3 {
        let (share, there) = if i.z < 0.0 {
            (self.transmitted[here], 1 - here)
        } else {
            (Vec3::ONE - self.transmitted[here], here)
        };
        let total = self.total[there].max(Vec3::splat(f32::MIN_POSITIVE));
        share * lost * self.lost(there, i) / total * (i.z.abs() * FRAC_1_PI)
    }
}

impl Treatment {
    fn loss(&self, n: &[f32; NUMBERS]) -> Vec3 {
        let plain = n[0] + self.a * n[1] + self.b * n[2];
        match &self.rest {
            Some(rest) => plain + rest.iter().zip(&n[5..]).map(|(&rest, &n)| rest * n).sum::<Vec3>(),
            None => plain,
        }
    }

    /// ∫ 2c rest dc.
    fn rest_average(&self) -> Vec3 {
        const STEP: f32 = 1.0 / (HATS - 1) as f32;
        let weight = |k: usize| match k {
            0 => STEP * STEP / 3.0,
            k if k + 1 == HATS => STEP * (1.0 - STEP / 3.0),
            k => 2.0 * STEP * STEP * k as f32,
        };
        self.rest.map_or(Vec3::ZERO, |rest| (0..HATS).map(|k| weight(k) * rest[k]).sum())
    }
}

fn numbers(facets: &Facets, w: Vec3, eta: f32, kappa: f32) -> [f32; NUMBERS] {
    let mut sum = [0.0; NUMBERS];
    let seen = facets.masking(w);
    visible_normals(facets, w, |h| {
        let c = w.dot(h).clamp(0.0, 1.0);
        let Interface { reflectance, g } = fresnel::interface(c, eta);
        let mirrored = 2.0 * c * h - w;
        let back = if mirrored.z > 0.0 { facets.masking(mirrored) } else { 0.0 };
        if g <= 0.0 {
            sum[0] += VISIBLE * (1.0 - back);
            return;
        }
        let refracted = fresnel::refract_with(w, h, c, g, eta);
        let through = if refracted.z < 0.0 {
            let out = facets.masking(refracted);
            (1.0 - kappa) * out + kappa * (out / seen.max(f32::MIN_POSITIVE)).min(1.0)
        } else {
            0.0
        };
        let more = VISIBLE * (through - back);
        // Of the angle outside: Snell's g is η cos θ_t.
        let (k, t) = hat(if eta > 1.0 { c } else { g / eta });
        sum[0] += VISIBLE * (1.0 - through);
        sum[1] += more;
        sum[2] += more * reflectance;
        sum[3] += VISIBLE * (1.0 - back);
        sum[4] += VISIBLE * (1.0 - back) * reflectance;
        sum[5 + k] += more * (1.0 - t);
        sum[6 + k] += more * t;
    });
    sum
}
