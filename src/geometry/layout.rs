//! Eight-wide nodes and their leaves, put where they stay.
//!
//! Subtrees within pieces of the plans are laid out in parallel, each in lines of its own behind those of the top.

use super::collapse::Plans;
use super::huge_pages::with_huge_pages;
use super::lines::{self, Line, Lined};
use super::wide_bvh::{Block, LEAF, Node};
use rayon::prelude::*;

/// The reference to be made to a subtree: child `slot` of the node at a line.
#[derive(Clone, Copy)]
struct Reference {
    node: u32,
    slot: usize,
}

/// A subtree left to others, below a number of nodes.
#[derive(Clone, Copy)]
struct Open {
    place: u32,
    reference: Reference,
    above: usize,
}

/// All lines, and the most nodes on a path from the root.
pub(super) fn lay_out<B: Lined>(plans: &Plans, leaf: impl Fn(&Block) -> B + Sync) -> (Vec<Line>, usize) {
    let left_open = |place| plans.is_in_piece(place);
    let mut top = Part::new(vec![Line::ZERO; length::<B>(plans, Plans::ROOT, left_open)], 0);
    top.fill(plans, Plans::ROOT, 1, &leaf, left_open);
    let lengths: Vec<usize> =
        top.open.par_iter().map(|open| length::<B>(plans, open.place, |_| false)).collect();
    let mut total = top.lines.len();
    for (&Open { reference: Reference { node, slot }, .. }, length) in top.open.iter().zip(&lengths) {
        lines::get_mut::<Node>(&mut top.lines, node).children[slot] = total as u32;
        total += length;
    }
    let mut all = with_huge_pages(total);
    (0..total).into_par_iter().map(|_| Line::ZERO).collect_into_vec(&mut all);
    let (above, mut rest) = all.split_at_mut(top.lines.len());
    above.copy_from_slice(&top.lines);
    let mut first = above.len() as u32;
    let mut parts = Vec::with_capacity(lengths.len());
    for (open, length) in top.open.iter().zip(lengths) {
        let (lines, behind) = rest.split_at_mut(length);
        parts.push((open, Part::new(lines, first)));
        first += length as u32;
        rest = behind;
    }
    let fill = |(open, mut part): (&Open, Part<&mut [Line]>)| {
        part.fill(plans, open.place, open.above + 1, &leaf, |_| false);
        part.depth
    };
    let depth = parts.into_par_iter().map(fill).max().unwrap_or(0);
    (all, depth.max(top.depth))
}

/// Lines that a subtree needs, without those within that are `left_open`.
fn length<B: Lined>(plans: &Plans, root: u32, left_open: impl Fn(u32) -> bool) -> usize {
    let mut length = 0;
    let mut work = vec![root];
    while let Some(place) = work.pop() {
        length += Node::LINES;
        let first = work.len();
        plans.children_of_wide(place, &mut work);
        let mut kept = first;
        for child in first..work.len() {
            let child = work[child];
            if plans.at(child).is_leaf {
                length += B::LINES;
            } else if !left_open(child) {
                work[kept] = child;
                kept += 1;
            }
        }
        work.truncate(kept);
    }
    length
}

/// Lines of a subtree.
struct Part<T> {
    lines: T,
    /// Number of the first line in the whole.
    first: u32,
    filled: u32,
    /// Most nodes on a path from the root of the whole.
    depth: usize,
    open: Vec<Open>,
}

impl<T: AsMut<[Line]>> Part<T> {
    fn new(lines: T, first: u32) -> Self {
        Self { lines, first, filled: 0, depth: 0, open: Vec::new() }
    }

    /// Appends a value; its line in this part.
    fn push<V: Lined>(&mut self, value: V) -> u32 {
        let at = self.filled;
        *lines::get_mut(self.lines.as_mut(), at) = value;
        self.filled += V::LINES as u32;
        at
    }

    /// Lays out a subtree; its root is the `level`-th node from that of the whole.
    fn fill<B: Lined>(
        &mut self,
        plans: &Plans,
        root: u32,
        level: usize,
        leaf: &impl Fn(&Block) -> B,
        left_open: impl Fn(u32) -> bool,
    ) {
        let mut children = Vec::with_capacity(8);
        let mut work = vec![(root, None::<Reference>, level)];
        while let Some((place, reference, level)) = work.pop() {
            self.depth = self.depth.max(level);
            let node = self.push(Node::EMPTY);
            if let Some(Reference { node: parent, slot }) = reference {
                lines::get_mut::<Node>(self.lines.as_mut(), parent).children[slot] = self.first + node;
            }
            children.clear();
            plans.children_of_wide(place, &mut children);
            let below = work.len();
            for (slot, &child) in children.iter().enumerate() {
                let plan = plans.at(child);
                let reference = Reference { node, slot };
                let mut line = LEAF;
                if plan.is_leaf {
                    line |= self.first + self.push(leaf(&plans.block(child)));
                } else if left_open(child) {
                    self.open.push(Open { place: child, reference, above: level });
                } else {
                    work.push((child, Some(reference), level + 1));
                }
                lines::get_mut::<Node>(self.lines.as_mut(), node).set(slot, &plan.bounds, line);
            }
            work[below..].reverse();
        }
    }
}
