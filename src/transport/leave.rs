//! Where a path goes on from a surface: the direction that was sampled, what it is weighed with later, Russian roulette.

use super::direct::Shaded;
use super::path::PathTracer;
use super::state::{Path, Vertex};
use crate::optics::BsdfSample;
use crate::sampling::Sampler;
use crate::subsurface::Aimed;

/// Surface bounces after which throughput decides whether a path goes on.
const ROULETTE_AFTER: u32 = 3;
/// Below this throughput a path at a surface plays Russian roulette.
const ROULETTE_BELOW: f32 = 0.5;

impl PathTracer<'_> {
    /// Sends a path on its way in a sampled direction. False: it ends.
    pub(super) fn leave(
        &self,
        shaded: &Shaded<'_>,
        sample: &BsdfSample,
        connected: bool,
        path: &mut Path,
        sampler: &mut Sampler,
    ) -> bool {
        let geometric = shaded.surface.geometric_normal;
        let mut wi = (shaded.frame * sample.wi).normalize();
        let mut weighed = connected && !sample.delta;
        let to_front = shaded.front != sample.transmitted;
        let consistent = (wi.dot(geometric) > 0.0) == to_front;
        let above = if consistent || sample.transmitted || sample.wi.z <= 0.0 {
            None
        } else {
            self.free_above(shaded)
        };
        if !consistent && above.is_none() {
            // The shading normal sends the light through the triangle on the wrong side. Losing it would darken
            // silhouettes and break the furnace: it is mirrored back, and as no light sampling can make such a
            // connection it counts in full.
            wi -= 2.0 * wi.dot(geometric) * geometric;
            weighed = false;
        }
        // The aimed direction finds what a refracted ray of a smooth boundary finds, and what light sampling finds
        // through a rough one.
        let none = Aimed::default();
        let rival = if sample.transmitted && consistent { path.head.aimed } else { none };
        let aimed = if connected == weighed { rival } else { none };
        path.head.aimed = Aimed::default();
        if !sample.delta {
            path.footprint.scatter(sample.pdf);
        }
        path.head.throughput *= sample.weight;
        path.head.direction = wi;
        if let Some(crossing) = shaded.crossing.filter(|_| sample.transmitted) {
            path.head.throughput *= shaded.undispersed();
            crossing.apply(&mut path.stack);
        }
        // Through a boundary between equal indices light goes straight on, and so do shadow rays: what is found beyond it
        // is still weighed with the vertex before.
        if !(shaded.matched && sample.delta && sample.transmitted) {
            path.vertex = Vertex {
                point: above.unwrap_or(shaded.surface.position),
                anchor: shaded.anchor,
                pdf: sample.pdf,
                connected: weighed,
                lights: shaded.lights as f32,
                aimed,
            };
        }
        path.leave_surface(shaded.surface);
        if let Some(above) = above {
            path.head.position = above;
        }
        path.step_in_place(false);
        path.bounces += 1;
        self.survives(path, sampler)
    }

    /// Russian roulette by throughput, in the radiance scale of vacuum.
    fn survives(&self, path: &mut Path, sampler: &mut Sampler) -> bool {
        let ior = self.ior_in(&path.stack);
        let largest = path.head.throughput.max_element() * ior * ior;
        if largest <= 0.0 {
            return false;
        }
        if path.bounces <= ROULETTE_AFTER || largest >= ROULETTE_BELOW {
            return true;
        }
        if sampler.rng().f32() * ROULETTE_BELOW < largest {
            path.head.throughput *= ROULETTE_BELOW / largest;
            return true;
        }
        false
    }
}
