//! One triangle mesh with its own hierarchy, in its own space.

use super::huge_pages::with_huge_pages;
use super::lanes::{Lanes, Native};
use super::nearest::{traverse_lowest, traverse_nearest};
use super::offset::{ROUNDING, gamma};
use super::ray::{Aabb, MeshHit, NearestPoint, Ray};
use super::traversal::traverse;
use super::triangle_block::{ShearRay, TriangleBlock, nearest_barycentrics};
use super::wide_bvh::{Block, NONE, WideBvh};
use glam::Vec3;
use rayon::prelude::*;

/// Greatest magnitude of a coordinate; squares and products of three lengths must stay finite.
const GREATEST: f32 = 1.0e18;

/// Length of a ray, relative to coordinates, on which what is in one place can be met: [`ROUNDING`] across a plane,
/// seen under 89°. Under flatter angles too, where vertices are equal or nearly so. What is met there and is not in the
/// place after all costs no more than the question ([`super::SceneGeometry::place`]).
pub(super) const BAND: f32 = 64.0 * ROUNDING;

/// Triangles and the hierarchy that answers ray queries about them. Immutable.
///
/// Triangles keep the indices they were given. Those that cannot be hit are left out of the hierarchy: a coordinate
/// that is not finite or beyond 10¹⁸, an index out of range ([`Self::dropped`] counts both), or two equal corners.
#[derive(Clone)]
pub struct MeshGeometry {
    bvh: WideBvh<TriangleBlock>,
    /// The last one is zero.
    positions: Vec<Vec3>,
    /// Places in `positions`; three times the last one for a triangle that was dropped.
    triangles: Vec<[u32; 3]>,
    normals: Vec<Vec3>,
    dropped: usize,
    reversed: bool,
    /// The largest coordinate of the bounds.
    reach: f32,
}

impl MeshGeometry {
    /// Builds from vertex positions and vertex indices; the front of a triangle sees it counter-clockwise.
    ///
    /// Deterministic: the number of threads does not change the result.
    pub fn build(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        Self::build_oriented(positions, triangles, false)
    }

    /// As [`Self::build`]; where `reversed`, the front of a triangle sees it clockwise.
    pub fn build_oriented(positions: &[Vec3], triangles: &[[u32; 3]], reversed: bool) -> Self {
        let (positions, triangles, dropped) = usable_triangles(positions, triangles);
        let corners = |i: u32| triangles[i as usize].map(|vertex| positions[vertex as usize]);
        let all = 0..triangles.len() as u32;
        let normal = |i| if reversed { -unit_normal(&corners(i)) } else { unit_normal(&corners(i)) };
        let mut normals = with_huge_pages(triangles.len());
        (0..triangles.len()).into_par_iter().map(|i| normal(i as u32)).collect_into_vec(&mut normals);
        let solid = |v: [Vec3; 3]| v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        let kept: Vec<u32> = all.filter(|&i| solid(corners(i))).collect();
        let mut boxes = with_huge_pages(kept.len());
        kept.par_iter().map(|&i| Aabb::from_points(&corners(i))).collect_into_vec(&mut boxes);
        let holds = |block: &[u32]| TriangleBlock::holds(block.iter().map(|&i| corners(kept[i as usize])));
        let leaf = |block: &Block| {
            let ids = block.map(|lane| kept.get(lane as usize).copied().unwrap_or(NONE));
            TriangleBlock::new(ids, corners)
        };
        let bvh = WideBvh::build(&boxes, 8, holds, leaf);
        let Aabb { min, max } = bvh.bounds;
        let reach = if bvh.bounds.is_empty() { 0.0 } else { min.abs().max(max.abs()).max_element() };
        Self { bvh, positions, triangles, normals, dropped, reversed, reach }
    }

