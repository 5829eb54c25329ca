//! How walks are connected to light through the boundary: guided ones at their events, plain ones where they meet it.

use super::intruders::Intruders;
use super::last_event::LastEvent;
use super::random_walk::placed;
use super::spectral::Coefficients;
use super::{Aim, Aimed, Connector};
use crate::geometry::{DistanceBound, MeshGeometry, Ray, Similarity};
use crate::sampling::{Sampler, fast_math};
use glam::{Vec3, Vec3A};

/// Depth below the boundary, in the longest mean free path, down to which directions are aimed at lights.
pub(super) const AIMING_DEPTH: f32 = 2.0;
/// Probability of aiming at the boundary, and how fast it falls with depth. Measured: more costs more than it saves.
pub(super) const AIMING_RATE: f32 = 0.35;
pub(super) const AIMING_FALLOFF: f32 = 1.5;
/// Connections where a walk meets the boundary.
const CONNECTIONS: f32 = 3.0;
/// How much those are trusted more than their density tells: each walk has them, light met by chance is rare.
const TRUST: f32 = 3.0;

/// An event of a walk, in the object's own space.
#[derive(Clone, Copy)]
pub(super) struct Event {
    /// Where it was.
    pub p: Vec3,
    /// How far the boundary is from there, at least.
    pub clear: f32,
    /// Direction of travel before it.
    pub incoming: Vec3,
    /// Throughput at the event.
    pub beta: Vec3A,
}

/// Connections of the walk in one object.
pub(super) struct Aiming<'a> {
    pub instance: u32,
    pub mesh: &'a MeshGeometry,
    pub transform: &'a Similarity,
    pub distance: &'a DistanceBound,
    pub intruders: &'a Intruders<'a>,
    aim: Aim,
    /// Probability that a direction was aimed at the last event.
    rate: f32,
    /// Whether there is anything to aim at, once that is known.
    ready: Option<bool>,
}

impl<'a> Aiming<'a> {
    pub fn new(
        instance: u32,
        (mesh, transform, distance): (&'a MeshGeometry, &'a Similarity, &'a DistanceBound),
        intruders: &'a Intruders<'a>,
    ) -> Self {
        Self { instance, mesh, transform, distance, intruders, aim: Aim::default(), rate: 0.0, ready: None }
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
        worth: f32,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) {
        let depth = event.clear * c.sigma_t.min_element();
        let decay = fast_math::exp_negative(Vec3A::splat(-AIMING_FALLOFF * depth));
        self.rate = AIMING_RATE * worth * decay.x;
        if sampler.rng().f32() < self.rate && self.is_ready(event, connector) {
            let density = |direction, t| {
                c.phase.eval_directions(event.incoming, direction) * c.arrival_probability(event.beta, t)
            };
            self.connect(c, event, (1.0 / self.rate, self.rate), density, false, sampler, connector);
        }
    }

    /// For a walk that met the boundary at a length `t` in direction `d`, and turned there with the density `phase` at the
    /// event: how it could have been aimed.
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

    /// Connects the last event of a walk that has met something at a length `t` in direction `d`: [`LastEvent`] has the idea.
    /// `channels` is the probability of each to draw the flight; `worth` is how often a path of its weight is to be connected,
    /// of once. How the walk could have been aimed.
    #[inline(never)]
    pub fn at_arrival(
        &mut self,
        c: &Coefficients,
        event: &Event,
        (channels, worth): (Vec3A, f32),
        (d, t): (Vec3, f32),
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Aimed {
        let Some(normal) = self.normal(event) else { return Aimed::default() };
        if !connector.aim(self.transform.point(event.p), self.transform.direction(normal), &mut self.aim) {
            return Aimed::default();
        }
        let last = LastEvent::new(c, channels, event.incoming, (normal, event.clear));
        let rate = TRUST * worth * last.rate();
        let mut aimed = self.aim.aimed(self.transform.direction(d), rate / last.density(d, t));
        aimed.alone = aimed.samples_light();
        let often = CONNECTIONS * worth;
        let weight = last.weight(d, t) / often;
        if weight > 0.0 {
            for _ in 0..(often + sampler.rng().f32()) as u32 {
                let density = |direction, t| last.density(direction, t);
                self.connect(c, event, (weight, rate), density, aimed.alone, sampler, connector);
            }
        }
        aimed
    }

    /// Connects an event to light once. `density` is that of a walk to turn to a direction and go a length.
    #[allow(clippy::too_many_arguments)]
    fn connect(
        &mut self,
        c: &Coefficients,
        event: &Event,
        (weight, rate): (f32, f32),
        density: impl Fn(Vec3, f32) -> f32,
        alone: bool,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) {
        let point = self.transform.point(event.p);
        let Some((direction, pdf)) = connector.draw(point, &mut self.aim, sampler) else { return };
        let local = self.transform.inverse_direction(direction);
        let ray = Ray { origin: event.p, direction: local, t_max: f32::INFINITY };
        let Some(hit) = self.mesh.intersect(&ray) else { return };
        if self.intruders.intersect(event.p, None, local, hit.t).is_some() {
            return;
        }
        let phase = c.phase.eval_directions(event.incoming, local);
        let throughput = event.beta * c.transmittance(hit.t) * (phase * weight / pdf);
        let mut aimed = self.aim.drawn(direction, rate / density(local, hit.t));
        aimed.alone = alone;
        let hit = placed(&hit, self.instance, self.transform.scale);
        connector.emerge(&hit, direction, throughput.into(), &self.aim, aimed, sampler);
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
