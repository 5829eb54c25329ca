//! `random-walk`: the ground truth. Volumetric path tracing from boundary to boundary, nothing approximated.
//!
//! | code | symbol | unit |
//! | --- | --- | --- |
//! | `sigma_t`, `sigma_s` | σt, σs | 1/m |
//! | `t` | free flight | m |
//! | `throughput` | β | 1 |
//!
//! **Distances.** A channel c is drawn with probability p_c = β_c/Σβ and the free flight from σt_c e^{−σt_c t}. The
//! estimator is weighted by the balance heuristic over channels: a collision at t has density Σ p_c σt_c e^{−σt_c t},
//! an arrival at a boundary at distance s has probability Σ p_c e^{−σt_c s}, so
//!
//! ```text
//! collision: β_k ← β_k σs_k e^{−σt_k t} / Σ_c p_c σt_c e^{−σt_c t}
//! boundary:  β_k ← β_k e^{−σt_k s} / Σ_c p_c e^{−σt_c s}
//! ```
//!
//! With p_c ∝ β_c the sum Σβ never grows. For albedo 1 this drawing at each event equals drawing one channel for the
//! whole path and weighting by the products of densities (β_c is that product), at no cost in memory.
//!
//! **Short queries.** In an object that contains nothing else the walk runs in the object's own space, and a flight
//! shorter than a lower bound of the distance to the boundary ([`crate::geometry::DistanceBound`]) asks no ray query.
//!
//! **Aimed connections.** At an event near the boundary, with probability a (less with depth and for paths of little
//! weight), a direction of density q is also aimed at a light beyond the boundary ([`super::Aim`]), and the light that it
//! finds directly is added. The path itself may find the same light: its direction has density p (the phase function),
//! and it reaches the boundary with probability P. Both are weighed by the power heuristic with r = a q/(p P)
//! ([`PathHead::aimed`]): 1/(1 + r²) for the path, r²/(1 + r²) for the aimed direction, and the sampling of light at the
//! boundary, which both share, cancels.

use super::{Aim, Arrival, Connection, Connector, Flight, PathHead, Propagator, SubsurfaceModel, textured};
use crate::geometry::{DistanceBound, Hit, MeshGeometry, MeshHit, Ray, Similarity, offset_origin};
use crate::optics::HenyeyGreenstein;
use crate::sampling::{Sampler, SmallRng, fast_math};
use crate::scene::Scene;
use glam::{Vec2, Vec3};

/// Below this throughput (largest channel, radiance scale of the outside) paths play Russian roulette.
const ROULETTE_BELOW: f32 = 0.5;

/// Depth below the boundary, in the longest mean free path, down to which directions are aimed at lights.
const AIMING_DEPTH: f32 = 2.0;
/// Probability of aiming at the boundary, and how fast it falls with depth. Measured: more costs more than it saves.
const AIMING_RATE: f32 = 0.35;
const AIMING_FALLOFF: f32 = 1.5;

/// Ratios of densities are cut here, so that their squares stay finite.
const LARGEST_RATIO: f32 = 1e15;

/// The ground truth.
pub struct RandomWalk;

impl SubsurfaceModel for RandomWalk {
    fn name(&self) -> &str {
        "random-walk"
    }

    fn summary(&self) -> &str {
        "volumetric path tracing below the surface: the ground truth"
    }

    fn prepare(&self, _scene: &Scene) -> Box<dyn Propagator> {
        Box::new(Walker)
    }
}

struct Walker;

impl Propagator for Walker {
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        let material = flight.scene.material(flight.enclosure.material);
        let textures = material.medium.as_ref();
        if textures.is_some_and(|m| m.absorption_texture.is_some() || m.scattering_texture.is_some()) {
            return textured::propagate(flight, head, sampler, connector);
        }
        match (&flight.object.distance, flight.connection) {
            (Some(distance), Connection::None | Connection::Boundary) => {
                walk_alone(flight, distance, head, sampler, connector)
            }
            _ => walk_in_scene(flight, head, sampler, connector),
        }
    }
}

