//! The inversion of [`seen_color`](super::seen_color) for pictures: millions of colours behind one boundary.
//!
//! The seen colour C is a smooth, falling function of van de Hulst's s from 1 at s = 0 to 0 at s = 1. It is computed at
//! steps of s that are small at both ends, and s(C) is interpolated between them by cubics that keep it monotone (Fritsch &
//! Carlson 1980), through both ends. Near white 1 − C is nearly linear in s, and near black C is in 1 − s, so that the share of absorption, s² and
//! more, is accurate where it is small, and so is that of scattering.

use super::diffusion::discrete_ordinates::HalfSpace;
use rayon::prelude::*;

/// Steps of s. The tests have the error.
const STEPS: usize = 96;

/// s(C) behind one boundary.
#[derive(Clone, Debug)]
pub struct SeenColorTable {
    g: f64,
    /// C, s, and ds/dC at the nodes, C rising.
    nodes: Vec<[f64; 3]>,
}

impl SeenColorTable {
    /// For mean cosine `g` in (−1, 1) and relative index `eta` ≥ 1.
    pub fn new(g: f64, eta: f64) -> Self {
        let half_space = HalfSpace::new(g, eta);
        let of_step = |i: usize| {
            let t = i as f64 / STEPS as f64;
            let s = t * t * (3.0 - 2.0 * t);
            let color = match i {
                0 => 1.0,
                STEPS => 0.0,
                _ => half_space.color(absorbed(s, g)).normal,
            };
            [color, s, 0.0]
        };
        let mut nodes: Vec<[f64; 3]> = (0..STEPS + 1).into_par_iter().rev().map(of_step).collect();
        nodes.dedup_by(|next, kept| next[0] <= kept[0]);
        let slopes = slopes(&nodes);
        nodes.iter_mut().zip(slopes).for_each(|(node, slope)| node[2] = slope);
        Self { g, nodes }
    }

    /// σs/σt and σa/σt of the medium that shows the colour `color` in \[0, 1\] (clamped), as
    /// [`shares_of_seen_color`](super::seen_color::shares_of_seen_color) has them. No number counts as black.
    pub fn shares(&self, color: f64) -> [f64; 2] {
        let color = if color.is_nan() { 0.0 } else { color.clamp(0.0, 1.0) };
        let above = self.nodes.partition_point(|node| node[0] <= color).clamp(1, self.nodes.len() - 1);
        let ([c0, s0, d0], [c1, s1, d1]) = (self.nodes[above - 1], self.nodes[above]);
        let h = c1 - c0;
        let t = (color - c0) / h;
        let u = 1.0 - t;
        // Hermite's cubic, from the end that is nearer, so that s is exact there and its small values keep their digits.
        let s = s0 * u * u * (1.0 + 2.0 * t) + s1 * t * t * (1.0 + 2.0 * u) + h * t * u * (d0 * u - d1 * t);
        let s = s.clamp(s1, s0);
        let share = absorbed(s, self.g);
        // 1 − share, without its cancellation near black.
        [(1.0 - s) * (1.0 + s) / (1.0 - self.g * s * s), share]
    }
}

/// Share of absorption of van de Hulst's s.
fn absorbed(s: f64, g: f64) -> f64 {
    s * s * (1.0 - g) / (1.0 - g * s * s)
}

/// Slopes of a monotone cubic through the nodes: weighted harmonic means of those of the neighbouring chords, and
/// three-point formulas at the ends.
fn slopes(nodes: &[[f64; 3]]) -> Vec<f64> {
    let n = nodes.len();
    let width = |i: usize| nodes[i + 1][0] - nodes[i][0];
    let chord = |i: usize| (nodes[i + 1][1] - nodes[i][1]) / width(i);
    let end = |a: usize, b: usize| {
        let (h, k) = (width(a), width(b));
        let slope = ((2.0 * h + k) * chord(a) - h * chord(b)) / (h + k);
        if slope * chord(a) <= 0.0 {
            0.0
        } else if slope.abs() > 3.0 * chord(a).abs() {
            3.0 * chord(a)
        } else {
            slope
        }
    };
    (0..n)
        .map(|i| match i {
            _ if n < 3 => chord(0),
            0 => end(0, 1),
            i if i == n - 1 => end(n - 2, n - 3),
            i => {
                let (a, b) = (2.0 * width(i) + width(i - 1), width(i) + 2.0 * width(i - 1));
                (a + b) / (a / chord(i - 1) + b / chord(i))
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::seen_color::{seen_color, shares_of_seen_color};

    /// Both shares against the inversion by root finding, each relative to itself, which is what a coefficient is off by,
    /// and the colour that comes back: a thirtieth of the smallest step of an 8-bit sRGB colour.
    #[test]
    fn the_table_is_the_inversion() {
        for (g, eta) in [(0.0, 1.5), (0.85, 1.4), (-0.4, 1.0)] {
            let table = SeenColorTable::new(g, eta);
            for color in [0.003, 0.02, 0.1234, 0.4, 0.7, 0.91, 0.985, 0.998] {
                let (found, exact) = (table.shares(color), shares_of_seen_color(color, g, eta));
                for i in 0..2 {
                    assert!(
                        (found[i] / exact[i] - 1.0).abs() < 5e-4,
                        "{color} {g} {eta} [{i}]: {found:?} {exact:?}"
                    );
                }
                let back = seen_color(found[0], g, eta);
                assert!((back - color).abs() < 1e-5, "{color} {g} {eta}: {back}");
            }
            assert_eq!(table.shares(1.0), [1.0, 0.0]);
            assert_eq!(table.shares(0.0), [0.0, 1.0]);
            assert_eq!((table.shares(7.0), table.shares(f64::NAN)), ([1.0, 0.0], [0.0, 1.0]));
        }
    }
}
