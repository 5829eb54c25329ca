//! Building a light tree from the top: each node is cut where the two halves are best kept apart, in space and in where
//! they shine: the surface area orientation heuristic of Conty Estevez & Kulla 2018, §4.4, in bins along each axis.
//!
//! | code | there |
//! | --- | --- |
//! | `flux` | energy of a cluster |
//! | `Cone::measure` | M_Ω |
//! | `size` | M_A, here the squared diagonal, which lights in a plane or a row have as well |
//! | `regularity` | K_r, keeps nodes from getting thin |

use super::tree::{LightBounds, Node};
use glam::Vec3;

/// Lights of a leaf at most.
const LEAF: usize = 4;
/// Cuts tried along an axis, plus 1.
const BINS: usize = 12;
/// Levels beyond log₂ n after which nodes are halved, so that no arrangement of lights makes a deep tree.
const TWICE_BALANCED: u32 = 8;

impl LightBounds {
    fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            cone: self.cone.union(&other.cone),
            flux: self.flux + other.flux,
            reach: self.reach.max(other.reach),
        }
    }

    fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }
}

fn union_of<'a>(lights: impl Iterator<Item = &'a LightBounds>) -> Option<LightBounds> {
    lights.copied().reduce(|a, b| a.union(&b))
}

/// Nodes, the root first, and the lights in the order of the leaves. `None` without lights.
pub(super) fn build(lights: &[LightBounds]) -> Option<(Vec<Node>, Vec<u32>)> {
    let all = union_of(lights.iter())?;
    let n = lights.len();
    let deepest = 2 * n.ilog2() + TWICE_BALANCED;
    let mut order: Vec<u32> = (0..n as u32).collect();
    let mut nodes = vec![Node::new(&all, 0, 0, 0)];
    let mut open = vec![(0usize, 0..n, 0u32, all)];
    while let Some((node, range, depth, bounds)) = open.pop() {
        let members = &mut order[range.clone()];
        if members.len() <= LEAF {
            nodes[node].first = range.start as u32;
            nodes[node].count = members.len() as u32;
            continue;
        }
        let cut = if depth < deepest { best_cut(lights, members, &bounds) } else { None };
        let middle = match cut {
            Some(cut) => {
                let (left, right): (Vec<u32>, Vec<u32>) =
                    members.iter().partition(|&&l| cut.is_left(&lights[l as usize]));
                members[..left.len()].copy_from_slice(&left);
                members[left.len()..].copy_from_slice(&right);
                left.len()
            }
            None => halve(lights, members),
        };
        let middle = range.start + middle;
        let first = nodes.len();
        nodes[node].first = first as u32;
        for (i, part) in [range.start..middle, middle..range.end].into_iter().enumerate() {
            let bounds = union_of(order[part.clone()].iter().map(|&l| &lights[l as usize]))?;
            nodes.push(Node::new(&bounds, node as u32, 0, 0));
            open.push((first + i, part, depth + 1, bounds));
        }
    }
    Some((nodes, order))
}

/// Splits into halves along the longest side; returns how many come first.
fn halve(lights: &[LightBounds], members: &mut [u32]) -> usize {
    let center = |l: u32| lights[l as usize].center();
    let low = members.iter().fold(Vec3::INFINITY, |a, &l| a.min(center(l)));
    let high = members.iter().fold(Vec3::NEG_INFINITY, |a, &l| a.max(center(l)));
    let axis = (high - low).max_position();
    let middle = members.len() / 2;
    members
        .select_nth_unstable_by(middle, |&a, &b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(&b)));
    middle
}

/// A plane between two bins.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    low: f32,
    scale: f32,
    /// The first bin on the right.
    bin: usize,
}

impl Cut {
    fn bin_of(&self, light: &LightBounds) -> usize {
        (((light.center()[self.axis] - self.low) * self.scale) as usize).min(BINS - 1)
    }

    fn is_left(&self, light: &LightBounds) -> bool {
        self.bin_of(light) < self.bin
    }
}

/// The cut of least cost; `None` where all lights are at one place.
fn best_cut(lights: &[LightBounds], members: &[u32], bounds: &LightBounds) -> Option<Cut> {
    let light = |l: &u32| &lights[*l as usize];
    let low = members.iter().fold(Vec3::INFINITY, |a, l| a.min(light(l).center()));
    let high = members.iter().fold(Vec3::NEG_INFINITY, |a, l| a.max(light(l).center()));
    let sides = bounds.high - bounds.low;
    let mut best: Option<(f32, Cut)> = None;
    for axis in 0..3 {
        let scale = BINS as f32 / (high[axis] - low[axis]);
        if !(scale > 0.0 && scale.is_finite()) {
            continue;
        }
        let cut = Cut { axis, low: low[axis], scale, bin: 0 };
        let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
        for l in members {
            let bin = &mut bins[cut.bin_of(light(l))];
            *bin = Some(bin.map_or(*light(l), |b| b.union(light(l))));
        }
        let regularity = sides.max_element() / sides[axis].max(f32::MIN_POSITIVE);
        for bin in 1..BINS {
            let part = |of: &[Option<LightBounds>]| union_of(of.iter().flatten());
            let (Some(left), Some(right)) = (part(&bins[..bin]), part(&bins[bin..])) else { continue };
            let cost = regularity * (cost(&left) + cost(&right));
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, Cut { bin, ..cut }));
            }
        }
    }
    best.map(|(_, cut)| cut)
}

fn cost(part: &LightBounds) -> f32 {
    let size = (part.high - part.low).length_squared();
    part.flux * part.cone.measure() * size
}
