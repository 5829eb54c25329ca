//! Radial profiles and their tables to sample from.
//!
//! | name | meaning, unit |
//! | --- | --- |
//! | R(r) | [`RadialProfile::eval`], 1/m² |
//! | p(r) = 2πr R/∫ | [`TabulatedProfile::pdf_radius`], 1/m |
//! | p(r)/(2πr) | [`TabulatedProfile::pdf_area`], 1/m² |
//!
//! A table holds p at radii that are evenly spaced in ln r and is linear in r between them, from a linear piece at 0 to
//! an exponential tail that keeps the energy beyond the last radius. The same polygon is what is sampled, what is
//! reported as density and what [`TabulatedProfile::eval`] multiplies by the total, so that a sample's weight is the
//! total reflectance exactly.

use super::quadrature;
use std::f64::consts::{LN_2, TAU};

/// A radially symmetric reflectance profile R(r).
pub trait RadialProfile {
    /// R at distance `r` > 0 in m, 1/m², ≥ 0. May be infinite at 0, but 2πr R may not.
    fn eval(&self, r: f64) -> f64;

    /// ∫ R 2πr dr: the reflected share of the power that enters, usually in \[0, 1\].
    fn total(&self) -> f64;
}

/// The sum of two profiles, such as a diffusion model and single scattering.
impl<A: RadialProfile, B: RadialProfile> RadialProfile for (A, B) {
    fn eval(&self, r: f64) -> f64 {
        self.0.eval(r) + self.1.eval(r)
    }

    fn total(&self) -> f64 {
        self.0.total() + self.1.total()
    }
}

/// ∫ R 2πr dr by the trapezoid rule in ln r around the length `scale`, m.
pub(super) fn integrate(profile: &impl RadialProfile, scale: f64) -> f64 {
    const NEAREST: f64 = -18.0;
    const FARTHEST: f64 = 18.0;
    const STEP: f64 = 0.25;
    if !(scale.is_finite() && scale > 0.0) {
        return 0.0;
    }
    quadrature::logarithmic(NEAREST, FARTHEST, STEP, |x| TAU * x * profile.eval(x * scale)) * scale * scale
}

/// A vertex of the polygon.
#[derive(Clone, Copy, Debug)]
struct Node {
    r: f32,
    /// Density of the radius, 1/m.
    pdf: f32,
    /// Probability of a smaller radius.
    cdf: f32,
}

/// A profile as a table, of one medium and channel: single precision, some tens of nanoseconds a sample.
#[derive(Clone, Debug)]
pub struct TabulatedProfile {
    nodes: Vec<Node>,
    /// For equal parts of \[0, 1), the last node whose cdf is not above the part's beginning.
    guide: Vec<u16>,
    total: f32,
    /// log2 of the first radius after 0, and nodes per factor of two.
    first: f32,
    density: f32,
    /// Mass and decay length (m) of the exponential beyond the last node.
    tail: f32,
    tail_length: f32,
    max_radius: f32,
    near_radius: f32,
}

/// Radii in a table, without 0.
const RADII: usize = 320;
/// Entries of the guide.
const GUIDE: usize = 256;
/// Shares of the energy inside the first radius and outside the last.
const INNER: f64 = 1e-4;
const OUTER: f64 = 2e-5;
/// Share of the energy inside [`TabulatedProfile::max_radius`].
const HELD: f32 = 0.9995;
/// Share of the energy inside [`TabulatedProfile::near_radius`].
const NEAR: f32 = 0.9;
/// Densities per area grow as 1/r towards the beam; nearer than this, m, they stay what they are there, so that they
/// are finite in single precision.
const NEAREST_RADIUS: f32 = 1e-20;
/// The radii that are searched for the profile, as powers of two: 1e-12 m to 3e7 m.
const SEARCHED: std::ops::RangeInclusive<i32> = -40..=25;

