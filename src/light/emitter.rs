//! A triangle that emits, seen from a point: how much light it may send, and sampling its solid angle.
//!
//! Directions are uniform over the solid angle, in double precision where the triangle is close
//! ([`CloseTriangle`]), or points are uniform over its area where it is far and small, since spherical triangles are
//! then lost to rounding. Which of them is a function of the point alone, so the density of any point of the emitter is
//! known from both.
//!
//! Heights above the plane are taken in double precision: a lamp may nearly touch what it lights, and its normal in single
//! floats is off by as much as that.

use std::{fmt, sync::Arc};

use glam::{DVec3, Vec2, Vec3};

use super::cone::Cone;
use super::tree::LightBounds;
use crate::sampling::{CloseTriangle, SphericalTriangle, spherical_triangle::solid_angle, warp};

/// Solid angle below which points on the area are sampled, steradians.
const MIN_SPHERICAL: f32 = 3e-4;

/// Height of the point over the distance of the farthest vertex, below which directions to vertices may be opposite, or all
/// of them near the horizon, to within 0.1.
const LOW: f32 = 0.1;

/// Distance of the farthest vertex over the longest edge, up to which a low triangle counts as close: from farther all of it
/// is seen in about the same direction.
const BESIDE: f32 = 2.0;

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

/// A point chosen on an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterSample {
    pub position: Vec3,
    pub direction: Vec3,
    pub distance: f32,
    pub radiance: Vec3,
    /// With respect to solid angle.
    pub pdf: f32,
}

/// How a point sees an emitter, which decides how it is sampled.
#[derive(Clone, Copy, PartialEq, Eq)]
enum View {
    /// Its solid angle, in single floats.
    Moderate,
    /// Its solid angle, in double precision.
    Close,
    /// Its area.
    Small,
}

/// An emissive triangle with what its sampling needs.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub source: EmissiveTriangle,
    /// Unit normal of the front.
    normal: DVec3,
    pub area: f32,
    /// Squared length of the longest edge.
    longest: f32,
    /// Mean radiance over the area and the channels.
    radiance: f32,
}

impl Emitter {
    /// `None` for a triangle without area or (finite) power.
    pub(super) fn new(source: EmissiveTriangle) -> Option<Self> {
        let [v0, v1, v2] = source.vertices.map(|v| v.as_dvec3());
        let cross = (v1 - v0).cross(v2 - v0);
        let normal = cross.try_normalize()?;
        let area = 0.5 * cross.length() as f32;
        let longest = [v1 - v0, v2 - v1, v0 - v2].map(|e| e.length_squared()).into_iter().fold(0.0, f64::max);
        let sides = if source.double_sided { 2.0 } else { 1.0 };
        let radiance = source.power.element_sum() / 3.0 / (std::f32::consts::PI * area * sides);
        if !(radiance > 0.0 && radiance.is_finite() && area > 0.0) {
            return None;
        }
        let normal = if normal.dot(source.geometric_normal.as_dvec3()) < 0.0 { -normal } else { normal };
        Some(Self { normal, area, longest: longest as f32, radiance, source })
    }

    /// For a light tree.
    pub(super) fn bounds(&self) -> LightBounds {
        let [a, b, c] = self.source.vertices;
        LightBounds {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            cone: Cone {
                axis: self.normal.as_vec3(),
                axes: 0.0,
                spread: std::f32::consts::FRAC_PI_2,
                two_sided: self.source.double_sided,
            },
            flux: self.radiance * self.area,
            reach: f32::INFINITY,
        }
    }

    /// Height of the point above the front, < 0 behind it.
    #[inline]
    fn signed_height(&self, point: Vec3) -> f64 {
        self.normal.dot(point.as_dvec3() - self.source.vertices[0].as_dvec3())
    }

