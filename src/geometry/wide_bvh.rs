//! An eight-wide bounding volume hierarchy, collapsed from a binary one.
//!
//! `clustering` and the parallel reinsertion of `obvhs` (Meister & Bittner 2018) decide which primitives belong together. They
//! see boxes scaled to the unit cube, so that areas neither overflow nor vanish; the boxes stored here are exact unions of the
//! primitives' own. `collapse` makes the binary tree eight-wide, `layout` puts nodes and leaves
//! into memory.

use super::clustering::cluster;
use super::collapse::Plans;
use super::huge_pages::with_huge_pages;
use super::lanes::WIDTH;
use super::layout::lay_out;
use super::lines::{Line, Lined};
use super::ray::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Bit of a child reference that marks a leaf; the other bits are its first line.
pub(super) const LEAF: u32 = 1 << 31;
/// The primitive of an unused lane of a block.
pub(super) const NONE: u32 = u32::MAX;

/// Part of the binary nodes that are tried elsewhere in the tree.
const REINSERTED: f32 = 0.02;

/// Eight child boxes and what they hold. An unused child has an empty box.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower x, y, z, upper x, y, z of each child.
    pub planes: [[f32; WIDTH]; 6],
    /// First line of a node, or of a leaf with [`LEAF`] set.
    pub children: [u32; WIDTH],
}

// SAFETY: numbers alone, four lines of them.
unsafe impl Lined for Node {}

impl Node {
    pub const EMPTY: Self = Self {
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

    pub fn set(&mut self, slot: usize, bounds: &Aabb, child: u32) {
        for axis in 0..3 {
            self.planes[axis][slot] = bounds.min[axis];
            self.planes[3 + axis][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }
}

/// Nodes, and leaves of type `B`; the root is first. There are none where there are no primitives.
#[derive(Clone)]
pub(super) struct WideBvh<B> {
    pub lines: Vec<Line>,
    pub bounds: Aabb,
    /// Most nodes on a path from the root.
    pub depth: usize,
    leaves: PhantomData<B>,
}

/// Primitives of one leaf, [`NONE`] in unused lanes.
pub(super) type Block = [u32; WIDTH];

impl<B: Lined> WideBvh<B> {
    /// Builds over finite boxes, with `1 <= capacity <= 8` primitives a leaf, those which a block `holds`: any four, and
    /// of more some. Deterministic.
    pub fn build(
        boxes: &[Aabb],
        capacity: u32,
        holds: impl Fn(&[u32]) -> bool + Sync,
        leaf: impl Fn(&Block) -> B + Sync,
    ) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
        let (lines, depth) = if boxes.is_empty() {
            (Vec::new(), 0)
        } else {
            let plans = Plans::new(&build_binary(boxes, &bounds), boxes, capacity, holds);
            lay_out(&plans, leaf)
        };
        Self { lines, bounds, depth, leaves: PhantomData }
    }
}

/// The binary tree, one primitive a leaf. Only its topology is used.
fn build_binary(boxes: &[Aabb], bounds: &Aabb) -> Bvh2 {
    let center = bounds.center();
    let scale = 1.0 / bounds.extent().max_element().max(f32::MIN_POSITIVE);
    let unit = |p: Vec3| Vec3A::from((p - center) * scale);
    let scaled = |b: &Aabb| obvhs::aabb::Aabb::new(unit(b.min), unit(b.max));
    let mut primitives = with_huge_pages(boxes.len());
    boxes.par_iter().map(scaled).collect_into_vec(&mut primitives);
    let mut tree = cluster(&primitives);
    ReinsertionOptimizer::default().run(&mut tree, REINSERTED, None);
    tree
}
