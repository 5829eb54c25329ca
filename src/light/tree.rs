//! A light tree: choosing among thousands of lights in logarithmic time (Conty Estevez & Kulla 2018, "Importance Sampling
//! of Many Lights with Adaptive Tree Splitting"; Pharr, Jakob & Humphreys, 4th ed., §12.6.3).
//!
//! Lights are the leaves of a binary tree. Each node knows a box around its lights, their strength, and a cone that
//! holds all directions they shine in, so it can tell about how much of its light may reach a point:
//!
//! ```text
//! importance = flux · cos θ · cos θi / (d² + 0.2 r²)
//! ```
//!
//! with r the radius of the box, d the distance to its middle, and each cosine the mean of that of the middle and the
//! largest that anything in the sphere around the box can have. (Measured: bounds alone, with max(d², r²), have half as
//! much noise again among lights that are all around, and seven times the variance below the lamps of a hall.) It is zero
//! only where no light can arrive. A light is chosen by descending from the root, at each node in proportion to the
//! importance of its children; the last few of a leaf are weighed one by one, exactly as they are where a scene has only a
//! few lights. The probability of a given light is found on the way back, from its leaf to the root, through the same
//! function, so it is that of the descent, for the same point and normal.

use super::cone::Cone;
use super::mixture::Mixture;
use super::tree_build;
use crate::sampling::ONE_MINUS_EPSILON;
use glam::{Vec2, Vec3};

/// Cosines are this far from zero before a node counts as dark: rounding must not hide what is just visible.
const SLACK: f32 = 1e-3;
/// Smallest cosine that importance counts with: bounds are loose where light grazes.
const LEAST_COSINE: f32 = 0.02;
/// Part of a node's squared radius that is added to squared distances.
const SOFTENING: f32 = 0.2;
/// Importances above are cut, so that two of them have a finite sum.
const LARGEST: f32 = 1e37;
/// Resolution of the numbers that a light is selected with.
const RESOLUTION: f64 = 1.0 / 8_388_608.0;

/// What a tree has to know of a light, or of many.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// Corners of a box around it.
    pub low: Vec3,
    pub high: Vec3,
    /// Directions in which it shines.
    pub cone: Cone,
    /// Radiance × area or intensity: over the squared distance it is an irradiance. Channel mean, ≥ 0.
    pub flux: f32,
    /// Distance beyond which there is no light.
    pub reach: f32,
}

/// A node; children are neighbours in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    center: Vec3,
    half: Vec3,
    radius: f32,
    axis: Vec3,
    /// Of the cone: the angle that holds all axes, and how far beyond it light spreads.
    cos_axes: f32,
    sin_axes: f32,
    cos_spread: f32,
    two_sided: bool,
    flux: f32,
    reach: f32,
    pub parent: u32,
    /// First child, or first light in the order of leaves.
    pub first: u32,
    /// Lights of a leaf; 0: an inner node.
    pub count: u32,
}

impl Node {
    pub fn new(bounds: &LightBounds, parent: u32, first: u32, count: u32) -> Self {
        let half = 0.5 * (bounds.high - bounds.low);
        let Cone { axis, axes, spread, two_sided } = bounds.cone;
        Self {
            center: bounds.low + half,
            half,
            radius: half.length(),
            axis,
            cos_axes: axes.cos(),
            sin_axes: axes.sin(),
            cos_spread: spread.cos(),
            two_sided,
            flux: bounds.flux,
            reach: bounds.reach,
            parent,
            first,
            count,
        }
    }

    /// About the irradiance (fluence without a normal) at a point where nothing is in the way; zero only where no light
    /// can arrive.
    #[inline]
    fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        let from = point - self.center;
        let highest = |n: Vec3| n.abs().dot(self.half) - n.dot(from);
        if normal.is_some_and(|n| highest(n) < -SLACK * self.radius) {
            return 0.0;
        }
        let (squared, radius_squared) = (from.length_squared(), self.radius * self.radius);
        let attenuated = self.flux / (squared + SOFTENING * radius_squared).max(f32::MIN_POSITIVE);
        if squared <= radius_squared {
            return attenuated.min(LARGEST);
        }
        let distance = squared.sqrt();
        if distance - self.radius > self.reach {
            return 0.0;
        }
        let towards = from / distance;
        let sin_size = self.radius / distance;
        let cos_size = (1.0 - sin_size * sin_size).max(0.0).sqrt();
        let cos_axis = self.axis.dot(towards);
        let cos_axis = if self.two_sided { cos_axis.abs() } else { cos_axis };
        let (cos, sin) = less(cos_axis, sine(cos_axis), self.cos_axes, self.sin_axes);
        let (cos_out, _) = less(cos, sin, cos_size, sin_size);
        if cos_out < self.cos_spread - SLACK {
            return 0.0;
        }
        let mut shown = mean_cosine(cos, cos_out);
        if let Some(n) = normal {
            let cos = -n.dot(towards);
            let (cos_in, _) = less(cos, sine(cos), cos_size, sin_size);
            if cos_in < -SLACK {
                return 0.0;
            }
            shown *= mean_cosine(cos, cos_in);
        }
        (attenuated * shown).min(LARGEST)
    }
}

