//! Directions inside a medium that lead through its boundary to light.
//!
//! A walk that meets a boundary in a random direction rarely refracts towards a lamp: for a rough boundary of GGX width
//! α only directions within about α(1 − 1/η) of the right one do. So directions are also *aimed*: choose an outside
//! direction ω_o towards light, a microfacet normal m of the boundary near by with density D(m) |m·n|, and refract:
//! ω = −refract(ω_o, m). The density of ω follows from the Jacobian of the half vector (Walter et al. 2007, eq. 17):
//!
//! ```text
//! q(ω | ω_o) = D(h) |h·n| η² |ω·h| / (ω_o·h − η ω·h)²,   h ∝ η ω − ω_o
//! ```
//!
//! D is wider than the boundary's own, to cover the bending of the surface. There are two ways to go on.
//!
//! - **Rough boundaries** ([`Aim::towards`]): a point of a light is sampled from the event, ω_o is the direction from the
//!   event to it, and n the normal where its light comes out if the boundary is taken for a plane: one step of manifold
//!   next-event estimation (Hanika et al. 2015), of which the lobe does the rest. Where the direction comes out, it is that
//!   very point ([`crate::light::LightPoint`]) that is connected, and lies in about the direction ω_o where it is far away.
//!   Path and point together have the density q(ω | ω_o) times that of the point: of any other technique's path and
//!   point of a light, ω_o and thus both densities can be told.
//! - **Smooth boundaries**, and nearly smooth ones ([`Aim::at_beacons`]): what comes out is not up to us, it is refracted
//!   on. The density must be that of ω alone, so ω_o is one of a handful of beacons ([`crate::light::beacon`]), and
//!   q(ω) = Σ_k w_k q(ω | ω_k), with D_k wide enough to cover the size of the light.

use crate::light::beacon::{Beacon, MOST};
use crate::light::{Anchor, LightSample};
use crate::optics::{fresnel, ggx};
use crate::sampling::{SmallRng, orthonormal_basis};
use crate::scene::NEARLY_SMOOTH;
use glam::{Mat3, Vec3};
use std::f32::consts::TAU;

/// How much wider than the boundary's own roughness the lobes are.
const WIDENING: f32 = 1.2;
/// Width that covers the bending of the surface between the nearest point and where the light comes out.
const CURVATURE: f32 = 0.06;
/// Light from farther below the horizon (sine of elevation) is not aimed at. That from just below is: the horizon of the
/// point where the direction comes out is another one.
const LOWEST: f32 = -0.5;
/// Widest lobe.
const WIDEST: f32 = 0.8;
/// Ratios of densities are cut here, so that their squares stay finite.
const LARGEST_RATIO: f32 = 1e15;

/// How a direction could have been aimed: the ratio of the density of aiming to that of the path itself, as a function
/// of the light beyond the boundary.
#[derive(Clone, Copy, Debug, Default)]
pub struct Aimed {
    /// The same for all light: beyond the boundary the direction is scattered on.
    fixed: f32,
    /// Times q(ω | ω_o): beyond the boundary the light ω_o is sampled.
    scale: f32,
    /// ω.
    direction: Vec3,
    /// What is aimed through.
    boundary: NearBoundary,
    alpha: f32,
    /// The unit direction from the event to a point of a light, and the normal of the boundary where that light comes out.
    light: Vec3,
    normal: Vec3,
    /// Whether the boundary leaves it to aiming to sample lights that can be found by chance, too.
    pub(crate) alone: bool,
}

impl Aimed {
    /// The same, for a point of a light in the unit direction `outside` from the event: its light comes out where the
    /// boundary has the normal that `emerging` finds.
    #[inline]
    pub fn resolve(mut self, outside: Vec3, emerging: impl FnOnce(&NearBoundary) -> Vec3) -> Self {
        if self.samples_light() && self.light != outside {
            self.normal = emerging(&self.boundary);
            self.light = outside;
        }
        self
    }

    /// Whether an aimed direction samples light beyond the boundary, rather than being scattered on.
    #[inline]
    pub fn samples_light(&self) -> bool {
        self.scale > 0.0
    }

    /// From where aimed directions have chosen their light, if they did.
    #[inline]
    pub fn anchor(&self) -> Option<Anchor> {
        self.samples_light().then(|| self.boundary.anchor())
    }

    /// The ratio for any light, where what comes out is scattered on; 0 where it samples light.
    #[inline]
    pub fn scattered_on(&self) -> f32 {
        self.fixed
    }

    /// The ratio for the point of a light that this was resolved for.
    #[inline]
    pub fn ratio(&self) -> f32 {
        let (normal, outside, eta) = (self.normal, self.light, self.boundary.eta);
        if outside.dot(normal) <= LOWEST {
            return 0.0;
        }
        let density = density(self.direction, outside, eta, self.alpha, |h| h.dot(normal));
        (self.scale * density).min(LARGEST_RATIO)
    }
}

