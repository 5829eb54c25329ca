//! Surfaces in one place.
//!
//! Files hold surfaces that coincide: a label on a wall, a drink that fills its glass, two halves of a block. Up to
//! rounding they are at one distance along a ray, and which one a query finds first is chance. So a hit tells whether
//! it is `crowded`, and this is the query for what is there: every triangle that the ray meets and whose plane is where
//! the first one's is.
//!
//! Two hits a and b are in one place where each is in the other's plane,
//!
//! ```text
//! |(p_b − p_a) · n_a| ≤ ε   and   |(p_b − p_a) · n_b| ≤ ε,   ε = ε_a + ε_b,
//! ```
//!
//! with ε_k of eight roundings of triangle k's coordinates, across its plane: what is left of equal vertices once two
//! transforms have moved them. The angle of the ray does not matter, and nor does the size of an axis-aligned floor: across
//! its plane it has no roundings.

use super::offset::{ROUNDING, offset_origin};
use super::ray::Ray;
use super::scene::{Hit, SceneGeometry, SurfacePoint};
use glam::Vec3;

/// Eight roundings: how far a plane may be from where its file means it, relative to its coordinates.
const TOLERANCE: f32 = 1.0 / (1_u32 << 21) as f32;
/// Barycentric coordinates below this are those of an edge, up to the rounding of a ray that was moved, also where triangles
/// are small for their coordinates.
const EDGE: f32 = 1e-3;

/// Errors of a point, as often as another surface in the same place may be away from it: a point's error is of two or three
/// roundings, and what touches was moved by a transform of its own.
pub const TOUCHING: f32 = 8.0;

/// Cosine to the normal below which a ray's own distance is as good as one across the plane.
const FLAT: f32 = 0.1;

impl SceneGeometry {
    /// Everything that a ray in a unit direction meets in the place of a hit, the hit itself included, in the order of
    /// (instance, triangle).
    ///
    /// Where a ray meets the edge between two triangles of a mesh that face the same way, there is one of them.
    pub fn place(&self, hit: &Hit, direction: Vec3) -> Vec<(Hit, SurfacePoint)> {
        let here = self.surface(hit);
        let tolerance = self.plane_tolerance(hit, &here);
        let before = 2.0 * hit.band;
        let ray = Ray { origin: here.position - before * direction, direction, t_max: 2.0 * before };
        let mut found = vec![(*hit, here)];
        self.visit_hits(&ray, |other| {
            if (other.instance, other.triangle) == (hit.instance, hit.triangle) {
                return;
            }
            let there = self.surface(&other);
            let allowed = tolerance + self.plane_tolerance(&other, &there);
            let apart = there.position - here.position;
            if apart.dot(here.geometric_normal).abs() <= allowed
                && apart.dot(there.geometric_normal).abs() <= allowed
                && !(is_at_edge(&other)
                    && found.iter().any(|known| {
                        is_at_edge(&known.0) && self.is_same_crossing(known, &(other, there), direction)
                    }))
            {
                found.push((other, there));
            }
        });
        found.sort_by_key(|(hit, _)| (hit.instance, hit.triangle));
        found
    }

    /// Distance along a ray from where it has left a triangle to where it meets another, from the points of the triangles:
    /// that of a hit begins off the first surface, which matters in thin sheets, and rounds with the distance of the origin.
    /// The hit's where nothing is known of the start.
    pub fn distance_between(&self, from: Option<&Hit>, hit: &Hit, direction: Vec3) -> f32 {
        let Some(from) = from else { return hit.t };
        let point = |h: &Hit| self.mesh_of(h.instance).point(h.triangle, h.u, h.v).0;
        // Across the plane of the hit: what barycentric coordinates round to moves points within their planes.
        let (way, normal, direction, scale) = if from.instance == hit.instance {
            let transform = self.transform(hit.instance);
            let normal = self.mesh_of(hit.instance).geometric_normal(hit.triangle);
            (point(hit) - point(from), normal, transform.inverse_direction(direction), transform.scale)
        } else {
            let (a, b) = (self.surface(from), self.surface(hit));
            (b.position - a.position, b.geometric_normal, direction, 1.0)
        };
        let cosine = normal.dot(direction);
        if cosine.abs() < FLAT { hit.t } else { (scale * way.dot(normal) / cosine).max(0.0) }
    }

    /// A point beside a surface, on the side that `towards` points to, where winding numbers of an instance can be asked for: off
    /// what may be in one place with the surface, also where that has no error of its own, as a floor at height zero.
    pub fn beside(&self, point: &SurfacePoint, towards: Vec3, instance: u32) -> Vec3 {
        let bounds = self.mesh_of(instance).bounds();
        let coordinates =
            bounds.min.abs().max(bounds.max.abs()).max_element() * self.transform(instance).scale;
        let error = TOUCHING * point.error + ROUNDING * coordinates;
        offset_origin(point.position, error, point.geometric_normal, towards)
    }

    /// How far the plane of a triangle may be from where its file means it, at a point of it.
    fn plane_tolerance(&self, hit: &Hit, point: &SurfacePoint) -> f32 {
        let transform = self.transform(hit.instance);
        let [a, b, c] = self.mesh_of(hit.instance).triangle(hit.triangle).map(Vec3::abs);
        let coordinates = transform.magnitude(a.max(b).max(c));
        point.geometric_normal.abs().dot(TOLERANCE * coordinates + point.error)
    }

    /// Whether the point of a hit lies in the plane of its triangle and `point` does, too, up to rounding.
    pub fn is_in_plane(&self, hit: &Hit, point: Vec3) -> bool {
        let here = self.surface(hit);
        let allowed = 2.0 * self.plane_tolerance(hit, &here);
        (point - here.position).dot(here.geometric_normal).abs() <= allowed
    }

    /// Whether two hits of an instance, both at edges, are one crossing: the triangles have an edge in common, which
    /// they run along in opposite directions, and both face the ray or neither does.
    fn is_same_crossing(&self, a: &(Hit, SurfacePoint), b: &(Hit, SurfacePoint), direction: Vec3) -> bool {
        let side = |point: &SurfacePoint| point.geometric_normal.dot(direction) < 0.0;
        if a.0.instance != b.0.instance || side(&a.1) != side(&b.1) {
            return false;
        }
        let mesh = self.mesh_of(a.0.instance);
        let [a, b] = [a, b].map(|hit| mesh.triangle(hit.0.triangle));
        let edge = |of: &[Vec3; 3], i: usize| [of[i], of[(i + 1) % 3]];
        (0..3).any(|i| {
            let [from, to] = edge(&a, i);
            (0..3).any(|j| edge(&b, j) == [to, from])
        })
    }
}

/// Whether a hit may be one with that of a neighbour.
fn is_at_edge(hit: &Hit) -> bool {
    hit.u.min(hit.v).min(1.0 - hit.u - hit.v) < EDGE
}
