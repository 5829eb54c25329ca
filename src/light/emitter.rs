//! A triangle that emits, seen from a point: how much light it may send, and sampling its solid angle.
//!
//! Where the triangle is seen under a moderate solid angle, directions are uniform over it (Arvo 1995), otherwise
//! points are uniform over its area (small spherical triangles are lost to rounding) or directions are uniform over
//! the whole hemisphere, which a nearly touching triangle fills. Either way the density is known from the point and
//! the position alone, so any hit can be weighed.

use std::{fmt, sync::Arc};

use glam::{Vec2, Vec3};

use super::cone::Cone;
use super::tree::LightBounds;
use crate::sampling::{Frame, SphericalTriangle, spherical_triangle::solid_angle, warp};

/// Solid angle below which points on the area are sampled, steradians.
const MIN_SPHERICAL: f32 = 3e-4;

/// Solid angle above which the hemisphere is sampled: 1 % of its directions miss.
const MAX_SPHERICAL: f32 = 6.22;

/// Squared distance over area beyond which the solid angle is that of a small flat patch (to a few per cent
/// of a compact one).
const FAR: f32 = 30.0;

/// Names an emissive triangle of [`super::Lights`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EmitterId(pub u32);

/// Emission that varies over triangles; implemented by whoever knows textures.
pub trait EmissionField: Send + Sync {
    /// Radiance emitted at a point of a triangle, given by the barycentric coordinates of its second and third vertex, in
    /// directions whose angle with the triangle's normal has that cosine, > 0.
    fn radiance(&self, instance: u32, triangle: u32, barycentrics: Vec2, cos: f32) -> Vec3;
}

/// Emitted radiance of a triangle.
#[derive(Clone)]
pub enum EmissiveRadiance {
    /// The same everywhere.
    Constant(Vec3),
    /// Looked up.
    Textured(Arc<dyn EmissionField>),
}

impl fmt::Debug for EmissiveRadiance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(radiance) => f.debug_tuple("Constant").field(radiance).finish(),
            Self::Textured(_) => f.write_str("Textured(..)"),
        }
    }
}

/// A triangle that emits from its front, or from both sides.
#[derive(Clone, Debug)]
pub struct EmissiveTriangle {
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in the instance's mesh.
    pub triangle: u32,
    /// World positions.
    pub vertices: [Vec3; 3],
    /// World normal of the front; only the side of the triangle that it is on counts.
    pub geometric_normal: Vec3,
    /// Whether the back emits as well.
    pub double_sided: bool,
    /// Power in watts: mean radiance × area × π × sides.
    pub power: Vec3,
    /// Emitted radiance.
    pub radiance: EmissiveRadiance,
}

/// A point or direction chosen on an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterSample {
    pub direction: Vec3,
    pub distance: f32,
    pub radiance: Vec3,
    /// With respect to solid angle.
    pub pdf: f32,
}

/// An emissive triangle with what its sampling needs.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub source: EmissiveTriangle,
    /// Unit normal of the front.
    normal: Vec3,
    pub area: f32,
    /// Mean radiance over the area and the channels.
    radiance: f32,
}

impl Emitter {
    /// `None` for a triangle without area or (finite) power.
    pub(super) fn new(source: EmissiveTriangle) -> Option<Self> {
        let [v0, v1, v2] = source.vertices;
        let cross = (v1 - v0).cross(v2 - v0);
        let normal = cross.try_normalize()?;
        let area = 0.5 * cross.length();
        let sides = if source.double_sided { 2.0 } else { 1.0 };
        let radiance = source.power.element_sum() / 3.0 / (std::f32::consts::PI * area * sides);
        if !(radiance > 0.0 && radiance.is_finite() && area > 0.0) {
            return None;
        }
        let normal = if normal.dot(source.geometric_normal) < 0.0 { -normal } else { normal };
        Some(Self { normal, area, radiance, source })
    }

    /// For a light tree.
    pub(super) fn bounds(&self) -> LightBounds {
        let [a, b, c] = self.source.vertices;
        LightBounds {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            cone: Cone {
                axis: self.normal,
                axes: 0.0,
                spread: std::f32::consts::FRAC_PI_2,
                two_sided: self.source.double_sided,
            },
            flux: self.radiance * self.area,
            reach: f32::INFINITY,
        }
    }

    /// Height of the point above the emitting side(s), ≤ 0 where nothing is emitted to.
    #[inline]
    fn height(&self, point: Vec3) -> f32 {
        let height = self.normal.dot(point - self.source.vertices[0]);
        if self.source.double_sided { height.abs() } else { height }
    }

