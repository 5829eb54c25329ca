//! Models that know what happens to light that came in through the boundary of an object. Where a path is inside for another
//! reason (the camera is, or it came through the boundary of another object) there is no x_o, and the walk takes over.

use super::{Arrival, Connector, Flight, PathHead, Propagator, RandomWalk, SubsurfaceModel};
use crate::geometry::Hit;
use crate::sampling::Sampler;
use crate::scene::Scene;

/// Answers for flights that begin at the boundary.
pub(super) trait FromBoundary: Send + Sync {
    /// As [`Propagator::propagate`]; `entry` is the point of the boundary.
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        entry: &Hit,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival;
}

struct OrWalk<M> {
    model: M,
    walk: Box<dyn Propagator>,
}

/// The model, with the walk for all other flights.
pub(super) fn or_walk(model: impl FromBoundary + 'static, scene: &Scene) -> Box<dyn Propagator> {
    Box::new(OrWalk { model, walk: RandomWalk.prepare(scene) })
}

impl<M: FromBoundary> Propagator for OrWalk<M> {
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        match flight.entry(head) {
            Some(entry) => self.model.arrive(flight, head, &entry, sampler, connector),
            None => self.walk.propagate(flight, head, sampler, connector),
        }
    }
}
