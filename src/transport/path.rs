//! One path: from the camera through surfaces and media until it finds no more light.

use super::direct::{Reached, Shaded};
use super::emerge::FlightLights;
use super::interface::Interface;
use super::pixel::{Caught, PixelSample};
use super::place::InPlace;
use super::render::RenderOptions;
use super::state::{Counters, Path, Vertex};
use super::surroundings::Surroundings;
use crate::geometry::{Hit, Ray};
use crate::optics::boundary::MATCHED_INDEX;
use crate::optics::{Bsdf, Medium};
use crate::sampling::Sampler;
use crate::scene::{AlphaMode, Camera, Footprint, Object, Scene, Shading, Surface};
use crate::subsurface::{Aimed, Arrival, Connection, Exit, Flight, PathHead, Propagator};
use glam::{Mat3, Vec2, Vec3};
use std::cell::Cell;

/// Lights that are sampled where a BSSRDF lets light into its object: what differs most between the exits near a point.
const LIGHTS_AT_EXITS: u32 = 3;
/// Surfaces that a path may pass straight, so that none goes on for ever.
const MOST_PASSES: u32 = 1 << 20;
/// Lights that are sampled where the camera sees an opaque surface: cheap beside the walks of a sample. Measured.
const LIGHTS_IN_VIEW: u32 = 2;

/// Follows paths through a scene; one for each thread.
pub(super) struct PathTracer<'a> {
    pub scene: &'a Scene,
    pub options: &'a RenderOptions,
    pub model: &'a dyn Propagator,
    pub camera: &'a Camera,
    /// The media around the camera.
    pub surroundings: &'a Surroundings,
    pub counters: Cell<Counters>,
}

