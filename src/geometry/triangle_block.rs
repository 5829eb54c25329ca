//! Eight triangles at once: watertight ray intersection and nearest point.
//!
//! Intersection follows Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection" (JCGT 2(1), 2013): vertices are
//! sheared into a space where the ray is the axis of its largest component, and three two-dimensional edge functions
//! decide. Three things differ from the paper:
//!
//! - *No double-precision fallback.* The edge function `cx * by - cy * bx` is a difference of two rounded products.
//!   Rounding is monotone, so its sign is never wrong, only sometimes zero; it is antisymmetric to the bit, so two
//!   triangles see opposite signs at a shared edge, and zero counts as inside for both. Nothing can pass between.
//! - *Distance near the origin.* The paper's interpolated depth T rounds relative to the triangle's size, more so for
//!   needles and at grazing angles, so a ray that leaves the triangle itself could find it again. Where T det is not
//!   well above the rounding of the products that it is made of, the distance comes from the plane,
//!   `n · (v0 - o) / n · d`, with the stored unit normal: its sign is sure once the origin is off the plane by the
//!   error that [`super::MeshGeometry::point`] reports. No hit is lost to an epsilon.
//! - *Eight lanes.*
//!
//! | code | paper |
//! | --- | --- |
//! | `axes` | kx, ky, kz |
//! | `shear` | Sx, Sy, Sz |
//! | `edge` | U, V, W |

use super::lanes::{Lanes, WIDTH};
use super::ray::Ray;
use super::wide_bvh::{Block, NONE};
use glam::Vec3;

/// Depths below this part of the products they are made of are taken from the triangle's plane.
const NEAR: f32 = 1.0 / 4096.0;

/// Up to eight triangles, one a lane. Unused lanes are points at the origin, which no ray hits.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock {
    /// Vertex, axis, lane.
    vertices: [[[f32; WIDTH]; 3]; 3],
    /// Unit normal: axis, lane.
    normals: [[f32; WIDTH]; 3],
    /// Triangle of the mesh.
    pub ids: Block,
}

/// A ray as the edge test wants it.
#[derive(Clone, Copy)]
pub(super) struct ShearRay<L> {
    axes: [usize; 3],
    origin: [L; 3],
    direction: [L; 3],
    shear: [L; 3],
}

impl<L: Lanes> ShearRay<L> {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let a = d.abs();
        let axes = if a.x >= a.y && a.x >= a.z {
            [1, 2, 0]
        } else if a.y >= a.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let permute = |v: Vec3| axes.map(|axis| L::splat(v[axis]));
        let sz = 1.0 / d[axes[2]];
        let shear = [L::splat(d[axes[0]] * sz), L::splat(d[axes[1]] * sz), L::splat(sz)];
        Self { axes, origin: permute(ray.origin), direction: permute(d), shear }
    }
}

/// Lanes that were hit; the numbers of other lanes mean nothing.
pub(super) struct BlockHits {
    pub mask: u32,
    pub t: [f32; WIDTH],
    pub u: [f32; WIDTH],
    pub v: [f32; WIDTH],
}

/// One axis of eight vectors.
#[inline(always)]
fn axis(vectors: &[[f32; WIDTH]; 3], axis: usize) -> &[f32; WIDTH] {
    debug_assert!(axis < 3, "axis = {axis}");
    // SAFETY: only called with `ShearRay::axes`, a permutation of 0, 1 and 2.
    unsafe { vectors.get_unchecked(axis) }
}

