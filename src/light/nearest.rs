//! The closest light to a point: what the light-biased model aims at.
//!
//! A lamp is a punctual light with a place, or all emissive triangles of one instance, which is as far away as its bounds.
//! Where there is no lamp the directional lights and the environment take its place, in proportion to their irradiance.

use super::emitter::Emitter;
use super::environment::{Environment, Facing};
use super::{EmitterId, LightPoint, LightSample, punctual};
use crate::geometry::Aabb;
use crate::sampling::Distribution1D;
use crate::scene::{PunctualKind, PunctualLight};
use glam::{Vec2, Vec3};

/// All lights, as things with a place.
#[derive(Clone, Debug)]
pub(super) struct Lamps {
    lamps: Vec<Lamp>,
    /// Indices of directional lights; one more than the last stands for the environment.
    distant: Vec<usize>,
    choice: Option<Distribution1D>,
}

/// Bytes that a lamp takes, with its box and about what a leaf and its share of the nodes above it take.
pub(super) const LAMP_BYTES: u64 = (size_of::<Lamp>() + size_of::<Aabb>() + 48) as u64;

#[derive(Clone, Debug)]
struct Lamp {
    low: Vec3,
    high: Vec3,
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Punctual(usize),
    /// Emitters from the first on, by power.
    Triangles(usize, Distribution1D),
}

impl Lamps {
    /// `emitters` are sorted by instance.
    pub fn new(emitters: &[Emitter], punctual: &[PunctualLight], environment: &Environment) -> Self {
        let mut lamps = Vec::new();
        let mut first = 0;
        for group in emitters.chunk_by(|a, b| a.source.instance == b.source.instance) {
            let powers: Vec<f32> = group.iter().map(|e| e.source.power.element_sum()).collect();
            let vertices = || group.iter().flat_map(|e| e.source.vertices);
            if let Some(table) = Distribution1D::new(&powers) {
                lamps.push(Lamp {
                    low: vertices().fold(Vec3::INFINITY, Vec3::min),
                    high: vertices().fold(Vec3::NEG_INFINITY, Vec3::max),
                    source: Source::Triangles(first, table),
                });
            }
            first += group.len();
        }
        let (mut distant, mut irradiance) = (Vec::new(), Vec::new());
        for (i, light) in punctual.iter().enumerate() {
            if light.kind == PunctualKind::Directional {
                distant.push(i);
                irradiance.push(light.intensity.element_sum() / 3.0);
            } else {
                let source = Source::Punctual(i);
                lamps.push(Lamp { low: light.position, high: light.position, source });
            }
        }
        distant.push(punctual.len());
        irradiance.push(environment.mean_radiance() * std::f32::consts::PI);
        Self { lamps, distant, choice: Distribution1D::new(&irradiance) }
    }

    /// A random point of the closest light; `None` where it sends nothing to the point.
    pub fn sample(
        &self,
        (emitters, punctual, environment): (&[Emitter], &[PunctualLight], &Environment),
        point: Vec3,
        u_select: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let distance = |lamp: &Lamp| point.distance_squared(point.clamp(lamp.low, lamp.high));
        let closest = self.lamps.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        match closest.map(|lamp| &lamp.source) {
            Some(Source::Triangles(first, table)) => {
                let (i, probability, _) = table.sample(u_select);
                let s = emitters[first + i].sample(point, u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: s.distance,
                    radiance: s.radiance,
                    pdf: s.pdf * probability,
                    point: LightPoint::Emitter(EmitterId((first + i) as u32), s.position),
                })
            }
            Some(Source::Punctual(i)) => of_punctual(punctual, *i, point, 1.0),
            None => {
                let (i, probability, _) = self.choice.as_ref()?.sample(u_select);
                if self.distant[i] < punctual.len() {
                    return of_punctual(punctual, self.distant[i], point, probability);
                }
                let s = environment.sample(Facing::All, u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: f32::INFINITY,
                    radiance: s.radiance,
                    pdf: s.pdf * probability,
                    point: LightPoint::Environment(s.direction),
                })
            }
        }
    }
}

fn of_punctual(lights: &[PunctualLight], i: usize, point: Vec3, probability: f32) -> Option<LightSample> {
    let p = punctual::irradiance(&lights[i], point)?;
    Some(LightSample {
        direction: p.direction,
        distance: p.distance,
        radiance: p.irradiance,
        pdf: probability,
        point: LightPoint::Punctual(i as u32),
    })
}
