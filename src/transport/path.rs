//! One path: from the camera through surfaces and media until it finds no more light.

use super::control::RenderStats;
use super::direct::{Reached, Shaded};
use super::emerge::FlightLights;
use super::gathered::{FirstEvent, Gathered, LightSource, Seen};
use super::media::MediumStack;
use super::options::{Settings, View};
use super::pixel::PixelSample;
use super::state::{Path, Vertex};
use super::surroundings::Surroundings;
use crate::film::composite::Caught;
use crate::geometry::Ray;
use crate::optics::boundary::MATCHED_INDEX;
use crate::optics::{Bsdf, Medium};
use crate::sampling::Sampler;
use crate::scene::{Camera, Object, Scene};
use crate::subsurface::{Aimed, Arrival, Connection, Exit, Flight, PathHead, Propagator, Stop};
use glam::{Mat3, Vec2, Vec3};
use std::cell::Cell;

/// Lights that are sampled where a BSSRDF lets light into its object: what differs most between the exits near a point.
const LIGHTS_AT_EXITS: u32 = 3;
/// Surfaces and walks after which a long path asks whether to stop.
const TURNS_BETWEEN_QUESTIONS: u32 = 256;
/// Surfaces that a path may pass straight, so that none goes on for ever.
const MOST_PASSES: u32 = 1 << 20;

/// Follows paths through a scene; one for each thread.
pub(super) struct PathTracer<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub settings: &'a Settings,
    pub model: &'a dyn Propagator,
    pub camera: &'a Camera,
    /// The media around the camera.
    pub surroundings: &'a Surroundings,
    pub counters: Cell<RenderStats>,
    pub stop: Stop<'a>,
}

