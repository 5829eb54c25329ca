//! What else may be inside of the object of a walk: other objects that reach into it, which flights meet before its own
//! boundary.

use super::Flight;
use crate::geometry::{Aabb, Hit, Ray, Similarity};
use crate::scene::{self, Intruder, Scene};
use glam::Vec3;

/// What else may be inside of the object of a walk.
pub(super) struct Intruders<'a> {
    scene: &'a Scene,
    /// The object.
    instance: u32,
    all: &'a scene::Intruders,
    transform: &'a Similarity,
    /// Length beyond which a flight has left the object, in its own space.
    longest: f32,
}

impl<'a> Intruders<'a> {
    pub fn new(flight: &Flight<'a>, transform: &'a Similarity, longest: f32) -> Self {
        let (instance, all) = (flight.enclosure.instance, &flight.object.intruders);
        Self { scene: flight.scene, instance, all, transform, longest }
    }

    /// The first of them that a flight of length `t` meets; lengths are in the object's own space. `world` is `p` in world
    /// space, where that is known better.
    #[inline]
    pub fn intersect(&self, p: Vec3, world: Option<Vec3>, d: Vec3, t: f32) -> Option<Hit> {
        if self.all.is_empty() { None } else { self.intersect_all(p, world, d, t) }
    }

    fn intersect_all(&self, p: Vec3, world: Option<Vec3>, d: Vec3, t: f32) -> Option<Hit> {
        let origin = world.unwrap_or_else(|| self.transform.point(p));
        let direction = self.transform.direction(d);
        let t_max = t.min(self.longest) * self.transform.scale;
        let ray = Ray { origin, direction, t_max };
        let first = match self.all {
            scene::Intruders::Few(list) => self.first_of(list, ray),
            scene::Intruders::Many => self.scene.geometry.intersect_others(self.instance, &ray),
        };
        let local = |length: f32| self.transform.inverse_length(length);
        first.map(|hit| Hit { t: local(hit.t), band: local(hit.band), ..hit })
    }

    fn first_of(&self, list: &[Intruder], mut ray: Ray) -> Option<Hit> {
        let way = Aabb::from_points(&[ray.origin, ray.origin + ray.direction * ray.t_max]);
        let mut first = None;
        for other in list {
            let apart = other.bounds.min.cmpgt(way.max).any() || other.bounds.max.cmplt(way.min).any();
            if apart {
                continue;
            }
            if let Some(hit) = self.scene.geometry.intersect_instance(other.instance, &ray) {
                let hit = hit.closer(first);
                ray.t_max = ray.t_max.min(hit.t + hit.band);
                first = Some(hit);
            }
        }
        first
    }
}