/// Of the middle and the most favourable place of a node.
#[inline]
fn mean_cosine(middle: f32, best: f32) -> f32 {
    (0.5 * (middle.max(0.0) + best)).max(LEAST_COSINE)
}

fn sine(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

/// Cosine and sine of max(0, a − b), for angles in \[0, π\].
#[inline]
fn less(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    if cos_a > cos_b {
        (1.0, 0.0)
    } else {
        (cos_a * cos_b + sin_a * sin_b, (sin_a * cos_b - cos_a * sin_b).max(0.0))
    }
}

/// A tree over lights 0 … n − 1.
#[derive(Clone, Debug)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// Lights in the order of leaves.
    order: Vec<u32>,
    /// Leaf of each light.
    leaf_of: Vec<u32>,
    /// δ of the choice within a leaf.
    defensive: f32,
}

impl LightTree {
    /// `defensive` is the share of a leaf's probability that is spread evenly. `None` without lights.
    pub fn new(lights: &[LightBounds], defensive: f32) -> Option<Self> {
        let (nodes, order) = tree_build::build(lights)?;
        let mut leaf_of = vec![0; lights.len()];
        for (i, node) in nodes.iter().enumerate() {
            let first = node.first as usize;
            order[first..first + node.count as usize].iter().for_each(|&l| leaf_of[l as usize] = i as u32);
        }
        Some(Self { nodes, order, leaf_of, defensive })
    }

    /// About the irradiance of all lights, as [`Node::importance`] has it.
    #[inline]
    pub fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        self.nodes[0].importance(point, normal)
    }

    /// A light and its probability; `None` where no light can arrive. `exact` weighs single lights: zero means impossible.
    #[inline]
    pub fn sample(
        &self,
        (point, normal): (Vec3, Option<Vec3>),
        mut u: f64,
        exact: impl Fn(usize) -> f32,
    ) -> Option<(usize, f32)> {
        let mut probability = 1.0;
        let mut at = 0;
        loop {
            let node = &self.nodes[at];
            if node.count > 0 {
                let u = (u as f32).clamp(0.0, ONE_MINUS_EPSILON);
                let (i, p, _) = self.leaf(node, exact).sample(u)?;
                let light = self.order[node.first as usize + i] as usize;
                probability *= p;
                return (probability >= f32::MIN_POSITIVE).then_some((light, probability));
            }
            let left = self.left(node, point, normal)?;
            at = node.first as usize;
            if u < f64::from(left) {
                u /= f64::from(left);
                probability *= left;
            } else {
                at += 1;
                u = (u - f64::from(left)) / (1.0 - f64::from(left));
                probability *= 1.0 - left;
            }
        }
    }

    /// The probability with which [`Self::sample`] chooses a light.
    #[inline]
    pub fn probability(
        &self,
        light: usize,
        (point, normal): (Vec3, Option<Vec3>),
        exact: impl Fn(usize) -> f32,
    ) -> f32 {
        let mut at = self.leaf_of[light];
        let leaf = &self.nodes[at as usize];
        let members = &self.order[leaf.first as usize..(leaf.first + leaf.count) as usize];
        let Some(i) = members.iter().position(|&l| l as usize == light) else { return 0.0 };
        let mut probability = self.leaf(leaf, exact).probability(i);
        while at != 0 && probability > 0.0 {
            let parent = self.nodes[at as usize].parent;
            let node = &self.nodes[parent as usize];
            let left = self.left(node, point, normal).unwrap_or(0.0);
            probability *= if at == node.first { left } else { 1.0 - left };
            at = parent;
        }
        probability
    }

    /// The probability of the first child; `None` where both are dark.
    #[inline]
    fn left(&self, node: &Node, point: Vec3, normal: Option<Vec3>) -> Option<f32> {
        let child = |i: u32| self.nodes[(node.first + i) as usize].importance(point, normal);
        let (a, b) = (child(0), child(1));
        (a + b > 0.0).then(|| a / (a + b))
    }

    #[inline]
    fn leaf(&self, node: &Node, exact: impl Fn(usize) -> f32) -> Mixture {
        let members = &self.order[node.first as usize..(node.first + node.count) as usize];
        Mixture::new(self.defensive, members.iter().map(|&l| exact(l as usize)))
    }
}

/// A number to select one of many lights with: that of the sampler has too few digits for some hundred thousand of them,
/// so it gets the last digits of the numbers that choose a point of the light, first digit last.
#[inline]
pub(super) fn finer(u: f32, spare: Vec2) -> f64 {
    let digits = |x: f32| ((x / RESOLUTION as f32) as u32).reverse_bits();
    let more = f64::from(digits(spare.x) ^ digits(spare.y).rotate_left(16)) / 4_294_967_296.0;
    (f64::from(u) + more * RESOLUTION).min(1.0 - f64::EPSILON)
}

#[cfg(test)]
#[path = "tree_tests.rs"]
mod tests;
