//! Light for the scattering events of a flight below a surface: in straight lines where nothing bends it, through the
//! boundary of the object where directions can be aimed.

use super::direct::{Reached, Shaded};
use super::gathered::{FirstEvent, Gathered, LightSource, LightTag, Seen};
use super::interface::Interface;
use super::media::{Enclosure, MediumStack};
use super::path::PathTracer;
use super::place::InPlace;
use super::shading_normal::from_below;
use super::state::{Path, Vertex};
use super::weight::Techniques;
use crate::geometry::{Hit, Ray, offset_origin};
use crate::light::{Anchor, LightSample};
use crate::optics::{Bsdf, HenyeyGreenstein, fresnel};
use crate::sampling::{Sampler, power_heuristic};
use crate::scene::{Shading, Surface};
use crate::subsurface::{Aim, Aimed, Connector, NearBoundary};
use glam::{Mat3, Vec3};

/// The lobe number that chooses refraction where there is any.
const REFRACT: f32 = 1.0 - f32::EPSILON / 2.0;

/// Area lights from behind that a ray may pass, so that none goes on for ever.
const MOST_ABSENT: u32 = 1 << 16;

/// What is known of all light that a flight finds.
#[derive(Clone, Copy)]
struct FlightTags {
    /// Events of the path before the flight.
    events: u32,
    seen: Seen,
    /// What the flight is in.
    instance: u32,
}

impl FlightTags {
    /// The tag of light that comes to an event of the flight.
    fn tag(&self, events: u32, light: LightSource) -> LightTag {
        let mut seen = self.seen;
        seen.note(FirstEvent::Medium, self.instance);
        seen.scatterings = seen.scatterings.saturating_add(events);
        seen.tag(self.events.saturating_add(events), light)
    }
}

/// The lights, as a flight sees them.
pub(super) struct FlightLights<'a, 'b, 'g> {
    tracer: &'a PathTracer<'b>,
    stack: MediumStack,
    enclosure: Enclosure,
    tags: FlightTags,
    /// Light found on the way.
    pub radiance: Vec3,
    /// What takes its parts.
    gathered: &'a mut Gathered<'g>,
    /// The last event, where directions found by chance are to be weighed.
    pub vertex: Option<Vertex>,
}

impl<'a, 'b, 'g> FlightLights<'a, 'b, 'g> {
    pub fn new(
        tracer: &'a PathTracer<'b>,
        path: &Path,
        enclosure: Enclosure,
        gathered: &'a mut Gathered<'g>,
    ) -> Self {
        let tags = FlightTags { events: path.events, seen: path.seen, instance: enclosure.instance };
        Self { tracer, stack: path.stack, enclosure, tags, radiance: Vec3::ZERO, gathered, vertex: None }
    }

    /// What a ray meets, area lights from behind left out.
    fn intersect_beyond_absent(&self, mut origin: Vec3, direction: Vec3) -> Option<Hit> {
        let scene = self.tracer.scene;
        let is_absent = |hit: &Hit| {
            let surface = Surface::new(scene, hit);
            let front = direction.dot(surface.geometric_normal) < 0.0;
            scene.material(surface.material).is_absent(front, false)
        };
        for _ in 0..MOST_ABSENT {
            let hit = scene.geometry.intersect(&Ray { origin, direction, t_max: f32::INFINITY })?;
            let others = || scene.geometry.place(&hit, direction).iter().any(|(other, _)| !is_absent(other));
            if !scene.has_area_lights || !is_absent(&hit) || (hit.crowded && others()) {
                return Some(hit);
            }
            let surface = Surface::new(scene, &hit);
            origin = offset_origin(surface.position, surface.error, surface.geometric_normal, direction);
        }
        None
    }

