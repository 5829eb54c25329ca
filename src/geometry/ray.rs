//! Rays, hits and boxes: the plain data of ray queries.

use glam::Vec3;

/// A ray segment: the points `origin + t * direction` with `0 < t < t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start; the point itself is not part of the ray.
    pub origin: Vec3,
    /// Unit direction, so that `t` is a distance in metres.
    pub direction: Vec3,
    /// End, metres; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// Where a ray meets a mesh. The point is `(1 - u - v) v0 + u v1 + v v2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance along the ray, in units of the mesh's space.
    pub t: f32,
    /// Index of the triangle, as it was given to the build.
    pub triangle: u32,
    /// Barycentric weight of the second vertex, in \[0, 1\].
    pub u: f32,
    /// Barycentric weight of the third vertex, in \[0, 1\].
    pub v: f32,
    /// Length of the ray before and after `t` on which another surface counts as in the same place; see [`Self::crowded`].
    pub band: f32,
    /// Whether the ray meets another triangle within the band: then both may be in one place, equal up to rounding.
    pub crowded: bool,
}

/// The point of a mesh that is nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint {
    /// Distance, in units of the mesh's space.
    pub distance: f32,
    /// Index of the triangle, as it was given to the build.
    pub triangle: u32,
    /// Barycentric weight of the second vertex, in \[0, 1\].
    pub u: f32,
    /// Barycentric weight of the third vertex, in \[0, 1\].
    pub v: f32,
}

/// An axis-aligned box; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: Vec3,
    /// Greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing, neutral in unions.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box of some points.
    pub fn from_points(points: &[Vec3]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Edge lengths; zero for an empty box.
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The middle; meaningless for an empty box.
    pub fn center(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Half the surface area, the weight of the surface area heuristic.
    pub fn half_area(&self) -> f32 {
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Whether both have a point in common, which may be on their boundaries.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && self.max.cmpge(other.min).all()
    }

    /// Whether the point is inside or on the boundary.
    pub fn contains(&self, p: Vec3) -> bool {
        self.min.cmple(p).all() && p.cmple(self.max).all()
    }
}
