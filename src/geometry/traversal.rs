//! The walk of a ray through the wide hierarchy.
//!
//! The slab test must never cull a box whose triangle the watertight edge test would accept (Woop, Benthin & Wald,
//! "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, section 3.3; Ize, "Robust BVH Ray Traversal", JCGT
//! 2(2), 2013). Both round relative to the distance from the origin to the vertex, so each slab is widened by
//! `slack = 2⁻²⁰ (|o| + m)`, 16 roundings of the largest coordinate difference m between the origin and anything in
//! the hierarchy. The slack is folded into constants of the ray: the test is one multiply-add a plane.
//!
//! Of the children that are hit, the nearest is next and the others are postponed, nearest on top. Most nodes have one or
//! two: these cases have their own branches, which predict well and keep the chain from node to node short. (Measured:
//! ordering by the ray's octant with one permutation and no branch at all is a quarter slower for long rays.) Memory of
//! all of them is asked for at once: in large meshes a ray does little but wait for memory.
//!
//! | code | formula |
//! | --- | --- |
//! | `inverse` | 1 / d, with abs(d) at least 2⁻⁶⁰ so that nothing is NaN |
//! | `near` | −o / d − slack / abs(d) |
//! | `far` | −o / d + slack / abs(d) |

use super::lanes::{Lanes, WIDTH};
use super::lines::{self, Lined};
use super::ray::{Aabb, Ray};
use super::wide_bvh::{LEAF, Node, WideBvh};
use glam::Vec3;
use std::mem::MaybeUninit;

/// Least magnitude of a direction's component; a smaller one moves the ray by less than its slack.
const LEAST_COMPONENT: f32 = 1.0 / (1_u64 << 60) as f32;
/// Slack of the slabs, relative to coordinates.
const SLACK: f32 = 1.0 / (1_u64 << 20) as f32;
/// Bytes of a row of planes.
const ROW: usize = size_of::<[f32; WIDTH]>();
/// Postponed children that fit on the stack of the thread; deeper hierarchies use the heap.
const STACK: usize = 192;

/// A ray as the slab test wants it.
#[derive(Clone, Copy)]
struct SlabRay<L: Lanes> {
    inverse: [L; 3],
    near: [L; 3],
    far: [L; 3],
    /// Rows of [`Node::planes`], in bytes from the first.
    near_plane: [usize; 3],
    far_plane: [usize; 3],
}

impl<L: Lanes> SlabRay<L> {
    #[inline(always)]
    fn new(ray: &Ray, bounds: &Aabb) -> Self {
        let reach = (bounds.min - ray.origin).abs().max((bounds.max - ray.origin).abs()).max_element();
        let slack = SLACK * (ray.origin.abs() + Vec3::splat(reach));
        let d = ray.direction;
        let inverse = d.abs().max(Vec3::splat(LEAST_COMPONENT)).copysign(d).recip();
        let middle = -ray.origin * inverse;
        let width = slack * inverse.abs();
        let (near, far) = (middle - width, middle + width);
        let splat = |v: Vec3| [L::splat(v.x), L::splat(v.y), L::splat(v.z)];
        let signs = d.is_negative_bitmask() & 7;
        let near_plane = std::array::from_fn(|axis| ROW * (axis + 3 * (signs >> axis & 1) as usize));
        // Rows k and k + 3 are opposite: 3 − x is the other one of 0 and 3, 5 − y of 1 and 4, 7 − z of 2 and 5.
        let far_plane = [3 * ROW - near_plane[0], 5 * ROW - near_plane[1], 7 * ROW - near_plane[2]];
        Self { inverse: splat(inverse), near: splat(near), far: splat(far), near_plane, far_plane }
    }

    /// Where the ray enters the children and where it leaves them, slot by slot.
    #[inline(always)]
    fn span(&self, node: &Node, t_max: f32) -> (L, L) {
        let plane = |row: usize, axis: usize, offset: &[L; 3]| {
            debug_assert!(row < 6 * ROW, "row = {row}");
            // SAFETY: rows are those of `near_plane`, or their opposites.
            let planes = unsafe { &*node.planes.as_ptr().byte_add(row) };
            L::load(planes).mul_add(self.inverse[axis], offset[axis])
        };
        let [x, y, z] = self.near_plane;
        let [fx, fy, fz] = self.far_plane;
        let enter = plane(x, 0, &self.near).max(plane(y, 1, &self.near));
        let enter = enter.max(plane(z, 2, &self.near).max(L::splat(0.0)));
        let leave = plane(fx, 0, &self.far).min(plane(fy, 1, &self.far));
        let leave = leave.min(plane(fz, 2, &self.far).min(L::splat(t_max)));
        (enter, leave)
    }
}

