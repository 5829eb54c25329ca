//! `random-walk`: the ground truth. Volumetric path tracing from boundary to boundary, nothing approximated.
//!
//! | code | symbol | unit |
//! | --- | --- | --- |
//! | `sigma_t`, `sigma_s` | σt, σs | 1/m |
//! | `t` | free flight | m |
//! | `throughput` | β | 1 |
//!
//! **Distances.** Free flights and their weights are those of [`super::spectral`].
//!
//! **Short queries.** In a closed object the walk runs in the object's own space, and a flight shorter than a lower
//! bound of the distance to the boundary ([`crate::geometry::DistanceBound`]) asks no ray query. Flights and directions
//! are drawn for several events at once ([`super::draws`]). What else reaches into the object's bounds is only asked
//! for by flights that come near it.
//!
//! **Jumps.** The accelerated walk crosses spheres at once ([`super::sphere_jumps`]).
//!
//! **Guiding.** Walks below a boundary that lights can be aimed through are drawn towards the strongest of them
//! ([`super::guide`]).
//!
//! **Connections.** Where a walk has met the boundary, its last event is connected to light ([`super::last_event`]): a
//! direction ω is aimed at light beyond the boundary ([`super::Aim`]) with density q, and the light that it finds
//! directly is added. Guided walks are connected at events near the boundary instead, each with some probability. The
//! path itself may find the same light: its direction has density p (the phase function), and it reaches the boundary
//! with probability P. Both are weighed by the power heuristic with the ratio r = a q/(p P), a connections being made
//! on average ([`PathHead::aimed`]); `transport::weight` has the weights.

use super::aiming::{self, Aiming, Event};
use super::draws::Draws;
use super::guide::{Guide, Plain, Steering, Way, Ways};
use super::intruders::Intruders;
use super::spectral::{Coefficients, draw_flight};
use super::sphere_jumps::{Jumping, SphereJumps};
use super::steps::{placed, scatter, survival};
use super::{
    Aimed, Arrival, BETWEEN_QUESTIONS, Connection, Connector, Flight, PathHead, Propagator, SubsurfaceModel,
    textured,
};
use crate::geometry::{DistanceBound, Hit, MeshHit, Ray, offset_origin};
use crate::optics::Medium;
use crate::sampling::Sampler;
use crate::scene::{MediumDescription, Scene};
use glam::{Vec3, Vec3A};

/// The ground truth.
pub struct RandomWalk;

impl SubsurfaceModel for RandomWalk {
    fn name(&self) -> &str {
        "random-walk"
    }

    fn summary(&self) -> &str {
        "volumetric path tracing below the surface: the ground truth"
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        prepare(scene, false)
    }
}

/// A walk, with jumps across spheres or without.
pub(super) fn prepare(scene: &Scene, jumps: bool) -> Box<dyn Propagator> {
    let media = (0..scene.objects.len() as u32).map(|instance| {
        let mut materials = scene.mesh(instance).triangle_materials.iter().copied();
        let material = materials.find(|&m| scene.medium(m).is_some())?;
        let medium = scene.medium(material)?;
        let jumps = if jumps && scene.objects[instance as usize].intruders.is_empty() {
            let scale = scene.geometry.transform(instance).scale * thinning(scene, instance, medium);
            let size = scene.geometry.mesh_of(instance).bounds().extent().min_element();
            SphereJumps::new(medium.sigma_a * scale, medium.sigma_s * scale, medium.g, size)
        } else {
            None
        };
        Some(Walkable { material, coefficients: coefficients(scene, instance, medium), jumps })
    });
    Box::new(Walker { media: media.collect() })
}

struct Walker {
    /// For each instance.
    media: Vec<Option<Walkable>>,
}

/// The first of the materials of an instance that has a medium, in its own space.
struct Walkable {
    material: u32,
    coefficients: Coefficients,
    jumps: Option<SphereJumps>,
}

/// Shortest mean free path in sizes of an object. Positions could not follow shorter ones, and nobody could see the
/// difference: light comes out where it went in.
const SHORTEST_PATH: f32 = 1e-6;

