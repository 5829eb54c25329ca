//! Next-event estimation: connecting a vertex to a light, and what the connection loses on its way.

use super::dispersion::Drawn;
use super::media::{Crossing, Enclosure, MediumStack};
use super::path::PathTracer;
use super::weight::Techniques;
use crate::geometry::{Ray, offset_origin};
use crate::light::{Anchor, LightSample};
use crate::optics::Bsdf;
use crate::optics::boundary::MATCHED_INDEX;
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::{AlphaMode, Surface};
use crate::subsurface::{Aimed, TexturedMedium};
use glam::{Mat3, Vec3};

/// Shadow rays end this fraction before the light, so that they do not meet the emitter itself. Relative, hence free
/// of scale.
const SHADOW_SHORTENING: f32 = 1e-4;

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
}

impl Shaded<'_> {
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
    /// Light from as many sampled lights as are to be, scattered at a surface towards the previous vertex.
    pub(super) fn direct(&self, s: &Shaded<'_>, stack: &MediumStack, sampler: &mut Sampler) -> Vec3 {
        let lights = &self.scene.lights;
        let select = sampler.next_1d();
        let mut sum = Vec3::ZERO;
        for i in 0..s.lights {
            let select = (select + i as f32 / s.lights as f32).fract();
            let u = sampler.next_2d();
            if s.reached.aimed.alone && !lights.has_delta() {
                continue;
            }
            if let Some(light) = lights.sample_at(&s.anchor, select, u) {
                sum += self.direct_surface(s, stack, &light, sampler);
                sum += self.direct_above(s, stack, &light, sampler);
            }
        }
        sum / s.lights as f32
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
        let mut stack = *stack;
        if let Some(e) = s.enclosure
            && to_front != s.front
        {
            if s.front { stack.enter(e) } else { stack.leave(e.instance) }
        }
        let n = s.surface.geometric_normal;
        let origin = offset_origin(s.surface.position, s.surface.error, n, light.direction);
        contribution * self.transmittance(origin, light.direction, light.distance, stack, sampler)
    }

    /// The fraction of light that survives a straight segment: zero where something opaque or refracting is in the
    /// way, otherwise what alpha, index-matched boundaries and media leave.
    pub(super) fn transmittance(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        mut stack: MediumStack,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let t_max = distance * (1.0 - SHADOW_SHORTENING);
        self.count_ray();
        if !self.scene.has_see_through && stack.is_empty() {
            let blocked = self.scene.geometry.occluded(&Ray { origin, direction, t_max });
            return if blocked { Vec3::ZERO } else { Vec3::ONE };
        }
        let (mut result, mut origin, mut remaining) = (Vec3::ONE, origin, t_max);
        for _ in 0..self.options.max_depth {
            let hit = self.scene.geometry.intersect(&Ray { origin, direction, t_max: remaining });
            let length = hit.as_ref().map_or(remaining, |h| h.t);
            result *= self.segment_transmittance(origin, direction, length, &stack, sampler);
            let Some(hit) = hit else { return result };
            let surface = Surface::new(self.scene, &hit);
            result *= self.surface_transmittance(&surface, direction, &mut stack);
            if result.max_element() <= 0.0 {
                return Vec3::ZERO;
            }
            let n = surface.geometric_normal;
            let next = offset_origin(surface.position, surface.error, n, direction);
            remaining -= length;
            origin = next;
            if remaining <= 0.0 {
                return result;
            }
            self.count_ray();
        }
        Vec3::ZERO
    }

    /// What a segment inside of the current medium lets through.
    pub(super) fn segment_transmittance(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        stack: &MediumStack,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let Some(e) = stack.current() else { return Vec3::ONE };
        let Some(medium) = self.scene.medium(e.material) else { return Vec3::ONE };
        let description = self.scene.material(e.material).medium.as_ref();
        if description.is_some_and(|m| m.absorption_texture.is_some() || m.scattering_texture.is_some())
            && length.is_finite()
        {
            let mut textured = TexturedMedium::new(self.scene, e);
            return textured.transmittance(origin, direction, length, sampler.rng());
        }
        // 0 · ∞ is 0 here: a clear channel loses nothing over any distance.
        Vec3::select(medium.sigma_t.cmpgt(Vec3::ZERO), (-medium.sigma_t * length).exp(), Vec3::ONE)
    }

    /// What a surface lets through in a straight line, with the stack after it.
    fn surface_transmittance(&self, surface: &Surface, direction: Vec3, stack: &mut MediumStack) -> Vec3 {
        let material = self.scene.material(surface.material);
        let alpha = self.scene.alpha(surface);
        let covered = match material.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(alpha >= cutoff),
            AlphaMode::Blend => alpha,
        };
        let mut through = Vec3::ZERO;
        if let Some(enclosure) = self.enclosure_of(surface)
            && covered > 0.0
        {
            let entering = direction.dot(surface.geometric_normal) < 0.0;
            if !entering && !stack.contains(enclosure.instance) {
                stack.enter(enclosure);
            }
            let (crossing, eta) = self.interface(stack, enclosure, entering);
            if crossing == Crossing::Hidden {
                through = Vec3::ONE;
            } else if (eta - 1.0).abs() < MATCHED_INDEX {
                through = self.scene.straight_transmission(surface);
            }
            if entering { stack.enter(enclosure) } else { stack.leave(enclosure.instance) }
        }
        through * covered + Vec3::splat(1.0 - covered)
    }

    /// Whether light comes into a medium there.
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

    /// What the boundary of `enclosure` is to a path with this stack, and its index inside over outside.
    pub(super) fn interface(
        &self,
        stack: &MediumStack,
        enclosure: Enclosure,
        entering: bool,
    ) -> (Crossing, f32) {
        let crossing = stack.crossing(enclosure, entering);
        let ior = |e: Enclosure| self.scene.medium(e.material).map_or(1.0, |m| m.ior);
        let inside = if entering { ior(enclosure) } else { stack.current().map_or(1.0, ior) };
        match crossing {
            Crossing::Hidden => (crossing, 1.0),
            Crossing::Interface { outside } => (crossing, inside / outside.map_or(1.0, ior)),
        }
    }
}