/// Coefficients of a homogeneous medium in the units of the walk.
#[derive(Clone, Copy)]
pub(super) struct Coefficients {
    pub sigma_s: Vec3,
    pub sigma_t: Vec3,
    pub phase: HenyeyGreenstein,
    grey: bool,
}

impl Coefficients {
    pub fn new(sigma_a: Vec3, sigma_s: Vec3, g: f32, scale: f32) -> Self {
        let sigma_t = (sigma_a + sigma_s) * scale;
        let grey = sigma_t.x == sigma_t.y && sigma_t.y == sigma_t.z;
        Self { sigma_s: sigma_s * scale, sigma_t, phase: HenyeyGreenstein { g }, grey }
    }

    /// A free flight drawn from the mixture over channels.
    #[inline]
    pub fn sample_distance(&self, throughput: Vec3, rng: &mut SmallRng) -> f32 {
        let sigma_t =
            if self.grey { self.sigma_t.x } else { pick_channel(self.sigma_t, throughput, rng.f32()) };
        if sigma_t > 0.0 { -fast_math::ln(rng.open01()) / sigma_t } else { f32::INFINITY }
    }

    /// The weight of a collision at `t`.
    #[inline]
    pub fn collision(&self, throughput: Vec3, t: f32) -> Vec3 {
        if self.grey {
            return throughput * self.sigma_s / self.sigma_t.x;
        }
        let transmittance = self.relative_transmittance(throughput, t);
        let density = (throughput * self.sigma_t * transmittance).element_sum() / throughput.element_sum();
        throughput * self.sigma_s * transmittance / density
    }

    /// The weight of reaching `t` without a collision.
    #[inline]
    pub fn arrival(&self, throughput: Vec3, t: f32) -> Vec3 {
        if self.grey {
            return throughput;
        }
        let transmittance = self.relative_transmittance(throughput, t);
        throughput * transmittance * (throughput.element_sum() / (throughput * transmittance).element_sum())
    }

    /// The probability to reach `t` without a collision, under the mixture over channels.
    #[inline]
    pub fn arrival_probability(&self, throughput: Vec3, t: f32) -> f32 {
        (throughput * (-self.sigma_t * t).exp()).element_sum() / throughput.element_sum()
    }

    /// e^{−σt t} up to a common factor, which both weights cancel: relative to the clearest channel that still carries
    /// light, so that the sum cannot underflow.
    #[inline]
    fn relative_transmittance(&self, throughput: Vec3, t: f32) -> Vec3 {
        let carried = Vec3::select(throughput.cmpgt(Vec3::ZERO), self.sigma_t, Vec3::INFINITY);
        fast_math::exp_negative((Vec3::splat(carried.min_element()) - self.sigma_t).min(Vec3::ZERO) * t)
    }
}

/// The element of `values` drawn with probability proportional to `weights`.
#[inline]
fn pick_channel(values: Vec3, weights: Vec3, u: f32) -> f32 {
    let u = u * weights.element_sum();
    if u < weights.x {
        values.x
    } else if u < weights.x + weights.y {
        values.y
    } else {
        values.z
    }
}

/// Russian roulette by throughput; `scale` brings it to the radiance of the outside. False: the path ends.
#[inline]
pub(super) fn roulette(throughput: &mut Vec3, scale: f32, rng: &mut SmallRng) -> bool {
    let largest = throughput.max_element() * scale;
    if largest >= ROULETTE_BELOW {
        return true;
    }
    if largest > 0.0 && rng.f32() * ROULETTE_BELOW < largest {
        *throughput *= ROULETTE_BELOW / largest;
        return true;
    }
    false
}