    /// Triangles that were left out because a coordinate or an index cannot be used.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Whether the front of a triangle sees it clockwise.
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// Bytes of everything that it holds: triangles, their normals, and the hierarchy.
    pub fn memory(&self) -> usize {
        size_of_val(&*self.bvh.lines)
            + size_of_val(&*self.positions)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.normals)
    }

    /// Number of triangles given to the build.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The hierarchy of its triangles.
    pub(super) fn bvh(&self) -> &WideBvh<TriangleBlock> {
        &self.bvh
    }

    /// Box around all triangles that can be hit.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds
    }

    /// Corners of a triangle, in the order of its indices (zeros where it was dropped).
    #[inline]
    pub fn triangle(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// Unit normal on the front side of a triangle.
    ///
    /// A triangle without area has some unit vector across its longest edge.
    #[inline]
    pub fn geometric_normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    /// The point of a triangle with the given barycentric weights, and a bound of its error on each axis.
    ///
    /// The bound counts what moves the point off the triangle's plane (rounding of `v0 + u e1 + v e2`, in the manner
    /// of PBRT 6.8.5) and what the plane's side can be mistaken by in the intersection test; errors of u and v
    /// move it within the plane.
    #[inline]
    pub fn point(&self, triangle: u32, u: f32, v: f32) -> (Vec3, Vec3) {
        let [v0, v1, v2] = self.triangle(triangle);
        let (e1, e2) = (u * (v1 - v0), v * (v2 - v0));
        (v0 + (e1 + e2), gamma(10) * (e1.abs() + e2.abs()) + gamma(2) * v0.abs())
    }

    /// Closest hit.
    // A call costs less than the registers that the walk takes from a caller's loop.
    #[inline(never)]
    pub fn intersect(&self, ray: &Ray) -> Option<MeshHit> {
        self.intersect_with::<Native>(ray)
    }

    /// Whether anything is hit.
    #[inline(never)]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_with::<Native>(ray)
    }

    /// Visits hits in any order until `visit` returns true.
    #[inline]
    pub(super) fn any_hit(&self, ray: &Ray, mut visit: impl FnMut(f32, u32) -> bool) -> bool {
        let mut shear = None;
        let mut found = false;
        traverse::<Native, false, _>(&self.bvh, ray, |block, t_max| {
            let shear = shear.get_or_insert_with(|| ShearRay::<Native>::new(ray));
            if let Some(hits) = block.intersect(shear, t_max) {
                found = bits(hits.mask).any(|lane| visit(hits.t[lane], block.ids[lane]));
            }
            if found { -1.0 } else { t_max }
        });
        found
    }

    /// All hits, sorted by distance (then by triangle), in place of what `hits` held.
    pub fn intersect_all(&self, ray: &Ray, hits: &mut Vec<MeshHit>) {
        self.intersect_all_with::<Native>(ray, hits);
    }

    /// Visits all hits, in no order that means anything.
    #[inline]
    pub fn visit_hits(&self, ray: &Ray, visit: impl FnMut(MeshHit)) {
        self.visit_hits_with::<Native>(ray, visit);
    }

    /// The point of the mesh nearest to `p`, if it is nearer than `upper_bound`.
    ///
    /// A good upper bound makes it fast; infinity is allowed.
    pub fn nearest(&self, p: Vec3, upper_bound: f32) -> Option<NearestPoint> {
        self.nearest_with::<Native>(p, upper_bound)
    }

    /// A lower bound of the distance from `p` to the mesh, which is known to be at most `upper_bound`; it may fall short
    /// by the part `slack`.
    pub(super) fn distance_at_least(&self, p: Vec3, upper_bound: f32, slack: f32) -> f32 {
        let shrink = 1.0 / ((1.0 + slack) * (1.0 + slack));
        let start = upper_bound * upper_bound * shrink;
        let mut least = start;
        traverse_nearest::<Native, _>(&self.bvh, p, start, |block, bound| {
            let squared = block.squared_distances::<Native>(p);
            let nearest = squared.into_iter().fold(f32::INFINITY, f32::min);
            least = bound.min(nearest * shrink);
            least
        });
        least.sqrt()
    }

    /// The least `n · (x - center)` of all triangles that reach into a ball, but at most `start`; nearly, as far as
    /// floats can tell.
    pub(super) fn least_along(&self, n: Vec3, (center, radius): (Vec3, f32), start: f32) -> f32 {
        let squared = radius * radius;
        let mut least = start;
        traverse_lowest::<Native, _>(&self.bvh, (center, squared), (n, start), |block, _| {
            let distances = block.squared_distances::<Native>(center);
            for (lane, _) in distances.iter().enumerate().filter(|(_, d)| **d <= squared) {
                for corner in self.triangle(block.ids[lane]) {
                    least = least.min(n.dot(corner - center));
                }
            }
            least
        });
        least
    }

    /// Positions, and the places of each triangle's corners in them.
    pub(super) fn indexed(&self) -> (&[Vec3], &[[u32; 3]]) {
        (&self.positions, &self.triangles)
    }

    /// Whether both hierarchies are the same, bit by bit.
    #[cfg(test)]
    pub(super) fn same_layout(&self, other: &Self) -> bool {
        self.bvh.lines == other.bvh.lines
    }

    #[inline(always)]
    pub(super) fn intersect_with<L: Lanes>(&self, ray: &Ray) -> Option<MeshHit> {
        let mut shear = None;
        let mut closest: Option<MeshHit> = None;
        // Distance of the closest hit but one.
        let mut second = f32::INFINITY;
        let band = BAND * self.coordinates(ray);
        traverse::<L, true, _>(&self.bvh, ray, |block, mut t_max| {
            let shear = shear.get_or_insert_with(|| ShearRay::<L>::new(ray));
            if let Some(hits) = block.intersect(shear, t_max) {
                for lane in bits(hits.mask) {
                    let t = hits.t[lane];
                    let least = closest.as_ref().map_or(f32::INFINITY, |hit| hit.t);
                    second = second.min(t.max(least));
                    if t < least {
                        let (triangle, u, v) = (block.ids[lane], hits.u[lane], hits.v[lane]);
                        t_max = t_max.min(t + band);
                        closest = Some(MeshHit { t, triangle, u, v, band, crowded: false });
                    }
                }
            }
            t_max
        });
        closest.map(|hit| MeshHit { crowded: second <= hit.t + band, ..hit })
    }

    /// Bound of the coordinates that are met on the way of a ray to the mesh.
    #[inline]
    pub(super) fn coordinates(&self, ray: &Ray) -> f32 {
        2.0 * ray.origin.abs().max_element() + self.reach
    }

    #[inline(always)]
    pub(super) fn occluded_with<L: Lanes>(&self, ray: &Ray) -> bool {
        let mut shear = None;
        let mut found = false;
        traverse::<L, false, _>(&self.bvh, ray, |block, t_max| {
            let shear = shear.get_or_insert_with(|| ShearRay::<L>::new(ray));
            found = block.intersect(shear, t_max).is_some();
            if found { -1.0 } else { t_max }
        });
        found
    }

    #[inline(always)]
    pub(super) fn intersect_all_with<L: Lanes>(&self, ray: &Ray, hits: &mut Vec<MeshHit>) {
        hits.clear();
        self.visit_hits_with::<L>(ray, |hit| hits.push(hit));
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    }

    #[inline(always)]
    fn visit_hits_with<L: Lanes>(&self, ray: &Ray, mut visit: impl FnMut(MeshHit)) {
        let mut shear = None;
        traverse::<L, false, _>(&self.bvh, ray, |block, t_max| {
            let shear = shear.get_or_insert_with(|| ShearRay::<L>::new(ray));
            if let Some(found) = block.intersect(shear, t_max) {
                for lane in bits(found.mask) {
                    let triangle = block.ids[lane];
                    let (t, u, v) = (found.t[lane], found.u[lane], found.v[lane]);
                    visit(MeshHit { t, triangle, u, v, band: 0.0, crowded: false });
                }
            }
            t_max
        });
    }

    #[inline(always)]
    pub(super) fn nearest_with<L: Lanes>(&self, p: Vec3, upper_bound: f32) -> Option<NearestPoint> {
        let mut best = None;
        traverse_nearest::<L, _>(&self.bvh, p, upper_bound * upper_bound, |block, mut bound| {
            let squared = block.squared_distances::<L>(p);
            for (lane, &d) in squared.iter().enumerate() {
                if d < bound {
                    bound = d;
                    best = Some(block.ids[lane]);
                }
            }
            bound
        });
        best.map(|triangle| {
            let corners = self.triangle(triangle);
            let (u, v) = nearest_barycentrics(&corners, p);
            let q = (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v + corners[0];
            NearestPoint { distance: p.distance(q), triangle, u, v }
        })
    }
}