impl TabulatedProfile {
    /// Tabulates `profile`; `None` where it reflects nothing. Costs about 400 evaluations and one of the total.
    pub fn new(profile: &dyn RadialProfile) -> Option<Self> {
        let density = |r: f64| {
            let p = TAU * r * profile.eval(r);
            if p.is_finite() { p.max(0.0) } else { 0.0 }
        };
        let (inner, outer, beyond) = range(&density)?;
        let step = (outer / inner).ln() / (RADII - 1) as f64;
        let mut vertices = vec![(0.0, 0.0)];
        vertices.extend((0..RADII).map(|i| inner * (step * i as f64).exp()).map(|r| (r, density(r))));
        let ((r1, p1), (r2, p2)) = (vertices[1], vertices[2]);
        vertices[0].1 = (p1 - r1 * (p2 - p1) / (r2 - r1)).max(0.0);

        let mut cumulative = vec![0.0];
        for pair in vertices.windows(2) {
            let mass = 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
            cumulative.push(cumulative[cumulative.len() - 1] + mass);
        }
        let last = vertices[RADII].1;
        let tail = if last > 0.0 { beyond } else { 0.0 };
        let sum = cumulative[RADII] + tail;
        let nodes: Vec<Node> = vertices
            .iter()
            .zip(&cumulative)
            .map(|(&(r, p), &c)| Node { r: r as f32, pdf: (p / sum) as f32, cdf: (c / sum) as f32 })
            .collect();
        let guide = (0..GUIDE)
            .map(|i| {
                let u = i as f32 / GUIDE as f32;
                (nodes.partition_point(|n| n.cdf <= u) - 1) as u16
            })
            .collect();
        let mut table = Self {
            nodes,
            guide,
            total: profile.total() as f32,
            first: inner.log2() as f32,
            density: (LN_2 / step) as f32,
            tail: (tail / sum) as f32,
            tail_length: if tail > 0.0 { (tail / last) as f32 } else { 0.0 },
            max_radius: 0.0,
            near_radius: 0.0,
        };
        table.max_radius = table.sample(HELD);
        table.near_radius = table.sample(NEAR);
        Some(table)
    }

    /// ∫ R 2πr dr.
    #[inline]
    pub fn total(&self) -> f32 {
        self.total
    }

    /// The radius in m that holds 99.95 % of the energy. Samples may lie beyond it.
    #[inline]
    pub fn max_radius(&self) -> f32 {
        self.max_radius
    }

    /// The radius in m that holds 90 % of the energy.
    #[inline]
    pub fn near_radius(&self) -> f32 {
        self.near_radius
    }