    /// Height of the point above the emitting side(s), ≤ 0 where nothing is emitted to.
    #[inline]
    fn height(&self, point: Vec3) -> f32 {
        let height = self.signed_height(point) as f32;
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

    /// How the emitter is sampled from a point at a height above it, that sees its vertices at `edges` under a solid angle.
    #[inline]
    fn view(&self, edges: &[Vec3; 3], height: f32, solid_angle: f32) -> View {
        let farthest = edges.map(Vec3::length_squared).into_iter().fold(0.0, f32::max);
        if height * height < LOW * LOW * farthest && farthest < BESIDE * BESIDE * self.longest {
            View::Close
        } else if solid_angle >= MIN_SPHERICAL {
            View::Moderate
        } else {
            View::Small
        }
    }

    /// The triangle as it is seen from a point close to it.
    fn close(&self, point: Vec3) -> Option<CloseTriangle> {
        CloseTriangle::new(self.source.vertices.map(|v| v.as_dvec3() - point.as_dvec3()))
    }

    /// A direction towards the emitter; `None` where it does not emit to the point.
    #[inline]
    pub(super) fn sample(&self, point: Vec3, u: Vec2) -> Option<EmitterSample> {
        let height = self.height(point);
        if height <= 0.0 {
            return None;
        }
        let [v0, v1, v2] = self.source.vertices;
        let edges = self.source.vertices.map(|v| v - point);
        let triangle = SphericalTriangle::with_volume(edges, 2.0 * self.area * height);
        let (direction, pdf) = match self.view(&edges, height, triangle.solid_angle) {
            View::Moderate => (triangle.sample(u)?.as_dvec3(), 1.0 / triangle.solid_angle),
            View::Close => {
                let triangle = self.close(point)?;
                (triangle.sample(u), (1.0 / triangle.solid_angle) as f32)
            }
            View::Small => {
                let barycentrics = warp::uniform_triangle(u);
                let position = v0 + barycentrics.x * (v1 - v0) + barycentrics.y * (v2 - v0);
                let (to, distance) = self.towards(point, position);
                let pdf = self.area_density(to, distance)?;
                let direction = (to / distance).as_vec3();
                let radiance = self.radiance_at(direction, || barycentrics);
                return Some(EmitterSample { position, direction, distance: distance as f32, radiance, pdf });
            }
        };
        let distance = -self.signed_height(point) / self.normal.dot(direction);
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let position = (point.as_dvec3() + distance * direction).as_vec3();
        let (direction, distance) = (direction.as_vec3(), distance as f32);
        let radiance =
            self.radiance_at(direction, || self.barycentrics(position).clamp(Vec2::ZERO, Vec2::ONE));
        Some(EmitterSample { position, direction, distance, radiance, pdf })
    }

    /// Density of [`Self::sample`] with respect to solid angle for the direction to `position`, a point of the emitter.
    #[inline]
    pub(super) fn pdf(&self, point: Vec3, position: Vec3) -> f32 {
        let height = self.height(point);
        if height <= 0.0 {
            return 0.0;
        }
        let edges = self.source.vertices.map(|v| v - point);
        let solid_angle = solid_angle(edges, 2.0 * self.area * height);
        match self.view(&edges, height, solid_angle) {
            View::Moderate => 1.0 / solid_angle,
            View::Close => self.close(point).map_or(0.0, |t| (1.0 / t.solid_angle) as f32),
            View::Small => {
                let (to, distance) = self.towards(point, position);
                self.area_density(to, distance).unwrap_or(0.0)
            }
        }
    }

    /// From a point to one of the emitter, at the point's own height above the plane, and the distance.
    #[inline]
    fn towards(&self, point: Vec3, position: Vec3) -> (DVec3, f64) {
        let to = position.as_dvec3() - point.as_dvec3();
        let to = to - self.normal * (self.normal.dot(to) + self.signed_height(point));
        (to, to.length())
    }

    /// The unit direction from a point to one of the emitter; `None` where they are the same.
    pub(super) fn towards_unit(&self, point: Vec3, position: Vec3) -> Option<Vec3> {
        let (to, distance) = self.towards(point, position);
        (distance > 0.0).then(|| (to / distance).as_vec3())
    }

    /// Density with respect to solid angle of uniform points.
    #[inline]
    fn area_density(&self, to: DVec3, distance: f64) -> Option<f32> {
        let pdf = (distance.powi(3) / (self.normal.dot(to).abs() * f64::from(self.area))) as f32;
        (pdf > 0.0 && pdf.is_finite()).then_some(pdf)
    }

    /// The solid angle of a small part of the emitter at `position`, seen from one point, over that seen from another.
    #[inline]
    pub(super) fn solid_angle_ratio(&self, one: Vec3, other: Vec3, position: Vec3) -> f32 {
        let seen = |point: Vec3| {
            let (to, distance) = self.towards(point, position);
            self.normal.dot(to).abs() / distance.powi(3)
        };
        (seen(one) / seen(other)) as f32
    }

    /// A point of the emitter seen from elsewhere: direction, distance and radiance. `None` where it does not emit to there.
    #[inline]
    pub(super) fn seen_from(&self, point: Vec3, position: Vec3) -> Option<(Vec3, f32, Vec3)> {
        if self.height(point) <= 0.0 {
            return None;
        }
        let (to, distance) = self.towards(point, position);
        let direction = (to / distance).as_vec3();
        let radiance =
            self.radiance_at(direction, || self.barycentrics(position).clamp(Vec2::ZERO, Vec2::ONE));
        (distance > 0.0).then_some((direction, distance as f32, radiance))
    }

    #[inline]
    fn radiance_at(&self, direction: Vec3, barycentrics: impl FnOnce() -> Vec2) -> Vec3 {
        match &self.source.radiance {
            EmissiveRadiance::Constant(radiance) => *radiance,
            EmissiveRadiance::Textured(field) => {
                let cos = self.normal.as_vec3().dot(direction).abs().max(f32::MIN_POSITIVE);
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
