//! Where light comes from, in a handful of directions: what a path below a surface aims at.
//!
//! A beacon stands for a punctual light, the emissive triangles of one instance, or a bright region of the environment
//! (the means of a k-means clustering of directions drawn from it). Beacons only shape sampling densities; what they
//! leave out is found by other techniques.

use super::{Environment, Facing, Lights};
use crate::scene::{PunctualKind, PunctualLight};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// Most beacons that are followed.
pub const MOST: usize = 16;
/// Regions of the environment.
const REGIONS: usize = 10;
/// Directions drawn from the environment to find them.
const DIRECTIONS: u32 = 1024;
/// Rounds of the clustering.
const ROUNDS: usize = 12;
/// Regions wider than this (radians) are found well enough by chance: aiming at them costs more than it saves.
const WIDEST: f32 = 0.15;

/// A place that light comes from.
#[derive(Clone, Copy, Debug)]
pub struct Beacon {
    place: Place,
    /// Radius in radians (distant) or metres (near).
    radius: f32,
    /// Irradiance (distant), or irradiance at one metre (near).
    strength: f32,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Distant(Vec3),
    Near(Vec3),
}

/// A beacon seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Unit direction towards it.
    pub direction: Vec3,
    /// Its angular radius, radians.
    pub radius: f32,
    /// Estimated irradiance of a surface that faces it.
    pub irradiance: f32,
}

impl Beacon {
    /// The beacon as seen from a point.
    pub fn seen_from(&self, point: Vec3) -> Sighting {
        match self.place {
            Place::Distant(direction) => {
                Sighting { direction, radius: self.radius, irradiance: self.strength }
            }
            Place::Near(center) => {
                let to = center - point;
                let squared = to.length_squared().max(self.radius * self.radius).max(f32::MIN_POSITIVE);
                let distance = squared.sqrt();
                Sighting {
                    direction: to.normalize_or(Vec3::Y),
                    radius: (self.radius / distance).min(1.0).asin(),
                    irradiance: self.strength / squared,
                }
            }
        }
    }
}

/// The strongest beacons of a scene.
pub fn beacons(lights: &Lights, punctual: &[PunctualLight]) -> Vec<Beacon> {
    let mean = |v: Vec3| v.element_sum() / 3.0;
    let mut found: Vec<Beacon> = punctual
        .iter()
        .map(|l| {
            let place = match l.kind {
                PunctualKind::Directional => Place::Distant(-l.direction),
                _ => Place::Near(l.position),
            };
            Beacon { place, radius: 0.0, strength: mean(l.intensity) }
        })
        .collect();
    let emitters: Vec<_> =
        (0..lights.emitter_count()).filter_map(|i| lights.emitter(super::EmitterId(i as u32))).collect();
    for group in emitters.chunk_by(|a, b| a.instance == b.instance) {
        let corners = group.iter().flat_map(|e| e.vertices);
        let (low, high) = corners
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b): (Vec3, Vec3), v| (a.min(v), b.max(v)));
        let power: f32 = group.iter().map(|e| mean(e.power)).sum();
        let (place, radius) = (Place::Near(0.5 * (low + high)), 0.5 * (high - low).length());
        found.push(Beacon { place, radius, strength: power * FRAC_1_PI });
    }
    found.extend(regions(lights.environment()));
    found.retain(|b| b.strength > 0.0 && b.strength.is_finite() && b.radius.is_finite());
    found.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    found.truncate(MOST);
    found
}

/// Bright regions of an environment map.
fn regions(environment: &Environment) -> Vec<Beacon> {
    if !matches!(environment, Environment::Map(_)) {
        return Vec::new();
    }
    let directions: Vec<Vec3> = (0..DIRECTIONS)
        .filter_map(|i| {
            let u = Vec2::new((i as f32 + 0.5) / DIRECTIONS as f32, radical_inverse(i));
            environment.sample(Facing::All, u).map(|s| s.direction)
        })
        .collect();
    if directions.len() < REGIONS {
        return Vec::new();
    }
    let mut means: Vec<Vec3> = (0..REGIONS).map(|k| directions[k * directions.len() / REGIONS]).collect();
    let mut region_of = vec![0; directions.len()];
    for _ in 0..ROUNDS {
        for (region, d) in region_of.iter_mut().zip(&directions) {
            let nearest = (0..REGIONS).max_by(|&a, &b| means[a].dot(*d).total_cmp(&means[b].dot(*d)));
            *region = nearest.unwrap_or(0);
        }
        for (k, mean) in means.iter_mut().enumerate() {
            let members = directions.iter().zip(&region_of).filter(|(_, r)| **r == k).map(|(d, _)| *d);
            *mean = members.sum::<Vec3>().normalize_or(*mean);
        }
    }
    let total = environment.mean_radiance() * 4.0 * PI / directions.len() as f32;
    (0..REGIONS)
        .filter_map(|k| {
            let members: Vec<f32> = directions
                .iter()
                .zip(&region_of)
                .filter(|(_, r)| **r == k)
                .map(|(d, _)| d.dot(means[k]).clamp(-1.0, 1.0).acos())
                .collect();
            let squared = members.iter().map(|a| a * a).sum::<f32>() / members.len().max(1) as f32;
            // A uniform disk's root mean square is its radius over √2.
            let radius = (2.0 * squared).sqrt();
            let strength = total * members.len() as f32;
            (radius < WIDEST).then_some(Beacon { place: Place::Distant(means[k]), radius, strength })
        })
        .collect()
}

/// Van der Corput's sequence in base 2.
fn radical_inverse(i: u32) -> f32 {
    (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::EnvironmentDescription;

    #[test]
    fn a_bright_patch_of_the_sky_is_found() {
        let (width, height) = (64, 32);
        let bright = |x: usize, y: usize| (41..43).contains(&x) && y == 8;
        let pixels = (0..width * height)
            .map(|i| if bright(i % width, i / width) { Vec3::splat(500.0) } else { Vec3::splat(0.01) })
            .collect();
        let environment =
            EnvironmentDescription::Map { width, height, pixels, scale: Vec3::ONE, rotation: 0.0 };
        let lights = Lights::build(Vec::new(), &[], &environment);
        let (u, v) = (42.0 / width as f32, 1.0 - 8.5 / height as f32);
        let (azimuth, elevation) = ((u - 0.5) * 2.0 * PI, (v - 0.5) * PI);
        let centre =
            Vec3::new(azimuth.cos() * elevation.cos(), elevation.sin(), azimuth.sin() * elevation.cos());
        let found = beacons(&lights, &[]);
        let strength: f32 = found.iter().map(|b| b.strength).sum();
        let near = |b: &&Beacon| b.seen_from(Vec3::ZERO).direction.dot(centre) > 0.95;
        let patch: f32 = found.iter().filter(near).map(|b| b.strength).sum();
        assert!(patch > 0.8 * strength, "{patch} of {strength}: {found:?}");
    }
}
