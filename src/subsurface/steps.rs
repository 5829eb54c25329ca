//! What walks have in common at an event: roulette, new directions, connections to lights.

use super::{Connector, PathHead};
use crate::geometry::{Hit, MeshHit};
use crate::optics::HenyeyGreenstein;
use crate::sampling::{Sampler, SmallRng, fast_math};
use glam::Vec3;

/// Below this throughput (largest channel, radiance scale of the outside) paths play Russian roulette.
const ROULETTE_BELOW: f32 = 0.5;

/// Russian roulette of a path of the given largest throughput, in the radiance scale of the outside: what to multiply its
/// throughput with, zero where it ends.
#[inline]
pub(super) fn survival(largest: f32, rng: &mut SmallRng) -> f32 {
    if largest >= ROULETTE_BELOW {
        1.0
    } else if rng.f32() * ROULETTE_BELOW < largest {
        ROULETTE_BELOW / largest
    } else {
        0.0
    }
}

/// A new direction of travel.
#[inline(always)]
pub(super) fn redirect(phase: HenyeyGreenstein, incoming: Vec3, rng: &mut SmallRng) -> Vec3 {
    if phase.g == 0.0 { uniform_direction(rng) } else { phase.sample(incoming, rng.vec2()).0 }
}

/// A direction uniform over the sphere.
#[inline]
pub(super) fn uniform_direction(rng: &mut SmallRng) -> Vec3 {
    let z = 1.0 - 2.0 * rng.f32();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = fast_math::sin_cos_turns(rng.f32() - 0.5);
    Vec3::new(radius * cos, radius * sin, z)
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
        connector.scattered(head.position, incoming, head.throughput, phase, head.events, sampler);
    }
    head.direction = redirect(phase, incoming, sampler.rng());
    if let Some(connector) = connector {
        connector.redirected(head.position, phase.eval_directions(incoming, head.direction));
    }
    true
}

/// A hit of an instance's mesh as one of the scene.
pub(super) fn placed(hit: &MeshHit, instance: u32, scale: f32) -> Hit {
    let &MeshHit { t, triangle, u, v, band, crowded } = hit;
    Hit { t: t * scale, instance, triangle, u, v, band: band * scale, crowded }
}