/// The coefficients of a medium in the space of an instance.
fn coefficients(scene: &Scene, instance: u32, medium: &Medium) -> Coefficients {
    let scale = scene.geometry.transform(instance).scale * thinning(scene, instance, medium);
    Coefficients::new(medium.sigma_a, medium.sigma_s, medium.g, scale)
}

/// What to multiply coefficients with, so that no mean free path is too short.
fn thinning(scene: &Scene, instance: u32, medium: &Medium) -> f32 {
    let scale = scene.geometry.transform(instance).scale;
    let size = scene.geometry.mesh_of(instance).bounds().extent().max_element();
    (medium.sigma_t.max_element() * scale * size * SHORTEST_PATH).max(1.0).recip()
}

impl Propagator for Walker {
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        let material = flight.scene.material(flight.enclosure.material);
        let textures = material.medium.as_ref();
        if textures.is_some_and(MediumDescription::is_textured) {
            return textured::propagate(flight, head, sampler, connector);
        }
        match (&flight.object.distance, flight.connection) {
            (Some(distance), Connection::None | Connection::Boundary) => {
                let enclosure = flight.enclosure;
                let distance = distance.get(flight.scene.geometry.mesh_of(enclosure.instance));
                match &self.media[enclosure.instance as usize] {
                    Some(m) if m.material == enclosure.material => {
                        let medium = (&m.coefficients, m.jumps.as_ref());
                        walk_inside(flight, medium, distance, head, sampler, connector)
                    }
                    _ => {
                        let c = coefficients(flight.scene, enclosure.instance, flight.medium);
                        walk_inside(flight, (&c, None), distance, head, sampler, connector)
                    }
                }
            }
            _ => walk_in_scene(flight, head, sampler, connector),
        }
    }
}

/// Events after which a long walk asks whether to stop: well below a millisecond.
const EVENTS_BETWEEN_QUESTIONS: u32 = 4096;

/// The walk in a closed object that light can leave only through its boundary, in the object's own space. What else is
/// inside is asked for where it can be.
fn walk_inside(
    flight: &Flight<'_>,
    (c, jumps): (&Coefficients, Option<&SphereJumps>),
    distance: &DistanceBound,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let instance = flight.enclosure.instance;
    let mesh = flight.scene.geometry.mesh_of(instance);
    let transform = flight.scene.geometry.transform(instance);
    let d = transform.inverse_direction(head.direction);
    let p = match &head.start {
        Some(s) if s.instance == instance => {
            let (p, error) = mesh.point(s.triangle, s.barycentric.x, s.barycentric.y);
            offset_origin(p, error, mesh.geometric_normal(s.triangle), d)
        }
        _ => transform.inverse_point(head.position),
    };
    match (guide(flight, c, p), jumps) {
        (Some(guide), _) => walk_steered(flight, (c, distance, &guide), (p, d), head, sampler, connector),
        (None, Some(jumps)) => {
            walk_steered(flight, (c, distance, &Jumping(jumps)), (p, d), head, sampler, connector)
        }
        (None, None) => walk_steered(flight, (c, distance, &Plain), (p, d), head, sampler, connector),
    }
}

