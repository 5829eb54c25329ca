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

use super::{Arrival, Connector, Flight, PathHead, Propagator, SubsurfaceModel, textured};
use crate::geometry::{Hit, Ray, offset_origin};
use crate::optics::phase;
use crate::sampling::{Sampler, SmallRng};
use crate::scene::Scene;
use glam::Vec3;

/// Below this throughput (largest channel, radiance scale of the outside) paths play Russian roulette.
const ROULETTE_BELOW: f32 = 0.5;

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
        connector: Option<&mut dyn Connector>,
    ) -> Arrival {
        let material = flight.scene.material(flight.enclosure.material);
        let textures = material.medium.as_ref();
        if textures.is_some_and(|m| m.absorption_texture.is_some() || m.scattering_texture.is_some()) {
            return textured::propagate(flight, head, sampler, connector);
        }
        match (&flight.object.distance, connector) {
            (Some(_), None) => walk_alone(flight, head, sampler.rng()),
            (_, connector) => walk_in_scene(flight, head, sampler, connector),
        }
    }
}

/// Coefficients of a homogeneous medium in the units of the walk.
#[derive(Clone, Copy)]
pub(super) struct Coefficients {
    pub sigma_s: Vec3,
    pub sigma_t: Vec3,
    pub g: f32,
    grey: bool,
}

impl Coefficients {
    pub fn new(sigma_a: Vec3, sigma_s: Vec3, g: f32, scale: f32) -> Self {
        let sigma_t = (sigma_a + sigma_s) * scale;
        let grey = sigma_t.x == sigma_t.y && sigma_t.y == sigma_t.z;
        Self { sigma_s: sigma_s * scale, sigma_t, g, grey }
    }

    /// A free flight drawn from the mixture over channels.
    #[inline]
    pub fn sample_distance(&self, throughput: Vec3, rng: &mut SmallRng) -> f32 {
        let sigma_t =
            if self.grey { self.sigma_t.x } else { pick_channel(self.sigma_t, throughput, rng.f32()) };
        if sigma_t > 0.0 { -rng.open01().ln() / sigma_t } else { f32::INFINITY }
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

    /// e^{−σt t} up to a common factor, which both weights cancel: relative to the clearest channel that still carries
    /// light, so that the sum cannot underflow.
    #[inline]
    fn relative_transmittance(&self, throughput: Vec3, t: f32) -> Vec3 {
        let carried = Vec3::select(throughput.cmpgt(Vec3::ZERO), self.sigma_t, Vec3::INFINITY);
        ((Vec3::splat(carried.min_element()) - self.sigma_t).min(Vec3::ZERO) * t).exp()
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
fn walk_alone(flight: &Flight<'_>, head: &mut PathHead, rng: &mut SmallRng) -> Arrival {
    let instance = flight.enclosure.instance;
    let Some(distance) = flight.object.distance.as_deref() else { return Arrival::Ended };
    let mesh = flight.scene.geometry.mesh_of(instance);
    let transform = flight.scene.geometry.transform(instance);
    let medium = flight.medium;
    let c = Coefficients::new(medium.sigma_a, medium.sigma_s, medium.g, transform.scale);
    let radiance_scale = medium.ior * medium.ior;

    let mut d = transform.inverse_direction(head.direction);
    let mut p = match &head.start {
        Some(s) if s.instance == instance => {
            let (p, error) = mesh.point(s.triangle, s.barycentric.x, s.barycentric.y);
            offset_origin(p, error, mesh.geometric_normal(s.triangle), d)
        }
        _ => transform.inverse_point(head.position),
    };
    let mut beta = head.throughput;
    let mut first = true;
    let arrival = loop {
        let t = c.sample_distance(beta, rng);
        // The first flight starts on the boundary, where the bound is zero.
        if first || t >= distance.bound(p) {
            first = false;
            if let Some(hit) = mesh.intersect(&Ray { origin: p, direction: d, t_max: t }) {
                beta = c.arrival(beta, hit.t);
                p += d * hit.t;
                let t = hit.t * transform.scale;
                break Arrival::Surface(Hit { t, instance, triangle: hit.triangle, u: hit.u, v: hit.v });
            }
            if t == f32::INFINITY {
                break Arrival::Escaped;
            }
        }
        beta = c.collision(beta, t);
        p += d * t;
        d = phase::sample(c.g, d, rng);
        head.events += 1;
        if head.events >= flight.budget || !roulette(&mut beta, radiance_scale, rng) {
            break Arrival::Ended;
        }
    };
    head.position = transform.point(p);
    head.direction = transform.direction(d);
    head.throughput = beta;
    arrival
}

/// The walk among whatever else is inside, in world space.
fn walk_in_scene(
    flight: &Flight<'_>,
    head: &mut PathHead,
    sampler: &mut Sampler,
    mut connector: Option<&mut dyn Connector>,
) -> Arrival {
    let medium = flight.medium;
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
        if !scatter(head, c.g, sampler, &mut connector) {
            return Arrival::Ended;
        }
        if head.events >= flight.budget || !roulette(&mut head.throughput, radiance_scale, sampler.rng()) {
            return Arrival::Ended;
        }
    }
}

/// A scattering event, with connections to lights where they can be made. False: nothing is left to carry.
pub(super) fn scatter(
    head: &mut PathHead,
    g: f32,
    sampler: &mut Sampler,
    connector: &mut Option<&mut dyn Connector>,
) -> bool {
    head.events += 1;
    if head.throughput.max_element() <= 0.0 {
        return false;
    }
    let incoming = head.direction;
    if let Some(connector) = connector {
        connector.scattered(head.position, incoming, head.throughput, g, sampler);
    }
    head.direction = phase::sample(g, incoming, sampler.rng());
    if let Some(connector) = connector {
        connector.redirected(head.position, phase::eval(g, incoming.dot(head.direction)));
    }
    true
}
