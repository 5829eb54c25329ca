//! Binary hierarchies from the bottom up: parallel locally-ordered clustering (Meister & Bittner, "Parallel Locally-Ordered
//! Clustering for Bounding Volume Hierarchy Construction", TVCG 2018).
//!
//! Boxes lie along a Morton curve. In each round every cluster looks for its nearest among those close to it on the curve, the
//! one with which it has the box of least area, and two that are each other's nearest become one.
//!
//! Nothing in that promises that many do: of boxes in one place, or of the faces of a cone, each may be nearest to the one
//! before it, so that a round makes one pair and time is quadratic. Where few agree, those who are left take their nearest in
//! order, as long as it is free. Each pair then keeps at most those waiting that are close to it on the curve, so every round
//! ends a part of the clusters that does not depend on their number.

use glam::{U64Vec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use rayon::prelude::*;

/// Places before and after its own where a cluster looks for its nearest.
const SEARCH_DISTANCE: usize = 14;
/// In the first rounds only neighbours are looked at, which is faster and as good.
const NEIGHBOUR_ROUNDS: usize = 2;
/// Part of the clusters that is to be in pairs after a round.
const ENOUGH: usize = 16;
/// Clusters that one task looks at.
const CHUNK: usize = 4096;
/// Bits of the Morton code on an axis.
const BITS: u32 = 21;

/// Builds the hierarchy of finite boxes, one primitive a leaf; parents come before their children. Deterministic, whatever the
/// number of threads.
pub(super) fn cluster(boxes: &[Aabb]) -> Bvh2 {
    let mut tree = Bvh2::zeroed(boxes.len());
    if boxes.is_empty() {
        return tree;
    }
    tree.primitive_indices = (0..boxes.len() as u32).collect();
    let mut clusters = along_the_curve(boxes);
    let mut next = Vec::with_capacity(clusters.len());
    let mut nearest = vec![0_i8; clusters.len()];
    let (mut free, mut rounds) = (tree.nodes.len(), 0);
    while clusters.len() > 1 {
        let nearest = &mut nearest[..clusters.len()];
        if rounds < NEIGHBOUR_ROUNDS {
            find_nearest::<1>(&clusters, nearest);
        } else {
            find_nearest::<SEARCH_DISTANCE>(&clusters, nearest);
        }
        if ENOUGH * pairs(nearest) < nearest.len() {
            agree(nearest);
        }
        merge(&clusters, nearest, &mut tree.nodes, &mut free, &mut next);
        std::mem::swap(&mut clusters, &mut next);
        rounds += 1;
    }
    tree.nodes[0] = clusters[0];
    tree.max_depth = tree.max_depth.max(rounds + 1);
    tree.children_are_ordered_after_parents = true;
    tree
}

/// Leaves in the order of the Morton codes of their middles.
fn along_the_curve(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    let bounds = boxes.par_iter().copied().reduce(Aabb::empty, |a, b| a.union(&b));
    let cells = (1_u64 << BITS) as f32;
    let extent = Vec3::from(bounds.diagonal());
    // An axis without extent has one cell.
    let scale = Vec3::select(extent.cmpgt(Vec3::ZERO), cells / extent, Vec3::ZERO);
    let code = |b: &Aabb| {
        let cell = (Vec3::from(b.center() - bounds.min) * scale).clamp(Vec3::ZERO, Vec3::splat(cells - 1.0));
        let cell: U64Vec3 = cell.as_u64vec3();
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut order: Vec<(u64, u32)> = boxes.par_iter().map(code).zip(0..boxes.len() as u32).collect();
    order.par_sort_unstable();
    order.par_iter().map(|&(_, i)| Bvh2Node::new(boxes[i as usize], 1, i)).collect()
}

/// Moves the 21 lower bits of a number three places apart.
fn spread(bits: u64) -> u64 {
    let mut x = bits & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Distance in the order from each cluster to its nearest among `D` before and after it.
fn find_nearest<const D: usize>(clusters: &[Bvh2Node], nearest: &mut [i8]) {
    nearest.par_chunks_mut(CHUNK).enumerate().for_each(|(number, nearest)| {
        let (begin, end) = (number * CHUNK, number * CHUNK + nearest.len());
        // The best so far of the next clusters. Of two that are equally near, the later one is taken.
        let mut waiting = [(f32::INFINITY, 0_i8); 64];
        const { assert!(D < 64 && D < i8::MAX as usize) };
        for i in begin.saturating_sub(D)..end {
            let here = *clusters[i].aabb();
            let (mut least, mut best) = std::mem::replace(&mut waiting[i % 64], (f32::INFINITY, 0));
            let others = &clusters[i + 1..clusters.len().min(i + 1 + D)];
            for (offset, other) in (1_i8..).zip(others) {
                let area = here.union(other.aabb()).half_area();
                if area <= least {
                    (least, best) = (area, offset);
                }
                let other = &mut waiting[(i + offset as usize) % 64];
                if area <= other.0 {
                    *other = (area, -offset);
                }
            }
            if i >= begin {
                nearest[i - begin] = best;
            }
        }
    });
}

/// The nearest of a cluster.
fn partner(nearest: &[i8], i: usize) -> usize {
    i.wrapping_add_signed(nearest[i].into())
}

/// How many clusters are the nearest of their nearest.
fn pairs(nearest: &[i8]) -> usize {
    (0..nearest.len()).filter(|&i| partner(nearest, partner(nearest, i)) == i).count()
}

/// Makes pairs of those who are not in one and whose nearest is not; who is left stands for itself.
fn agree(nearest: &mut [i8]) {
    let mut taken: Vec<bool> =
        (0..nearest.len()).map(|i| partner(nearest, partner(nearest, i)) == i).collect();
    for i in 0..nearest.len() {
        if taken[i] {
            continue;
        }
        let other = partner(nearest, i);
        if taken[other] {
            continue;
        }
        (taken[i], taken[other]) = (true, true);
        nearest[other] = -nearest[i];
    }
}

/// Makes clusters of pairs; the two halves of each go into the last places of the tree that are free.
fn merge(
    clusters: &[Bvh2Node],
    nearest: &[i8],
    nodes: &mut [Bvh2Node],
    free: &mut usize,
    next: &mut Vec<Bvh2Node>,
) {
    next.clear();
    for (i, &here) in clusters.iter().enumerate() {
        let other = partner(nearest, i);
        if other == i || partner(nearest, other) != i {
            next.push(here);
        } else if other < i {
            *free -= 2;
            (nodes[*free], nodes[*free + 1]) = (here, clusters[other]);
            let bounds = here.aabb().union(clusters[other].aabb());
            next.push(Bvh2Node::new(bounds, 0, *free as u32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use std::f32::consts::TAU;

    /// Primitives below each node are found once, children after their parents, and there are few rounds.
    fn check(boxes: &[Aabb], name: &str) {
        let tree = cluster(boxes);
        let mut found = vec![false; boxes.len()];
        let mut reached = vec![false; tree.nodes.len()];
        reached[0] = true;
        for (i, node) in tree.nodes.iter().enumerate() {
            assert!(reached[i], "{name}: node {i}");
            if node.is_leaf() {
                let primitive = tree.primitive_indices[node.first_index as usize] as usize;
                assert!(!std::mem::replace(&mut found[primitive], true), "{name}: primitive {primitive}");
            } else {
                let child = node.first_index as usize;
                assert!(child > i, "{name}: node {i}");
                (reached[child], reached[child + 1]) = (true, true);
            }
        }
        assert!(found.iter().all(|&found| found), "{name}");
        // A round that halves what is left would need 15; obvhs 0.4 needs about 10 000 for each of these.
        assert!(tree.max_depth <= 150, "{name}: {} rounds", tree.max_depth);
    }

    #[test]
    fn few_rounds_are_needed_also_where_few_agree() {
        const COUNT: usize = 20_000;
        let some = |f: &dyn Fn(f32) -> [Vec3A; 2]| -> Vec<Aabb> {
            (0..COUNT)
                .map(|i| f(i as f32 / COUNT as f32))
                .map(|[a, b]| Aabb::new(a.min(b), a.max(b)))
                .collect()
        };
        let around = |t: f32| Vec3A::new((TAU * t).cos(), (TAU * t).sin(), 0.0);
        check(&some(&|_| [Vec3A::ZERO, Vec3A::ONE]), "one place");
        check(&some(&|_| [Vec3A::ZERO; 2]), "one point");
        check(&some(&|t| [t * Vec3A::X, (t + 0.001) * Vec3A::X]), "a line");
        check(&some(&|t| [Vec3A::ZERO, around(t) + Vec3A::Z]), "a cone");
        check(&some(&|t| [Vec3A::ZERO, Vec3A::splat(t + 0.001)]), "boxes within boxes");
        check(&some(&|t| [Vec3A::ZERO, Vec3A::splat((10.0 * t).exp2())]), "boxes that grow");
        check(&some(&|t| [t * t * t * Vec3A::X; 2]), "points ever farther apart");
    }

    #[test]
    fn few_boxes_are_a_tree() {
        for count in [0, 1, 2, 3, 17] {
            let boxes: Vec<_> = (0..count).map(|i| Aabb::from_point(Vec3A::splat(i as f32))).collect();
            if count > 0 {
                check(&boxes, "few");
            } else {
                assert_eq!(cluster(&boxes).nodes.len(), 0);
            }
        }
    }
}
