//! The random walk where coefficients come from textures: delta tracking against the factors.
//!
//! σ at an interior point is that of its nearest boundary point, so the medium is a function of position, the same for
//! every path. Textures multiply the factors and are at most 1, so the factors bound them: tentative collisions are
//! drawn from one majorant M = max_k σt_k, and each is real or null. Media of the Khronos drafts keep their extinction, and
//! textures of their multi-scatter albedo ρ say how much of it scatters: ρ is looked up first, and σs follows from it there.
//!
//! **Spectral weights** (null-scattering path integral, Miller, Georgiev & Jarosz 2019). At a tentative collision let
//! σn = M − σt ≥ 0 for each channel. It is real with probability P = Σβσs / Σβ(σs + σn), and then
//! β ← β σs/(M P); otherwise β ← β σn/(M (1−P)). Either way Σβ' = Σβ(σs + σn)/M ≤ Σβ. (Counting null collisions of the
//! clearer channels as scattering would gain energy; the coloured furnace shows it.)
//!
//! The nearest boundary point of the last event bounds the next search: it is at most the distance travelled farther. It
//! also says how far the boundary is, so in an object that holds nothing else a shorter flight asks no ray query.
//!
//! **Aimed connections** are those of [`super::random_walk`], made at real collisions. On the way to the boundary the
//! transmittance is estimated by ratio tracking, but weights need a density that all techniques agree on: P is
//! Σβ e^{−σt t}/Σβ with β and σt of the event, exact where the medium is the same all the way. Weights add up to 1 for
//! every path whatever P is, so a wrong P costs noise and nothing else.

use super::aiming::{AIMING_DEPTH, AIMING_FALLOFF, AIMING_RATE};
use super::steps::{scatter, survival};
use super::{Aim, Aimed, Arrival, BETWEEN_QUESTIONS, Connection, Connector, Flight, PathHead};
use crate::geometry::{Hit, MeshGeometry, Ray, Similarity};
use crate::optics::albedo::{absorbed_from_multiple, single_from_multiple};
use crate::sampling::{Sampler, SmallRng};
use crate::scene::{Scene, Surface};
use crate::transport::Enclosure;
use glam::{Vec2, Vec3, Vec4};

/// Room for rounding in distances, so that a bound cannot exclude the very point that it came from.
const SLACK: f32 = 1e-4;

/// The coefficients of one object as a function of position.
pub struct TexturedMedium<'a> {
    scene: &'a Scene,
    enclosure: Enclosure,
    /// Where the last look-up was, in local space, how far its boundary point, and on which triangle.
    last: Option<(Vec3, f32, u32)>,
}

impl<'a> TexturedMedium<'a> {
    /// Coefficients of the medium of `enclosure`.
    pub fn new(scene: &'a Scene, enclosure: Enclosure) -> Self {
        Self { scene, enclosure, last: None }
    }

    /// (σa, σs) at a world position, 1/m.
    pub fn coefficients(&mut self, position: Vec3) -> (Vec3, Vec3) {
        let Some(medium) = &self.scene.material(self.enclosure.material).medium else {
            return (Vec3::ZERO, Vec3::ZERO);
        };
        let instance = self.enclosure.instance;
        let (mesh, transform) = self.geometry();
        let p = transform.inverse_point(position);
        let reach = self.last.map_or(f32::INFINITY, |(q, r, _)| (r + p.distance(q)) * (1.0 + SLACK));
        let nearest = mesh.nearest(p, reach).or_else(|| mesh.nearest(p, f32::INFINITY));
        let Some(nearest) = nearest else { return (medium.sigma_a, medium.sigma_s) };
        self.last = Some((p, nearest.distance, nearest.triangle));
        let point = Surface {
            position,
            error: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            normal: Vec3::Z,
            instance,
            triangle: nearest.triangle,
            barycentric: Vec2::new(nearest.u, nearest.v),
            material: self.enclosure.material,
            footprint: 0.0,
        };
        let factor = |texture: &Option<_>| match texture {
            Some(t) => point.texture(self.scene, t).clamp(Vec4::ZERO, Vec4::ONE),
            None => Vec4::ONE,
        };
        if let Some(split) = &medium.multi_scatter {
            let rho = split.rho * factor(&split.color_texture).truncate() * factor(&split.strength_texture).w;
            let sigma_t = medium.sigma_a + medium.sigma_s;
            return (
                sigma_t * rho.map(|r| absorbed_from_multiple(r, split.mapping_anisotropy)),
                sigma_t * rho.map(|r| single_from_multiple(r, split.mapping_anisotropy)),
            );
        }
        let factor = |texture: &Option<_>| factor(texture).truncate();
        (
            medium.sigma_a * factor(&medium.absorption_texture),
            medium.sigma_s * factor(&medium.scattering_texture),
        )
    }