fn walk_steered<S: Steering>(
    flight: &Flight<'_>,
    (c, distance, steering): (&Coefficients, &DistanceBound, &S),
    (mut p, mut d): (Vec3, Vec3),
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let instance = flight.enclosure.instance;
    let mesh = flight.scene.geometry.mesh_of(instance);
    let transform = flight.scene.geometry.transform(instance);
    let medium = flight.medium;
    let radiance_scale = medium.ior * medium.ior;
    let bounds = mesh.bounds();
    let intruders = Intruders::new(flight, transform, bounds.extent().length());
    // Plain walks are connected to light where they meet the boundary, guided ones at their events.
    let at_arrival = flight.connection == Connection::Boundary && !S::GUIDED;
    let at_events = flight.connection == Connection::Boundary && S::GUIDED;
    let mut aiming = Aiming::new(instance, (mesh, transform, distance), &intruders, radiance_scale);
    // After the last event that counts, light could not come out any more.
    let last = flight.budget.saturating_sub(1);
    // The last event, where it was connected to light.
    let mut event = Event { p, clear: 0.0, incoming: d, beta: Vec3A::ZERO };

    // Where the walk sets out from the surface of something else, `p` has lost what keeps it off that surface.
    let mut outset = Some(head.position);
    let mut beta = Vec3A::from(head.throughput);
    let enough = aiming::reach(c);
    // How far the boundary is at least.
    let mut clear = 0.0;
    // Events before the flight that the walk set out with, or that a jump ended with: it was not scattered into that.
    let mut first = 0;
    // Direction of travel before the last event.
    let mut before = d;
    distance.prefetch(p);
    let mut question = EVENTS_BETWEEN_QUESTIONS;
    let mut draws = Draws::new(c.phase, sampler.rng());
    let mut next_flight = draw_flight(sampler.rng());
    let arrival = 'walk: loop {
        let (channel, mean_free_path) = c.draw_channel(beta, sampler.rng());
        let mut stretch = steering.stretch(channel, p, d, sampler.rng());
        let most = c.stretch.min(S::LONGEST).min((flight.budget - head.events) as usize);
        let (mut collisions, mut length, mut jumps) = (0, 0.0, false);
        while collisions < most {
            let t = stretch.flight(next_flight * mean_free_path, d);
            // What comes next is drawn before the branches, which are hard to predict: it need not be done again.
            let (flight, scattered) = draws.event(d);
            next_flight = flight;
            let turned = stretch.direction(sampler.rng()).unwrap_or(scattered);
            let intruder = intruders.intersect(p, outset.take(), d, t);
            // The boundary may be in the same place as what is met before it.
            let t_max = intruder.as_ref().map_or(t, |hit| hit.t + hit.band);
            if t >= clear {
                let stays;
                (clear, stays) = distance.bound_ahead(mesh, p, d * t);
                if t >= clear && !stays {
                    let boundary = mesh.intersect(&Ray { origin: p, direction: d, t_max });
                    if let Some(hit) = boundary
                        && let Some(hit) = before_intruder(hit, intruder.as_ref())
                    {
                        let mut aimed = Aimed::default();
                        if at_events {
                            aimed = aiming.aimed_at_event(c, &event, (d, hit.t), connector);
                        } else if at_arrival && head.events > first && head.events < last {
                            let (event, way) =
                                (Event { p, clear, incoming: before, beta }, (collisions, length));
                            aiming.events = head.events;
                            aimed = aiming.at_arrival(c, event, way, (d, hit.t), sampler, connector);
                        }
                        // Nothing is aimed through what is in one place with something else.
                        head.aimed = if hit.crowded { Aimed::default() } else { aimed };
                        p += d * hit.t;
                        beta = stretch.weigh(c, beta, Way { collisions, length: length + hit.t, p }, d);
                        break 'walk Arrival::Surface(placed(&hit, instance, transform.scale));
                    }
                    // Rounding next to a sharp edge may have let the walk out.
                    if intruder.is_none() && (t == f32::INFINITY || !bounds.contains(p)) {
                        break 'walk Arrival::Escaped;
                    }
                }
            }
            if let Some(hit) = intruder {
                if at_arrival && head.events > first && head.events < last {
                    let clear = distance.bound(mesh, p);
                    let (event, way) = (Event { p, clear, incoming: before, beta }, (collisions, length));
                    aiming.events = head.events;
                    aiming.at_arrival(c, event, way, (d, hit.t), sampler, connector);
                }
                p += d * hit.t;
                beta = stretch.weigh(c, beta, Way { collisions, length: length + hit.t, p }, d);
                let (t, band) = (hit.t * transform.scale, hit.band * transform.scale);
                break 'walk Arrival::Surface(Hit { t, band, ..hit });
            }
            p += d * t;
            length += t;
            clear -= t;
            collisions += 1;
            head.events += 1;
            before = d;
            stretch.collide(d);
            if clear >= steering.room() {
                jumps = true;
                break;
            }
            d = turned;
            if !at_events {
                continue;
            }
            aiming.forget();
            if clear >= enough || head.events >= last {
                continue;
            }
            clear = distance.bound(mesh, p);
            if clear >= enough {
                continue;
            }
            let at_event = stretch.weigh_event(c, beta, Way { collisions, length, p });
            event = Event { p, clear, incoming: before, beta: at_event };
            aiming.events = head.events;
            aiming.at_event(c, &event, sampler, connector);
        }
        beta = stretch.weigh(c, beta, Way { collisions, length, p }, d);
        let survival = survival(beta.max_element() * radiance_scale, sampler.rng());
        if head.events >= question {
            question = head.events.saturating_add(EVENTS_BETWEEN_QUESTIONS);
            if flight.stop.asked() {
                break Arrival::Ended;
            }
        }
        if survival == 0.0 || head.events >= flight.budget {
            break Arrival::Ended;
        }
        beta *= survival;
        if jumps {
            (p, d, beta) = steering.jump(c, (p, d, beta), clear, sampler.rng());
            clear = 0.0;
            head.events += 1;
            first = head.events;
        }
    };
    head.position = transform.point(p);
    head.direction = transform.direction(d);
    head.throughput = beta.into();
    arrival
}