/// q(ω | ω_o) for a lobe of width `alpha`; `cos` tells the cosine of a unit vector to the normal.
#[inline]
fn density(direction: Vec3, outside: Vec3, eta: f32, alpha: f32, cos: impl Fn(Vec3) -> f32) -> f32 {
    let half = eta * direction - outside;
    let length = half.length();
    if length <= 0.0 {
        return 0.0;
    }
    let h = half / length;
    let (cos_o, cos_i, cos_h) = (outside.dot(h), direction.dot(h), cos(h));
    if cos_h <= 0.0 || cos_o <= 0.0 || cos_i <= 0.0 {
        return 0.0;
    }
    let sin = (1.0 - cos_h * cos_h).max(0.0).sqrt();
    // |ω_o·h − η ω·h| is the length of the unnormalised half vector.
    ggx::distribution(Vec3::new(sin, 0.0, cos_h), alpha) * cos_h * eta * eta * cos_i / (length * length)
}

/// The boundary of an object, near to a point inside.
#[derive(Clone, Copy, Debug, Default)]
pub struct NearBoundary {
    /// The object.
    pub instance: u32,
    /// The point.
    pub point: Vec3,
    /// Outward unit normal of the boundary.
    pub normal: Vec3,
    /// Index inside over outside (> 1).
    pub eta: f32,
}

impl NearBoundary {
    /// Where lights are chosen that come in here.
    fn anchor(&self) -> Anchor {
        Anchor { point: self.point, normal: None, about: Some(self.normal) }
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Lobe {
    /// Towards the light, in the frame of the boundary.
    outside: Vec3,
    alpha: f32,
    /// Share of this lobe, and of all up to it.
    share: f32,
    cumulative: f32,
}

/// Aimed directions at one point.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    boundary: NearBoundary,
    frame: Mat3,
    /// The light that was aimed at.
    light: Vec3,
    /// GGX width of the boundary.
    alpha: f32,
    lobes: [Lobe; MOST],
    len: usize,
    chosen: Option<LightSample>,
    events: u32,
}

impl Default for Aim {
    fn default() -> Self {
        let (frame, lobes) = (Mat3::IDENTITY, [Lobe::default(); MOST]);
        Self {
            boundary: NearBoundary::default(),
            frame,
            light: Vec3::ZERO,
            alpha: 0.0,
            lobes,
            len: 0,
            chosen: None,
            events: 0,
        }
    }
}

impl Aim {
    /// Says which event of the flight it is, from 1, that is aimed from.
    pub fn set_events(&mut self, events: u32) {
        self.events = events;
    }

    /// Number of the event that is aimed from.
    pub fn events(&self) -> u32 {
        self.events
    }

    /// Aims through a boundary near by of GGX width `alpha`.
    pub fn set_boundary(&mut self, boundary: NearBoundary, alpha: f32) {
        let (x, y) = orthonormal_basis(boundary.normal);
        self.boundary = boundary;
        self.frame = Mat3::from_cols(x, y, boundary.normal);
        self.alpha = alpha;
        self.len = 0;
        self.chosen = None;
    }

    /// Whether to aim at light samples rather than at beacons.
    #[inline]
    pub fn samples_light(&self) -> bool {
        self.alpha >= NEARLY_SMOOTH
    }

    /// From where the light is chosen.
    #[inline]
    pub fn anchor(&self) -> Anchor {
        self.boundary.anchor()
    }

    /// The light that was aimed at, as it is seen from the event.
    #[inline]
    pub fn chosen(&self) -> Option<&LightSample> {
        self.chosen.as_ref()
    }

    /// Width of the lobes for light from one direction.
    #[inline]
    fn width(&self) -> f32 {
        (WIDENING * self.alpha).hypot(CURVATURE)
    }

    /// What is aimed through.
    pub fn boundary(&self) -> &NearBoundary {
        &self.boundary
    }

    /// Aims at a point of a light in the unit direction `outside`, whose light comes out where the boundary has this normal.
    /// False: it does not reach the boundary.
    pub fn towards(&mut self, outside: Vec3, normal: Vec3, chosen: LightSample) -> bool {
        let (x, y) = orthonormal_basis(normal);
        self.frame = Mat3::from_cols(x, y, normal);
        self.light = outside;
        let outside = self.frame.transpose() * outside;
        self.chosen = Some(chosen);
        self.lobes[0] = Lobe { outside, alpha: self.width().min(WIDEST), share: 1.0, cumulative: 1.0 };
        self.len = 1;
        outside.z > LOWEST
    }

