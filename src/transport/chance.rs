//! Light that a path meets by chance, weighed against the techniques that look for it.

use super::path::PathTracer;
use super::state::Path;
use super::weight::Techniques;
use crate::scene::Surface;
use glam::Vec3;

impl PathTracer<'_> {
    /// Radiance of the environment at the end of a path.
    pub(super) fn environment(&self, path: &Path) -> Vec3 {
        let radiance = self.scene.lights.environment_radiance(path.head.direction);
        let v = &path.vertex;
        let direction = path.head.direction;
        let (light, chance) = if v.connected {
            (v.lights * self.scene.lights.environment_pdf_at(&v.anchor, direction), v.pdf)
        } else {
            (0.0, 1.0)
        };
        let weight =
            Techniques::new(&self.resolved(v.aimed, direction), direction, light, chance).weigh_chance();
        let mut scale = 1.0;
        if let Some(medium) = path.stack.current().and_then(|e| self.scene.medium(e.material)) {
            // Only an open mesh lets a path out without crossing the boundary; bring radiance back to vacuum.
            self.count(|c| c.leaks += 1);
            scale = medium.ior * medium.ior;
        }
        path.head.throughput * radiance * (weight * scale)
    }

    /// Emission of a surface that was hit by chance.
    pub(super) fn emitted(&self, surface: &Surface, path: &Path) -> Vec3 {
        let v = &path.vertex;
        let id = self.scene.lights.emitter_id(surface.instance, surface.triangle);
        let (light, chance) = match id.filter(|_| v.connected) {
            Some(id) => {
                let pdf = self.scene.lights.emitter_pdf_at(id, v.point, &v.anchor, surface.position);
                (v.lights * pdf, v.pdf)
            }
            None => (0.0, 1.0),
        };
        let weight =
            Techniques::new(&self.resolved(v.aimed, path.head.direction), path.head.direction, light, chance)
                .weigh_chance();
        // Where lights were sampled, too, both techniques must find the same light.
        let footprint = if v.connected { 0.0 } else { surface.footprint };
        let emission = self.scene.emission(&Surface { footprint, ..*surface }, -path.head.direction);
        path.head.throughput * emission * weight
    }
}
