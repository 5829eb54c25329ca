//! Walks through the wide hierarchy: rays in order of distance, rays in any order, nearest points.
//!
//! The slab test must never cull a box whose triangle the watertight edge test would accept (Woop, Benthin & Wald,
//! "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, section 3.3; Ize, "Robust BVH Ray Traversal", JCGT
//! 2(2), 2013). Both round relative to the distance from the origin to the vertex, so each slab is widened by
//! `slack = 2⁻²⁰ (|o| + m)`, 16 roundings of the largest coordinate difference m between the origin and anything in
//! the hierarchy. The slack is folded into constants of the ray: the test is one multiply-add a plane.
//!
//! | code | formula |
//! | --- | --- |
//! | `inverse` | 1 / d, with abs(d) at least 2⁻⁶⁰ so that nothing is NaN |
//! | `near` | −o / d − slack / abs(d) |
//! | `far` | −o / d + slack / abs(d) |

use super::lanes::Lanes;
use super::ray::{Aabb, Ray};
use super::wide_bvh::{LEAF, Node, WideBvh};
use glam::Vec3;
use std::mem::MaybeUninit;

/// Least magnitude of a direction's component; a smaller one moves the ray by less than its slack.
const LEAST_COMPONENT: f32 = 1.0 / (1_u64 << 60) as f32;
/// Slack of the slabs, relative to coordinates.
const SLACK: f32 = 1.0 / (1_u64 << 20) as f32;
/// Postponed children that fit on the stack of the thread; deeper hierarchies use the heap.
const STACK: usize = 192;

/// A ray as the slab test wants it.
#[derive(Clone, Copy)]
struct SlabRay<L> {
    inverse: [L; 3],
    near: [L; 3],
    far: [L; 3],
    near_plane: [usize; 3],
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
        let near_plane = std::array::from_fn(|axis| if inverse[axis] < 0.0 { axis + 3 } else { axis });
        Self { inverse: splat(inverse), near: splat(near), far: splat(far), near_plane }
    }

    /// Bits of the children that the segment may meet, and where it enters them.
    #[inline(always)]
    fn children(&self, node: &Node, t_max: f32) -> (u32, L) {
        let plane = |p: usize, axis: usize, offset: &[L; 3]| {
            // `p` is below 6: the bound is for the compiler.
            L::load(&node.planes[p % 6]).mul_add(self.inverse[axis], offset[axis])
        };
        let [nx, ny, nz] = self.near_plane;
        let flip = |p: usize| if p < 3 { p + 3 } else { p - 3 };
        let enter = plane(nx, 0, &self.near).max(plane(ny, 1, &self.near));
        let enter = enter.max(plane(nz, 2, &self.near)).max(L::splat(0.0));
        let leave = plane(flip(nx), 0, &self.far).min(plane(flip(ny), 1, &self.far));
        let leave = leave.min(plane(flip(nz), 2, &self.far)).min(L::splat(t_max));
        (L::bits(enter.le(leave)), enter)
    }
}

/// Postponed children: `sort key << 32 | child`.
struct Stack {
    fixed: [MaybeUninit<u64>; STACK],
    heap: Vec<u64>,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self { fixed: [const { MaybeUninit::uninit() }; STACK], heap: Vec::new() }
    }

    /// Room for every child that a walk through the hierarchy can postpone.
    #[inline(always)]
    fn slots(&mut self, bvh: &WideBvh) -> &mut [MaybeUninit<u64>] {
        let need = 8 * bvh.depth + 1;
        if need <= STACK {
            &mut self.fixed
        } else {
            self.heap.reserve(need);
            self.heap.spare_capacity_mut()
        }
    }
}