/// The walk in an object that contains nothing else, in the object's own space.
fn walk_alone(
    flight: &Flight<'_>,
    distance: &DistanceBound,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let instance = flight.enclosure.instance;
    let mesh = flight.scene.geometry.mesh_of(instance);
    let transform = flight.scene.geometry.transform(instance);
    let medium = flight.medium;
    let c = Coefficients::new(medium.sigma_a, medium.sigma_s, medium.g, transform.scale);
    let radiance_scale = medium.ior * medium.ior;
    let least_sigma_t = c.sigma_t.min_element();
    let aims = flight.connection == Connection::Boundary;
    let mut aiming = Aiming { mesh, transform, distance, aim: Aim::default(), rate: 0.0, state: None };
    let mut phase_pdf = 0.0;

    let mut d = transform.inverse_direction(head.direction);
    let mut p = match &head.start {
        Some(s) if s.instance == instance => {
            let (p, error) = mesh.point(s.triangle, s.barycentric.x, s.barycentric.y);
            offset_origin(p, error, mesh.geometric_normal(s.triangle), d)
        }
        _ => transform.inverse_point(head.position),
    };
    let mut beta = head.throughput;
    let bounds = mesh.bounds();
    let mut bound = 0.0;
    let arrival = loop {
        let t = c.sample_distance(beta, sampler.rng());
        if t >= bound {
            if let Some(hit) = mesh.intersect(&Ray { origin: p, direction: d, t_max: t }) {
                if aiming.rate > 0.0 && aiming.ready(p, bound, connector) {
                    let density = phase_pdf * c.arrival_probability(beta, hit.t);
                    let aimed = aiming.rate * aiming.aim.pdf(transform.direction(d));
                    head.aimed = (aimed / density).min(LARGEST_RATIO);
                }
                beta = c.arrival(beta, hit.t);
                p += d * hit.t;
                break Arrival::Surface(placed(&hit, instance, transform.scale));
            }
            if t == f32::INFINITY {
                break Arrival::Escaped;
            }
        }
        beta = c.collision(beta, t);
        p += d * t;
        head.events += 1;
        if head.events >= flight.budget || !roulette(&mut beta, radiance_scale, sampler.rng()) {
            break Arrival::Ended;
        }
        bound = distance.bound(p);
        if bound == 0.0 && !bounds.contains(p) {
            // Rounding next to a sharp edge has let the walk out.
            break Arrival::Escaped;
        }
        aiming.forget();
        let depth = bound * least_sigma_t;
        if aims && depth < AIMING_DEPTH {
            // A path of little weight is not worth aiming.
            let worth = (beta.max_element() * radiance_scale).min(1.0);
            aiming.rate = AIMING_RATE * worth * (-AIMING_FALLOFF * depth).exp();
            if sampler.rng().f32() < aiming.rate
                && aiming.ready(p, bound, connector)
                && let Some((direction, pdf)) = aiming.aim.sample(sampler.rng())
            {
                let local = transform.inverse_direction(direction);
                let ray = Ray { origin: p, direction: local, t_max: f32::INFINITY };
                if let Some(hit) = mesh.intersect(&ray) {
                    let phase = c.phase.eval_directions(d, local);
                    let density = phase * c.arrival_probability(beta, hit.t);
                    let throughput = beta * (-c.sigma_t * hit.t).exp() * (phase / (pdf * aiming.rate));
                    let ratio = (aiming.rate * pdf / density).min(LARGEST_RATIO);
                    let hit = placed(&hit, instance, transform.scale);
                    connector.emerge(&hit, direction, throughput, ratio, sampler);
                }
            }
        }
        let incoming = d;
        d = redirect(c.phase, incoming, sampler.rng());
        if aiming.rate > 0.0 {
            phase_pdf = c.phase.eval_directions(incoming, d);
        }
    };
    head.position = transform.point(p);
    head.direction = transform.direction(d);
    head.throughput = beta;
    arrival
}