/// Visits those of the leaves' `blocks` that the ray may meet, nearest box first where `ORDERED`.
///
/// `visit(block, t_max)` returns the new end of the ray; a negative one stops the walk.
#[inline(always)]
pub(super) fn traverse<L: Lanes, const ORDERED: bool, B: Lined>(
    bvh: &WideBvh<B>,
    ray: &Ray,
    visit: impl FnMut(&B, f32) -> f32,
) {
    if bvh.lines.is_empty() {
        return;
    }
    // A level postpones at most seven children.
    let need = 7 * bvh.depth;
    let mut fixed = [const { MaybeUninit::uninit() }; STACK];
    let mut heap = Vec::new();
    // One place that calls `visit`, which is then a part of the loop.
    let stack = if need <= STACK {
        &mut fixed[..]
    } else {
        heap.resize(need, MaybeUninit::uninit());
        &mut heap[..]
    };
    walk::<L, ORDERED, B>(bvh, ray, visit, stack);
}

/// The stack holds `entry distance << 32 | child`, which sorts by distance.
#[inline(always)]
fn walk<L: Lanes, const ORDERED: bool, B: Lined>(
    bvh: &WideBvh<B>,
    ray: &Ray,
    mut visit: impl FnMut(&B, f32) -> f32,
    stack: &mut [MaybeUninit<u64>],
) {
    assert!(stack.len() >= 7 * bvh.depth);
    let slab = SlabRay::<L>::new(ray, &bvh.bounds);
    let stack = stack.as_mut_ptr().cast::<u64>();
    let lines = bvh.lines.as_ptr();
    let mut t_max = ray.t_max;
    let mut top = 0;
    let mut current = 0_u32;
    loop {
        if current & LEAF == 0 {
            // SAFETY: the build only makes references to nodes that are there.
            let node = unsafe { &*lines.add(current as usize).cast::<Node>() };
            let (enter, leave) = slab.span(node, t_max);
            let mut hits = L::bits(enter.le(leave));
            if hits != 0 {
                let first = hits.trailing_zeros() as usize & 7;
                hits &= hits - 1;
                if hits == 0 {
                    current = node.children[first];
                    continue;
                }
                let enter = enter.store();
                let key = |lane: usize| {
                    lines::prefetch(lines, node.children[lane] & !LEAF);
                    (u64::from(enter[lane].to_bits()) << 32) | u64::from(node.children[lane])
                };
                let mut nearest = key(first);
                let second = key(hits.trailing_zeros() as usize & 7);
                hits &= hits - 1;
                let farther = nearest.max(second);
                nearest = nearest.min(second);
                debug_assert!(top + 7 <= 7 * bvh.depth, "top = {top}");
                // SAFETY (here and below): a node of level l (the root has 1) is visited with at most 7 (l - 1)
                // entries postponed and adds at most 7; l is at most the depth.
                unsafe { stack.add(top).write(farther) };
                let base = top;
                top += 1;
                while hits != 0 {
                    let mut next = key(hits.trailing_zeros() as usize & 7);
                    hits &= hits - 1;
                    let mut slot = top;
                    if ORDERED {
                        (nearest, next) = (nearest.min(next), nearest.max(next));
                        while slot > base {
                            // SAFETY: the entry has been written.
                            let above = unsafe { stack.add(slot - 1).read() };
                            if above >= next {
                                break;
                            }
                            unsafe { stack.add(slot).write(above) };
                            slot -= 1;
                        }
                    }
                    unsafe { stack.add(slot).write(next) };
                    top += 1;
                }
                current = nearest as u32;
                continue;
            }
        } else {
            t_max = visit(lines::get(&bvh.lines, current & !LEAF), t_max);
            if t_max < 0.0 {
                return;
            }
        }
        loop {
            if top == 0 {
                return;
            }
            top -= 1;
            // SAFETY: the entries below the old `top` have been written.
            let entry = unsafe { stack.add(top).read() };
            if !ORDERED || f32::from_bits((entry >> 32) as u32) <= t_max {
                current = entry as u32;
                break;
            }
        }
    }
}
