//! What a path does where it meets a surface: what is not there is passed, what shines is counted, and what is left gets a
//! scattering function.

use super::direct::{Reached, Shaded};
use super::gathered::{Gathered, LightSource};
use super::interface::{Crossing, Interface};
use super::path::PathTracer;
use super::place::InPlace;
use super::state::Path;
use crate::geometry::Hit;
use crate::optics::Bsdf;
use crate::optics::boundary::MATCHED_INDEX;
use crate::sampling::Sampler;
use crate::scene::{AlphaMode, Shading, Surface};
use crate::subsurface::Aimed;
use glam::{Mat3, Vec3};

/// Lights that are sampled where the camera sees an opaque surface: cheap beside the walks of a sample. Measured.
const LIGHTS_IN_VIEW: u32 = 2;

impl PathTracer<'_> {
    /// Shades a surface and chooses where the path goes on. False: it ends.
    pub(super) fn meet_surface(
        &self,
        hit: &Hit,
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> bool {
        let surface = Surface::new(self.scene, hit);
        path.footprint.travel(surface.position.distance(path.head.position));
        if hit.crowded {
            path.place = InPlace::new(self.scene, hit, path.head.direction, (&path.stack, path.direct_view))
                .map(Box::new);
            if path.place.is_some() {
                path.head.aimed = Aimed::default();
                return self.meet_in_place(path, gathered, sampler);
            }
        }
        self.meet(std::slice::from_ref(&surface), path, gathered, sampler)
    }

    /// Meets a sheet, or the boundaries of media in one place. False: the path ends.
    pub(super) fn meet(
        &self,
        surfaces: &[Surface],
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> bool {
        let wo = -path.head.direction;
        let bounds_medium = self.bounds_medium(&surfaces[0]);
        let mut interface = Interface::NONE;
        if bounds_medium {
            self.find_interface(&mut interface, &path.stack, surfaces, &path.head.direction);
        }
        if let Some(stack) = interface.corrected.as_deref() {
            self.moved(path, |s| *s = *stack);
        }
        let mut surface = surfaces[interface.contrast.as_ref().map_or(0, |c| c.boundary)];
        surface.footprint = path.footprint.width;
        let material = self.scene.material(surface.material);
        let face = wo.dot(surface.geometric_normal) > 0.0;
        let see_through = material.is_see_through() || bounds_medium;

        let culled = path.direct_view && !face && !material.double_sided && !see_through
            || material.is_absent(face, path.direct_view);
        let open = path.place.as_deref().is_some_and(InPlace::is_open);
        if culled || open || !self.covered(material.alpha_mode, &surface, sampler) {
            if let Some(place) = &mut path.place {
                place.open();
            }
            return self.pass(&surface, &interface.crossing, path);
        }
        if material.unlit {
            path.direct_view = false;
            let light = path.head.throughput * self.scene.base_color(&surface).truncate();
            gathered.add(light, || path.tag(LightSource::Surface(surface.instance)));
            return false;
        }
        if self.scene.lights.has_emitters() {
            let light = self.emission_of(surfaces, surface.footprint, path);
            if light != Vec3::ZERO {
                gathered.add(light, || path.tag(LightSource::Surface(surface.instance)));
            }
        }
        if material.area_light {
            return false;
        }

        let (mut eta, mut dispersed) = (1.0, 1.0);
        let (mut front, mut enclosure, mut drawn) = (face, None, None);
        let mut refracting = None;
        if bounds_medium {
            let Some(contrast) = &interface.contrast else {
                return self.pass(&surface, &interface.crossing, path);
            };
            front = contrast.entering;
            if front != face {
                // A body that is wound the other way: outside is where its triangles show their backs.
                surface.turn();
            }
            eta = contrast.eta;
            if (eta - 1.0).abs() < MATCHED_INDEX && self.scene.is_clear(&surface) {
                return self.pass(&surface, &interface.crossing, path);
            }
            enclosure = Some(contrast.enclosure);
            refracting = Some(eta).filter(|_| (eta - 1.0).abs() >= MATCHED_INDEX);
            if self.scene.has_dispersion
                && let Some((index, wavelength)) = self.disperse(path, contrast, sampler)
            {
                dispersed = (index / eta) * (index / eta);
                (eta, drawn) = (index, wavelength);
            }
        }
        path.direct_view = false;
        path.events += 1;
        if path.events > self.settings.max_depth {
            return false;
        }
        let shading = Shading::new(self.scene, &surface);
        let normal = match refracting {
            // A wavelength that is drawn here must not matter to where the boundary reflects.
            Some(index) => {
                let index = if drawn.is_some() { index } else { eta };
                self.refracting_normal(&surface, shading.normal, wo, index, path, sampler)
            }
            None => shading.normal,
        };
        let mut bsdf = shading.bsdf(eta, enclosure.is_some(), self.settings.microfacet);
        if let Bsdf::Layered(layered) = &mut bsdf {
            layered.place(&Shaded::frame_of(&surface, wo, normal, front, see_through));
        }
        if let Some(drawn) = &mut drawn {
            self.weigh_wavelength(path, &bsdf, drawn);
        }
        if !matches!(bsdf, Bsdf::Boundary(_)) {
            path.head.aimed = Aimed::default();
        }
        if front
            && drawn.is_none()
            && let Some(e) = enclosure
        {
            self.weigh_below(&mut bsdf, e);
        }
        let lit_inside = enclosure.is_none_or(|e| {
            let object = &self.scene.objects[e.instance as usize];
            object.lit_inside || object.overlapped || !object.closed
        });
        let place = path.place.clone();
        let shaded = Shaded {
            surface: &surface,
            bsdf: &bsdf,
            frame: Mat3::IDENTITY,
            wo: Vec3::Z,
            front,
            enclosure,
            crossing: bounds_medium.then_some(&interface.crossing),
            place: place.as_deref(),
            dispersed,
            anchor: Shaded::NOWHERE,
            lights: if path.bounces == 0 && enclosure.is_none() { LIGHTS_IN_VIEW } else { 1 },
            lit_inside,
            reached: Reached { aimed: path.head.aimed, by_aiming: false },
            matched: enclosure.is_some() && (eta - 1.0).abs() < MATCHED_INDEX,
            drawn,
            above: None,
        };
        self.scatter(shaded, normal, see_through, path, gathered, sampler)
    }

    /// Goes straight on through what is not there, into what is beyond it.
    fn pass(&self, surface: &Surface, crossing: &Crossing, path: &mut Path) -> bool {
        if !matches!(crossing, Crossing::Nothing) {
            self.moved(path, |stack| crossing.apply(stack));
        }
        path.pass(surface);
        true
    }

    fn covered(&self, mode: AlphaMode, surface: &Surface, sampler: &mut Sampler) -> bool {
        match mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => self.scene.alpha(surface) >= cutoff,
            AlphaMode::Blend => sampler.rng().f32() < self.scene.alpha(surface),
        }
    }
}
