//! `light-biased`: the preview. The report from which this project grew looked for the exit point where the closest light
//! is, and added the BRDF approximation:
//!
//! 1. enter along the inward normal to a random depth −ln ξ/σt (one channel's σt, spectral MIS over the channels);
//! 2. aim from there at a random point of the closest light;
//! 3. intersect the object itself: the exit point, s metres away;
//! 4. add α/(4π) e^{−σt s} F_t(ω_i) L, with L attenuated by the distance to the light as any light is, where nothing
//!    outside is in the way;
//! 5. let the path leave where it entered, by [`super::BrdfApproximation`], which sees all lights.
//!
//! **Bias.** Light of step 4 is scattered once and goes straight through the boundary; the phase function is taken for
//! isotropic. Single scattering is also in f⁽¹⁾ of step 5, so it counts twice; light that is scattered more often comes in
//! where it leaves, so nothing bleeds sideways, and other lights than the closest do not shine through.

use super::brdf_approximation::leave_here;
use super::from_boundary::{FromBoundary, or_walk};
use super::spectral::{Coefficients, draw_flight};
use super::tables::sigmas_at;
use super::{Arrival, Connector, Flight, PathHead, Propagator, SubsurfaceModel};
use crate::geometry::{Hit, Ray, offset_origin};
use crate::optics::diffusion::Cosines;
use crate::optics::fresnel;
use crate::sampling::Sampler;
use crate::scene::{Scene, Surface};
use glam::Vec3;
use std::f32::consts::PI;

/// The light-biased preview.
#[derive(Clone, Copy, Debug)]
pub struct LightBiased {
    /// Which cosines divide single scattering.
    pub cosines: Cosines,
}

impl SubsurfaceModel for LightBiased {
    fn name(&self) -> &str {
        "light-biased"
    }

    fn summary(&self) -> &str {
        "preview: BRDF approximation and a glimpse of the closest light through the object; biased"
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        or_walk(Preview { cosines: self.cosines }, scene)
    }
}

struct Preview {
    cosines: Cosines,
}

impl FromBoundary for Preview {
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        hit: &Hit,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        shine_through(flight, head, hit, sampler, connector);
        head.events += 1;
        Arrival::Exit(Box::new(leave_here(flight, head, hit, self.cosines)))
    }
}

/// Steps 1 to 4.
fn shine_through(
    flight: &Flight<'_>,
    head: &PathHead,
    hit: &Hit,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) {
    let geometry = &flight.scene.geometry;
    let from = geometry.surface(hit);
    let (sigma_a, sigma_s) = sigmas_at(flight, from.position);
    let c = Coefficients::of_one_event(sigma_a, sigma_s, 0.0);
    let beta = head.throughput.into();
    let depth = draw_flight(sampler.rng()) * c.draw_mean_free_path(beta, sampler.rng());
    let down = -from.geometric_normal;
    let origin = offset_origin(from.position, from.error, from.geometric_normal, down);
    let way = Ray { origin, direction: down, t_max: depth };
    if !depth.is_finite() || geometry.intersect_instance(hit.instance, &way).is_some() {
        return;
    }
    let point = way.at(depth);
    let Some(light) = connector.closest_light(point, sampler) else { return };
    let out = Ray { origin: point, direction: light.direction, t_max: light.distance };
    let Some(hit) = geometry.intersect_instance(hit.instance, &out) else { return };
    let surface = Surface::new(flight.scene, &hit);
    let cos = light.direction.dot(surface.normal);
    if cos <= 0.0 {
        return;
    }
    let eta = flight.eta;
    let entering = (1.0 - fresnel::dielectric(cos, eta)) * eta * eta;
    let (sigma_a, sigma_s) = sigmas_at(flight, surface.position);
    let scattered = Vec3::from(c.weigh(beta, 1, depth)) * (-(sigma_a + sigma_s) * hit.t).exp();
    let tint = flight.scene.straight_transmission(&surface);
    connector.deliver(&surface, &light, hit.t, scattered * tint * (entering / (4.0 * PI)), sampler);
}
