//! Next-event estimation: connecting a vertex to a light.

use super::dispersion::Drawn;
use super::gathered::Gathered;
use super::interface::Crossing;
use super::media::{Enclosure, MediumStack};
use super::path::PathTracer;
use super::place::InPlace;
use super::state::Path;
use super::weight::Techniques;
use crate::light::{Anchor, LightSample};
use crate::optics::Bsdf;
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::Surface;
use crate::subsurface::Aimed;
use glam::{Mat3, Vec3};

/// A surface vertex ready for shading: frame, scattering function, surrounding.
pub(super) struct Shaded<'a> {
    pub surface: &'a Surface,
    pub bsdf: &'a Bsdf,
    /// Local to world; z is the shading normal on the side that the scattering function calls its front.
    pub frame: Mat3,
    /// Towards the previous vertex, local.
    pub wo: Vec3,
    /// Whether the previous vertex is on the geometric front.
    pub front: bool,
    /// The object whose boundary this is, if it bounds a medium.
    pub enclosure: Option<Enclosure>,
    /// What leads to the other side of a boundary.
    pub crossing: Option<&'a Crossing>,
    /// What else is in the same place.
    pub place: Option<&'a InPlace>,
    /// Squared index of the path's wavelength over that of the medium, each inside over outside.
    pub dispersed: f32,
    /// For choosing lights.
    pub anchor: Anchor,
    /// How many are chosen.
    pub lights: u32,
    /// Whether light can come from the inside of the boundary.
    pub lit_inside: bool,
    /// How the vertex was reached, and how much likelier it was the other way.
    pub reached: Reached,
    /// A boundary between equal indices: light passes it in a straight line.
    pub matched: bool,
    /// The wavelength that was drawn here.
    pub drawn: Option<Drawn>,
    /// From where reflected light goes that the shading normal sends through the triangle, where there is such a place.
    pub above: Option<Vec3>,
}

/// How a boundary was reached from inside.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reached {
    /// How much likelier it was by aiming.
    pub aimed: Aimed,
    /// Whether it was by aiming.
    pub by_aiming: bool,
}

impl Shaded<'_> {
    /// For fields that [`Shaded::orient`] sets.
    pub const NOWHERE: Anchor = Anchor { point: Vec3::ZERO, normal: None, about: None };

    /// Sets the frame, the outgoing direction and which lights count. Where the shading normal would put the viewer on the
    /// other side of the surface, the geometric one is used.
    pub fn orient(&mut self, wo: Vec3, normal: Vec3, see_through: bool) {
        self.frame = Self::frame_of(self.surface, wo, normal, self.front, see_through);
        let z = self.frame.z_axis;
        self.wo = self.frame.transpose() * wo;
        let normal = match (see_through, self.enclosure) {
            (false, _) => Some(z),
            (true, Some(_)) if !self.lit_inside => Some(z),
            _ => None,
        };
        self.anchor = Anchor::at(self.surface.position, normal);
    }

    /// What to multiply light that has crossed with, so that its scale is that of the media's nominal indices, which is what
    /// follows from where a path is.
    pub fn undispersed(&self) -> f32 {
        if self.front { self.dispersed } else { 1.0 / self.dispersed }
    }

    /// The frame that [`Shaded::orient`] sets.
    pub fn frame_of(surface: &Surface, wo: Vec3, normal: Vec3, front: bool, see_through: bool) -> Mat3 {
        let consistent = (wo.dot(normal) > 0.0) == front && wo.dot(normal) != 0.0;
        let mut z = if consistent { normal } else { surface.geometric_normal };
        if !see_through && !front {
            z = -z;
        }
        let (x, y) = orthonormal_basis(z);
        Mat3::from_cols(x, y, z)
    }
}

