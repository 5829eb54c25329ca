//! Random walks drawn towards light: an exponential transform, beside the plain walk.
//!
//! Behind a slab, a leaf or an ear the light is on the far side, and few plain walks get there. A *guided* stretch of a
//! walk prefers an axis **a** towards the light. With µ = ω·a and 0 < c < 1 its free flights are longer along the axis,
//!
//! ```text
//! p(t) = σt (1 − cµ) e^{−σt (1 − cµ) t},                                                             (1)
//! ```
//!
//! and where scattering is isotropic it turns with (Dwivedi 1982; Křivánek & d'Eon 2014)
//!
//! ```text
//! p(ω) = K / (4π (1 − cµ)),   K = c / artanh c.                                                      (2)
//! ```
//!
//! Otherwise it turns by the phase function. The density of the guided way over that of the plain one telescopes: after
//! n collisions, a displacement Δ along the axis and directions µ_0 … µ_n, the last of them drawn or still under way,
//!
//! ```text
//! r = (1 − cµ_0)/(1 − cµ_n) K^n e^{cσt Δ}   isotropic,                                              (3)
//! r = Π_{i<n} (1 − cµ_i) e^{cσt Δ}          otherwise.                                              (4)
//! ```
//!
//! A share q of the stretches is guided, and the balance heuristic over both ways and the three channels weighs all:
//! each term of the density in [`super::spectral`] is multiplied by 1 − q + q r. So weights are at most 1/(1 − q) times
//! those of the plain walk, however wrong the axis is. At an event, before a direction is drawn, (3) is
//! (1 − cµ_0) K^{n−1} e^{cσt Δ}.
//!
//! **How strongly.** Zero variance would need c σt = |∇ ln I| for the importance I. In a medium without end that is the
//! reciprocal of the diffusion length, c_D² = 3 (1 − α)(1 − gα). Through a depth ℓ without absorption I grows linearly
//! from the extrapolated boundary 0.7/σt′ behind the walk, which is ln(1 + σt′ℓ/0.7) over ℓ on average: c_L. Both together
//! give c² = c_D² + c_L². Walks that set out where the light comes in are plain: held back there they are noisier by
//! a half.

use super::spectral::{Coefficients, LONGEST_STRETCH};
use crate::sampling::{SmallRng, fast_math, orthonormal_basis};
use glam::{Mat3, Vec3, Vec3A};

/// q. Measured on slabs (which like more) and thick objects (which like less).
const SHARE: f32 = 0.4;
/// Most events of a guided stretch: the products of longer ones differ more from those of plain ones.
const LONGEST_GUIDED: usize = 8;
/// Strongest guiding.
const STRONGEST: f32 = 0.8;
/// Weakest, so that quotients stay accurate.
const WEAKEST: f32 = 0.02;
/// Least c_L: through more than about ten mean free paths guiding costs more than it saves.
const LEAST_GRADIENT: f32 = 0.25;
/// Depth in mean free paths below which a walk is already where the light comes in.
const LEAST_DEPTH: f32 = 0.1;
/// Extrapolation distance in transport mean free paths.
const EXTRAPOLATION: f32 = 0.7;
/// Largest exponent of e^{cσt Δ}, below where f32 overflows.
const LARGEST_EXPONENT: f32 = 80.0;

/// How a walk chooses its ways; compiled once for each kind, so that plain walks pay nothing.
pub(super) trait Steering {
    /// Whether some ways are other than plain.
    const GUIDED: bool;
    /// Most events of a stretch.
    const LONGEST: usize = LONGEST_STRETCH;
    /// A few events.
    type Stretch<'a>: Ways
    where
        Self: 'a;

    /// A stretch that sets out from `p` in direction `d`, with free flights of that channel.
    fn stretch(&self, channel: usize, p: Vec3, d: Vec3, rng: &mut SmallRng) -> Self::Stretch<'_>;

