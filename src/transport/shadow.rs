//! Shadow rays: what a connection to a light loses on its way.
//!
//! A ray towards an emitter ends where it meets the emitter's own triangle: ending it short of that would make what is
//! close to a lamp transparent. What lies in one place with the triangle hides it where it is on top
//! ([`super::place`]). The way to a punctual light ends at its point, up to rounding.
//!
//! Alpha, boundaries between equal indices and media are passed; other boundaries bend light, so nothing gets through in a
//! straight line. Where alpha lets light into a medium of another index, L/n² is what stays.

use super::gathered::LightSource;
use super::interface::Interface;
use super::media::MediumStack;
use super::path::PathTracer;
use super::place::InPlace;
use crate::geometry::{Hit, ROUNDING, Ray, offset_origin};
use crate::light::{LightPoint, LightSample};
use crate::optics::boundary::MATCHED_INDEX;
use crate::sampling::Sampler;
use crate::scene::{AlphaMode, MediumDescription, Surface};
use crate::subsurface::{Start, TexturedMedium};
use glam::Vec3;

/// Surfaces that a shadow ray may pass, so that none goes on for ever.
const MOST_PASSED: u32 = 1 << 16;

/// A shadow ray from a surface or an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    origin: Vec3,
    direction: Vec3,
    distance: f32,
    /// Instance and triangle of the light.
    emitter: Option<(u32, u32)>,
    /// The point of the surface that it leaves.
    from: Option<Hit>,
}