impl PathTracer<'_> {
    pub(super) fn count_ray(&self) {
        self.count(|c| c.rays += 1);
    }

    pub(super) fn count(&self, f: impl FnOnce(&mut Counters)) {
        let mut c = self.counters.get();
        f(&mut c);
        self.counters.set(c);
    }

    /// One sample of the pixel at (x, y).
    pub(super) fn sample_pixel(&self, x: u32, y: u32, sampler: &mut Sampler) -> PixelSample {
        let raster = Vec2::new(x as f32, y as f32) + sampler.next_2d();
        let mut sample = self.trace(self.camera.ray(raster), sampler);
        if !sample.radiance.is_finite() {
            self.count(|c| c.invalid += 1);
            sample.radiance = Vec3::ZERO;
        }
        sample
    }

    fn trace(&self, ray: Ray, sampler: &mut Sampler) -> PixelSample {
        let mut path = Path {
            head: PathHead {
                position: ray.origin,
                direction: ray.direction,
                throughput: Vec3::ONE,
                events: 0,
                start: None,
                aimed: Aimed::default(),
            },
            stack: self.surroundings.at(self.scene, ray.origin),
            place: None,
            vertex: Vertex::unconnected(ray.origin),
            events: 0,
            passes: 0,
            bounces: 0,
            total_reflections: 0,
            wavelength: None,
            direct_view: true,
            footprint: if self.options.filter_textures {
                self.camera.footprint(&ray, self.options.spp)
            } else {
                Footprint::default()
            },
        };
        let mut radiance = Vec3::ZERO;
        let caught = self.follow(&mut path, &mut radiance, sampler);
        // What is seen straight through clear media is dimmed.
        let clear = if path.direct_view { path.head.throughput.element_sum() / 3.0 } else { 0.0 };
        PixelSample { radiance, covered: 1.0 - clear, caught }
    }

    /// Follows a path until it ends; what it sees if that is the ground.
    pub(super) fn follow(
        &self,
        path: &mut Path,
        radiance: &mut Vec3,
        sampler: &mut Sampler,
    ) -> Option<Caught> {
        while path.passes < MOST_PASSES {
            if path.place.is_some() {
                if self.meet_in_place(path, radiance, sampler) {
                    continue;
                }
                self.count_cut(path);
                return None;
            }
            let from = path.head.position;
            let arrival = self.advance(path, radiance, sampler);
            if path.direct_view
                && path.stack.is_empty()
                && let Some(t) = self.ground_distance(from, path.head.direction, &arrival)
            {
                return Some(self.catch(path, from + t * path.head.direction, sampler));
            }
            let alive = match arrival {
                Arrival::Surface(hit) => self.meet_surface(&hit, path, radiance, sampler),
                Arrival::Exit(exit) => self.leave_below(*exit, path, radiance, sampler),
                Arrival::Escaped => {
                    if !(path.direct_view && self.options.transparent) {
                        *radiance += self.environment(path);
                    }
                    return None;
                }
                Arrival::Ended => false,
            };
            if !alive {
                self.count_cut(path);
                return None;
            }
        }
        self.count(|c| c.truncated += 1);
        None
    }

    /// Counts a path that has ended if it was for an event too many.
    fn count_cut(&self, path: &Path) {
        if path.events > self.options.max_depth {
            self.count(|c| c.truncated += 1);
        }
    }

    /// Moves the head to where it arrives next.
    fn advance(&self, path: &mut Path, radiance: &mut Vec3, sampler: &mut Sampler) -> Arrival {
        let Some((enclosure, medium)) =
            path.stack.current().and_then(|e| Some((e, self.scene.medium(e.material)?)))
        else {
            return self.straight(path);
        };
        if medium.sigma_s.max_element() <= 0.0 {
            let PathHead { position, direction, start, .. } = path.head;
            let arrival = self.straight(path);
            if let Arrival::Surface(hit) = &arrival {
                let from = start.map(|s| s.hit());
                let length = self.scene.geometry.distance_between(from.as_ref(), hit, direction);
                path.head.throughput *=
                    self.segment_transmittance(position, direction, length, &path.stack, sampler);
            }
            return arrival;
        }
        let object = &self.scene.objects[enclosure.instance as usize];
        // An event more than there may be ends the path: the flight after the last one is to arrive.
        let budget = self.options.max_depth.saturating_sub(path.events).saturating_add(1);
        let connection = self.connection(path, object, medium);
        let mut around = path.stack;
        around.leave(enclosure.instance);
        let eta = medium.ior / self.ior_in(&around);
        let flight = Flight { scene: self.scene, enclosure, object, medium, eta, budget, connection };
        path.head.events = 0;
        path.head.aimed = Aimed::default();
        let mut lights = FlightLights::new(self, path.stack, enclosure);
        let arrival = self.model.propagate(&flight, &mut path.head, sampler, &mut lights);
        *radiance += lights.radiance;
        if let Some(vertex) = lights.vertex {
            path.vertex = vertex;
        } else if path.head.events > 0 {
            path.vertex = Vertex::unconnected(path.head.position);
        }
        path.events = path.events.saturating_add(path.head.events);
        let events = path.head.events;
        self.count(|c| {
            c.rays += 1;
            c.events += u64::from(events);
        });
        path.direct_view &= events == 0;
        if events > 0 {
            path.total_reflections = 0;
            path.footprint.forget();
        }
        arrival
    }

    /// How the scattering events of a flight can be connected to lights.
    fn connection(&self, path: &Path, object: &Object, medium: &Medium) -> Connection {
        if object.lit_inside || (medium.ior - 1.0).abs() < MATCHED_INDEX {
            Connection::Straight
        } else if object.aimable && path.stack.len() == 1 && self.options.aim {
            Connection::Boundary
        } else {
            Connection::None
        }
    }

    fn straight(&self, path: &mut Path) -> Arrival {
        self.count_ray();
        let head = &mut path.head;
        let ray = Ray { origin: head.position, direction: head.direction, t_max: f32::INFINITY };
        match self.scene.geometry.intersect(&ray) {
            Some(hit) => Arrival::Surface(hit),
            None => Arrival::Escaped,
        }
    }

    /// Shades a surface and chooses where the path goes on. False: it ends.
    fn meet_surface(&self, hit: &Hit, path: &mut Path, radiance: &mut Vec3, sampler: &mut Sampler) -> bool {
        let surface = Surface::new(self.scene, hit);
        path.footprint.travel(surface.position.distance(path.head.position));
        if hit.crowded {
            path.place = InPlace::new(self.scene, hit, path.head.direction, (&path.stack, path.direct_view))
                .map(Box::new);
            if path.place.is_some() {
                path.head.aimed = Aimed::default();
                return self.meet_in_place(path, radiance, sampler);
            }
        }
        self.meet(std::slice::from_ref(&surface), path, radiance, sampler)
    }

    /// Meets a sheet, or the boundaries of media in one place. False: the path ends.
    pub(super) fn meet(
        &self,
        surfaces: &[Surface],
        path: &mut Path,
        radiance: &mut Vec3,
        sampler: &mut Sampler,
    ) -> bool {
        let wo = -path.head.direction;
        let bounds_medium = self.bounds_medium(&surfaces[0]);
        let interface = bounds_medium.then(|| self.interface(&path.stack, surfaces, path.head.direction));
        if let Some(stack) = interface.as_ref().and_then(|i| i.corrected.as_deref()) {
            self.moved(path, |s| *s = *stack);
        }
        let contrast = interface.as_ref().and_then(|i| i.contrast);
        let mut surface = surfaces[contrast.map_or(0, |c| c.boundary)];
        surface.footprint = path.footprint.width;
        let material = self.scene.material(surface.material);
        let face = wo.dot(surface.geometric_normal) > 0.0;
        let see_through = material.is_see_through() || bounds_medium;

        let culled = path.direct_view && !face && !material.double_sided && !see_through;
        let open = path.place.as_deref().is_some_and(InPlace::is_open);
        if culled || open || !self.covered(material.alpha_mode, &surface, sampler) {
            if let Some(place) = &mut path.place {
                place.open();
            }
            return self.pass(&surface, interface.as_ref(), path);
        }
        if material.unlit {
            path.direct_view = false;
            *radiance += path.head.throughput * self.scene.base_color(&surface).truncate();
            return false;
        }
        if self.scene.lights.has_emitters() {
            *radiance += self.emission_of(surfaces, surface.footprint, path);
        }

        let (mut eta, mut dispersed) = (1.0, 1.0);
        let (mut front, mut enclosure, mut drawn) = (face, None, None);
        let mut refracting = None;
        if let Some(interface) = &interface {
            let Some(contrast) = &interface.contrast else {
                return self.pass(&surface, Some(interface), path);
            };
            front = contrast.entering;
            if front != face {
                // A body that is wound the other way: outside is where its triangles show their backs.
                surface.turn();
            }
            eta = contrast.eta;
            if (eta - 1.0).abs() < MATCHED_INDEX && self.scene.is_clear(&surface) {
                return self.pass(&surface, Some(interface), path);
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
        if path.events > self.options.max_depth {
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
        let mut bsdf = shading.bsdf(eta, enclosure.is_some(), self.options.microfacet);
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
            crossing: interface.as_ref().map(|i| &i.crossing),
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
        self.scatter(shaded, normal, see_through, path, radiance, sampler)
    }

    /// An exit that a BSSRDF has found: the path leaves the object there.
    fn leave_below(&self, exit: Exit, path: &mut Path, radiance: &mut Vec3, sampler: &mut Sampler) -> bool {
        let Exit { mut surface, lobe } = exit;
        if let Some(e) = path.stack.current() {
            path.stack.leave(e.instance);
            self.look_around(&mut path.stack, e, &mut surface);
        }
        let bsdf = Bsdf::Exit(lobe);
        path.head.direction = -surface.normal;
        let shaded = Shaded {
            surface: &surface,
            bsdf: &bsdf,
            frame: Mat3::IDENTITY,
            wo: Vec3::Z,
            front: true,
            enclosure: None,
            crossing: None,
            place: None,
            dispersed: 1.0,
            anchor: Shaded::NOWHERE,
            lights: LIGHTS_AT_EXITS,
            lit_inside: false,
            reached: Reached::default(),
            matched: false,
            drawn: None,
            above: None,
        };
        self.scatter(shaded, surface.normal, false, path, radiance, sampler)
    }

    /// Connects a shaded vertex to a light and samples its scattering function.
    fn scatter(
        &self,
        mut shaded: Shaded<'_>,
        normal: Vec3,
        see_through: bool,
        path: &mut Path,
        radiance: &mut Vec3,
        sampler: &mut Sampler,
    ) -> bool {
        shaded.orient(-path.head.direction, normal, see_through);
        shaded.above = self.above(&shaded);
        let connected = !shaded.bsdf.is_delta();
        if connected {
            *radiance += path.head.throughput * self.direct(&shaded, &path.stack, sampler);
        }
        let (u_lobe, u) = (sampler.next_1d(), sampler.next_2d());
        let Some(sample) = shaded.bsdf.sample(shaded.wo, u_lobe, u) else { return false };
        if let Some(drawn) = &shaded.drawn {
            self.keep_wavelength(path, drawn, shaded.wo, &sample);
        }
        let alive = self.leave(&shaded, &sample, connected, path, sampler);
        let walks = if alive && sample.transmitted && shaded.front { self.walks(path) } else { 1 };
        if walks > 1 {
            self.follow_each(path, walks, radiance, sampler);
            return false;
        }
        alive
    }

    /// Goes straight on through what is not there, into what is beyond it.
    fn pass(&self, surface: &Surface, interface: Option<&Interface>, path: &mut Path) -> bool {
        if let Some(interface) = interface {
            self.moved(path, |stack| interface.crossing.apply(stack));
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