    /// The room about an event that a jump needs; infinite where none are made.
    #[inline]
    fn room(&self) -> f32 {
        f32::INFINITY
    }

    /// Jumps from an event with that much room: where to, the direction there, and the throughput.
    #[inline]
    fn jump(
        &self,
        _: &Coefficients,
        state: (Vec3, Vec3, Vec3A),
        _clear: f32,
        _: &mut SmallRng,
    ) -> (Vec3, Vec3, Vec3A) {
        state
    }
}

/// A few events of a walk that are weighed as one.
pub(super) trait Ways {
    /// A free flight in direction `d` that is `t` long in a plain walk.
    fn flight(&self, t: f32, d: Vec3) -> f32;
    /// A new direction, where it is not the phase function's.
    fn direction(&self, rng: &mut SmallRng) -> Option<Vec3>;
    /// Notes a collision at the end of a flight in direction `d`.
    fn collide(&mut self, d: Vec3);
    /// The throughput after `events` collisions on a way of a length, where the walk is at `p`, under way in direction `d`.
    fn weigh(&self, c: &Coefficients, beta: Vec3A, way: Way, d: Vec3) -> Vec3A;
    /// The throughput at the last collision, before a direction was drawn.
    fn weigh_event(&self, c: &Coefficients, beta: Vec3A, way: Way) -> Vec3A;
}

/// The way of a stretch so far.
#[derive(Clone, Copy)]
pub(super) struct Way {
    pub collisions: usize,
    /// In the units of the walk.
    pub length: f32,
    /// Where it has led.
    pub p: Vec3,
}

/// Plain walks.
pub(super) struct Plain;

impl Steering for Plain {
    const GUIDED: bool = false;
    type Stretch<'a> = Plain;

    #[inline]
    fn stretch(&self, _: usize, _: Vec3, _: Vec3, _: &mut SmallRng) -> Plain {
        Plain
    }
}

impl Ways for Plain {
    #[inline]
    fn flight(&self, t: f32, _: Vec3) -> f32 {
        t
    }

    #[inline]
    fn direction(&self, _: &mut SmallRng) -> Option<Vec3> {
        None
    }

    #[inline]
    fn collide(&mut self, _: Vec3) {}

    #[inline]
    fn weigh(&self, c: &Coefficients, beta: Vec3A, way: Way, _: Vec3) -> Vec3A {
        c.weigh(beta, way.collisions, way.length)
    }

    #[inline]
    fn weigh_event(&self, c: &Coefficients, beta: Vec3A, way: Way) -> Vec3A {
        c.weigh(beta, way.collisions, way.length)
    }
}

/// The guide of one flight; each channel has its own strength.
pub(super) struct Guide {
    /// z is the axis.
    frame: Mat3,
    /// c.
    strength: Vec3A,
    /// −2 artanh c = ln((1 − c)/(1 + c)).
    log_range: Vec3A,
    /// K^n.
    powers: [Vec3A; LONGEST_GUIDED + 1],
    isotropic: bool,
}

impl Guide {
    /// Guides along a unit axis through the length `ahead` of the medium, where that can help.
    pub fn new(c: &Coefficients, axis: Vec3, ahead: f32) -> Option<Self> {
        let g = c.phase.g;
        if c.sigma_t.max_element() * ahead < LEAST_DEPTH {
            return None;
        }
        let depth = (c.sigma_t * ahead).max(Vec3A::splat(LEAST_DEPTH));
        let across = depth.map(|x| fast_math::ln(1.0 + (1.0 - g) * x / EXTRAPOLATION) / x);
        if across.max_element() < LEAST_GRADIENT {
            return None;
        }
        let squared = c.inverse_diffusion_length * c.inverse_diffusion_length + across * across;
        let strength = squared.map(|c2| c2.sqrt().clamp(WEAKEST, STRONGEST));
        let log_range = strength.map(|s| fast_math::ln((1.0 - s) / (1.0 + s)));
        let turn = -2.0 * strength / log_range;
        let mut powers = [Vec3A::ONE; LONGEST_GUIDED + 1];
        for n in 1..powers.len() {
            powers[n] = powers[n - 1] * turn;
        }
        let (x, y) = orthonormal_basis(axis);
        let frame = Mat3::from_cols(x, y, axis);
        Some(Self { frame, strength, log_range, powers, isotropic: g == 0.0 })
    }

