//! What single scattering loses at a rough dielectric boundary, and how that energy is shared, over roughness and
//! direction for one relative index. `docs/boundary.md` derives the equations named here.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | side 0, 1 | a, b | the rarer and the denser side |
//! | `eta` | η ≥ 1 | index of the denser side over that of the rarer side |
//! | `correlation` | κ(η) | share of the masking of refracted light that straight-on passage undoes, eq. (5) |
//! | `exchange` | X | transmitted part of the hemispherical loss of side 0; η² times that of side 1, eq. (8) |

use super::lobe::{Lobe, Warp};
use super::loss::Quadrature;
use super::{fresnel, warp};
use glam::Vec3;
use std::cell::Cell;
use std::collections::HashMap;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Least roughness of the tables, and of a boundary that is not taken for smooth.
pub const MIN_ROUGH_ALPHA: f32 = 1e-3;

/// Slices over α from [`MIN_ROUGH_ALPHA`] to 1.
const SLICES: usize = 96;

/// Share of the slices spaced geometrically; the rest are spaced evenly.
const GEOMETRIC_SHARE: f32 = 0.75;

/// Position of roughness `alpha` among the slices, 0 to 1, increasing.
#[inline]
fn position(alpha: f32) -> f32 {
    let geometric = 1.0 - alpha.ln() / MIN_ROUGH_ALPHA.ln();
    let even = (alpha - MIN_ROUGH_ALPHA) / (1.0 - MIN_ROUGH_ALPHA);
    GEOMETRIC_SHARE * geometric + (1.0 - GEOMETRIC_SHARE) * even
}

/// Roughness of slice `j`.
fn slice_alpha(j: usize) -> f32 {
    let target = j as f32 / (SLICES - 1) as f32;
    let (mut low, mut high) = (MIN_ROUGH_ALPHA, 1.0f32);
    for _ in 0..40 {
        let mid = 0.5 * (low + high);
        if position(mid) < target {
            low = mid;
        } else {
            high = mid;
        }
    }
    if j + 1 == SLICES { 1.0 } else { low }
}

/// Tables are built for η rounded to a multiple of this, so that nearly equal indices share one.
const ETA_STEP: f32 = 1.0 / 16_384.0;

/// Decay of the correlation κ = exp(−(η − 1)/0.3), fitted to walks on the microsurface (`docs/boundary.md` §4).
const CORRELATION_DECAY: f32 = 0.3;

/// How the chance that reflected light, once masked, still leaves as reflection changes from its smooth to its rough
/// limit: F_dr^(α/(α + 0.12)), fitted to walks on the microsurface (`docs/boundary.md` §5).
pub(super) const SECOND_BOUNCE_ALPHA: f32 = 0.12;

/// κ(η) of eq. (5), for η on either side of 1.
#[inline]
pub(super) fn correlation(eta: f32) -> f32 {
    (-(eta.max(1.0 / eta) - 1.0) / CORRELATION_DECAY).exp()
}

/// The index, or its inverse if it is below 1, for which there are tables.
pub(super) fn rounded(eta: f32) -> f32 {
    (eta.max(1.0 / eta) / ETA_STEP).round().max(1.0 / ETA_STEP + 1.0) * ETA_STEP
}

/// One roughness.
struct Slice {
    sides: [Lobe; 2],
    exchange: f32,
}

/// Loss and exchange of a rough boundary of one relative index, for every roughness. Slices are made when a roughness
/// first needs them: most scenes need few of them.
pub struct BoundaryTables {
    eta: f32,
    alphas: [f32; SLICES],
    slices: [OnceLock<Slice>; SLICES],
}