    /// Light found by refracting on through a smooth or nearly smooth boundary.
    fn refracted(&self, shaded: &Shaded<'_>, aimed: &Aimed, sampler: &mut Sampler) -> (Vec3, LightSource) {
        const NOTHING: (Vec3, LightSource) = (Vec3::ZERO, LightSource::Environment);
        let delta = shaded.bsdf.is_delta();
        let u_lobe = if delta { REFRACT } else { sampler.next_1d() };
        let Some(sample) = shaded.bsdf.sample(shaded.wo, u_lobe, sampler.next_2d()) else {
            return NOTHING;
        };
        let direction = (shaded.frame * sample.wi).normalize();
        let n = shaded.surface.geometric_normal;
        if !sample.transmitted || direction.dot(n) <= 0.0 {
            return NOTHING;
        }
        let from = shaded.surface.position;
        let origin = offset_origin(from, shaded.surface.error, n, direction);
        self.tracer.count_ray();
        let scene = self.tracer.scene;
        let (light, density, source) = match self.intersect_beyond_absent(origin, direction) {
            None => {
                let density = scene.lights.environment_pdf_at(&shaded.anchor, direction);
                (scene.lights.environment_radiance(direction), density, LightSource::Environment)
            }
            Some(hit) => {
                let top = || {
                    let mut stack = self.stack;
                    shaded.crossing?.apply(&mut stack);
                    InPlace::new(scene, &hit, direction, (&stack, false))?.members().next()?.first().copied()
                };
                let alone = Surface::new(scene, &hit);
                let surface = if hit.crowded { top().unwrap_or(alone) } else { alone };
                let material = scene.material(surface.material);
                let front = direction.dot(surface.geometric_normal) < 0.0;
                if material.unlit || !(front || material.double_sided) {
                    return NOTHING;
                }
                let id = scene.lights.emitter_id(surface.instance, surface.triangle);
                let pdf = |id| scene.lights.emitter_pdf_at(id, from, &shaded.anchor, surface.position);
                let source = LightSource::Surface(surface.instance);
                (scene.emission(&surface, -direction), id.map_or(0.0, pdf), source)
            }
        };
        let weigh =
            |light, chance| Techniques::new(light, chance, aimed.scattered_on() * chance).weigh_aimed();
        let weight = if delta { sample.pdf * weigh(0.0, 1.0) } else { weigh(density, sample.pdf) };
        (light * sample.weight * weight, source)
    }
}

