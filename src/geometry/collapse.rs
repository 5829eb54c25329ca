//! Which nodes of a binary hierarchy become the children of eight-wide ones, and which become leaves.
//!
//! The dynamic programme of Ylitie, Karras & Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs" (HPG 2017), section 4.1, with full-precision boxes:
//!
//! | code | paper | meaning |
//! | --- | --- | --- |
//! | `cost[i - 1]` | C(n, i) | least cost of showing the subtree n as at most i roots |
//! | `split(j)` | argmin of C_distribute(n, j) | roots given to the left child when j are shared |
//!
//! A leaf holds up to `capacity` primitives and costs one test, since one block of lanes tests them all at once.
//!
//! All plans are one array in depth-first order: the left child is next, the right one some places on. Subtrees below a
//! certain depth are *pieces* of it, which are planned in parallel; what is above them, the *top*, comes first. The depth
//! follows from the number of primitives, so threads make no difference.

use super::huge_pages::with_huge_pages;
use super::lanes::WIDTH;
use super::ray::Aabb;
use super::wide_bvh::{Block, NONE};
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use rayon::prelude::*;

/// Primitives that fit into a block whatever they are.
const ANY: usize = 4;
/// Price of testing a block of primitives, in visits of a node.
const BLOCK_COST: f32 = 1.0;
/// Primitives of a piece if the hierarchy is balanced.
const PIECE: usize = 64;
/// Hierarchies of fewer primitives have a top alone.
const LEAST: usize = 1024;

#[derive(Clone, Copy)]
enum Kind {
    /// A primitive; `link` is its index.
    Primitive,
    /// A node with children; `link` is the distance to the right one.
    Inner,
    /// In the top: the root of a piece, whose place is `link`.
    Piece,
}

/// What the programme knows about a binary node.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    /// C(n, 1) … C(n, 7).
    cost: [f32; WIDTH - 1],
    pub bounds: Aabb,
    link: u32,
    /// Roots for the left child when j = 2 … 8 are shared, in bits 4 (j - 1) to 4 j - 1.
    splits: u32,
    kind: Kind,
    /// Whether its primitives are one leaf.
    pub is_leaf: bool,
    /// Primitives below, or 255 if there are more.
    count: u8,
    /// Bit i set: C(n, i) is C(n, i − 1).
    fewer: u8,
}

impl Plan {
    fn primitive(index: u32, bounds: Aabb) -> Self {
        let cost = [bounds.half_area() * BLOCK_COST; WIDTH - 1];
        Self {
            cost,
            bounds,
            link: index,
            splits: 0,
            kind: Kind::Primitive,
            is_leaf: true,
            count: 1,
            fewer: 0,
        }
    }

    fn of(node: &Bvh2Node, binary: &Bvh2, boxes: &[Aabb]) -> Self {
        if !node.is_leaf() {
            return Self::unknown(Kind::Inner, 0);
        }
        let primitive = binary.primitive_indices[node.first_index as usize];
        Self::primitive(primitive, boxes[primitive as usize])
    }

    /// Not planned yet.
    fn unknown(kind: Kind, link: u32) -> Self {
        let bounds = Aabb::EMPTY;
        Self { cost: [0.0; 7], bounds, link, splits: 0, kind, is_leaf: false, count: 0, fewer: 0 }
    }

    fn split(&self, roots: usize) -> usize {
        (self.splits >> (4 * (roots - 1)) & 15) as usize
    }
}

/// The plans of all nodes. A place in it stands for a subtree.
pub(super) struct Plans {
    plans: Vec<Plan>,
    /// Length of the top.
    top: u32,
}

impl Plans {
    /// The place of the root.
    pub const ROOT: u32 = 0;