    /// 1 − cµ.
    #[inline]
    fn slowing(&self, direction: Vec3) -> Vec3A {
        Vec3A::ONE - self.strength * direction.dot(self.frame.z_axis)
    }
}

impl Steering for Guide {
    const GUIDED: bool = true;
    const LONGEST: usize = LONGEST_GUIDED;
    type Stretch<'a> = Stretch<'a>;

    #[inline]
    fn stretch(&self, channel: usize, p: Vec3, d: Vec3, rng: &mut SmallRng) -> Stretch<'_> {
        let ratio = if self.isotropic { self.slowing(d) } else { Vec3A::ONE };
        let (strength, log_range) = (self.strength[channel], self.log_range[channel]);
        Stretch { guide: self, guided: rng.f32() < SHARE, strength, log_range, from: p, ratio }
    }
}

/// A stretch that may be guided.
pub(super) struct Stretch<'a> {
    guide: &'a Guide,
    guided: bool,
    /// Of the channel.
    strength: f32,
    log_range: f32,
    from: Vec3,
    /// 1 − cµ_0, or the product of (4).
    ratio: Vec3A,
}

impl Stretch<'_> {
    /// `last` is what (3) has beside 1 − cµ_0 and the exponential.
    fn weigh_with(&self, c: &Coefficients, beta: Vec3A, way: Way, last: Vec3A) -> Vec3A {
        let guide = self.guide;
        let along = (way.p - self.from).dot(guide.frame.z_axis);
        let exponent = guide.strength * c.sigma_t * along;
        let small = fast_math::exp_negative(-exponent.abs().min(Vec3A::splat(LARGEST_EXPONENT)));
        let growth = Vec3A::select(exponent.cmpgt(Vec3A::ZERO), small.recip(), small);
        let ways = Vec3A::splat(1.0 - SHARE) + SHARE * self.ratio * last * growth;
        c.weigh_ways(beta, way.collisions, way.length, ways)
    }
}

