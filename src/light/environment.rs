//! Light from infinitely far away: nothing, one radiance, or an equirectangular map.
//!
//! Maps are in `environment_map.rs`. A constant environment is sampled uniformly over the sphere, or by the cosine about a
//! normal.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::environment_map::EnvironmentMap;
use crate::sampling::{Frame, warp};
use crate::scene::EnvironmentDescription;

/// Largest radiance of a channel; more (or infinity) in a map is brought down to it, so that sums stay finite.
pub const MAX_RADIANCE: f32 = 1e18;

/// A direction chosen in proportion to the environment's light.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// Unit direction towards the light.
    pub direction: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density with respect to solid angle, > 0.
    pub pdf: f32,
}

/// What light from infinitely far away is chosen for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// For any direction alike.
    All,
    /// For a surface with that unit normal: light from its other side does not count.
    Surface(Vec3),
    /// For surfaces with about that unit normal: light from the other side is hardly chosen, or not at all.
    About(Vec3),
}

/// Light from infinitely far away, ready to be looked up and sampled.
#[derive(Clone, Debug)]
pub enum Environment {
    /// Darkness.
    None,
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// An equirectangular map.
    Map(Box<EnvironmentMap>),
}

impl Environment {
    /// Prepares a description. A map without any positive finite pixel, or whose pixels do not fill its size, is darkness.
    pub fn new(description: &EnvironmentDescription) -> Self {
        match description {
            EnvironmentDescription::Constant(radiance) => {
                let radiance = sanitize(*radiance).0;
                if radiance == Vec3::ZERO { Self::None } else { Self::Constant(radiance) }
            }
            EnvironmentDescription::Map { width, height, pixels, scale, rotation } => {
                EnvironmentMap::new(*width, *height, pixels, *scale, *rotation)
                    .map_or(Self::None, |map| Self::Map(Box::new(map)))
            }
        }
    }

    /// Whether no light comes from anywhere.
    pub fn is_none(&self) -> bool {
        matches!(self, Self::None)
    }

    /// Radiance from a unit direction (pointing away from the scene).
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// A direction with its radiance, about in proportion to radiance times cosine; `None` where there is no light.
    #[inline]
    pub fn sample(&self, facing: Facing, u: Vec2) -> Option<EnvironmentSample> {
        match self {
            Self::None => None,
            Self::Constant(radiance) => Some(match facing {
                Facing::Surface(normal) => {
                    let local = warp::cosine_hemisphere(u);
                    let direction = Frame::from_normal(normal).to_world(local);
                    let pdf = warp::cosine_hemisphere_pdf(normal.dot(direction));
                    if pdf <= 0.0 {
                        return None;
                    }
                    EnvironmentSample { direction, radiance: *radiance, pdf }
                }
                Facing::All | Facing::About(_) => EnvironmentSample {
                    direction: warp::uniform_sphere(u),
                    radiance: *radiance,
                    pdf: warp::UNIFORM_SPHERE_PDF,
                },
            }),
            Self::Map(map) => map.sample(facing, u),
        }
    }

    /// Density with respect to solid angle with which [`Self::sample`] chooses a direction.
    #[inline]
    pub fn pdf(&self, facing: Facing, direction: Vec3) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Constant(_) => match facing {
                Facing::Surface(normal) => warp::cosine_hemisphere_pdf(normal.dot(direction)),
                Facing::All | Facing::About(_) => warp::UNIFORM_SPHERE_PDF,
            },
            Self::Map(map) => map.pdf(facing, direction),
        }
    }

    /// Mean radiance over the sphere, averaged over the channels.
    pub fn mean_radiance(&self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Constant(radiance) => mean(*radiance),
            Self::Map(map) => map.mean_radiance(),
        }
    }

    /// The solid angle that most light comes from, steradians: (∫ L dω)² / ∫ L² dω, 4π where all directions are alike.
    pub fn effective_solid_angle(&self) -> f32 {
        match self {
            Self::None | Self::Constant(_) => 4.0 * PI,
            Self::Map(map) => map.effective_solid_angle(),
        }
    }

    /// About the irradiance of a surface with that unit normal, channel mean: positive wherever there is light.
    #[inline]
    pub fn irradiance(&self, normal: Vec3) -> f32 {
        match self {
            Self::Map(map) => map.irradiance(normal),
            _ => PI * self.mean_radiance(),
        }
    }

    /// Power in watts (channel mean) that enters a sphere of the given radius: 4π² r² L.
    pub fn power(&self, scene_radius: f32) -> f32 {
        4.0 * PI * PI * scene_radius * scene_radius * self.mean_radiance()
    }
}

#[inline]
pub(super) fn mean(v: Vec3) -> f32 {
    v.element_sum() * (1.0 / 3.0)
}

pub(super) fn sanitize(v: Vec3) -> (Vec3, bool) {
    let repaired = Vec3::from_array(v.to_array().map(|c| if c > 0.0 { c.min(MAX_RADIANCE) } else { 0.0 }));
    (repaired, repaired != v)
}

#[cfg(test)]
#[path = "environment_tests.rs"]
mod tests;