impl PathTracer<'_> {
    /// A shadow ray from a point of free space.
    pub(super) fn shadow_ray(&self, origin: Vec3, light: &LightSample) -> ShadowRay {
        let &LightSample { direction, distance, .. } = light;
        ShadowRay { origin, direction, distance, emitter: self.triangle_of(light), from: None }
    }

    /// Instance and triangle of a light that has an area.
    pub(super) fn triangle_of(&self, light: &LightSample) -> Option<(u32, u32)> {
        match light.point {
            LightPoint::Emitter(id, _) => self.scene.lights.emitter_triangle(id),
            LightPoint::Environment(_) | LightPoint::Punctual(_) => None,
        }
    }

    /// What a point of a light belongs to.
    pub(super) fn source_of(&self, point: &LightPoint) -> LightSource {
        match *point {
            LightPoint::Environment(_) => LightSource::Environment,
            LightPoint::Punctual(index) => LightSource::Punctual(index),
            LightPoint::Emitter(id, _) => {
                let instance =
                    self.scene.lights.emitter_triangle(id).map_or(u32::MAX, |(instance, _)| instance);
                LightSource::Surface(instance)
            }
        }
    }

    /// A shadow ray from a point of a surface.
    pub(super) fn shadow_ray_from(&self, surface: &Surface, light: &LightSample) -> ShadowRay {
        let n = surface.geometric_normal;
        let origin = offset_origin(surface.position, surface.error, n, light.direction);
        ShadowRay { from: Some(Start::of(surface).hit()), ..self.shadow_ray(origin, light) }
    }

    /// A shadow ray from a member of a place, and what it loses in the place.
    pub(super) fn shadow_ray_in(
        &self,
        place: &InPlace,
        light: &LightSample,
        stack: &mut MediumStack,
    ) -> (ShadowRay, Vec3) {
        let members = place.towards(light.direction);
        let losses = members.map(|(member, open)| self.passed(member, open, light.direction, stack));
        let through = losses.product();
        (self.shadow_ray(place.origin(light.direction), light), through)
    }

    /// The fraction of light that survives a straight segment: zero where something opaque or refracting is in the
    /// way, otherwise what alpha, index-matched boundaries and media leave.
    pub(super) fn transmittance(
        &self,
        ray: &ShadowRay,
        mut stack: MediumStack,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let geometry = &self.scene.geometry;
        let &ShadowRay { mut origin, direction, distance, emitter, .. } = ray;
        self.count_ray();
        let whole = Ray { origin, direction, t_max: distance };
        let band = match emitter {
            Some((instance, triangle)) => geometry.band(&whole, instance, triangle),
            None if distance.is_finite() => ROUNDING * (origin.abs().max_element() + distance),
            None => 0.0,
        };
        if !self.scene.has_see_through && stack.is_empty() {
            let blocked = match emitter {
                Some((instance, triangle)) => geometry.occluded_before(&whole, instance, triangle, band),
                None => Some(geometry.occluded(&Ray { t_max: distance - band, ..whole })),
            };
            match blocked {
                Some(true) => return Vec3::ZERO,
                Some(false) => return Vec3::ONE,
                None => {}
            }
        }
        let start = self.ior_in(&stack);
        let (mut result, mut remaining, mut from) = (Vec3::ONE, distance, ray.from);
        let mut passed = 0;
        loop {
            if passed == MOST_PASSED {
                return Vec3::ZERO;
            }
            passed += 1;
            let t_max = if emitter.is_some() { remaining + band } else { remaining - band };
            let hit = geometry.intersect(&Ray { origin, direction, t_max });
            let length = match &hit {
                Some(hit) => geometry.distance_between(from.as_ref(), hit, direction),
                None => remaining,
            };
            result *= self.segment_transmittance(origin, direction, length, &stack, sampler);
            let Some(hit) = hit else { break };
            let place =
                hit.crowded.then(|| InPlace::new(self.scene, &hit, direction, (&stack, false))).flatten();
            let itself = |s: &Surface| emitter == Some((s.instance, s.triangle));
            let surface = Surface::new(self.scene, &hit);
            let mut arrived = false;
            if let Some(place) = &place {
                for member in place.members() {
                    arrived = member.iter().any(itself);
                    if arrived {
                        break;
                    }
                    result *= self.passed(member, false, direction, &mut stack);
                }
            } else {
                // The ray may have passed beside the triangle by rounding, and met what goes on in its plane.
                let light = whole.origin + whole.direction * distance;
                let beside = || emitter.is_some() && hit.t >= remaining - band;
                arrived = itself(&surface) || (beside() && geometry.is_in_plane(&hit, light));
                if !arrived {
                    result *= self.passed(&[surface], false, direction, &mut stack);
                }
            }
            if arrived {
                break;
            }
            if result.max_element() <= 0.0 {
                return Vec3::ZERO;
            }
            let next = offset_origin(surface.position, surface.error, surface.geometric_normal, direction);
            origin = place.as_ref().map_or(next, |p| p.origin(direction));
            from = Some(hit);
            remaining -= hit.t;
            if remaining <= 0.0 {
                break;
            }
            self.count_ray();
        }
        // The environment is outside of everything, also where an open mesh never ends.
        let end = if distance.is_finite() { self.ior_in(&stack) } else { 1.0 };
        let ratio = start / end;
        if ratio == 1.0 { result } else { result * (ratio * ratio) }
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
        if description.is_some_and(MediumDescription::is_textured) && length.is_finite() {
            let mut textured = TexturedMedium::new(self.scene, e);
            return textured.transmittance(origin, direction, length, sampler.rng());
        }
        // 0 · ∞ is 0 here: a clear channel loses nothing over any distance.
        Vec3::select(medium.sigma_t.cmpgt(Vec3::ZERO), (-medium.sigma_t * length).exp(), Vec3::ONE)
    }

    /// What a sheet, or the boundaries of media in one place, let through in a straight line, with the stack after them;
    /// everything where they are `open`.
    fn passed(&self, surfaces: &[Surface], open: bool, direction: Vec3, stack: &mut MediumStack) -> Vec3 {
        let absent = |surface: &Surface| {
            let front = direction.dot(surface.geometric_normal) < 0.0;
            self.scene.material(surface.material).is_absent(front, false)
        };
        let coverage = |surface: &Surface| if open || absent(surface) { 0.0 } else { self.coverage(surface) };
        if !self.bounds_medium(&surfaces[0]) {
            return Vec3::splat(1.0 - coverage(&surfaces[0]));
        }
        let mut interface = Interface::NONE;
        self.find_interface(&mut interface, stack, surfaces, &direction);
        interface.crossing.apply(stack);
        let Some(contrast) = &interface.contrast else { return Vec3::ONE };
        let surface = &surfaces[contrast.boundary];
        let covered = coverage(surface);
        let matched = covered > 0.0 && (contrast.eta - 1.0).abs() < MATCHED_INDEX;
        let through = if matched { self.scene.straight_transmission(surface) } else { Vec3::ZERO };
        through * covered + Vec3::splat(1.0 - covered)
    }

    /// Share of a surface that is there.
    fn coverage(&self, surface: &Surface) -> f32 {
        let alpha = self.scene.alpha(surface);
        match self.scene.material(surface.material).alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(alpha >= cutoff),
            AlphaMode::Blend => alpha,
        }
    }
}