    /// Estimate of the irradiance at a point (or of the fluence without a normal), ignoring occlusion. Zero only where the
    /// emitter sends nothing to the upper side of the surface.
    #[inline]
    pub(super) fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        let height = self.height(point);
        if height <= 0.0 {
            return 0.0;
        }
        let edges = self.source.vertices.map(|v| v - point);
        let [a, b, c] = edges.map(|v| v.length_squared());
        let distance_squared = (a + b + c) * (1.0 / 3.0);
        let cosine = |n: Vec3, v: Vec3, length_squared: f32| n.dot(v).max(0.0) / length_squared.sqrt();
        let cosines = normal.map_or(1.0, |n| {
            (cosine(n, edges[0], a) + cosine(n, edges[1], b) + cosine(n, edges[2], c)) * (1.0 / 3.0)
        });
        let solid_angle = if distance_squared > FAR * self.area {
            self.area * height / (distance_squared * distance_squared.sqrt())
        } else {
            solid_angle(edges, 2.0 * self.area * height)
        };
        self.radiance * solid_angle * cosines
    }

    /// A direction towards the emitter; `None` where it does not emit to the point.
    #[inline]
    pub(super) fn sample(&self, point: Vec3, u: Vec2) -> Option<EmitterSample> {
        let height = self.height(point);
        if height <= 0.0 {
            return None;
        }
        let [v0, v1, v2] = self.source.vertices;
        let triangle =
            SphericalTriangle::with_volume(self.source.vertices.map(|v| v - point), 2.0 * self.area * height);
        if triangle.solid_angle >= MIN_SPHERICAL {
            let (direction, pdf) = if triangle.solid_angle <= MAX_SPHERICAL {
                (triangle.sample(u)?, 1.0 / triangle.solid_angle)
            } else {
                let towards = self.normal * self.normal.dot(v0 - point).signum();
                let direction = Frame::from_normal(towards).to_world(warp::uniform_hemisphere(u));
                (direction, warp::UNIFORM_HEMISPHERE_PDF)
            };
            let distance = self.normal.dot(v0 - point) / self.normal.dot(direction);
            if !(distance > 0.0 && distance.is_finite()) {
                return None;
            }
            let position = point + distance * direction;
            if triangle.solid_angle > MAX_SPHERICAL {
                let b = self.barycentrics(position);
                if b.min_element() < 0.0 || b.element_sum() > 1.0 {
                    return None;
                }
            }
            let radiance =
                self.radiance_at(direction, || self.barycentrics(position).clamp(Vec2::ZERO, Vec2::ONE));
            return Some(EmitterSample { direction, distance, radiance, pdf });
        }
        let barycentrics = warp::uniform_triangle(u);
        let position = v0 + barycentrics.x * (v1 - v0) + barycentrics.y * (v2 - v0);
        let (direction, distance, pdf) = self.area_density(point, position)?;
        Some(EmitterSample {
            direction,
            distance,
            radiance: self.radiance_at(direction, || barycentrics),
            pdf,
        })
    }

    /// Density of [`Self::sample`] with respect to solid angle for the direction to `position`, a point of the emitter.
    #[inline]
    pub(super) fn pdf(&self, point: Vec3, position: Vec3) -> f32 {
        let height = self.height(point);
        if height <= 0.0 {
            return 0.0;
        }
        let solid_angle = solid_angle(self.source.vertices.map(|v| v - point), 2.0 * self.area * height);
        if solid_angle > MAX_SPHERICAL {
            return warp::UNIFORM_HEMISPHERE_PDF;
        }
        if solid_angle >= MIN_SPHERICAL {
            return 1.0 / solid_angle;
        }
        self.area_density(point, position).map_or(0.0, |(_, _, pdf)| pdf)
    }

    /// Direction, distance and density with respect to solid angle of uniform points.
    #[inline]
    fn area_density(&self, point: Vec3, position: Vec3) -> Option<(Vec3, f32, f32)> {
        let to_light = position - point;
        let distance_squared = to_light.length_squared();
        let distance = distance_squared.sqrt();
        let direction = to_light / distance;
        let pdf = distance_squared / (self.normal.dot(direction).abs() * self.area);
        (pdf > 0.0 && pdf.is_finite()).then_some((direction, distance, pdf))
    }

    #[inline]
    fn radiance_at(&self, direction: Vec3, barycentrics: impl FnOnce() -> Vec2) -> Vec3 {
        match &self.source.radiance {
            EmissiveRadiance::Constant(radiance) => *radiance,
            EmissiveRadiance::Textured(field) => {
                let cos = self.normal.dot(direction).abs();
                field.radiance(self.source.instance, self.source.triangle, barycentrics(), cos)
            }
        }
    }

    /// Barycentric coordinates of the second and third vertex of a point of the triangle's plane.
    fn barycentrics(&self, position: Vec3) -> Vec2 {
        let [v0, v1, v2] = self.source.vertices;
        let (e1, e2, p) = (v1 - v0, v2 - v0, position - v0);
        let n = e1.cross(e2);
        let scale = 1.0 / n.length_squared();
        Vec2::new(p.cross(e2).dot(n) * scale, e1.cross(p).dot(n) * scale)
    }
}
