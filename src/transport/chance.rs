//! Light that a path meets by chance, weighed against the techniques that look for it.

use super::path::PathTracer;
use super::place::InPlace;
use super::state::Path;
use crate::light::LightPoint;
use crate::scene::Surface;
use glam::Vec3;

impl PathTracer<'_> {
    /// Radiance of the environment at the end of a path.
    pub(super) fn environment(&self, path: &Path) -> Vec3 {
        let radiance = self.scene.lights.environment_radiance(path.head.direction);
        let point = LightPoint::Environment(path.head.direction);
        let weight = self.weigh_chance(&path.vertex, Some(point));
        let mut scale = 1.0;
        let inside = path.stack.current();
        if let Some((e, medium)) = inside.and_then(|e| Some((e, self.scene.medium(e.material)?))) {
            // The path came out without crossing the boundary; bring radiance back to vacuum.
            let closed = self.scene.objects.get(e.instance as usize).is_some_and(|object| object.closed);
            self.count(|c| {
                c.leaked_paths += 1;
                c.lost_paths += u64::from(closed);
            });
            scale = medium.ior * medium.ior;
        }
        path.head.throughput * radiance * (weight * scale)
    }

    /// Emission of surfaces in one place towards a path that comes there.
    pub(super) fn emission_of(&self, surfaces: &[Surface], footprint: f32, path: &Path) -> Vec3 {
        let emits = |s: &&Surface| {
            let material = self.scene.material(s.material);
            let faces = path.head.direction.dot(s.geometric_normal) < 0.0;
            material.emission != Vec3::ZERO && (faces || material.double_sided)
        };
        let emitted = |s: &Surface| self.emitted(&Surface { footprint, ..*s }, path);
        surfaces.iter().filter(emits).map(emitted).sum()
    }

    /// Emission of a surface that was hit by chance.
    pub(super) fn emitted(&self, surface: &Surface, path: &Path) -> Vec3 {
        let v = &path.vertex;
        let id = self.scene.lights.emitter_id(surface.instance, surface.triangle);
        let point = id.map(|id| LightPoint::Emitter(id, surface.position));
        let sampled = point.is_some() && !path.place.as_deref().is_some_and(InPlace::has_scattered);
        let weight = if sampled { self.weigh_chance(v, point) } else { 1.0 };
        // Where lights were sampled, too, both techniques must find the same light.
        let footprint = if v.connected { 0.0 } else { surface.footprint };
        let emission = self.scene.emission(&Surface { footprint, ..*surface }, -path.head.direction);
        path.head.throughput * emission * weight
    }
}
