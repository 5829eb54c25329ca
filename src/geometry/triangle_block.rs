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
//! - *Eight lanes, corners shared.* Neighbouring triangles have corners in common. A block keeps each once, moves it into
//!   the ray's space once, and then deals it out to the lanes: half the memory of eight loose triangles, and the same
//!   bits for every triangle at a corner.
//!
//! | code | paper |
//! | --- | --- |
//! | `axes` | kx, ky, kz |
//! | `shear` | Sx, Sy, Sz |
//! | `edge` | U, V, W |

use super::lanes::{Lanes, WIDTH};
use super::lines::Lined;
use super::ray::Ray;
use super::wide_bvh::{Block, NONE};
use glam::Vec3;

/// Depths below this part of the products they are made of are taken from the triangle's plane.
const NEAR: f32 = 1.0 / 4096.0;

/// Different corners that a block can hold. Eight triangles in one piece have at most ten, in two pieces twelve.
pub(super) const CORNERS: usize = 12;

/// Up to eight triangles, one a lane, with at most [`CORNERS`] corners: three cache lines. In unused lanes all three
/// corners are the first one; no ray hits that.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Axis, corner.
    positions: [[f32; CORNERS]; 3],
    /// Positions of the first, second and third vertex of each lane, four bits each.
    corners: [u32; 3],
    /// So that there is no padding.
    _unused: u32,
    /// Triangle of the mesh.
    pub ids: Block,
}

// SAFETY: numbers alone, three lines of them.
unsafe impl Lined for TriangleBlock {}

/// Adds the corners of a triangle that are not there yet; their places.
fn add_corners(found: &mut Vec<Vec3>, triangle: &[Vec3; 3]) -> [usize; 3] {
    triangle.map(|corner| {
        found.iter().position(|&p| p == corner).unwrap_or_else(|| {
            found.push(corner);
            found.len() - 1
        })
    })
}

/// `map` of an array, which compilers do not always make a part of the loop that calls it.
#[inline(always)]
fn each<T, U>([a, b, c]: [T; 3], f: impl Fn(T) -> U) -> [U; 3] {
    [f(a), f(b), f(c)]
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
        // Of arrays: choosing a component of a vector is a chain of branches.
        let (o, d) = (ray.origin.to_array(), d.to_array());
        let [x, y, z] = axes;
        let inverse = 1.0 / d[z];
        Self {
            axes,
            origin: [L::splat(o[x]), L::splat(o[y]), L::splat(o[z])],
            direction: [L::splat(d[x]), L::splat(d[y]), L::splat(d[z])],
            shear: [L::splat(d[x] * inverse), L::splat(d[y] * inverse), L::splat(inverse)],
        }
    }
}

/// Lanes that were hit; the numbers of other lanes mean nothing.
pub(super) struct BlockHits {
    pub mask: u32,
    pub t: [f32; WIDTH],
    pub u: [f32; WIDTH],
    pub v: [f32; WIDTH],
}

impl TriangleBlock {
    /// Whether triangles have few enough different corners for one block.
    pub fn holds(triangles: impl Iterator<Item = [Vec3; 3]>) -> bool {
        let mut found = Vec::with_capacity(3 * WIDTH);
        triangles.for_each(|triangle| {
            add_corners(&mut found, &triangle);
        });
        found.len() <= CORNERS
    }

    /// Gathers triangles that a block [holds](Self::holds).
    pub fn new(ids: Block, triangle: impl Fn(u32) -> [Vec3; 3]) -> Self {
        let mut this = Self { positions: [[0.0; CORNERS]; 3], corners: [0; 3], _unused: 0, ids };
        let mut found = Vec::with_capacity(CORNERS);
        for (lane, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NONE) {
            for (nibbles, place) in this.corners.iter_mut().zip(add_corners(&mut found, &triangle(id))) {
                *nibbles |= (place as u32) << (4 * lane);
            }
        }
        for (place, position) in found.iter().enumerate() {
            for axis in 0..3 {
                this.positions[axis][place] = position[axis];
            }
        }
        this
    }

    /// One coordinate of all corners, less a number.
    #[inline(always)]
    fn row<L: Lanes>(&self, axis: usize, origin: L) -> [L; 2] {
        debug_assert!(axis < 3, "axis = {axis}");
        // SAFETY: only called with an axis of `ShearRay::axes`, or 0, 1 and 2.
        let row = unsafe { self.positions.get_unchecked(axis) };
        let (low, high) = row.split_at(WIDTH);
        let low = L::load(low.try_into().expect("there are twelve"));
        let high = L::load_half(high.try_into().expect("there are twelve"));
        [low.sub(origin), high.sub(origin)]
    }