/// Aiming at the last event: how likely it was, and the directions, which are found when they are asked for.
struct Aiming<'a> {
    mesh: &'a MeshGeometry,
    transform: &'a Similarity,
    distance: &'a DistanceBound,
    aim: Aim,
    /// Probability that a direction was aimed.
    rate: f32,
    /// Whether there is anything to aim at, once that is known.
    state: Option<bool>,
}

impl Aiming<'_> {
    fn forget(&mut self) {
        self.rate = 0.0;
        self.state = None;
    }

    /// Finds the directions from `p`, where the boundary is at least `bound` away.
    fn ready(&mut self, p: Vec3, bound: f32, connector: &mut dyn Connector) -> bool {
        if let Some(state) = self.state {
            return state;
        }
        let state = self.mesh.nearest(p, self.distance.reach(bound)).is_some_and(|nearest| {
            let normal = self.transform.direction(self.mesh.geometric_normal(nearest.triangle));
            connector.aim(self.transform.point(p), normal, &mut self.aim)
        });
        self.state = Some(state);
        state
    }
}

/// A hit of an instance's mesh as one of the scene.
fn placed(hit: &MeshHit, instance: u32, scale: f32) -> Hit {
    Hit { t: hit.t * scale, instance, triangle: hit.triangle, u: hit.u, v: hit.v }
}

/// The walk among whatever else is inside, in world space.
fn walk_in_scene(
    flight: &Flight<'_>,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let medium = flight.medium;
    let straight = flight.connection == Connection::Straight;
    let c = Coefficients::new(medium.sigma_a, medium.sigma_s, medium.g, 1.0);
    let radiance_scale = medium.ior * medium.ior;
    loop {
        let t = c.sample_distance(head.throughput, sampler.rng());
        let ray = Ray { origin: head.position, direction: head.direction, t_max: t };
        if let Some(hit) = flight.scene.geometry.intersect(&ray) {
            head.throughput = c.arrival(head.throughput, hit.t);
            head.position += head.direction * hit.t;
            return Arrival::Surface(hit);
        }
        if t == f32::INFINITY {
            return Arrival::Escaped;
        }
        head.throughput = c.collision(head.throughput, t);
        head.position += head.direction * t;
        if !scatter(head, c.phase, sampler, straight.then_some(&mut *connector)) {
            return Arrival::Ended;
        }
        if head.events >= flight.budget || !roulette(&mut head.throughput, radiance_scale, sampler.rng()) {
            return Arrival::Ended;
        }
    }
}

/// A new direction of travel.
#[inline]
fn redirect(phase: HenyeyGreenstein, incoming: Vec3, rng: &mut SmallRng) -> Vec3 {
    if phase.g == 0.0 { uniform_direction(rng) } else { phase.sample(incoming, rng.vec2()).0 }
}

/// A direction uniform over the sphere, without trigonometry (Marsaglia 1972).
#[inline]
fn uniform_direction(rng: &mut SmallRng) -> Vec3 {
    loop {
        let p = rng.vec2() * 2.0 - Vec2::ONE;
        let s = p.length_squared();
        if s < 1.0 {
            return (p * (2.0 * (1.0 - s).sqrt())).extend(1.0 - 2.0 * s);
        }
    }
}

/// A scattering event, with connections to lights where they can be made. False: nothing is left to carry.
pub(super) fn scatter(
    head: &mut PathHead,
    phase: HenyeyGreenstein,
    sampler: &mut Sampler,
    mut connector: Option<&mut dyn Connector>,
) -> bool {
    head.events += 1;
    if head.throughput.max_element() <= 0.0 {
        return false;
    }
    let incoming = head.direction;
    if let Some(connector) = &mut connector {
        connector.scattered(head.position, incoming, head.throughput, phase, sampler);
    }
    head.direction = redirect(phase, incoming, sampler.rng());
    if let Some(connector) = connector {
        connector.redirected(head.position, phase.eval_directions(incoming, head.direction));
    }
    true
}