impl TriangleBlock {
    /// Gathers the triangles of a block; `vertices` and `normals` are indexed by triangle.
    pub fn new(ids: Block, vertices: &[[Vec3; 3]], normals: &[Vec3]) -> Self {
        let mut this = Self { vertices: [[[0.0; 8]; 3]; 3], normals: [[0.0; 8]; 3], ids };
        for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NONE) {
            for axis in 0..3 {
                for (corner, position) in vertices[id as usize].iter().enumerate() {
                    this.vertices[corner][axis][lane] = position[axis];
                }
                this.normals[axis][lane] = normals[id as usize][axis];
            }
        }
        this
    }

    /// Hits with `0 < t < t_max`.
    #[inline(always)]
    pub fn intersect<L: Lanes>(&self, ray: &ShearRay<L>, t_max: f32) -> Option<BlockHits> {
        let corner = |c: usize| {
            let row = |k: usize| L::load(axis(&self.vertices[c], ray.axes[k])).sub(ray.origin[k]);
            let (x, y, z) = (row(0), row(1), row(2));
            (ray.shear[0].neg_mul_add(z, x), ray.shear[1].neg_mul_add(z, y), z)
        };
        let (ax, ay, az) = corner(0);
        let (bx, by, bz) = corner(1);
        let (cx, cy, cz) = corner(2);
        let edge = |px: L, py: L, qx: L, qy: L| px.mul(qy).sub(py.mul(qx));
        let u = edge(cx, cy, bx, by);
        let v = edge(ax, ay, cx, cy);
        let w = edge(bx, by, ax, ay);
        let zero = L::splat(0.0);
        let negative = L::bits(u.min(v).min(w).lt(zero));
        let positive = L::bits(zero.lt(u.max(v).max(w)));
        let inside = negative ^ positive;
        if inside == 0 {
            return None;
        }
        let det = u.add(v).add(w);
        let inverse = L::splat(1.0).div(det);
        let (u, v, w) = (u.mul(inverse), v.mul(inverse), w.mul(inverse));
        let depth = u.mul_add(az, v.mul_add(bz, w.mul(cz)));
        let most = |a: L, b: L, c: L| a.abs().max(b.abs()).max(c.abs());
        let range = most(az, bz, cz);
        let products = most(ax, bx, cx).mul(most(ay, by, cy)).mul(range);
        let mut t = depth.mul(ray.shear[2]);
        let rough = depth.mul(det).abs().lt(products.mul(L::splat(NEAR)));
        // Seen from afar, a needle or an edge-on triangle is better off with T, which stays within its corners.
        let near = L::and(rough, depth.abs().lt(range.mul(L::splat(1.0 / 16.0))));
        if L::bits(near) & inside != 0 {
            let mut height = zero;
            let mut slope = zero;
            for (i, &k) in ray.axes.iter().enumerate() {
                let normal = L::load(axis(&self.normals, k));
                height = normal.mul_add(L::load(axis(&self.vertices[0], k)).sub(ray.origin[i]), height);
                slope = normal.mul_add(ray.direction[i], slope);
            }
            t = L::select(near, height.div(slope), t);
        }
        let mask = inside & L::bits(zero.lt(t)) & L::bits(t.lt(L::splat(t_max)));
        if mask == 0 {
            return None;
        }
        Some(BlockHits { mask, t: t.store(), u: v.store(), v: w.store() })
    }

    /// Squared distances to the triangles; unused lanes hold infinity.
    #[inline(always)]
    pub fn squared_distances<L: Lanes>(&self, p: Vec3) -> [f32; WIDTH] {
        let point = [L::splat(p.x), L::splat(p.y), L::splat(p.z)];
        let zero = L::splat(0.0);
        let one = L::splat(1.0);
        let dot = |a: &[L; 3], b: &[L; 3]| a[0].mul_add(b[0], a[1].mul_add(b[1], a[2].mul(b[2])));
        let normal: [L; 3] = std::array::from_fn(|k| L::load(&self.normals[k]));
        let corner = |c: usize| -> [L; 3] { std::array::from_fn(|k| L::load(&self.vertices[c][k])) };
        let corners = [corner(0), corner(1), corner(2)];
        let mut nearest = L::splat(f32::INFINITY);
        // Least of the signed sides; positive where the foot of the perpendicular is inside.
        let mut side = L::splat(f32::INFINITY);
        let mut height = zero;
        for i in 0..3 {
            let (a, b) = (&corners[i], &corners[(i + 1) % 3]);
            let along: [L; 3] = std::array::from_fn(|k| b[k].sub(a[k]));
            let from: [L; 3] = std::array::from_fn(|k| point[k].sub(a[k]));
            let length = dot(&along, &along);
            // A zero-length edge gives NaN, which `max` replaces by zero.
            let s = dot(&along, &from).div(length).max(zero).min(one);
            let rest: [L; 3] = std::array::from_fn(|k| s.neg_mul_add(along[k], from[k]));
            nearest = dot(&rest, &rest).min(nearest);
            let across = [
                normal[1].mul(along[2]).sub(normal[2].mul(along[1])),
                normal[2].mul(along[0]).sub(normal[0].mul(along[2])),
                normal[0].mul(along[1]).sub(normal[1].mul(along[0])),
            ];
            side = dot(&across, &from).min(side);
            height = dot(&normal, &from);
        }
        let squared = L::select(zero.lt(side), height.mul(height).min(nearest), nearest);
        let mut out = squared.store();
        for (lane, &id) in self.ids.iter().enumerate() {
            if id == NONE {
                out[lane] = f32::INFINITY;
            }
        }
        out
    }
}

/// Barycentric weights (of the second and third vertex) of the triangle's point nearest to `p`.
///
/// Ericson, "Real-Time Collision Detection" (2005), section 5.1.5, in double precision.
pub(super) fn nearest_barycentrics(triangle: &[Vec3; 3], p: Vec3) -> (f32, f32) {
    let [a, b, c] = triangle.map(|v| v.as_dvec3());
    let p = p.as_dvec3();
    let (ab, ac) = (b - a, c - a);
    let ap = p - a;
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (0.0, 0.0);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (1.0, 0.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return ((d1 / (d1 - d3)) as f32, 0.0);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (0.0, 1.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (0.0, (d2 / (d2 - d6)) as f32);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return ((1.0 - w) as f32, w as f32);
    }
    let scale = 1.0 / (va + vb + vc);
    ((vb * scale) as f32, (vc * scale) as f32)
}