/// Whether a position is finite, and small enough to compute with.
pub(super) fn is_usable(p: Vec3) -> bool {
    p.abs().cmple(Vec3::splat(GREATEST)).all()
}

/// Positions and one more, which is zero; triangles, with that one as all corners where they cannot be used; how many of
/// these there are.
fn usable_triangles(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>, usize) {
    let usable = |i: &u32| positions.get(*i as usize).is_some_and(|p| is_usable(*p));
    let is_usable = |t: &[u32; 3]| t.iter().all(usable);
    let dropped = triangles.par_iter().filter(|t| !is_usable(t)).count();
    // Of positions that many meshes share, each keeps its own.
    let own = 3 * triangles.len() < positions.len();
    let zero = if own { 3 * triangles.len() } else { positions.len() };
    let mut kept_positions = with_huge_pages(zero + 1);
    if own {
        let at = |i: &u32| positions.get(*i as usize).copied().unwrap_or_default();
        kept_positions.extend(triangles.iter().flatten().map(at));
    } else {
        kept_positions.extend_from_slice(positions);
    }
    kept_positions.push(Vec3::ZERO);
    let place = |(i, t): (usize, &[u32; 3])| match (is_usable(t), own) {
        (false, _) => [zero as u32; 3],
        (true, true) => [0, 1, 2].map(|corner| 3 * i as u32 + corner),
        (true, false) => *t,
    };
    let mut kept_triangles = with_huge_pages(triangles.len());
    triangles.par_iter().enumerate().map(place).collect_into_vec(&mut kept_triangles);
    (kept_positions, kept_triangles, dropped)
}

/// The set bits of a lane mask.
#[inline(always)]
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let lane = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            lane
        })
    })
}

/// Counter-clockwise unit normal, computed in double precision.
fn unit_normal(v: &[Vec3; 3]) -> Vec3 {
    let [a, b, c] = v.map(|v| v.as_dvec3());
    let edges = [b - a, c - b, a - c];
    let n = edges[0].cross(edges[1]);
    // Scaled first: the square of an area can underflow.
    let n = n / n.abs().max_element();
    if n.is_finite() {
        return n.normalize().as_vec3();
    }
    let longest = edges
        .into_iter()
        .fold(glam::DVec3::ZERO, |l, e| if e.length_squared() > l.length_squared() { e } else { l });
    longest.try_normalize().map_or(Vec3::Z, |e| e.any_orthonormal_vector().as_vec3())
}