/// A hit of the boundary, if it comes before what is inside or is in one place with it; crowded then.
#[inline]
fn before_intruder(boundary: MeshHit, inside: Option<&Hit>) -> Option<MeshHit> {
    let Some(inside) = inside else { return Some(boundary) };
    let together = (boundary.t - inside.t).abs() <= boundary.band.max(inside.band);
    let crowded = boundary.crowded || together;
    (together || boundary.t < inside.t).then_some(MeshHit { crowded, ..boundary })
}

/// Guides walks from `p` towards the strongest light that directions can be aimed at.
fn guide(flight: &Flight<'_>, c: &Coefficients, p: Vec3) -> Option<Guide> {
    if flight.connection != Connection::Boundary {
        return None;
    }
    let instance = flight.enclosure.instance;
    let transform = flight.scene.geometry.transform(instance);
    let from = transform.point(p);
    let lights = flight.scene.beacons.iter().map(|b| b.seen_from(from));
    let light = lights.max_by(|a, b| a.irradiance.total_cmp(&b.irradiance))?;
    let axis = transform.inverse_direction(light.direction);
    let ray = Ray { origin: p, direction: axis, t_max: f32::INFINITY };
    let ahead = flight.scene.geometry.mesh_of(instance).intersect(&ray).map_or(0.0, |hit| hit.t);
    Guide::new(c, axis, ahead)
}

/// The walk among whatever else is inside, in world space.
fn walk_in_scene(
    flight: &Flight<'_>,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let medium = flight.medium;
    let straight = flight.connection == Connection::Straight;
    let thinning = thinning(flight.scene, flight.enclosure.instance, medium);
    let c = Coefficients::new(medium.sigma_a, medium.sigma_s, medium.g, thinning);
    let radiance_scale = medium.ior * medium.ior;
    let bounds = flight.bounds();
    loop {
        let mean_free_path = c.draw_mean_free_path(head.throughput.into(), sampler.rng());
        let t = draw_flight(sampler.rng()) * mean_free_path;
        let ray = Ray { origin: head.position, direction: head.direction, t_max: t };
        if let Some(hit) = flight.scene.geometry.intersect(&ray) {
            head.throughput = c.weigh(head.throughput.into(), 0, hit.t).into();
            head.position += head.direction * hit.t;
            return Arrival::Surface(hit);
        }
        if t == f32::INFINITY {
            return Arrival::Escaped;
        }
        head.throughput = c.weigh(head.throughput.into(), 1, t).into();
        head.position += head.direction * t;
        if !bounds.contains(head.position) {
            return Arrival::Escaped;
        }
        let connects = straight && head.events + 1 < flight.budget;
        if !scatter(head, c.phase, sampler, connects.then_some(&mut *connector)) {
            return Arrival::Ended;
        }
        head.throughput *= survival(head.throughput.max_element() * radiance_scale, sampler.rng());
        let asked = head.events.is_multiple_of(BETWEEN_QUESTIONS) && flight.stop.asked();
        if head.events >= flight.budget || head.throughput.max_element() <= 0.0 || asked {
            return Arrival::Ended;
        }
    }
}