impl Connector for FlightLights<'_, '_, '_> {
    fn scattered(
        &mut self,
        point: Vec3,
        incoming: Vec3,
        throughput: Vec3,
        phase: HenyeyGreenstein,
        events: u32,
        sampler: &mut Sampler,
    ) {
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        let Some(light) = self.tracer.scene.lights.sample(point, None, u_select, u) else { return };
        let f = phase.eval_directions(incoming, light.direction);
        let weight = if light.point.is_delta() { 1.0 } else { power_heuristic(light.pdf, f) };
        let contribution = throughput * light.radiance * (f * weight / light.pdf);
        if contribution.max_element() > 0.0 {
            let ray = self.tracer.shadow_ray(point, &light);
            let found = contribution * self.tracer.transmittance(&ray, self.stack, sampler);
            let (tags, tracer) = (self.tags, self.tracer);
            self.radiance += found;
            self.gathered.note_part(|| (found, tags.tag(events, tracer.source_of(&light.point))));
        }
    }

    fn redirected(&mut self, point: Vec3, pdf: f32) {
        self.vertex = Some(Vertex {
            point,
            anchor: Anchor::at(point, None),
            pdf,
            connected: true,
            lights: 1.0,
            aimed: Aimed::default(),
        });
    }

    fn light(&mut self, point: Vec3, sampler: &mut Sampler) -> Option<LightSample> {
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        self.tracer.scene.lights.sample(point, None, u_select, u)
    }

    fn closest_light(&mut self, point: Vec3, sampler: &mut Sampler) -> Option<LightSample> {
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        self.tracer.scene.lights.sample_closest(point, u_select, u)
    }

    fn deliver(
        &mut self,
        surface: &Surface,
        light: &LightSample,
        covered: f32,
        throughput: Vec3,
        sampler: &mut Sampler,
    ) {
        let contribution = throughput * light.radiance / light.pdf;
        let distance = light.distance - covered;
        let counts = contribution.is_finite() && contribution.max_element() > 0.0 && distance > 0.0;
        if !counts || !self.tracer.bounds_medium(surface) {
            return;
        }
        let mut stack = self.stack;
        stack.leave(self.enclosure.instance);
        let mut surface = *surface;
        let scale = self.tracer.look_around(&mut stack, self.enclosure, &mut surface);
        let ray = self.tracer.shadow_ray_from(&surface, &LightSample { distance, ..*light });
        let found = contribution * scale * self.tracer.transmittance(&ray, stack, sampler);
        let (tags, tracer) = (self.tags, self.tracer);
        self.radiance += found;
        self.gathered.note_part(|| (found, tags.tag(1, tracer.source_of(&light.point))));
    }

    fn aim(&self, point: Vec3, normal: Vec3, aim: &mut Aim) -> bool {
        let scene = self.tracer.scene;
        let material = scene.material(self.enclosure.material);
        let Some(medium) = &material.medium else { return false };
        let alpha = material.roughness * material.roughness;
        let instance = self.enclosure.instance;
        aim.set_boundary(NearBoundary { instance, point, normal, eta: medium.ior }, alpha);
        aim.samples_light() || aim.at_beacons(&scene.beacons, point)
    }

    fn draw(&self, point: Vec3, aim: &mut Aim, sampler: &mut Sampler) -> Option<(Vec3, f32)> {
        if aim.samples_light() {
            let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
            let lights = &self.tracer.scene.lights;
            let light = lights.sample_at(&aim.anchor(), u_select, u)?;
            let outside = lights.direction_to(&light.point, point)?;
            let normal = self.tracer.emerging_normal(aim.boundary(), outside);
            if !aim.towards(outside, normal, light) {
                return None;
            }
        }
        aim.sample(sampler.rng())
    }

    fn emerge(
        &mut self,
        hit: &Hit,
        incoming: Vec3,
        throughput: Vec3,
        aim: &Aim,
        aimed: Aimed,
        sampler: &mut Sampler,
    ) {
        let tracer = self.tracer;
        let surface = Surface::new(tracer.scene, hit);
        if hit.crowded || !tracer.bounds_medium(&surface) || incoming.dot(surface.geometric_normal) <= 0.0 {
            return;
        }
        let mut interface = Interface::NONE;
        tracer.find_interface(&mut interface, &self.stack, std::slice::from_ref(&surface), &incoming);
        let Some(contrast) = interface.contrast.as_ref().filter(|c| !c.entering) else { return };
        let shading = Shading::new(tracer.scene, &surface);
        let bsdf = shading.bsdf(contrast.eta, true, tracer.settings.microfacet);
        if !matches!(bsdf, Bsdf::Boundary(_)) {
            return;
        }
        let normal = from_below(&surface, shading.normal, -incoming, contrast.eta);
        let mut shaded = Shaded {
            surface: &surface,
            bsdf: &bsdf,
            frame: Mat3::IDENTITY,
            wo: Vec3::Z,
            front: false,
            enclosure: Some(contrast.enclosure),
            crossing: Some(&interface.crossing),
            place: None,
            dispersed: 1.0,
            anchor: Shaded::NOWHERE,
            lights: 1,
            lit_inside: false,
            reached: Reached { aimed, by_aiming: true },
            matched: false,
            drawn: None,
            above: None,
        };
        shaded.orient(-incoming, normal, true);
        let (light, source) = match aim.chosen() {
            Some(chosen) => {
                let seen = tracer.scene.lights.seen_from(chosen, aim.boundary().point, surface.position);
                let light =
                    seen.map_or(Vec3::ZERO, |l| tracer.direct_surface(&shaded, &self.stack, &l, sampler));
                (light, LightSource::Environment)
            }
            None => self.refracted(&shaded, &aimed, sampler),
        };
        let tags = self.tags;
        let tag = || {
            // The boundary on the way to the light is one more event.
            let source = aim.chosen().map_or(source, |light| tracer.source_of(&light.point));
            let tag = tags.tag(aim.events(), source);
            LightTag { events: tag.events.saturating_add(1), ..tag }
        };
        let found = throughput * light;
        self.radiance += found;
        self.gathered.note_part(|| (found, tag()));
    }
}

/// Light is taken to come from at least so far above the horizon (sine of elevation), to find where it comes out: that from
/// below the horizon near by comes out where the boundary bends towards it.
const LEAST_ABOVE: f32 = 0.05;

impl PathTracer<'_> {
    /// The normal of the boundary where light from the unit direction `outside` leaves towards a point inside, to first
    /// order: where it would if the boundary had the normal near by everywhere.
    pub(super) fn emerging_normal(&self, nearby: &NearBoundary, outside: Vec3) -> Vec3 {
        let NearBoundary { instance, point, normal, eta } = *nearby;
        let above = outside.dot(normal);
        let outside = if above < LEAST_ABOVE {
            (outside + (LEAST_ABOVE - above) * normal).normalize()
        } else {
            outside
        };
        let Some(inward) = fresnel::refract(outside, normal, eta) else { return normal };
        let direction = -inward.normalize();
        let ray = Ray { origin: point, direction, t_max: f32::INFINITY };
        match self.scene.geometry.intersect_instance(instance, &ray) {
            Some(hit) => {
                let surface = Surface::new(self.scene, &hit);
                if direction.dot(surface.geometric_normal) > 0.0 { surface.normal } else { normal }
            }
            None => normal,
        }
    }

    /// `aimed`, for light from the unit direction `outside`.
    #[inline]
    pub(super) fn resolved(&self, aimed: Aimed, outside: Vec3) -> Aimed {
        aimed.resolve(outside, |nearby| self.emerging_normal(nearby, outside))
    }
}
