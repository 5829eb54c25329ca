//! An eight-wide bounding volume hierarchy, collapsed from the binary one that `obvhs` builds.
//!
//! `obvhs` (PLOC clustering, Meister & Bittner 2018, and parallel reinsertion, 2018) decides which primitives belong
//! together. It sees boxes scaled to the unit cube, so that its areas neither overflow nor vanish; the boxes stored
//! here are exact unions of the primitives' own. The binary tree becomes eight-wide by the dynamic programme of
//! Ylitie, Karras & Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs" (HPG 2017),
//! section 4.1, with full-precision boxes:
//!
//! | code | paper | meaning |
//! | --- | --- | --- |
//! | `cost[i - 1]` | C(n, i) | least cost of showing the subtree n as at most i roots |
//! | `split[j]` | argmin of C_distribute(n, j) | roots given to the left child when j are shared |
//!
//! A leaf holds up to `capacity` primitives and costs one test, since one block of lanes tests them all at once.

use super::huge_pages::{on_huge_pages, with_huge_pages};
use super::lanes::WIDTH;
use super::ray::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

/// Bit of a child reference that marks a leaf; the other bits are its block.
pub(super) const LEAF: u32 = 1 << 31;
/// The primitive of an unused lane of a block.
pub(super) const NONE: u32 = u32::MAX;

/// Primitives that fit into a block whatever they are.
const ANY: u32 = 4;
/// Part of the binary nodes that are tried elsewhere in the tree.
const REINSERTED: f32 = 0.02;
/// Price of testing a block of primitives, in visits of a node.
const BLOCK_COST: f32 = 1.0;

/// Eight child boxes and what they hold. An unused child has an empty box.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower x, y, z, upper x, y, z of each child.
    pub planes: [[f32; WIDTH]; 6],
    /// Index of a node, or of a block with [`LEAF`] set.
    pub children: [u32; WIDTH],
}

impl Node {
    const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [LEAF; WIDTH],
    };

    fn set(&mut self, slot: usize, bounds: &Aabb, child: u32) {
        for axis in 0..3 {
            self.planes[axis][slot] = bounds.min[axis];
            self.planes[3 + axis][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }
}

/// The nodes; node 0 is the root. There are none where there are no primitives.
#[derive(Clone)]
pub(super) struct WideBvh {
    pub nodes: Vec<Node>,
    pub bounds: Aabb,
    /// Most nodes on a path from the root.
    pub depth: usize,
}

/// Primitives of one leaf, [`NONE`] in unused lanes.
pub(super) type Block = [u32; WIDTH];

impl WideBvh {
    /// Builds over finite boxes, with `1 <= capacity <= 8` primitives a leaf, those which a block `holds`: any four, and
    /// of more some. Deterministic.
    pub fn build(boxes: &[Aabb], capacity: u32, holds: impl Fn(&[u32]) -> bool + Sync) -> (Self, Vec<Block>) {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
        if boxes.is_empty() {
            return (Self { nodes: Vec::new(), bounds, depth: 0 }, Vec::new());
        }
        let binary = build_binary(boxes, &bounds);
        Collapse::new(&binary, boxes, capacity, holds).run(bounds)
    }
}

/// The binary tree, one primitive a leaf. Only its topology is used.
fn build_binary(boxes: &[Aabb], bounds: &Aabb) -> Bvh2 {
    let center = bounds.center();
    let scale = 1.0 / bounds.extent().max_element().max(f32::MIN_POSITIVE);
    let unit = |p: Vec3| Vec3A::from((p - center) * scale);
    let scaled = |b: &Aabb| ScaledBox(obvhs::aabb::Aabb::new(unit(b.min), unit(b.max)));
    let mut primitives = with_huge_pages(boxes.len());
    boxes.par_iter().map(scaled).collect_into_vec(&mut primitives);
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &primitives,
        indices,
        SortPrecision::U64,
        2,
    );
    ReinsertionOptimizer::default().run(&mut tree, REINSERTED, None);
    tree
}

/// A box that `obvhs` accepts as a primitive.
struct ScaledBox(obvhs::aabb::Aabb);

impl obvhs::Boundable for ScaledBox {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

/// What the dynamic programme knows about a binary node.
#[derive(Clone, Copy)]
struct Plan {
    /// C(n, 1) … C(n, 7).
    cost: [f32; WIDTH - 1],
    /// Roots for the left child when j = 2 … 8 are shared; at index 1, zero for a leaf.
    split: [u8; WIDTH + 1],
    /// Bit i set: C(n, i) is C(n, i − 1).
    fewer: u8,
    bounds: Aabb,
}

struct Collapse<'a> {
    binary: &'a Bvh2,
    capacity: u32,
    /// Binary nodes, parents before children.
    order: Vec<u32>,
    plans: Vec<Plan>,
}