impl Ways for Stretch<'_> {
    #[inline]
    fn flight(&self, t: f32, d: Vec3) -> f32 {
        if self.guided { t / (1.0 - self.strength * d.dot(self.guide.frame.z_axis)) } else { t }
    }

    /// (2), where scattering is isotropic.
    #[inline]
    fn direction(&self, rng: &mut SmallRng) -> Option<Vec3> {
        if !(self.guided && self.guide.isotropic) {
            return None;
        }
        let power = fast_math::exp_negative(Vec3A::splat(self.log_range * rng.f32())).x;
        let c = self.strength;
        let z = ((1.0 - (1.0 + c) * power) / c).clamp(-1.0, 1.0);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = fast_math::sin_cos_turns(rng.f32() - 0.5);
        Some(self.guide.frame * Vec3::new(radius * cos, radius * sin, z))
    }

    #[inline]
    fn collide(&mut self, d: Vec3) {
        if !self.guide.isotropic {
            self.ratio *= self.guide.slowing(d);
        }
    }

    #[inline]
    fn weigh(&self, c: &Coefficients, beta: Vec3A, way: Way, d: Vec3) -> Vec3A {
        let guide = self.guide;
        let last = if guide.isotropic { guide.powers[way.collisions] / guide.slowing(d) } else { Vec3A::ONE };
        self.weigh_with(c, beta, way, last)
    }

    #[inline]
    fn weigh_event(&self, c: &Coefficients, beta: Vec3A, way: Way) -> Vec3A {
        let guide = self.guide;
        let turns = way.collisions.saturating_sub(1);
        let last = if guide.isotropic { guide.powers[turns] } else { Vec3A::ONE };
        self.weigh_with(c, beta, way, last)
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectral::draw_flight;
    use super::*;

    fn coefficients(g: f32) -> Coefficients {
        Coefficients::new(Vec3::new(30.0, 100.0, 200.0), Vec3::new(700.0, 800.0, 900.0), g, 1.0)
    }

    /// Means and variances of two moments of walks of three events in an infinite medium.
    fn moments(c: &Coefficients, steering: &impl Steering) -> [(Vec3A, Vec3A); 2] {
        const N: usize = 200_000;
        let mut rng = SmallRng::new(11);
        let (mut sum, mut squares) = ([Vec3A::ZERO; 2], [Vec3A::ZERO; 2]);
        for _ in 0..N {
            let (mut p, mut d, mut length) = (Vec3::ZERO, Vec3::Z, 0.0);
            let (channel, mean_free_path) = c.draw_channel(Vec3A::ONE, &mut rng);
            let mut stretch = steering.stretch(channel, p, d, &mut rng);
            for _ in 0..3 {
                let t = stretch.flight(draw_flight(&mut rng) * mean_free_path, d);
                p += d * t;
                length += t;
                stretch.collide(d);
                d = stretch.direction(&mut rng).unwrap_or_else(|| c.phase.sample(d, rng.vec2()).0);
            }
            let way = Way { collisions: 3, length, p };
            let under_way = stretch.weigh(c, Vec3A::ONE, way, d) * (1.0 + d.x + 0.3 * d.z);
            let at_event = stretch.weigh_event(c, Vec3A::ONE, way) * (p.z * 500.0);
            for (i, value) in [under_way, at_event].into_iter().enumerate() {
                sum[i] += value;
                squares[i] += value * value;
            }
        }
        let n = N as f32;
        std::array::from_fn(|i| {
            let mean = sum[i] / n;
            (mean, (squares[i] / n - mean * mean) / n)
        })
    }

    /// Whatever the guide, the mean of the weight times a test function is the plain walk's. Twelve moments, |z| < 4.
    #[test]
    fn guided_walks_have_the_moments_of_plain_ones() {
        for g in [0.0, 0.6] {
            let c = coefficients(g);
            let guide = Guide::new(&c, Vec3::new(0.6, 0.0, 0.8), 0.004).expect("a thin part");
            let (plain, guided) = (moments(&c, &Plain), moments(&c, &guide));
            for i in 0..2 {
                let error = (plain[i].1 + guided[i].1).powf(0.5);
                let z = (plain[i].0 - guided[i].0) / error;
                assert!(z.abs().max_element() < 4.0, "g {g}, moment {i}: {:?} {:?}", plain[i], guided[i]);
            }
        }
    }

    /// However wrong the guide, weights are at most those of the defensive share.
    #[test]
    fn weights_are_bounded() {
        let c = coefficients(0.0);
        let guide = Guide::new(&c, Vec3::X, 0.01).expect("a thin part");
        let mut rng = SmallRng::new(3);
        for _ in 0..1000 {
            let stretch = guide.stretch(0, Vec3::ZERO, Vec3::NEG_X, &mut rng);
            let way = Way { collisions: 4, length: 0.02, p: Vec3::NEG_X * 0.02 };
            let beta = stretch.weigh(&c, Vec3A::ONE, way, Vec3::NEG_X);
            let plain = c.weigh(Vec3A::ONE, 4, 0.02);
            assert!((beta / plain).max_element() <= 1.0 / (1.0 - SHARE) + 1e-4);
        }
    }

    /// Where the light comes in, and through thick parts, walks are plain.
    #[test]
    fn guides_only_where_it_pays() {
        let c = coefficients(0.0);
        assert!(Guide::new(&c, Vec3::X, 1e-6).is_none() && Guide::new(&c, Vec3::X, 1.0).is_none());
    }
}