/// Visits the blocks that the ray may meet, nearest box first where `ORDERED`.
///
/// `visit(block, t_max)` returns the new end of the ray; a negative one stops the walk.
#[inline(always)]
pub(super) fn traverse<L: Lanes, const ORDERED: bool>(
    bvh: &WideBvh,
    ray: &Ray,
    mut visit: impl FnMut(u32, f32) -> f32,
) {
    if bvh.nodes.is_empty() {
        return;
    }
    let slab = SlabRay::<L>::new(ray, &bvh.bounds);
    let mut t_max = ray.t_max;
    let mut stack = Stack::new();
    let stack = stack.slots(bvh);
    let mut top = 0;
    let mut current = 0_u32;
    loop {
        if current & LEAF == 0 {
            let node = &bvh.nodes[current as usize];
            let (mut hits, enter) = slab.children(node, t_max);
            if hits != 0 {
                let first = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                if hits == 0 {
                    current = node.children[first & 7];
                    continue;
                }
                let enter = enter.store();
                let key = |lane: usize| {
                    (u64::from(enter[lane & 7].to_bits()) << 32) | u64::from(node.children[lane & 7])
                };
                let base = top;
                let mut nearest = key(first);
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let mut next = key(lane);
                    if ORDERED && next < nearest {
                        std::mem::swap(&mut next, &mut nearest);
                    }
                    let mut slot = top;
                    if ORDERED {
                        while slot > base {
                            // SAFETY: slots below `top` have been written.
                            let above = unsafe { stack[slot - 1].assume_init() };
                            if above >= next {
                                break;
                            }
                            stack[slot].write(above);
                            slot -= 1;
                        }
                    }
                    stack[slot].write(next);
                    top += 1;
                }
                current = nearest as u32;
                continue;
            }
        } else {
            t_max = visit(current & !LEAF, t_max);
            if t_max < 0.0 {
                return;
            }
        }
        loop {
            if top == 0 {
                return;
            }
            top -= 1;
            // SAFETY: slots below the old `top` have been written.
            let entry = unsafe { stack[top].assume_init() };
            if !ORDERED || f32::from_bits((entry >> 32) as u32) <= t_max {
                current = entry as u32;
                break;
            }
        }
    }
}

/// Visits the blocks that may hold a point nearer to `p` than the square root of `bound`, nearest box first.
///
/// `visit(block, bound)` returns the new bound of the squared distance.
#[inline(always)]
pub(super) fn traverse_nearest<L: Lanes>(
    bvh: &WideBvh,
    p: Vec3,
    mut bound: f32,
    mut visit: impl FnMut(u32, f32) -> f32,
) {
    if bvh.nodes.is_empty() {
        return;
    }
    let point = [L::splat(p.x), L::splat(p.y), L::splat(p.z)];
    let mut stack = Stack::new();
    let stack = stack.slots(bvh);
    let mut top = 0;
    let mut current = 0_u32;
    loop {
        if current & LEAF == 0 {
            let node = &bvh.nodes[current as usize];
            let zero = L::splat(0.0);
            let mut squared = zero;
            for (axis, &p) in point.iter().enumerate() {
                let below = L::load(&node.planes[axis]).sub(p);
                let above = p.sub(L::load(&node.planes[axis + 3]));
                let gap = below.max(above).max(zero);
                squared = gap.mul_add(gap, squared);
            }
            let mut hits = L::bits(squared.lt(L::splat(bound)));
            if hits != 0 {
                let squared = squared.store();
                let key = |lane: usize| {
                    (u64::from(squared[lane & 7].to_bits()) << 32) | u64::from(node.children[lane & 7])
                };
                let base = top;
                while hits != 0 {
                    let next = key(hits.trailing_zeros() as usize);
                    hits &= hits - 1;
                    let mut slot = top;
                    while slot > base {
                        // SAFETY: slots below `top` have been written.
                        let above = unsafe { stack[slot - 1].assume_init() };
                        if above >= next {
                            break;
                        }
                        stack[slot].write(above);
                        slot -= 1;
                    }
                    stack[slot].write(next);
                    top += 1;
                }
            }
        } else {
            bound = visit(current & !LEAF, bound);
        }
        loop {
            if top == 0 {
                return;
            }
            top -= 1;
            // SAFETY: slots below the old `top` have been written.
            let entry = unsafe { stack[top].assume_init() };
            if f32::from_bits((entry >> 32) as u32) < bound {
                current = entry as u32;
                break;
            }
        }
    }
}