impl<'a> Collapse<'a> {
    fn new(binary: &'a Bvh2, boxes: &[Aabb], capacity: u32, holds: impl Fn(&[u32]) -> bool + Sync) -> Self {
        let mut order = with_huge_pages(binary.nodes.len());
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            order.push(index);
            let node = &binary.nodes[index as usize];
            if !node.is_leaf() {
                stack.push(node.first_index);
                stack.push(node.first_index + 1);
            }
        }
        let empty = Plan { cost: [0.0; 7], split: [0; 9], fewer: 0, bounds: Aabb::EMPTY };
        let mut plans = with_huge_pages(binary.nodes.len());
        plans.resize(binary.nodes.len(), empty);
        let mut this = Self { binary, capacity, order, plans };
        this.plan(boxes, holds);
        this
    }

    fn plan(&mut self, boxes: &[Aabb], holds: impl Fn(&[u32]) -> bool + Sync) {
        let binary = self.binary;
        let mut counts = vec![0_u32; binary.nodes.len()];
        for &index in self.order.iter().rev() {
            let index = index as usize;
            let node = &binary.nodes[index];
            if node.is_leaf() {
                counts[index] = 1;
                let bounds = boxes[binary.primitive_indices[node.first_index as usize] as usize];
                let plan = &mut self.plans[index];
                plan.bounds = bounds;
                plan.cost = [bounds.half_area() * BLOCK_COST; 7];
                continue;
            }
            let (left, right) = (node.first_index as usize, node.first_index as usize + 1);
            counts[index] = counts[left] + counts[right];
            let (l, r) = (self.plans[left], self.plans[right]);
            let bounds = l.bounds.union(r.bounds);
            let area = bounds.half_area();
            let mut plan = Plan { cost: [0.0; 7], split: [0; 9], fewer: 0, bounds };
            let mut distribute = [0.0_f32; WIDTH + 1];
            for (j, least) in distribute.iter_mut().enumerate().skip(2) {
                let mut best = (f32::INFINITY, 1);
                for k in 1..j {
                    let cost = l.cost[k - 1] + r.cost[j - k - 1];
                    if cost < best.0 {
                        best = (cost, k);
                    }
                }
                *least = best.0;
                plan.split[j] = best.1 as u8;
            }
            plan.cost[0] = distribute[WIDTH] + area;
            plan.split[1] = 1;
            if counts[index] <= self.capacity
                && plan.cost[0] >= area * BLOCK_COST
                && (counts[index] <= ANY || holds(&self.block(index as u32)[..counts[index] as usize]))
            {
                plan.cost[0] = area * BLOCK_COST;
                plan.split[1] = 0;
            }
            for (i, &cost) in distribute.iter().enumerate().take(WIDTH).skip(2) {
                plan.cost[i - 1] = cost;
                if cost >= plan.cost[i - 2] {
                    plan.cost[i - 1] = plan.cost[i - 2];
                    plan.fewer |= 1 << i;
                }
            }
            self.plans[index] = plan;
        }
    }

    /// Appends the at most `roots` binary nodes that stand for the subtree.
    fn gather(&self, index: u32, mut roots: usize, out: &mut Vec<u32>) {
        let node = &self.binary.nodes[index as usize];
        let plan = &self.plans[index as usize];
        while roots > 1 && plan.fewer & (1 << roots) != 0 {
            roots -= 1;
        }
        if node.is_leaf() || roots == 1 {
            out.push(index);
        } else {
            let k = plan.split[roots] as usize;
            self.gather(node.first_index, k, out);
            self.gather(node.first_index + 1, roots - k, out);
        }
    }

    fn block(&self, root: u32) -> Block {
        let mut block = [NONE; WIDTH];
        let mut filled = 0;
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index as usize];
            if node.is_leaf() {
                block[filled] = self.binary.primitive_indices[node.first_index as usize];
                filled += 1;
            } else {
                stack.push(node.first_index + 1);
                stack.push(node.first_index);
            }
        }
        block
    }

    fn run(&self, bounds: Aabb) -> (WideBvh, Vec<Block>) {
        let mut nodes = vec![Node::EMPTY];
        let mut blocks = Vec::new();
        let mut depth = 1;
        // (binary node, wide node to fill, its depth); children of a node lie side by side.
        let mut work = vec![(0_u32, 0_usize, 1_usize)];
        let mut roots = Vec::with_capacity(WIDTH);
        while let Some((index, slot, level)) = work.pop() {
            depth = depth.max(level);
            roots.clear();
            let node = &self.binary.nodes[index as usize];
            if node.is_leaf() || self.plans[index as usize].split[1] == 0 {
                // Only the root of the whole tree: every other leaf is placed by its parent.
                roots.push(index);
            } else {
                let k = self.plans[index as usize].split[WIDTH] as usize;
                self.gather(node.first_index, k, &mut roots);
                self.gather(node.first_index + 1, WIDTH - k, &mut roots);
            }
            let first = work.len();
            for (i, &root) in roots.iter().enumerate() {
                let plan = &self.plans[root as usize];
                let child = if plan.split[1] == 0 {
                    blocks.push(self.block(root));
                    LEAF | (blocks.len() - 1) as u32
                } else {
                    nodes.push(Node::EMPTY);
                    work.push((root, nodes.len() - 1, level + 1));
                    (nodes.len() - 1) as u32
                };
                nodes[slot].set(i, &plan.bounds, child);
            }
            work[first..].reverse();
        }
        (WideBvh { nodes: on_huge_pages(&nodes), bounds, depth }, blocks)
    }
}