impl PathTracer<'_> {
    pub(super) fn count_ray(&self) {
        self.count(|c| c.rays += 1);
    }

    pub(super) fn count(&self, f: impl FnOnce(&mut RenderStats)) {
        let mut c = self.counters.get();
        f(&mut c);
        self.counters.set(c);
    }

    /// One sample of the pixel at (x, y).
    pub(super) fn sample_pixel(&self, x: u32, y: u32, sampler: &mut Sampler) -> PixelSample {
        let raster = Vec2::new(x as f32, y as f32) + sampler.next_2d();
        let ray = match self.camera.has_lens() {
            true => self.camera.lens_ray(raster, sampler.next_2d()),
            false => self.camera.ray(raster),
        };
        let mut sample = self.trace(ray, sampler);
        if !sample.radiance.is_finite() {
            self.count(|c| c.invalid_samples += 1);
            sample.radiance = Vec3::ZERO;
            sample.parts.fill(Vec3::ZERO);
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
            footprint: self.camera.footprint(&ray, self.settings.texture_filter),
            seen: Seen::default(),
        };
        let mut gathered = Gathered::new(&self.view.light_layers);
        let caught = self.follow(&mut path, &mut gathered, sampler);
        // What is seen straight through clear media is dimmed.
        let clear = if path.direct_view { path.head.throughput.element_sum() / 3.0 } else { 0.0 };
        let Gathered { sum: radiance, parts, .. } = gathered;
        PixelSample { radiance, parts, covered: 1.0 - clear, caught }
    }

    /// Follows a path until it ends; what it sees if that is the ground.
    pub(super) fn follow(
        &self,
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> Option<Caught> {
        let mut turns = 0_u32;
        while path.passes < MOST_PASSES {
            turns = turns.wrapping_add(1);
            if turns.is_multiple_of(TURNS_BETWEEN_QUESTIONS) && self.stop.asked() {
                break;
            }
            if path.place.is_some() {
                if self.meet_in_place(path, gathered, sampler) {
                    continue;
                }
                self.count_cut(path);
                return None;
            }
            let from = path.head.position;
            let reach = self.reach(path);
            let outside = path.stack.is_empty();
            let arrival = self.advance(path, reach, gathered, sampler);
            if path.direct_view
                && outside
                && let Some(t) = self.ground_distance(from, path.head.direction, &arrival, reach)
            {
                return Some(self.catch(path, from + t * path.head.direction, sampler));
            }
            let alive = match arrival {
                Arrival::Surface(hit) => self.meet_surface(&hit, path, gathered, sampler),
                Arrival::Exit(exit) => self.leave_below(*exit, path, gathered, sampler),
                Arrival::Escaped => {
                    if !(path.direct_view && self.view.transparent) {
                        gathered.add(self.environment(path), || path.tag(LightSource::Environment));
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
        self.count(|c| c.truncated_paths += 1);
        None
    }

    /// Counts a path that has ended if it was for an event too many.
    fn count_cut(&self, path: &Path) {
        if path.events > self.settings.max_depth {
            self.count(|c| c.truncated_paths += 1);
        }
    }

    /// How far a path can go before it leaves what the camera sees.
    #[inline]
    fn reach(&self, path: &Path) -> f32 {
        if path.direct_view {
            self.camera.reach(path.head.position, path.head.direction)
        } else {
            f32::INFINITY
        }
    }

    /// Nothing is beyond the far plane, media neither.
    #[inline]
    fn end_view(&self, path: &mut Path, reach: f32, arrival: &Arrival) {
        if reach < f32::INFINITY && matches!(arrival, Arrival::Escaped) {
            self.moved(path, |stack| *stack = MediumStack::default());
        }
    }

    /// Lets a path that has flown through a medium without an event out at the far plane.
    #[cold]
    fn end_flight(&self, path: &mut Path, (from, reach): (Vec3, f32), arrival: Arrival) -> Arrival {
        let arrival = match arrival {
            Arrival::Surface(_) if from.distance(path.head.position) > reach => Arrival::Escaped,
            other => other,
        };
        self.end_view(path, reach, &arrival);
        arrival
    }

    /// Moves the head to where it arrives next. What is seen straight ends after `reach`; flights through media that
    /// scatter do not, since nobody can say of light that was scattered on which side of the plane it was seen.
    fn advance(
        &self,
        path: &mut Path,
        reach: f32,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> Arrival {
        let Some((enclosure, medium)) =
            path.stack.current().and_then(|e| Some((e, self.scene.medium(e.material)?)))
        else {
            let arrival = self.straight(path, reach);
            self.end_view(path, reach, &arrival);
            return arrival;
        };
        if medium.sigma_s.max_element() <= 0.0 {
            let PathHead { position, direction, start, .. } = path.head;
            let arrival = self.straight(path, reach);
            let length = match &arrival {
                Arrival::Surface(hit) => {
                    let from = start.map(|s| s.hit());
                    Some(self.scene.geometry.distance_between(from.as_ref(), hit, direction))
                }
                _ => Some(reach).filter(|reach| reach.is_finite()),
            };
            if let Some(length) = length {
                path.head.throughput *=
                    self.segment_transmittance(position, direction, length, &path.stack, sampler);
            }
            self.end_view(path, reach, &arrival);
            return arrival;
        }
        let object = &self.scene.objects[enclosure.instance as usize];
        // An event more than there may be ends the path: the flight after the last one is to arrive.
        let budget = self.settings.max_depth.saturating_sub(path.events).saturating_add(1);
        let connection = self.connection(path, object, medium);
        let eta = medium.ior / self.ior_of(path.stack.below());
        let stop = self.stop;
        let flight = Flight { scene: self.scene, enclosure, object, medium, eta, budget, connection, stop };
        let from = path.head.position;
        path.head.events = 0;
        path.head.aimed = Aimed::default();
        let mut lights = FlightLights::new(self, path, enclosure, gathered);
        let arrival = self.model.propagate(&flight, &mut path.head, sampler, &mut lights);
        let FlightLights { radiance, vertex, .. } = lights;
        gathered.add_noted(radiance);
        if let Some(vertex) = vertex {
            path.vertex = vertex;
        } else if path.head.events > 0 {
            path.vertex = Vertex::unconnected(path.head.position);
        }
        path.events = path.events.saturating_add(path.head.events);
        let events = path.head.events;
        self.count(|c| {
            c.rays += 1;
            c.scattering_events += u64::from(events);
        });
        path.direct_view &= events == 0;
        if events > 0 {
            path.seen.note(FirstEvent::Medium, enclosure.instance);
            path.seen.scatterings = path.seen.scatterings.saturating_add(events);
            path.total_reflections = 0;
            path.footprint.forget();
        } else if reach < f32::INFINITY {
            return self.end_flight(path, (from, reach), arrival);
        }
        arrival
    }

    /// How the scattering events of a flight can be connected to lights.
    fn connection(&self, path: &Path, object: &Object, medium: &Medium) -> Connection {
        if object.lit_inside || (medium.ior - 1.0).abs() < MATCHED_INDEX {
            Connection::Straight
        } else if object.aimable && path.stack.len() == 1 && self.settings.aim {
            Connection::Boundary
        } else {
            Connection::None
        }
    }

    fn straight(&self, path: &mut Path, reach: f32) -> Arrival {
        self.count_ray();
        let head = &mut path.head;
        let ray = Ray { origin: head.position, direction: head.direction, t_max: reach };
        match self.scene.geometry.intersect(&ray) {
            Some(hit) => Arrival::Surface(hit),
            None => Arrival::Escaped,
        }
    }

    /// An exit that a BSSRDF has found: the path leaves the object there.
    fn leave_below(
        &self,
        exit: Exit,
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> bool {
        let Exit { mut surface, lobe } = exit;
        if let Some(e) = path.stack.current() {
            path.stack.leave(e.instance);
            path.head.throughput *= self.look_around(&mut path.stack, e, &mut surface);
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
        self.scatter(shaded, surface.normal, false, path, gathered, sampler)
    }

    /// Connects a shaded vertex to a light and samples its scattering function.
    pub(super) fn scatter(
        &self,
        mut shaded: Shaded<'_>,
        normal: Vec3,
        see_through: bool,
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> bool {
        shaded.orient(-path.head.direction, normal, see_through);
        // Written only where there is one: it is large, and mostly there is none.
        if let Some(above) = self.above(&shaded) {
            shaded.above = Some(above);
        }
        let connected = !shaded.bsdf.is_delta();
        let is_first = path.seen.first == FirstEvent::None;
        path.seen.note(FirstEvent::Surface, shaded.surface.instance);
        if connected {
            let light = self.direct(&shaded, path, gathered, sampler);
            gathered.add_noted(light);
        }
        let (u_lobe, u) = (sampler.next_1d(), sampler.next_2d());
        let Some(sample) = shaded.bsdf.sample(shaded.wo, u_lobe, u) else { return false };
        if let Some(drawn) = &shaded.drawn {
            self.keep_wavelength(path, drawn, shaded.wo, &sample);
        }
        let alive = self.leave(&shaded, &sample, connected, path, sampler);
        if is_first && sample.transmitted && shaded.enclosure.is_some() {
            path.seen.first = FirstEvent::Refraction;
        }
        let walks = if alive && sample.transmitted && shaded.front { self.walks(path) } else { 1 };
        if walks > 1 {
            self.follow_each(path, walks, gathered, sampler);
            return false;
        }
        alive
    }
}
