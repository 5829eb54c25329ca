//! How walks are connected to light through the boundary: guided ones at their events, plain ones where they meet it.

use super::intruders::Intruders;
use super::last_event::LastEvent;
use super::spectral::Coefficients;
use super::steps::placed;
use super::{Aim, Aimed, Connector};
use crate::geometry::{DistanceBound, MeshGeometry, MeshHit, Ray, Similarity};
use crate::sampling::{Sampler, fast_math};
use glam::{Vec3, Vec3A};

/// Depth below the boundary, in the longest mean free path, down to which directions are aimed at lights.
pub(super) const AIMING_DEPTH: f32 = 2.0;
/// Probability of aiming at the boundary, and how fast it falls with depth. Measured: more costs more than it saves.
pub(super) const AIMING_RATE: f32 = 0.5;
pub(super) const AIMING_FALLOFF: f32 = 1.5;
/// Connections where a walk meets the boundary: a smooth one, where no light is sampled for them and few get through,
/// can have more. Measured.
const CONNECTIONS: f32 = 2.0;
const SMOOTH_CONNECTIONS: f32 = 4.0;
/// Depth of the last event down to which that is done, in the longest mean free path: nearly all. Measured: with 2 instead
/// the variance is a tenth to a third larger.
const ARRIVAL_DEPTH: f32 = 5.0;

/// An event of a walk, in the object's own space.
#[derive(Clone, Copy)]
pub(super) struct Event {
    /// Where it was.
    pub p: Vec3,
    /// How far the boundary is from there, at least.
    pub clear: f32,
    /// Direction of travel before it.
    pub incoming: Vec3,
    /// Throughput there.
    pub beta: Vec3A,
}

/// A direction aimed at light, in world space and in the object's own.
struct Found {
    direction: Vec3,
    local: Vec3,
    /// Where it meets the boundary.
    hit: MeshHit,
    /// Density of the walk to turn to it.
    phase: f32,
    /// What light from there is worth, over the density of the direction.
    throughput: Vec3A,
}

/// Distance from the boundary, down to which events are connected to light.
pub(super) fn reach(c: &Coefficients) -> f32 {
    AIMING_DEPTH / c.sigma_t.min_element()
}

/// Connections of the walk in one object.
pub(super) struct Aiming<'a> {
    instance: u32,
    mesh: &'a MeshGeometry,
    transform: &'a Similarity,
    distance: &'a DistanceBound,
    intruders: &'a Intruders<'a>,
    /// Radiance inside for one outside.
    radiance_scale: f32,
    aim: Aim,
    /// Probability that a direction was aimed at the last event.
    rate: f32,
    /// Whether there is anything to aim at, once that is known.
    ready: Option<bool>,
    /// Events of the flight so far, for who is told of the light.
    pub events: u32,
}