    /// How far the boundary is from where coefficients were last asked for, in metres, and its outward unit normal.
    fn boundary(&self) -> Option<(f32, Vec3)> {
        let (_, distance, triangle) = self.last?;
        let (mesh, transform) = self.geometry();
        let normal = transform.direction(mesh.geometric_normal(triangle));
        Some((distance * transform.scale * (1.0 - SLACK), normal))
    }

    fn geometry(&self) -> (&'a MeshGeometry, &'a Similarity) {
        let geometry = &self.scene.geometry;
        (geometry.mesh_of(self.enclosure.instance), geometry.transform(self.enclosure.instance))
    }

    /// An unbiased estimate of the transmittance over a segment that stays in the medium (ratio tracking).
    pub fn transmittance(&mut self, origin: Vec3, direction: Vec3, length: f32, rng: &mut SmallRng) -> Vec3 {
        let Some(medium) = &self.scene.material(self.enclosure.material).medium else { return Vec3::ONE };
        let majorant = (medium.sigma_a + medium.sigma_s).max_element();
        if majorant <= 0.0 {
            return Vec3::ONE;
        }
        if medium.multi_scatter.is_some() {
            // Such textures share extinction out and do not change it. 0 · ∞ is 0 here.
            let sigma_t = medium.sigma_a + medium.sigma_s;
            return Vec3::select(sigma_t.cmpgt(Vec3::ZERO), (-sigma_t * length).exp(), Vec3::ONE);
        }
        let (mut t, mut transmittance) = (0.0, Vec3::ONE);
        loop {
            t += rng.exponential() / majorant;
            if t >= length {
                return transmittance;
            }
            let (sigma_a, sigma_s) = self.coefficients(origin + direction * t);
            transmittance *= Vec3::ONE - (sigma_a + sigma_s) / majorant;
            transmittance *= survival(transmittance.max_element(), rng);
            if transmittance.max_element() <= 0.0 {
                return Vec3::ZERO;
            }
        }
    }
}

/// Null collisions of a flight, at most: in an open mesh there is no end to them.
const MOST_NULL_COLLISIONS: u32 = 1 << 16;

/// Follows a path through a textured medium.
pub(super) fn propagate(
    flight: &Flight<'_>,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let medium = flight.medium;
    let majorant = medium.sigma_t.max_element();
    let radiance_scale = medium.ior * medium.ior;
    let mut textured = TexturedMedium::new(flight.scene, flight.enclosure);
    let alone = flight.object.isolated;
    let straight = flight.connection == Connection::Straight;
    let mut aiming = (flight.connection == Connection::Boundary).then(Aiming::default);
    // The boundary is at least that far.
    let mut clear = 0.0;
    let bounds = flight.bounds();
    // They turn nothing: what is met after them is seen from where the flight set out.
    let mut nulls = 0;
    loop {
        let t = if majorant > 0.0 { sampler.rng().exponential() / majorant } else { f32::INFINITY };
        if (t >= clear || !alone)
            && let Some(hit) =
                intersect(flight, alone, &Ray { origin: head.position, direction: head.direction, t_max: t })
        {
            if let Some(aiming) = &mut aiming
                && hit.instance == flight.enclosure.instance
                && !hit.crowded
            {
                head.aimed = aiming.aimed(head.direction, hit.t, connector);
            }
            head.position += head.direction * hit.t;
            return Arrival::Surface(hit);
        }
        if t == f32::INFINITY {
            return Arrival::Escaped;
        }
        head.position += head.direction * t;
        if !bounds.contains(head.position) {
            return Arrival::Escaped;
        }
        let (sigma_a, sigma_s) = textured.coefficients(head.position);
        let boundary = textured.boundary();
        clear = boundary.map_or(0.0, |(distance, _)| distance);
        let sigma_n = (Vec3::splat(majorant) - sigma_a - sigma_s).max(Vec3::ZERO);
        let scattered = (head.throughput * sigma_s).element_sum();
        let total = scattered + (head.throughput * sigma_n).element_sum();
        if total <= 0.0 {
            return Arrival::Ended;
        }
        let real = scattered / total;
        if sampler.rng().f32() < real {
            head.throughput *= sigma_s / (majorant * real);
            let incoming = head.direction;
            let connects = straight && head.events + 1 < flight.budget;
            if !scatter(head, medium.phase(), sampler, connects.then_some(&mut *connector)) {
                return Arrival::Ended;
            }
            if let (Some(aiming), Some((distance, normal))) = (&mut aiming, boundary) {
                *aiming = Aiming {
                    point: head.position,
                    normal,
                    incoming,
                    throughput: head.throughput,
                    sigma_t: sigma_a + sigma_s,
                    ..Aiming::default()
                };
                aiming.phase_pdf = medium.phase().eval_directions(incoming, head.direction);
                aiming.rate = aiming_rate(distance, sigma_a + sigma_s, head.throughput * radiance_scale);
                if head.events + 1 < flight.budget && sampler.rng().f32() < aiming.rate {
                    aiming.aim.set_events(head.events);
                    aiming.shoot(flight, &mut textured, sampler, connector);
                }
            }
        } else {
            head.throughput *= sigma_n / (majorant * (1.0 - real));
            nulls += 1;
            if let Some(aiming) = &mut aiming {
                aiming.flown += t;
            }
        }
        head.throughput *= survival(head.throughput.max_element() * radiance_scale, sampler.rng());
        let asked = (head.events + nulls).is_multiple_of(BETWEEN_QUESTIONS) && flight.stop.asked();
        let over = head.events >= flight.budget || nulls >= MOST_NULL_COLLISIONS || asked;
        if over || head.throughput.max_element() <= 0.0 {
            return Arrival::Ended;
        }
    }
}

