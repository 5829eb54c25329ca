//! What microfacets of two widths reflect, let through and lose, direction by direction: tables over both widths, the
//! cosine and the azimuth, each made when it is first needed.
//!
//! Energy is returned by Kulla & Conty's lobe L(ω_o) L(ω_i) µ_i/(π A), A = ∫ L µ dω/π. It is reciprocal, and returns to
//! each direction just what that direction lost, if L is known as a function of the direction: of its azimuth, too,
//! where facets have a tangent. A brushed surface loses little of what comes along the brushing and half of
//! what comes across it.
//!
//! Between nodes and between widths everything is linear, and averages are those of the interpolant, so that the only
//! error of the energy is that of L itself.

use super::anisotropic::Facets;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::lobe::Warp;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Widths from [`MIN_ROUGH_ALPHA`] to 1.
const WIDTHS: usize = 36;
/// Share of the widths spaced geometrically; the rest are spaced evenly.
const GEOMETRIC_SHARE: f32 = 0.75;
/// Nodes over the cosine and over a quarter of the azimuth; the other quarters are its mirror images.
const COSINES: usize = 41;
const AZIMUTHS: usize = 25;
/// Visible normals of a node: rings and normals on a ring.
const RINGS: usize = 24;
const SPOKES: usize = 24;
/// The least cosine that stands for none.
const GRAZING: f32 = 1e-4;

/// Functions of the cosine between a facet and a direction that any other is made of, where it is not known beforehand:
/// linear between so many even nodes.
pub(super) const HATS: usize = 9;

/// The hats that are not zero at a cosine: the first of two, and the weight of the second.
#[inline]
pub(super) fn hat(cos: f32) -> (usize, f32) {
    let x = cos.clamp(0.0, 1.0) * (HATS - 1) as f32;
    let k = (x as usize).min(HATS - 2);
    (k, x - k as f32)
}

fn position(alpha: f32) -> f32 {
    let geometric = 1.0 - alpha.ln() / MIN_ROUGH_ALPHA.ln();
    let even = (alpha - MIN_ROUGH_ALPHA) / (1.0 - MIN_ROUGH_ALPHA);
    GEOMETRIC_SHARE * geometric + (1.0 - GEOMETRIC_SHARE) * even
}

/// The argument at which an increasing function has a value, by bisection.
fn inverse(f: impl Fn(f32) -> f32, value: f32, (mut low, mut high): (f32, f32)) -> f32 {
    for _ in 0..40 {
        let mid = 0.5 * (low + high);
        if f(mid) < value {
            low = mid;
        } else {
            high = mid;
        }
    }
    0.5 * (low + high)
}

fn widths() -> &'static [f32; WIDTHS] {
    static ALL: OnceLock<[f32; WIDTHS]> = OnceLock::new();
    ALL.get_or_init(|| {
        std::array::from_fn(|j| match j {
            0 => MIN_ROUGH_ALPHA,
            j if j + 1 == WIDTHS => 1.0,
            j => inverse(position, j as f32 / (WIDTHS - 1) as f32, (MIN_ROUGH_ALPHA, 1.0)),
        })
    })
}

/// `V` numbers for each direction, of one pair of widths.
struct Slice<const V: usize> {
    cosines: [f32; COSINES],
    azimuths: [f32; AZIMUTHS],
    values: Vec<[f32; V]>,
    /// ∫ µ x dω/π of each.
    average: [f32; V],
}

impl<const V: usize> Slice<V> {
    /// `of` gets a pair of widths and a direction.
    #[cold]
    fn new(alpha: Vec2, eta: f32, of: &impl Fn(&Facets, Vec3) -> [f32; V]) -> Self {
        let facets = Facets { alpha, tangent: Vec2::X };
        let warp = Warp::new((alpha.x * alpha.y).sqrt(), eta);
        // Half of the nodes are where light is lost, half where reflectances change.
        let place = |mu: f32| 0.5 * (warp.position(mu) + mu.sqrt());
        let cosines = std::array::from_fn(|i| match i {
            0 => 0.0,
            i if i + 1 == COSINES => 1.0,
            i => inverse(place, i as f32 / (COSINES - 1) as f32, (0.0, 1.0)),
        });
        // Masking changes where αx cos φ and αy sin φ are alike, which may be in a small part of the quarter.
        let turned = |phi: f32| {
            let stretched = (alpha.y * phi.sin()).atan2(alpha.x * phi.cos().max(0.0));
            0.5 * (phi + stretched) / FRAC_PI_2
        };
        let azimuths: [f32; AZIMUTHS] =
            std::array::from_fn(|j| inverse(turned, j as f32 / (AZIMUTHS - 1) as f32, (0.0, FRAC_PI_2)));
        let mut values = Vec::with_capacity(COSINES * AZIMUTHS);
        for mu in cosines {
            for phi in azimuths {
                let mu = mu.max(GRAZING);
                let r = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
                values.push(of(&facets, Vec3::new(r * phi.cos(), r * phi.sin(), mu)));
            }
        }
        let mut slice = Self { cosines, azimuths, values, average: [0.0; V] };
        for i in 1..COSINES {
            let (a, b) = (slice.cosines[i - 1], slice.cosines[i]);
            let (low, high) = (slice.row(i - 1), slice.row(i));
            for v in 0..V {
                let (p, q) = (low[v], high[v]);
                slice.average[v] += (b - a) * (2.0 * p * a + p * b + q * a + 2.0 * q * b) / 3.0;
            }
        }
        slice
    }