impl<'a> Aiming<'a> {
    pub fn new(
        instance: u32,
        (mesh, transform, distance): (&'a MeshGeometry, &'a Similarity, &'a DistanceBound),
        intruders: &'a Intruders<'a>,
        radiance_scale: f32,
    ) -> Self {
        Self {
            instance,
            mesh,
            transform,
            distance,
            intruders,
            radiance_scale,
            aim: Aim::default(),
            rate: 0.0,
            ready: None,
            events: 0,
        }
    }

    /// No direction was aimed at the last event.
    #[inline]
    pub fn forget(&mut self) {
        self.rate = 0.0;
        self.ready = None;
    }

    /// Now and then connects an event to light.
    pub fn at_event(
        &mut self,
        c: &Coefficients,
        event: &Event,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) {
        let depth = event.clear * c.sigma_t.min_element();
        let decay = fast_math::exp_negative(Vec3A::splat(-AIMING_FALLOFF * depth));
        self.rate = AIMING_RATE * self.worth(event.beta) * decay.x;
        if sampler.rng().f32() < self.rate && self.is_ready(event, connector) {
            let Some(found) = self.draw(c, event, sampler, connector) else { return };
            self.aim.set_events(self.events);
            let density = found.phase * c.arrival_probability(event.beta, found.hit.t);
            let aimed = self.aim.drawn(found.direction, self.rate / density);
            self.emerge(&found, 1.0 / self.rate, aimed, sampler, connector);
        }
    }

    /// For a walk that turned to the direction `d` at the last event, and met the boundary at a length `t`: how it
    /// could have been aimed.
    pub fn aimed_at_event(
        &mut self,
        c: &Coefficients,
        event: &Event,
        (d, t): (Vec3, f32),
        connector: &mut dyn Connector,
    ) -> Aimed {
        if self.rate <= 0.0 || !self.is_ready(event, connector) {
            return Aimed::default();
        }
        let phase = c.phase.eval_directions(event.incoming, d);
        self.aim
            .aimed(self.transform.direction(d), self.rate / (phase * c.arrival_probability(event.beta, t)))
    }

    /// Connects the last event of a walk that has met something at a length `t` in direction `d`, if the boundary is near:
    /// [`LastEvent`] has the idea. The event's throughput is that before its stretch, of as many collisions on the way of a
    /// length. How the walk could have been aimed.
    #[inline(never)]
    pub fn at_arrival(
        &mut self,
        c: &Coefficients,
        event: Event,
        (collisions, length): (usize, f32),
        (d, t): (Vec3, f32),
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Aimed {
        if event.clear * c.sigma_t.min_element() >= ARRIVAL_DEPTH {
            return Aimed::default();
        }
        let worth = self.worth(event.beta);
        let channels = c.channels(event.beta, collisions, length);
        let event = &Event { beta: c.weigh(event.beta, collisions, length), ..event };
        let Some(normal) = self.normal(event) else { return Aimed::default() };
        if !connector.aim(self.transform.point(event.p), self.transform.direction(normal), &mut self.aim) {
            return Aimed::default();
        }
        let last = LastEvent::new(c, channels, event.incoming, (normal, event.clear));
        let rate = worth * last.rate();
        let mut aimed = self.aim.aimed(self.transform.direction(d), rate / last.density(d, t));
        aimed.alone = aimed.samples_light();
        let connections = if aimed.alone { CONNECTIONS } else { SMOOTH_CONNECTIONS };
        let often = connections * worth;
        let weight = last.weight(d, t) / often;
        if weight > 0.0 {
            self.aim.set_events(self.events);
            for _ in 0..(often + sampler.rng().f32()) as u32 {
                let Some(found) = self.draw(c, event, sampler, connector) else { continue };
                let density = last.density(found.local, found.hit.t);
                let mut towards = self.aim.drawn(found.direction, rate / density);
                towards.alone = aimed.alone;
                self.emerge(&found, weight, towards, sampler, connector);
            }
        }
        aimed
    }

    /// Aims a direction from an event at light, as far as the boundary.
    fn draw(
        &mut self,
        c: &Coefficients,
        event: &Event,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Option<Found> {
        let (direction, pdf) = connector.draw(self.transform.point(event.p), &mut self.aim, sampler)?;
        let local = self.transform.inverse_direction(direction);
        let hit = self.mesh.intersect(&Ray { origin: event.p, direction: local, t_max: f32::INFINITY })?;
        if hit.crowded || self.intruders.intersect(event.p, None, local, hit.t + hit.band).is_some() {
            return None;
        }
        let phase = c.phase.eval_directions(event.incoming, local);
        let throughput = event.beta * c.transmittance(hit.t) * (phase / pdf);
        Some(Found { direction, local, hit, phase, throughput })
    }

    /// Adds the light that comes in where a direction meets the boundary.
    fn emerge(
        &self,
        found: &Found,
        weight: f32,
        aimed: Aimed,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) {
        let hit = placed(&found.hit, self.instance, self.transform.scale);
        connector.emerge(
            &hit,
            found.direction,
            (found.throughput * weight).into(),
            &self.aim,
            aimed,
            sampler,
        );
    }

    /// How often a path of such a throughput is to be connected, of once: one of little weight is not worth it.
    fn worth(&self, beta: Vec3A) -> f32 {
        (beta.max_element() * self.radiance_scale).min(1.0)
    }

    /// Finds the directions from an event.
    fn is_ready(&mut self, event: &Event, connector: &mut dyn Connector) -> bool {
        if let Some(ready) = self.ready {
            return ready;
        }
        let ready = self.normal(event).is_some_and(|n| {
            connector.aim(self.transform.point(event.p), self.transform.direction(n), &mut self.aim)
        });
        self.ready = Some(ready);
        ready
    }

    /// Outward unit normal of the boundary near by.
    fn normal(&self, event: &Event) -> Option<Vec3> {
        let nearest = || self.mesh.nearest(event.p, self.distance.reach(event.clear));
        let normal = self.distance.normal(self.mesh, event.p);
        normal.or_else(|| nearest().map(|n| self.mesh.geometric_normal(n.triangle)))
    }
}