fn intersect(flight: &Flight<'_>, alone: bool, ray: &Ray) -> Option<Hit> {
    let geometry = &flight.scene.geometry;
    if alone { geometry.intersect_instance(flight.enclosure.instance, ray) } else { geometry.intersect(ray) }
}

/// The probability to aim at light from a depth below the boundary; paths of little weight are not worth it.
fn aiming_rate(depth: f32, sigma_t: Vec3, weight: Vec3) -> f32 {
    let depth = depth * sigma_t.min_element();
    if depth >= AIMING_DEPTH {
        return 0.0;
    }
    AIMING_RATE * weight.max_element().min(1.0) * (-AIMING_FALLOFF * depth).exp()
}

/// Aiming at the last real collision, and what the weights have to know of it.
#[derive(Default)]
struct Aiming {
    aim: Aim,
    /// Whether there is anything to aim at, once that is known.
    ready: Option<bool>,
    /// Probability that a direction was aimed.
    rate: f32,
    point: Vec3,
    /// Of the boundary near by.
    normal: Vec3,
    incoming: Vec3,
    throughput: Vec3,
    sigma_t: Vec3,
    /// Density of the direction that the path itself has taken.
    phase_pdf: f32,
    /// How far it has come since.
    flown: f32,
}

impl Aiming {
    fn ready(&mut self, connector: &mut dyn Connector) -> bool {
        if self.rate <= 0.0 {
            return false;
        }
        let (point, normal, aim) = (self.point, self.normal, &mut self.aim);
        *self.ready.get_or_insert_with(|| connector.aim(point, normal, aim))
    }

    /// P, as a function of the event and the distance alone.
    fn arrival_probability(&self, t: f32) -> f32 {
        (self.throughput * (-self.sigma_t * t).exp()).element_sum() / self.throughput.element_sum()
    }

    /// How likely the path's own way to the boundary, `t` metres on, was to be aimed.
    fn aimed(&mut self, direction: Vec3, t: f32, connector: &mut dyn Connector) -> Aimed {
        if !self.ready(connector) {
            return Aimed::default();
        }
        let density = self.phase_pdf * self.arrival_probability(self.flown + t);
        self.aim.aimed(direction, self.rate / density)
    }

    /// Aims, and adds what is found beyond the boundary.
    fn shoot(
        &mut self,
        flight: &Flight<'_>,
        textured: &mut TexturedMedium<'_>,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) {
        if !self.ready(connector) {
            return;
        }
        let Some((direction, pdf)) = connector.draw(self.point, &mut self.aim, sampler) else { return };
        let ray = Ray { origin: self.point, direction, t_max: f32::INFINITY };
        let hit = intersect(flight, flight.object.isolated, &ray);
        let own = |h: &Hit| h.instance == flight.enclosure.instance && !h.crowded;
        let Some(hit) = hit.filter(own) else { return };
        let here = textured.last;
        let transmittance = textured.transmittance(self.point, direction, hit.t, sampler.rng());
        textured.last = here;
        let phase = flight.medium.phase().eval_directions(self.incoming, direction);
        let aimed = self.aim.drawn(direction, self.rate / (phase * self.arrival_probability(hit.t)));
        let throughput = self.throughput * transmittance * (phase / (pdf * self.rate));
        if throughput.max_element() > 0.0 {
            connector.emerge(&hit, direction, throughput, &self.aim, aimed, sampler);
        }
    }
}