impl BoundaryTables {
    /// The tables for relative index `eta` (> 0; an index and its inverse share tables).
    ///
    /// Kept for the life of the process, up to 170 kB each. Later calls from the same thread take no lock as long as it
    /// uses few indices.
    pub fn get(eta: f32) -> &'static Self {
        const RECENT: usize = 4;
        type Entry = (f32, Option<&'static BoundaryTables>);
        thread_local! {
            static LATEST: Cell<[Entry; RECENT]> = const { Cell::new([(0.0, None); RECENT]) };
        }
        let recent = LATEST.get();
        for (key, tables) in recent {
            if let (true, Some(tables)) = (key == eta, tables) {
                return tables;
            }
        }
        let tables = Self::shared(eta);
        let mut updated = recent;
        updated.rotate_right(1);
        updated[0] = (eta, Some(tables));
        LATEST.set(updated);
        tables
    }

    fn shared(eta: f32) -> &'static Self {
        static ALL: Mutex<Option<HashMap<u32, &'static BoundaryTables>>> = Mutex::new(None);
        let eta = rounded(eta);
        let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
        all.get_or_insert_default()
            .entry(eta.to_bits())
            .or_insert_with(|| Box::leak(Box::new(Self::new(eta))))
    }

    /// The tables for `eta` > 1.
    pub fn new(eta: f32) -> Self {
        Self {
            eta,
            alphas: std::array::from_fn(slice_alpha),
            slices: std::array::from_fn(|_| OnceLock::new()),
        }
    }

    /// Slice `j`; the same on every machine, whichever thread makes it.
    #[inline]
    fn slice(&self, j: usize) -> &Slice {
        self.slices[j].get_or_init(|| Slice::new(self.alphas[j], self.eta))
    }

    /// The index these tables were built for, ≥ 1: a multiple of 2⁻¹⁴ for those from [`BoundaryTables::get`].
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// The compensation at roughness `alpha` in \[[`MIN_ROUGH_ALPHA`], 1\] (clamped).
    #[inline]
    pub(super) fn at(&self, alpha: f32) -> Compensation<'_> {
        let slices = self.between(alpha);
        self.compensation([slices; 2])
    }

    #[inline]
    fn between(&self, alpha: f32) -> Between<'_> {
        let alpha = alpha.clamp(MIN_ROUGH_ALPHA, 1.0);
        let guess = (position(alpha) * (SLICES - 1) as f32) as usize;
        let mut j = guess.min(SLICES - 2);
        if alpha < self.alphas[j] {
            j = j.saturating_sub(1);
        } else if alpha > self.alphas[j + 1] {
            j = (j + 1).min(SLICES - 2);
        }
        let (low, high) = (self.slice(j), self.slice(j + 1));
        let (from, to) = (self.alphas[j], self.alphas[j + 1]);
        let t = ((alpha - from) / (to - from)).clamp(0.0, 1.0);
        Between { low, high, t }
    }

    #[inline]
    fn compensation<'a>(&self, slices: [Between<'a>; 2]) -> Compensation<'a> {
        let total = [slices[0].mix(|s| s.sides[0].total()), slices[1].mix(|s| s.sides[1].total())];
        let feasible = total[0].min(self.eta * self.eta * total[1]);
        let exchange = slices[0].mix(|s| s.exchange).min(feasible);
        let share = |x: f32, a: f32| (x / a.max(f32::MIN_POSITIVE)).min(1.0);
        let transmitted = [share(exchange, total[0]), share(exchange / (self.eta * self.eta), total[1])];
        Compensation { slices, total, transmitted }
    }
}

impl Slice {
    #[cold]
    fn new(alpha: f32, eta: f32) -> Self {
        let (rare, dense) = (Quadrature::<12, 12>::new(), Quadrature::<10, 12>::new());
        let kappa = correlation(eta);
        let mut reflected = 0.0;
        let mut last = (0.0, 0.0);
        let outside = Lobe::new(Warp::new(alpha, eta), |mu| {
            let lost = rare.lost(mu, alpha, eta, kappa);
            reflected += (mu - last.0) * (mu * lost.reflected + last.0 * last.1);
            last = (mu, lost.reflected);
            lost.reflected + lost.refracted
        });
        let inside = Lobe::new(Warp::new(alpha, 1.0 / eta), |mu| {
            let lost = dense.lost(mu, alpha, 1.0 / eta, kappa);
            lost.reflected + lost.refracted
        });
        let average = fresnel::diffuse_reflectance(eta);
        let stays = reflected * average.powf(alpha / (alpha + SECOND_BOUNCE_ALPHA));
        let feasible = outside.total().min(eta * eta * inside.total());
        let exchange = (outside.total() - stays).clamp(0.0, feasible);
        Self { sides: [outside, inside], exchange }
    }
}

