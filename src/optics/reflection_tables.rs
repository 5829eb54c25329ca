//! What single scattering reflects off, and loses at, a GGX microsurface with Schlick's Fresnel term, over roughness
//! and direction: the tables behind the opaque surfaces of glTF.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `loss` | L(µ) | share lost by perfectly reflecting facets |
//! | `schlick` | E_w(µ) | share reflected by facets of reflectance (1 − ω·h)⁵ |
//!
//! Single scattering is linear in f0 and f90: facets of reflectance f0 + (f90 − f0)(1 − ω·h)⁵ reflect
//! f0 (1 − L(µ) − E_w(µ)) + f90 E_w(µ).

use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::fresnel::{SCHLICK_AVERAGE, schlick_weight};
use super::lobe::{CELLS, Lobe, Warp};
use super::loss::Quadrature;
use super::reflectance::NODES;
use std::sync::OnceLock;

/// Slices over α, geometric from [`MIN_ROUGH_ALPHA`] to 1.
const SLICES: usize = 64;

struct Slice {
    lobe: Lobe,
    /// E_w − (1 − L) (1 − µ)⁵: what the facets' slopes change, little where the surface is nearly smooth, so that the few
    /// nodes there are between the horizon and the normal do then.
    bent: [f32; CELLS + 1],
    schlick_average: f32,
}

/// The reflection of rough surfaces at one roughness: linear between two slices, or the smooth limit.
#[derive(Clone, Copy)]
pub(super) struct Reflection {
    /// The slices and the weight of the second; none for a smooth surface.
    between: Option<(&'static Slice, &'static Slice, f32)>,
    /// A = ∫ 2µ L dµ.
    pub(super) lost_average: f32,
    /// ∫ 2µ E_w dµ.
    pub(super) schlick_average: f32,
}

/// What is reflected and lost in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directional {
    /// L(µ).
    pub(super) lost: f32,
    /// E_w(µ).
    pub(super) schlick: f32,
}

impl Reflection {
    /// Without microfacets.
    pub(super) const SMOOTH: Self =
        Self { between: None, lost_average: 0.0, schlick_average: SCHLICK_AVERAGE };

    /// At roughness `alpha`; smooth below [`MIN_ROUGH_ALPHA`]. Slices are made when they are first needed.
    pub(super) fn at(alpha: f32) -> Self {
        static ALL: [OnceLock<Slice>; SLICES] = [const { OnceLock::new() }; SLICES];
        if alpha < MIN_ROUGH_ALPHA {
            return Self::SMOOTH;
        }
        let slice = |j: usize| ALL[j].get_or_init(|| Slice::new(j));
        let x = (1.0 - alpha.min(1.0).ln() / MIN_ROUGH_ALPHA.ln()) * (SLICES - 1) as f32;
        let j = (x as usize).min(SLICES - 2);
        let (low, high, t) = (slice(j), slice(j + 1), (x - j as f32).clamp(0.0, 1.0));
        Self {
            between: Some((low, high, t)),
            lost_average: mix(low.lobe.total(), high.lobe.total(), t),
            schlick_average: mix(low.schlick_average, high.schlick_average, t),
        }
    }

    /// L and E_w at cosine `mu` in \[0, 1\].
    #[inline]
    pub(super) fn directional(&self, mu: f32) -> Directional {
        let Some((low, high, t)) = self.between else {
            return Directional { lost: 0.0, schlick: schlick_weight(mu) };
        };
        let (a, b) = (low.directional(mu), high.directional(mu));
        Directional { lost: mix(a.lost, b.lost, t), schlick: mix(a.schlick, b.schlick, t) }
    }

    /// A cosine with density 2µ L(µ)/A; `u` in \[0, 1).
    #[inline]
    pub(super) fn sample_lost(&self, u: f32) -> f32 {
        let Some((low, high, t)) = self.between else { return u.sqrt() };
        let (a, b) = ((1.0 - t) * low.lobe.total(), t * high.lobe.total());
        let x = u * (a + b);
        if x < a {
            low.lobe.sample(x / a)
        } else {
            high.lobe.sample(((x - a) / b.max(f32::MIN_POSITIVE)).min(1.0))
        }
    }
}

impl std::fmt::Debug for Reflection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reflection").field("lost_average", &self.lost_average).finish_non_exhaustive()
    }
}

impl Slice {
    #[cold]
    fn new(j: usize) -> Self {
        let alpha = MIN_ROUGH_ALPHA.powf(1.0 - j as f32 / (SLICES - 1) as f32);
        let quadrature = Quadrature::<12, 12>::new();
        let mut bent = Vec::with_capacity(CELLS + 1);
        let lobe = Lobe::new(Warp::new(alpha, 1.0), |mu| {
            let mut d = Directional { lost: 0.0, schlick: 0.0 };
            quadrature.lines(mu, alpha, 1.0, 0.0, |line| {
                d.lost += line.masked_reflected;
                d.schlick += schlick_weight(line.cos) * (line.facing - line.masked_reflected);
            });
            bent.push(d.schlick - (1.0 - d.lost) * schlick_weight(mu));
            d.lost
        });
        let bent: [f32; CELLS + 1] = std::array::from_fn(|i| bent[i]);
        let mu = lobe.nodes();
        let mut slice = Self { lobe: lobe.clone(), bent, schlick_average: 0.0 };
        for pair in mu.windows(2) {
            let width = pair[1] - pair[0];
            for (x, w) in NODES {
                let mu = pair[0] + width * x;
                slice.schlick_average += 2.0 * mu * w * width * slice.directional(mu).schlick;
            }
        }
        slice
    }

    #[inline]
    fn directional(&self, mu: f32) -> Directional {
        let (i, t) = self.lobe.locate(mu);
        let lost = self.lobe.loss(mu);
        let bent = mix(self.bent[i], self.bent[i + 1], t);
        Directional { lost, schlick: (1.0 - lost) * schlick_weight(mu) + bent }
    }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}