    /// A radius in m of density [`TabulatedProfile::pdf_radius`], for `u` in \[0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> f32 {
        debug_assert!((0.0..1.0).contains(&u), "u = {u}");
        let mut k = usize::from(self.guide[((u * GUIDE as f32) as usize).min(GUIDE - 1)]);
        let last = self.nodes.len() - 1;
        while k < last && self.nodes[k + 1].cdf <= u {
            k += 1;
        }
        if k == last {
            let rest = (1.0 - u) / self.tail;
            return self.nodes[last].r - self.tail_length * if rest < 1.0 { rest.ln() } else { 0.0 };
        }
        let (a, b) = (self.nodes[k], self.nodes[k + 1]);
        let xi = (u - a.cdf) / (b.cdf - a.cdf);
        // The inverse of a linear density's distribution, in the form that does not cancel where it is nearly even.
        let root = (a.pdf * a.pdf + xi * (b.pdf - a.pdf) * (b.pdf + a.pdf)).max(0.0).sqrt();
        a.r + (b.r - a.r) * (xi * (a.pdf + b.pdf) / (a.pdf + root)).min(1.0)
    }

    /// Probability of a radius smaller than `r` in m.
    pub fn cdf(&self, r: f32) -> f32 {
        let last = self.nodes.len() - 1;
        let k = self.nodes.partition_point(|n| n.r <= r).saturating_sub(1);
        if k == last {
            let tail = (-(r - self.nodes[last].r) / self.tail_length).exp();
            return if self.tail > 0.0 { 1.0 - self.tail * tail } else { 1.0 };
        }
        let (a, b) = (self.nodes[k], self.nodes[k + 1]);
        let (step, x) = (b.r - a.r, r - a.r);
        a.cdf + x * (a.pdf + 0.5 * (b.pdf - a.pdf) * x / step)
    }

    /// R averaged over the disk of radius `r` in m, 1/m².
    pub fn disk_mean(&self, r: f32) -> f32 {
        self.total * self.cdf(r) / (std::f32::consts::PI * r * r)
    }

    /// Density of the sampled radius at `r` ≥ 0 in m, 1/m; integrates to 1.
    #[inline]
    pub fn pdf_radius(&self, r: f32) -> f32 {
        self.pdf_radius_at(r, r.log2())
    }

    /// The same where log2 r is known already.
    #[inline]
    fn pdf_radius_at(&self, r: f32, log_r: f32) -> f32 {
        let last = self.nodes.len() - 1;
        if r >= self.nodes[last].r {
            return if self.tail > 0.0 {
                self.nodes[last].pdf * (-(r - self.nodes[last].r) / self.tail_length).exp()
            } else {
                0.0
            };
        }
        // log2 is rounded: the cell may be one off.
        let guess = if r < self.nodes[1].r { 0.0 } else { 1.0 + (log_r - self.first) * self.density };
        let mut k = (guess as usize).min(last - 1);
        if r < self.nodes[k].r {
            k -= 1;
        } else if r >= self.nodes[k + 1].r {
            k += 1;
        }
        let (a, b) = (self.nodes[k], self.nodes[k + 1]);
        a.pdf + (b.pdf - a.pdf) * ((r - a.r) / (b.r - a.r))
    }

    /// Density per unit area at distance `r` in m, 1/m²: `pdf_radius(r)/(2πr)`.
    #[inline]
    pub fn pdf_area(&self, r: f32) -> f32 {
        self.pdf_area_at(r, r.log2())
    }

    /// The same where log2 r is known already.
    #[inline]
    pub fn pdf_area_at(&self, r: f32, log_r: f32) -> f32 {
        let r = r.max(NEAREST_RADIUS);
        self.pdf_radius_at(r, log_r) / (std::f32::consts::TAU * r)
    }

    /// R(r) of the table, 1/m²: `total × pdf_area(r)`.
    #[inline]
    pub fn eval(&self, r: f32) -> f32 {
        self.total * self.pdf_area(r)
    }
}

/// The radii inside and outside of which `density` (of the radius) holds next to nothing, and what the outer part
/// still holds.
fn range(density: &impl Fn(f64) -> f64) -> Option<(f64, f64, f64)> {
    let power: Vec<(f64, f64)> = SEARCHED.map(|i| 2f64.powi(i)).map(|r| (r, r * density(r) * LN_2)).collect();
    let sum: f64 = power.iter().map(|p| p.1).sum();
    if !(sum.is_finite() && sum > 0.0) {
        return None;
    }
    let held = |share: f64, from: &mut dyn Iterator<Item = &(f64, f64)>| {
        let mut held = 0.0;
        let mut at = power[0].0;
        for &(r, p) in from {
            held += p;
            if held > share * sum {
                break;
            }
            at = r;
        }
        at
    };
    let inner = held(INNER, &mut power.iter());
    let outer = held(OUTER, &mut power.iter().rev());
    if outer <= inner {
        return None;
    }
    // The part of the trapezoid sum beyond the last radius: half of its own term and all after it.
    let beyond = power
        .iter()
        .map(|&(r, p)| {
            if r > outer {
                p
            } else if r == outer {
                0.5 * p
            } else {
                0.0
            }
        })
        .sum();
    Some((inner, outer, beyond))
}