impl std::fmt::Debug for BoundaryTables {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BoundaryTables").field("eta", &self.eta).finish_non_exhaustive()
    }
}

/// A roughness between those of two slices.
#[derive(Clone, Copy)]
struct Between<'a> {
    low: &'a Slice,
    high: &'a Slice,
    t: f32,
}

impl Between<'_> {
    #[inline]
    fn mix(&self, f: impl Fn(&Slice) -> f32) -> f32 {
        f(self.low) * (1.0 - self.t) + f(self.high) * self.t
    }
}

/// Loss and exchange at one roughness, or one for light from each side: linear between two slices.
#[derive(Clone, Copy)]
pub(super) struct Compensation<'a> {
    slices: [Between<'a>; 2],
    /// A_a.
    pub(super) total: [f32; 2],
    /// τ_a: the share of the lost light of side a that leaves on the other side.
    pub(super) transmitted: [f32; 2],
}

impl Compensation<'_> {
    /// L_a(µ).
    #[inline]
    pub(super) fn loss(&self, side: usize, mu: f32) -> f32 {
        self.slices[side].mix(|s| s.sides[side].loss(mu))
    }

    /// A cosine on side a with density 2µ L_a(µ)/A_a; `u` in \[0, 1).
    #[inline]
    pub(super) fn sample(&self, side: usize, u: f32) -> f32 {
        let slices = &self.slices[side];
        let low = (1.0 - slices.t) * slices.low.sides[side].total();
        let high = slices.t * slices.high.sides[side].total();
        let x = u * (low + high);
        if x < low {
            slices.low.sides[side].sample(x / low)
        } else {
            slices.high.sides[side].sample(((x - low) / high.max(f32::MIN_POSITIVE)).min(1.0))
        }
    }

    /// Energy per steradian and unit cosine of arrival that compensation sends from cosine `o` on side `here` to the signed
    /// cosine `i` (negative: on the other side): eq. (6) times |cos θ_i|.
    #[inline]
    pub(super) fn lost_energy(&self, here: usize, o: f32, i: f32) -> f32 {
        let lost = self.loss(here, o);
        if lost <= 0.0 {
            return 0.0;
        }
        let transmitted = self.transmitted[here];
        let (share, there) = if i < 0.0 { (transmitted, 1 - here) } else { (1.0 - transmitted, here) };
        let total = self.total[there];
        if total <= 0.0 {
            return 0.0;
        }
        share * lost * self.loss(there, i.abs()) * i.abs() * FRAC_1_PI / total
    }

    /// A direction of [`Self::lost_energy`], given that the light was lost; z < 0 on the other side.
    pub(super) fn sample_lost(&self, here: usize, u: f32, u_azimuth: f32) -> Vec3 {
        let transmitted = self.transmitted[here];
        let (there, sign, u) = if u < transmitted {
            (1 - here, -1.0, u / transmitted)
        } else {
            (here, 1.0, (u - transmitted) / (1.0 - transmitted))
        };
        let mu = self.sample(there, warp::clamp_unit(u));
        let r = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
        let (sin, cos) = (TAU * u_azimuth).sin_cos();
        Vec3::new(r * cos, r * sin, sign * mu)
    }
}

impl std::fmt::Debug for Compensation<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Compensation").field("total", &self.total).finish_non_exhaustive()
    }
}