    /// The three vertices of each lane, axis by axis, from rows of corners.
    #[inline(always)]
    fn vertices<L: Lanes>(&self, rows: [[L; 2]; 3]) -> [[L; 3]; 3] {
        each(self.corners, |nibbles| {
            let at = L::indices(nibbles);
            each(rows, |[low, high]| L::pick(low, high, at))
        })
    }

    /// Hits with `0 < t < t_max`.
    #[inline(always)]
    pub fn intersect<L: Lanes>(&self, ray: &ShearRay<L>, t_max: f32) -> Option<BlockHits> {
        let [x, y, z] = each([0, 1, 2], |k: usize| self.row(ray.axes[k], ray.origin[k]));
        let sheared = |shear: L, x: [L; 2]| [shear.neg_mul_add(z[0], x[0]), shear.neg_mul_add(z[1], x[1])];
        let (x, y) = (sheared(ray.shear[0], x), sheared(ray.shear[1], y));
        let at = each(self.corners, L::indices);
        let [ax, bx, cx] = each(at, |at| L::pick(x[0], x[1], at));
        let [ay, by, cy] = each(at, |at| L::pick(y[0], y[1], at));
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
        let [az, bz, cz] = each(at, |at| L::pick(z[0], z[1], at));
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
            t = L::select(near, self.plane_distances(ray), t);
        }
        let mask = inside & L::bits(zero.lt(t)) & L::bits(t.lt(L::splat(t_max)));
        if mask == 0 {
            return None;
        }
        Some(BlockHits { mask, t: t.store(), u: v.store(), v: w.store() })
    }

    /// Distances to the planes of the triangles.
    #[inline(always)]
    fn plane_distances<L: Lanes>(&self, ray: &ShearRay<L>) -> L {
        let corners = self.vertices(each([0, 1, 2], |k: usize| self.row(ray.axes[k], ray.origin[k])));
        let normal = normals(&corners);
        dot(&normal, &corners[0]).div(dot(&normal, &ray.direction))
    }

    /// Squared distances to the triangles; unused lanes hold infinity.
    #[inline(always)]
    pub fn squared_distances<L: Lanes>(&self, p: Vec3) -> [f32; WIDTH] {
        let point = [L::splat(p.x), L::splat(p.y), L::splat(p.z)];
        let zero = L::splat(0.0);
        let one = L::splat(1.0);
        let corners = self.vertices(each([0, 1, 2], |axis| self.row(axis, zero)));
        let normal = normals(&corners);
        let length = dot(&normal, &normal).sqrt();
        let normal = each(normal, |x| x.div(length));
        let mut nearest = L::splat(f32::INFINITY);
        // Least of the signed sides; positive where the foot of the perpendicular is inside.
        let mut side = L::splat(f32::INFINITY);
        let mut height = zero;
        for i in 0..3 {
            let (a, b) = (&corners[i], &corners[(i + 1) % 3]);
            let along = each([0, 1, 2], |k: usize| b[k].sub(a[k]));
            let from = each([0, 1, 2], |k: usize| point[k].sub(a[k]));
            let length = dot(&along, &along);
            // A zero-length edge gives NaN, which `max` replaces by zero.
            let s = dot(&along, &from).div(length).max(zero).min(one);
            let rest = each([0, 1, 2], |k: usize| s.neg_mul_add(along[k], from[k]));
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

#[inline(always)]
fn dot<L: Lanes>(a: &[L; 3], b: &[L; 3]) -> L {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2].mul(b[2])))
}

/// Normals, no longer than 2; zero for triangles without an area, NaN where all corners are one.
///
/// Products are subtracted as if exact (Kahan; Jeannerod et al. 2013, "Further analysis of Kahan's algorithm for the
/// accurate computation of 2x2 determinants"), so these are the normals of triangles whose corners are off by a
/// rounding, needles included: above a triangle, its distance is off by a rounding of its size.
#[inline(always)]
fn normals<L: Lanes>([a, b, c]: &[[L; 3]; 3]) -> [L; 3] {
    let edge = |to: &[L; 3]| each([0, 1, 2], |k: usize| to[k].sub(a[k]));
    let (ab, ac) = (edge(b), edge(c));
    let longest = |e: &[L; 3]| e[0].abs().max(e[1].abs()).max(e[2].abs());
    // The square of an area can overflow or underflow.
    let scale = L::splat(1.0).div(longest(&ab).max(longest(&ac)));
    let (ab, ac) = (each(ab, |x| x.mul(scale)), each(ac, |x| x.mul(scale)));
    let minor = |i: usize, j: usize| {
        let product = ab[j].mul(ac[i]);
        let error = ab[j].neg_mul_add(ac[i], product);
        ab[i].mul_add(ac[j], L::splat(0.0).sub(product)).add(error)
    };
    [minor(1, 2), minor(2, 0), minor(0, 1)]
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