    /// Aims at beacons from `point`. False: there is nothing to aim at.
    pub fn at_beacons(&mut self, beacons: &[Beacon], point: Vec3) -> bool {
        self.len = 0;
        let mut total = 0.0;
        for beacon in beacons {
            let seen = beacon.seen_from(point);
            let outside = self.frame.transpose() * seen.direction;
            // Large lights shine from above the horizon though their middle is below.
            let cosine = outside.z + 0.5 * seen.radius;
            if cosine <= 0.02 {
                continue;
            }
            let size = seen.radius / (self.boundary.eta - 1.0);
            let width = self.width().hypot(size).min(WIDEST);
            let share = seen.irradiance * cosine.min(1.0);
            total += share;
            self.lobes[self.len] = Lobe { outside, alpha: width, share, cumulative: total };
            self.len += 1;
        }
        if total <= 0.0 || !total.is_finite() {
            return false;
        }
        for lobe in &mut self.lobes[..self.len] {
            lobe.share /= total;
            lobe.cumulative /= total;
        }
        true
    }

    /// A unit direction of travel and its density per steradian.
    pub fn sample(&self, rng: &mut SmallRng) -> Option<(Vec3, f32)> {
        let u = rng.f32();
        let lobes = &self.lobes[..self.len];
        let lobe = lobes.iter().find(|l| u < l.cumulative).or(lobes.last())?;
        let (u, phi) = (rng.f32(), TAU * rng.f32());
        // D(m) |m·n|: tan²θ = α² u/(1 − u).
        let tan = lobe.alpha * (u / (1.0 - u)).sqrt();
        let m = Vec3::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalize();
        if lobe.outside.dot(m) <= 0.0 {
            return None;
        }
        let direction = -fresnel::refract(lobe.outside, m, self.boundary.eta)?.normalize();
        let pdf = self.pdf_local(direction);
        (pdf > 0.0).then(|| (self.frame * direction, pdf))
    }

    /// Density of [`Aim::sample`] at a unit direction of travel.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.pdf_local(self.frame.transpose() * direction)
    }

    fn pdf_local(&self, direction: Vec3) -> f32 {
        let of = |l: &Lobe| l.share * density(direction, l.outside, self.boundary.eta, l.alpha, |h| h.z);
        self.lobes[..self.len].iter().map(of).sum()
    }

    /// [`Aim::aimed`] of a direction that has just been drawn.
    pub fn drawn(&self, direction: Vec3, scale: f32) -> Aimed {
        self.aimed(direction, scale).resolve(self.light, |_| self.frame.z_axis)
    }

    /// How the direction of travel `direction` could have been aimed, with a probability of aiming at all that is `scale`
    /// times the density of the direction without aiming.
    pub fn aimed(&self, direction: Vec3, scale: f32) -> Aimed {
        let none = Aimed::default();
        if self.samples_light() {
            let (boundary, alpha) = (self.boundary, self.width().min(WIDEST));
            let normal = boundary.normal;
            Aimed { scale: scale.min(LARGEST_RATIO), direction, boundary, normal, alpha, ..none }
        } else {
            Aimed { fixed: (scale * self.pdf(direction)).min(LARGEST_RATIO), ..none }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Lights, beacon::beacons};
    use crate::scene::{EnvironmentDescription, PunctualKind, PunctualLight};

    fn aim() -> Aim {
        let light = |x: f32, y: f32, z: f32| PunctualLight {
            name: String::new(),
            intensity: Vec3::ONE,
            position: Vec3::new(x, y, z),
            direction: Vec3::NEG_Z,
            range: None,
            kind: PunctualKind::Point,
        };
        let punctual = [light(1.0, 0.0, 1.0), light(-2.0, 1.0, 0.5)];
        let environment = EnvironmentDescription::default();
        let lights = Lights::build(Vec::new(), &punctual, &environment);
        let mut aim = Aim::default();
        let normal = Vec3::new(0.1, 0.2, 0.97).normalize();
        aim.set_boundary(NearBoundary { instance: 0, point: Vec3::ZERO, normal, eta: 1.4 }, 0.3);
        assert!(aim.at_beacons(&beacons(&lights, &punctual), Vec3::ZERO));
        aim
    }

    #[test]
    fn the_density_is_that_of_the_samples() {
        // E_q[g/q] over the sampler must be the integral of g where q > 0; with g = a test function both sides are
        // computed: sampling, and uniform directions. |z| < 4.
        let aim = aim();
        let g = |d: Vec3| (1.0 + d.z).powi(2);
        let mut rng = SmallRng::new(7);
        const N: usize = 400_000;
        let (mut a, mut a2, mut b, mut b2, mut hits) = (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0u32);
        for _ in 0..N {
            if let Some((d, _)) = aim.sample(&mut rng) {
                let v = f64::from(g(d));
                a += v;
                a2 += v * v;
                hits += 1;
            }
            let d = crate::sampling::warp::uniform_sphere(rng.vec2());
            let v = f64::from(g(d) * aim.pdf(d) * 4.0 * std::f32::consts::PI);
            b += v;
            b2 += v * v;
        }
        let n = N as f64;
        let (ma, mb) = (a / n, b / n);
        let variance = (a2 / n - ma * ma + b2 / n - mb * mb) / n;
        let z = (ma - mb) / variance.sqrt();
        assert!(hits > N as u32 / 2);
        assert!(z.abs() < 4.0, "{ma} against {mb}, z {z}");
    }
}