    /// Plans leaves of up to `capacity` primitives, those which a block `holds`.
    pub fn new(binary: &Bvh2, boxes: &[Aabb], capacity: u32, holds: impl Fn(&[u32]) -> bool + Sync) -> Self {
        let depth = if boxes.len() < LEAST { u32::MAX } else { (boxes.len() / PIECE).ilog2() };
        let (mut top, roots) = top(binary, boxes, depth);
        let lengths: Vec<usize> = roots.par_iter().map(|&root| length(binary, root)).collect();
        let mut end = top.len();
        let mut ends = lengths.iter().map(|length| {
            end += length;
            end
        });
        for plan in top.iter_mut().filter(|plan| matches!(plan.kind, Kind::Piece)) {
            let (number, end) = (plan.link as usize, ends.next().expect("every piece has a length"));
            plan.link = (end - lengths[number]) as u32;
        }
        let mut plans = with_huge_pages(end);
        let unknown = |_| Plan::unknown(Kind::Inner, 0);
        (0..end).into_par_iter().map(unknown).collect_into_vec(&mut plans);
        let (above, mut rest) = plans.split_at_mut(top.len());
        above.copy_from_slice(&top);
        let mut pieces = Vec::with_capacity(roots.len());
        for (&root, &length) in roots.iter().zip(&lengths) {
            let (piece, behind) = rest.split_at_mut(length);
            pieces.push((root, piece));
            rest = behind;
        }
        pieces.into_par_iter().for_each(|(root, piece)| {
            let length = piece.len();
            fill(binary, boxes, root, piece);
            plan_first(piece, length, capacity, &holds);
        });
        plan_first(&mut plans, top.len(), capacity, &holds);
        Self { plans, top: top.len() as u32 }
    }

    /// What is known about a subtree.
    pub fn at(&self, place: u32) -> &Plan {
        &self.plans[place as usize]
    }

    /// Whether a subtree lies within one piece.
    pub fn is_in_piece(&self, place: u32) -> bool {
        place >= self.top
    }

    /// Appends what becomes the children of a wide node, at most eight.
    pub fn children_of_wide(&self, place: u32, out: &mut Vec<u32>) {
        // Only the root of the whole hierarchy can be a leaf: others are placed by what is above them.
        match children(&self.plans, place).filter(|_| !self.at(place).is_leaf) {
            None => out.push(place),
            Some([left, right]) => {
                let k = self.at(place).split(WIDTH);
                self.gather(left, k, out);
                self.gather(right, WIDTH - k, out);
            }
        }
    }

    /// Appends the at most `roots` subtrees that stand for one.
    fn gather(&self, place: u32, mut roots: usize, out: &mut Vec<u32>) {
        let plan = self.at(place);
        while roots > 1 && plan.fewer & (1 << roots) != 0 {
            roots -= 1;
        }
        match children(&self.plans, place).filter(|_| roots > 1) {
            None => out.push(resolve(&self.plans, place)),
            Some([left, right]) => {
                let k = plan.split(roots);
                self.gather(left, k, out);
                self.gather(right, roots - k, out);
            }
        }
    }

    /// The primitives of a subtree that has at most eight.
    pub fn block(&self, place: u32) -> Block {
        block(&self.plans, place)
    }
}

/// Of a piece's root in the top, the root itself.
fn resolve(plans: &[Plan], place: u32) -> u32 {
    match plans[place as usize] {
        Plan { kind: Kind::Piece, link, .. } => link,
        _ => place,
    }
}

/// The children of an inner node; none of a primitive.
fn children(plans: &[Plan], place: u32) -> Option<[u32; 2]> {
    let place = resolve(plans, place);
    let Plan { kind, link, .. } = plans[place as usize];
    matches!(kind, Kind::Inner).then_some([place + 1, place + link])
}

/// The primitives of a subtree that has at most eight.
fn block(plans: &[Plan], place: u32) -> Block {
    let mut block = [NONE; WIDTH];
    let mut filled = 0;
    let mut stack = Vec::with_capacity(WIDTH);
    stack.push(place);
    while let Some(place) = stack.pop() {
        match children(plans, place) {
            Some([left, right]) => stack.extend([right, left]),
            None => {
                block[filled] = plans[resolve(plans, place) as usize].link;
                filled += 1;
            }
        }
    }
    block
}

