//! What single scattering loses at a rough dielectric boundary, and how that energy is shared, over roughness and
//! direction for one relative index. `docs/boundary.md` derives the equations named here.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | side 0, 1 | a, b | the rarer and the denser side |
//! | `eta` | η ≥ 1 | index of the denser side over that of the rarer side |
//! | `correlation` | κ(η) | share of the masking of refracted light that straight-on passage undoes, eq. (4) |
//! | `exchange` | X | transmitted part of the hemispherical loss of side 0; η² times that of side 1, eq. (8) |

use super::fresnel;
use super::lobe::{Lobe, Warp};
use super::loss::Quadrature;
use std::cell::Cell;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Least roughness of the tables, and of a boundary that is not taken for smooth.
pub const MIN_ROUGH_ALPHA: f32 = 1e-3;

/// Slices over α, geometric from [`MIN_ROUGH_ALPHA`] to 1.
const SLICES: usize = 80;

/// Tables are built for η rounded to a multiple of this, so that nearly equal indices share one.
const ETA_STEP: f32 = 1.0 / 16_384.0;

/// Decay of the correlation κ = exp(−(η − 1)/0.2), fitted to walks on the microsurface (`docs/boundary.md` §4).
const CORRELATION_DECAY: f32 = 0.2;

/// How the chance that reflected light, once masked, still leaves as reflection changes from its smooth to its rough
/// limit: F_dr^(α/(α + 0.12)), fitted to walks on the microsurface (`docs/boundary.md` §5).
const SECOND_BOUNCE_ALPHA: f32 = 0.12;

/// κ(η) of eq. (4), for η on either side of 1.
#[inline]
pub(super) fn correlation(eta: f32) -> f32 {
    (-(eta.max(1.0 / eta) - 1.0) / CORRELATION_DECAY).exp()
}

/// One roughness.
struct Slice {
    sides: [Lobe; 2],
    exchange: f32,
}

/// Loss and exchange of a rough boundary of one relative index, for every roughness.
pub struct BoundaryTables {
    eta: f32,
    slices: Vec<Slice>,
}

impl BoundaryTables {
    /// The tables for relative index `eta` (> 0; an index and its inverse share tables).
    ///
    /// Built on first use, which takes some tens of milliseconds, and kept for the life of the process, about 130 kB
    /// each. Later calls from the same thread take no lock as long as it uses few indices.
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
        let steps = (eta.max(1.0 / eta) / ETA_STEP).round().max(1.0 / ETA_STEP + 1.0);
        let eta = steps * ETA_STEP;
        let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
        all.get_or_insert_default()
            .entry(eta.to_bits())
            .or_insert_with(|| Box::leak(Box::new(Self::new(eta))))
    }

    /// Builds the tables for `eta` > 1, on the calling thread.
    pub fn new(eta: f32) -> Self {
        let (rare, dense) = (Quadrature::<12, 12>::new(), Quadrature::<8, 12>::new());
        let kappa = correlation(eta);
        let critical = ((eta - 1.0) * (eta + 1.0)).sqrt() / eta;
        let average = fresnel::diffuse_reflectance(eta);
        let slices = (0..SLICES)
            .map(|j| {
                let alpha = MIN_ROUGH_ALPHA.powf(1.0 - j as f32 / (SLICES - 1) as f32);
                let mut reflected = 0.0;
                let mut last = (0.0, 0.0);
                let outside = Lobe::new(Warp::new(alpha, None), |mu| {
                    let lost = rare.lost(mu, alpha, eta, kappa);
                    reflected += (mu - last.0) * (mu * lost.reflected + last.0 * last.1);
                    last = (mu, lost.reflected);
                    lost.reflected + lost.refracted
                });
                let inside = Lobe::new(Warp::new(alpha, Some(critical)), |mu| {
                    let lost = dense.lost(mu, alpha, 1.0 / eta, kappa);
                    lost.reflected + lost.refracted
                });
                let stays = reflected * average.powf(alpha / (alpha + SECOND_BOUNCE_ALPHA));
                let feasible = outside.total().min(eta * eta * inside.total());
                let exchange = (outside.total() - stays).clamp(0.0, feasible);
                Slice { sides: [outside, inside], exchange }
            })
            .collect();
        Self { eta, slices }
    }

    /// The index these tables were built for, ≥ 1: a multiple of 2⁻¹⁴ for those from [`BoundaryTables::get`].
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// The compensation at roughness `alpha` in \[[`MIN_ROUGH_ALPHA`], 1\] (clamped).
    #[inline]
    pub(super) fn at(&self, alpha: f32) -> Compensation<'_> {
        let span = -MIN_ROUGH_ALPHA.ln();
        let x = (alpha.clamp(MIN_ROUGH_ALPHA, 1.0).ln() / span + 1.0) * (SLICES - 1) as f32;
        let j = (x as usize).min(SLICES - 2);
        Compensation {
            low: &self.slices[j],
            high: &self.slices[j + 1],
            t: (x - j as f32).clamp(0.0, 1.0),
            inv_eta2: 1.0 / (self.eta * self.eta),
        }
    }
}

impl std::fmt::Debug for BoundaryTables {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BoundaryTables").field("eta", &self.eta).finish_non_exhaustive()
    }
}

/// Loss and exchange at one roughness: linear between two slices.
#[derive(Clone, Copy)]
pub(super) struct Compensation<'a> {
    low: &'a Slice,
    high: &'a Slice,
    t: f32,
    inv_eta2: f32,
}

impl Compensation<'_> {
    #[inline]
    fn mix(&self, f: impl Fn(&Slice) -> f32) -> f32 {
        f(self.low) * (1.0 - self.t) + f(self.high) * self.t
    }

    /// L_a(µ).
    #[inline]
    pub(super) fn loss(&self, side: usize, mu: f32) -> f32 {
        self.mix(|s| s.sides[side].loss(mu))
    }

    /// A_a.
    #[inline]
    pub(super) fn total(&self, side: usize) -> f32 {
        self.mix(|s| s.sides[side].total())
    }

    /// τ_a: the share of the lost light of side a that leaves on the other side.
    #[inline]
    pub(super) fn transmitted(&self, side: usize) -> f32 {
        let exchange = self.mix(|s| s.exchange) * if side == 0 { 1.0 } else { self.inv_eta2 };
        (exchange / self.total(side).max(f32::MIN_POSITIVE)).min(1.0)
    }

    /// A cosine on side a with density 2µ L_a(µ)/A_a; `u` in \[0, 1).
    #[inline]
    pub(super) fn sample(&self, side: usize, u: f32) -> f32 {
        let low = (1.0 - self.t) * self.low.sides[side].total();
        let high = self.t * self.high.sides[side].total();
        let x = u * (low + high);
        if x < low {
            self.low.sides[side].sample(x / low)
        } else {
            self.high.sides[side].sample(((x - low) / high.max(f32::MIN_POSITIVE)).min(1.0))
        }
    }
}

impl std::fmt::Debug for Compensation<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Compensation").field("t", &self.t).finish_non_exhaustive()
    }
}