    /// Averages over the azimuth at one cosine.
    fn row(&self, i: usize) -> [f32; V] {
        let mut sum = [0.0; V];
        for j in 1..AZIMUTHS {
            let share = 0.5 * (self.azimuths[j] - self.azimuths[j - 1]) / FRAC_PI_2;
            let (a, b) = (&self.values[i * AZIMUTHS + j - 1], &self.values[i * AZIMUTHS + j]);
            for v in 0..V {
                sum[v] += share * (a[v] + b[v]);
            }
        }
        sum
    }

    /// Adds the values at a cosine and an azimuth in the first quarter, weighed.
    #[inline]
    fn add(&self, (mu, phi): (f32, f32), weight: f32, sum: &mut [f32; V]) {
        let (i, s) = between(&self.cosines, mu);
        let (j, t) = between(&self.azimuths, phi);
        let at = i * AZIMUTHS + j;
        let (w, u) = (weight * (1.0 - s), weight * s);
        let corners = [
            (at, w * (1.0 - t)),
            (at + 1, w * t),
            (at + AZIMUTHS, u * (1.0 - t)),
            (at + AZIMUTHS + 1, u * t),
        ];
        for (k, w) in corners {
            for (sum, x) in sum.iter_mut().zip(&self.values[k]) {
                *sum += w * x;
            }
        }
    }
}

/// The interval of increasing nodes that a value is in, and where in it.
#[inline]
fn between<const N: usize>(nodes: &[f32; N], x: f32) -> (usize, f32) {
    let i = nodes[1..N - 1].partition_point(|&node| node <= x);
    (i, ((x - nodes[i]) / (nodes[i + 1] - nodes[i])).clamp(0.0, 1.0))
}

/// `V` numbers for each direction and pair of widths.
pub(super) struct FacetTables<const V: usize> {
    eta: f32,
    slices: [[OnceLock<Box<Slice<V>>>; WIDTHS]; WIDTHS],
}

impl<const V: usize> FacetTables<V> {
    /// For light that refracts with the relative index `eta`, if it does: where nodes are needed.
    pub(super) const fn new(eta: f32) -> Self {
        Self { eta, slices: [const { [const { OnceLock::new() }; WIDTHS] }; WIDTHS] }
    }

    /// What the tables say of facets: `of` fills them, and is always the same.
    pub(super) fn at(&'static self, facets: &Facets, of: impl Fn(&Facets, Vec3) -> [f32; V]) -> At<V> {
        let swapped = facets.alpha.x < facets.alpha.y;
        let [(j, s), (k, t)] = [facets.alpha.max_element(), facets.alpha.min_element()]
            .map(|alpha| between(widths(), alpha.clamp(MIN_ROUGH_ALPHA, 1.0)));
        let slice = |j: usize, k: usize| -> &'static Slice<V> {
            let alpha = Vec2::new(widths()[j], widths()[k]);
            self.slices[j][k].get_or_init(|| Box::new(Slice::new(alpha, self.eta, &of)))
        };
        let corners = [
            (slice(j, k), (1.0 - s) * (1.0 - t)),
            (slice(j + 1, k), s * (1.0 - t)),
            (slice(j, k + 1), (1.0 - s) * t),
            (slice(j + 1, k + 1), s * t),
        ];
        let mut average = [0.0; V];
        for (slice, weight) in corners {
            for (average, x) in average.iter_mut().zip(&slice.average) {
                *average += weight * x;
            }
        }
        At { corners, swapped, average }
    }
}

/// Numbers of one pair of widths.
pub(super) struct At<const V: usize> {
    corners: [(&'static Slice<V>, f32); 4],
    swapped: bool,
    /// ∫ µ x dω/π of each number.
    pub(super) average: [f32; V],
}

impl<const V: usize> Clone for At<V> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<const V: usize> Copy for At<V> {}

impl<const V: usize> std::fmt::Debug for At<V> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("At").field("average", &self.average).finish_non_exhaustive()
    }
}

impl<const V: usize> At<V> {
    /// The numbers of a turned direction (x along the tangent), on either side.
    pub(super) fn towards(&self, w: Vec3) -> [f32; V] {
        let (x, y) = if self.swapped { (w.y.abs(), w.x.abs()) } else { (w.x.abs(), w.y.abs()) };
        let place = (w.z.abs().min(1.0), y.atan2(x));
        let mut sum = [0.0; V];
        for (slice, weight) in &self.corners {
            if *weight > 0.0 {
                slice.add(place, *weight, &mut sum);
            }
        }
        sum
    }
}

/// Normals that a turned direction sees, all with the same probability, each once.
pub(super) fn visible_normals(facets: &Facets, w: Vec3, mut visit: impl FnMut(Vec3)) {
    for ring in 0..RINGS {
        // Half a step from ring to ring, so that no two rings have the same azimuths.
        let turn = 0.5 + 0.5 * (ring % 2) as f32;
        for spoke in 0..SPOKES {
            let u = Vec2::new((spoke as f32 + turn) / SPOKES as f32, (ring as f32 + 0.5) / RINGS as f32);
            visit(facets.sample_visible(w, u));
        }
    }
}

/// The weight of each of [`visible_normals`].
pub(super) const VISIBLE: f32 = 1.0 / (RINGS * SPOKES) as f32;