/// The nodes down to a depth, and those where it ends, which are pieces with their numbers.
fn top(binary: &Bvh2, boxes: &[Aabb], depth: u32) -> (Vec<Plan>, Vec<u32>) {
    let mut plans: Vec<Plan> = Vec::new();
    let mut roots = Vec::new();
    // Of right children, the place of the parent.
    let mut stack = vec![(0, 0, None::<usize>)];
    while let Some((index, level, parent)) = stack.pop() {
        let here = plans.len();
        if let Some(parent) = parent {
            plans[parent].link = (here - parent) as u32;
        }
        let node = &binary.nodes[index as usize];
        if level == depth {
            plans.push(Plan::unknown(Kind::Piece, roots.len() as u32));
            roots.push(index);
        } else {
            plans.push(Plan::of(node, binary, boxes));
            if !node.is_leaf() {
                stack.push((node.first_index + 1, level + 1, Some(here)));
                stack.push((node.first_index, level + 1, None));
            }
        }
    }
    (plans, roots)
}

/// Number of nodes of a subtree.
fn length(binary: &Bvh2, root: u32) -> usize {
    let mut length = 0;
    let mut stack = vec![root];
    while let Some(index) = stack.pop() {
        length += 1;
        let node = &binary.nodes[index as usize];
        if !node.is_leaf() {
            stack.extend([node.first_index + 1, node.first_index]);
        }
    }
    length
}

/// Puts a subtree into its piece.
fn fill(binary: &Bvh2, boxes: &[Aabb], root: u32, piece: &mut [Plan]) {
    let mut stack = vec![(root, None::<usize>)];
    for here in 0..piece.len() {
        let (index, parent) = stack.pop().expect("the piece is as long as the subtree");
        if let Some(parent) = parent {
            piece[parent].link = (here - parent) as u32;
        }
        let node = &binary.nodes[index as usize];
        piece[here] = Plan::of(node, binary, boxes);
        if !node.is_leaf() {
            stack.extend([(node.first_index + 1, Some(here)), (node.first_index, None)]);
        }
    }
}

/// Plans the first `count` nodes, children before parents; pieces that lie behind have been planned.
fn plan_first(plans: &mut [Plan], count: usize, capacity: u32, holds: &impl Fn(&[u32]) -> bool) {
    for index in (0..count).rev() {
        let Plan { link, kind, .. } = plans[index];
        match kind {
            Kind::Primitive => {}
            Kind::Piece => plans[index] = Plan { kind, link, ..plans[link as usize] },
            Kind::Inner => {
                let (left, right) = (&plans[index + 1], &plans[index + link as usize]);
                let mut plan = Plan { link, ..combine(left, right) };
                let area = plan.bounds.half_area();
                let count = usize::from(plan.count);
                if count <= capacity as usize
                    && plan.cost[0] >= area * BLOCK_COST
                    && (count <= ANY || holds(&block(plans, index as u32)[..count]))
                {
                    plan.is_leaf = true;
                    plan.cost[0] = area * BLOCK_COST;
                }
                for i in 2..WIDTH {
                    if plan.cost[i - 1] >= plan.cost[i - 2] {
                        plan.cost[i - 1] = plan.cost[i - 2];
                        plan.fewer |= 1 << i;
                    }
                }
                plans[index] = plan;
            }
        }
    }
}

/// The costs of showing two subtrees together, as a leaf not yet.
fn combine(left: &Plan, right: &Plan) -> Plan {
    let bounds = left.bounds.union(right.bounds);
    let count = left.count.saturating_add(right.count);
    let mut plan = Plan { bounds, count, ..Plan::unknown(Kind::Inner, 0) };
    let mut distribute = [0.0_f32; WIDTH + 1];
    for (roots, least) in distribute.iter_mut().enumerate().skip(2) {
        let mut best = (f32::INFINITY, 1);
        for k in 1..roots {
            let cost = left.cost[k - 1] + right.cost[roots - k - 1];
            best = if cost < best.0 { (cost, k) } else { best };
        }
        *least = best.0;
        plan.splits |= (best.1 as u32) << (4 * (roots - 1));
    }
    plan.cost[1..].copy_from_slice(&distribute[2..WIDTH]);
    plan.cost[0] = distribute[WIDTH] + bounds.half_area();
    plan
}
