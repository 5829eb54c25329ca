//! `single-scattering`: the term L^(1) of Jensen et al. 2001 (§3.2): light that is scattered exactly once.
//!
//! A distance is drawn along the refracted view ray, s_o' = −ln ξ/σt with one channel's σt (spectral MIS over the channels),
//! and the point there is connected to a light. The connection is a straight line; where it leaves the object at distance
//! s_i with outside cosine |ω_i·n_i|, the refracted path has about the length
//!
//! ```text
//! s_i' = s_i |ω_i·n_i| / √(1 − (1 − |ω_i·n_i|²)/η²)
//! ```
//!
//! With the radiance η² T L inside and dω' = cos θ_i/(η² cos θ_i') dω, the light arriving at the point is
//! T L cos θ_i/cos θ_i': the factor without which the printed L^(1) is not physical.
//!
//! Textured coefficients are those of x_o for scattering and the way to the camera, those of x_i for the way of the light
//! (Jensen et al. 2001, §3.3).

use super::from_boundary::{FromBoundary, or_walk};
use super::spectral::{Coefficients, draw_flight};
use super::tables::sigmas_at;
use super::{Arrival, Connector, Flight, PathHead, Propagator, SubsurfaceModel};
use crate::geometry::{Hit, Ray};
use crate::optics::fresnel;
use crate::sampling::Sampler;
use crate::scene::{Scene, Surface};
use glam::Vec3;

/// Single scattering alone.
#[derive(Clone, Copy, Debug)]
pub struct SingleScattering;

impl SubsurfaceModel for SingleScattering {
    fn name(&self) -> &str {
        "single-scattering"
    }

    fn summary(&self) -> &str {
        "light that is scattered exactly once (Jensen et al. 2001)"
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        or_walk(Single, scene)
    }
}

struct Single;

impl FromBoundary for Single {
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        _: &Hit,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        connect(flight, head, sampler, connector);
        head.events += 1;
        Arrival::Ended
    }
}

/// Adds the light that is scattered once along the path that has just entered; the path itself stays where it is.
pub(super) fn connect(
    flight: &Flight<'_>,
    head: &PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) {
    let medium = flight.medium;
    let (sigma_a, sigma_s) = sigmas_at(flight, head.position);
    let c = Coefficients::of_one_event(sigma_a, sigma_s, medium.g);
    let beta = head.throughput.into();
    let t = draw_flight(sampler.rng()) * c.draw_mean_free_path(beta, sampler.rng());
    let instance = flight.enclosure.instance;
    let geometry = &flight.scene.geometry;
    let way = Ray { origin: head.position, direction: head.direction, t_max: t };
    if !t.is_finite() || geometry.intersect_instance(instance, &way).is_some() {
        return;
    }
    let point = way.at(t);
    let Some(light) = connector.light(point, sampler) else { return };
    let out = Ray { origin: point, direction: light.direction, t_max: light.distance };
    let Some(hit) = geometry.intersect_instance(instance, &out) else { return };
    let surface = Surface::new(flight.scene, &hit);
    let n = surface.normal;
    let cos = light.direction.dot(n);
    if cos <= 0.0 {
        return;
    }
    let eta = flight.eta;
    let cos_inside = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    if cos_inside <= 0.0 {
        return;
    }
    let length = hit.t * cos / cos_inside;
    // Refracted towards the light: the tangential part shrinks by η.
    let inside = ((light.direction - cos * n) / eta + cos_inside * n).normalize();
    let phase = c.phase.eval_directions(head.direction, inside);
    let entering = (1.0 - fresnel::dielectric(cos, eta)) * cos / cos_inside;
    let (sigma_a, sigma_s) = sigmas_at(flight, surface.position);
    let scattered = Vec3::from(c.weigh(beta, 1, t)) * (-(sigma_a + sigma_s) * length).exp();
    let tint = flight.scene.straight_transmission(&surface);
    connector.deliver(&surface, &light, hit.t, scattered * tint * (phase * entering), sampler);
}
