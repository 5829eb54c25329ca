//! Light at the terminator of coarse meshes with smooth normals.
//!
//! A shading normal turns the horizon of a point away from that of its triangle. Light from between the two horizons
//! comes through the triangle: without it, shadows end along edges instead of where the smooth surface turns away from
//! the light. It would be right from the smooth surface above the triangle
//! ([`crate::scene::Surface::smooth_position`]), and so reflected light in those directions, sampled or met by chance,
//! goes from there. All other directions go from the triangle. What is reflected is an integral over the whole
//! hemisphere of the shading normal then, with nothing lost and nothing counted twice.
//!
//! Where the smooth surface is not above the triangle, or something is in between, there is no such light, and scattered
//! rays are mirrored back to the triangle's own side ([`super::leave`]). So it is at boundaries of media, too: what passes
//! them has to start at the triangle.

use super::direct::Shaded;
use super::media::MediumStack;
use super::path::PathTracer;
use super::weight::Techniques;
use crate::geometry::{Ray, offset_origin};
use crate::light::LightSample;
use crate::sampling::Sampler;
use glam::Vec3;

impl PathTracer<'_> {
    /// [`Shaded::above`] of a vertex that is otherwise ready.
    pub(super) fn above(&self, s: &Shaded<'_>) -> Option<Vec3> {
        if s.enclosure.is_some() || s.place.is_some() || s.wo.z <= 0.0 {
            return None;
        }
        s.surface.smooth_position(self.scene, s.frame.z_axis)
    }

    /// [`Shaded::above`], where nothing is between it and the triangle, for a reflected direction through the triangle.
    pub(super) fn free_above(&self, s: &Shaded<'_>) -> Option<Vec3> {
        let above = s.above?;
        let n = s.surface.geometric_normal;
        let origin = offset_origin(s.surface.position, s.surface.error, n, above - s.surface.position);
        let way = above - origin;
        let (direction, t_max) = (way.try_normalize()?, way.length());
        self.count_ray();
        (!self.scene.geometry.occluded(&Ray { origin, direction, t_max })).then_some(above)
    }

    /// Whether a direction goes through the triangle from the side that the frame is on.
    pub(super) fn goes_through(s: &Shaded<'_>, direction: Vec3) -> bool {
        let n = s.surface.geometric_normal;
        (direction.dot(n) > 0.0) != (s.frame.z_axis.dot(n) > 0.0)
    }

    /// Light from a light that was chosen at the surface, reflected from above it.
    pub(super) fn direct_above(
        &self,
        s: &Shaded<'_>,
        stack: &MediumStack,
        light: &LightSample,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let Some(from) = s.above else { return Vec3::ZERO };
        let Some(light) = self.scene.lights.seen_from(light, s.surface.position, from) else {
            return Vec3::ZERO;
        };
        let wi = s.frame.transpose() * light.direction;
        if wi.z <= 0.0 || !Self::goes_through(s, light.direction) {
            return Vec3::ZERO;
        }
        let (f, pdf) = s.bsdf.eval_pdf(s.wo, wi);
        let by_chance = if light.point.is_delta() { 0.0 } else { pdf };
        let weight = Techniques::new(s.lights as f32 * light.pdf, by_chance, 0.0).weigh_light();
        let contribution = f * light.radiance * (weight / light.pdf);
        if contribution.max_element() <= 0.0 || self.free_above(s).is_none() {
            return Vec3::ZERO;
        }
        contribution * self.transmittance(&self.shadow_ray(from, &light), *stack, sampler)
    }
}