impl PathTracer<'_> {
    /// Light from as many sampled lights as are to be, scattered at a surface towards the path, whose throughput it has.
    pub(super) fn direct(
        &self,
        s: &Shaded<'_>,
        path: &Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let lights = &self.scene.lights;
        let stack = &path.stack;
        let select = sampler.next_1d();
        let mut sum = Vec3::ZERO;
        for i in 0..s.lights {
            let select = (select + i as f32 / s.lights as f32).fract();
            let u = sampler.next_2d();
            if s.reached.aimed.alone && !lights.has_delta() {
                continue;
            }
            if let Some(light) = lights.sample_at(&s.anchor, select, u) {
                let on = self.direct_surface(s, stack, &light, sampler);
                let above = self.direct_above(s, stack, &light, sampler);
                sum += on;
                sum += above;
                gathered.note_part(|| {
                    let part = path.head.throughput * (on + above) / s.lights as f32;
                    (part, path.tag(self.source_of(&light.point)))
                });
            }
        }
        path.head.throughput * (sum / s.lights as f32)
    }

    /// Light from one sampled light, scattered at a surface towards the previous vertex. It was chosen at the surface, or
    /// by aiming where the path came from, if that is how it came.
    pub(super) fn direct_surface(
        &self,
        s: &Shaded<'_>,
        stack: &MediumStack,
        light: &LightSample,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let Reached { ref aimed, by_aiming } = s.reached;
        let delta = light.point.is_delta();
        if aimed.alone && !by_aiming && !delta {
            return Vec3::ZERO;
        }
        let wi = s.frame.transpose() * light.direction;
        let to_front = light.direction.dot(s.surface.geometric_normal) > 0.0;
        let frame_front = s.frame.z_axis.dot(s.surface.geometric_normal) > 0.0;
        if (wi.z > 0.0) != (to_front == frame_front) {
            return Vec3::ZERO;
        }
        if !to_front && s.enclosure.is_some() && !s.lit_inside {
            return Vec3::ZERO;
        }
        if s.place.is_some_and(|place| self.triangle_of(light).is_some_and(|id| place.holds(id))) {
            return Vec3::ZERO;
        }
        let (f, pdf) = s.bsdf.eval_pdf(s.wo, wi);
        if f.max_element() <= 0.0 {
            return Vec3::ZERO;
        }
        let by_chance = if delta { 0.0 } else { pdf };
        let from = s.surface.position;
        let weight = if by_aiming {
            let alone = aimed.alone && !delta;
            let sampled =
                if alone { 0.0 } else { self.scene.lights.density_at(&s.anchor, &light.point, from) };
            Techniques::new(sampled, by_chance, aimed.ratio() * light.pdf).weigh_aimed()
        } else {
            let aimed = self.aimed_density(aimed, Some(&light.point), from, by_chance);
            Techniques::new(s.lights as f32 * light.pdf, by_chance, aimed).weigh_light()
        };
        let contribution = f * light.radiance * (weight / light.pdf);
        if contribution.max_element() <= 0.0 {
            return Vec3::ZERO;
        }
        let (mut stack, mut scale) = (*stack, 1.0);
        if let Some(crossing) = s.crossing.filter(|_| to_front != s.front) {
            crossing.apply(&mut stack);
            scale = s.undispersed();
        }
        let (ray, through) = match s.place {
            Some(place) => self.shadow_ray_in(place, light, &mut stack),
            None => (self.shadow_ray_from(s.surface, light), Vec3::ONE),
        };
        if through.max_element() <= 0.0 {
            return Vec3::ZERO;
        }
        contribution * through * scale * self.transmittance(&ray, stack, sampler)
    }

    /// Whether a surface is the boundary of a medium.
    pub(super) fn bounds_medium(&self, surface: &Surface) -> bool {
        self.scene.medium(surface.material).is_some()
    }

    /// The object whose boundary a surface is, if it bounds a medium.
    pub(super) fn enclosure_of(&self, surface: &Surface) -> Option<Enclosure> {
        self.scene.medium(surface.material)?;
        Some(Enclosure {
            instance: surface.instance,
            material: surface.material,
            rank: self.scene.objects[surface.instance as usize].rank,
        })
    }
}
