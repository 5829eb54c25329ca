//! The walks through the wide hierarchy that find nearest points, boxes in order of distance until none is nearer than
//! what has been found, and what reaches farthest in a direction near a point.

use super::lanes::Lanes;
use super::lines::{self, Lined};
use super::wide_bvh::{LEAF, Node, WideBvh};
use glam::Vec3;

/// Postponed children that fit on the stack of the thread; deeper hierarchies use the heap.
const STACK: usize = 128;

/// Visits the blocks that may hold a point nearer to `p` than the square root of `bound`, nearest box first.
///
/// `visit(block, bound)` returns the new bound of the squared distance.
#[inline(always)]
pub(super) fn traverse_nearest<L: Lanes, B: Lined>(
    bvh: &WideBvh<B>,
    p: Vec3,
    mut bound: f32,
    mut visit: impl FnMut(&B, f32) -> f32,
) {
    if bvh.lines.is_empty() {
        return;
    }
    let point = [L::splat(p.x), L::splat(p.y), L::splat(p.z)];
    // Postponed children: `squared distance << 32 | child`. Seven are added a level.
    let mut fixed = [0_u64; STACK];
    let mut heap = Vec::new();
    let need = 8 * bvh.depth + 1;
    let stack = if need <= STACK {
        &mut fixed[..]
    } else {
        heap.resize(need, 0);
        &mut heap[..]
    };
    let mut top = 0;
    let mut current = 0_u32;
    loop {
        if current & LEAF == 0 {
            let node: &Node = lines::get(&bvh.lines, current);
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
                    lines::prefetch(bvh.lines.as_ptr(), node.children[lane & 7] & !LEAF);
                    (u64::from(squared[lane & 7].to_bits()) << 32) | u64::from(node.children[lane & 7])
                };
                let base = top;
                while hits != 0 {
                    let next = key(hits.trailing_zeros() as usize);
                    hits &= hits - 1;
                    let mut slot = top;
                    while slot > base {
                        let above = stack[slot - 1];
                        if above >= next {
                            break;
                        }
                        stack[slot] = above;
                        slot -= 1;
                    }
                    stack[slot] = next;
                    top += 1;
                }
            }
        } else {
            bound = visit(lines::get(&bvh.lines, current & !LEAF), bound);
        }
        loop {
            if top == 0 {
                return;
            }
            top -= 1;
            let entry = stack[top];
            if f32::from_bits((entry >> 32) as u32) < bound {
                current = entry as u32;
                break;
            }
        }
    }
}

/// Visits the blocks that may reach into the ball of radius √`squared` about `p`, and there may hold a point x with
/// `n · (x - p)` below `least`.
///
/// `visit(block, least)` returns the new `least`.
#[inline(always)]
pub(super) fn traverse_lowest<L: Lanes, B: Lined>(
    bvh: &WideBvh<B>,
    (p, squared): (Vec3, f32),
    (n, mut least): (Vec3, f32),
    mut visit: impl FnMut(&B, f32) -> f32,
) {
    if bvh.lines.is_empty() {
        return;
    }
    let point = [L::splat(p.x), L::splat(p.y), L::splat(p.z)];
    let normal = [L::splat(n.x), L::splat(n.y), L::splat(n.z)];
    let lowest: [usize; 3] = std::array::from_fn(|axis| if n[axis] > 0.0 { axis } else { axis + 3 });
    // Postponed children, each with the least that it may hold.
    let mut stack = vec![(f32::NEG_INFINITY, 0_u32)];
    while let Some((may_hold, child)) = stack.pop() {
        if may_hold >= least {
            continue;
        }
        if child & LEAF != 0 {
            least = visit(lines::get(&bvh.lines, child & !LEAF), least);
            continue;
        }
        let node: &Node = lines::get(&bvh.lines, child);
        let zero = L::splat(0.0);
        let (mut away, mut along) = (zero, zero);
        for (axis, &p) in point.iter().enumerate() {
            let below = L::load(&node.planes[axis]).sub(p);
            let above = p.sub(L::load(&node.planes[axis + 3]));
            let gap = below.max(above).max(zero);
            away = gap.mul_add(gap, away);
            along = L::load(&node.planes[lowest[axis]]).sub(p).mul_add(normal[axis], along);
        }
        let mut hits = L::bits(away.le(L::splat(squared))) & L::bits(along.lt(L::splat(least)));
        let along = along.store();
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & 7;
            hits &= hits - 1;
            stack.push((along[lane], node.children[lane]));
        }
    }
}
