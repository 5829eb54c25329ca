//! Edges where solids touch: which of their triangles belong together.
//!
//! Two blocks that share a face, or only an edge, have edges of four triangles once equal positions are one. Around such
//! an edge, fronts tell on which side of each triangle material is: going around, material begins at one triangle and
//! ends at another. Where beginnings and ends take turns, each wedge of material is the edge of one solid.

use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// Directions around an edge that differ by less, radians, are one: faces that touch need not have equal triangles.
const SAME_DIRECTION: f64 = 1e-6;

/// A triangle at an edge: where its third corner is, and whether it runs along the edge from `low` to `high`.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub triangle: u32,
    pub corner: Vec3,
    pub upwards: bool,
}

/// Pairs of triangles between which there is material, if that is clear from their fronts.
pub(super) fn wedges([low, high]: [Vec3; 2], sides: &[Side]) -> Option<Vec<[u32; 2]>> {
    let up = sides.iter().filter(|side| side.upwards).count();
    if 2 * up != sides.len() {
        return None;
    }
    let axis = (high.as_dvec3() - low.as_dvec3()).try_normalize()?;
    let (x, y) = axis.any_orthonormal_pair();
    // Counter-clockwise, seen against the axis.
    let (x, y) = if x.cross(y).dot(axis) < 0.0 { (y, x) } else { (x, y) };
    let angle = |side: &Side| {
        let out: DVec3 = side.corner.as_dvec3() - low.as_dvec3();
        out.dot(y).atan2(out.dot(x))
    };
    let mut around: Vec<(f64, Side)> = sides.iter().map(|side| (angle(side), *side)).collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.triangle.cmp(&b.1.triangle)));
    // Begin after a gap, so that no group of one direction is cut.
    let n = around.len();
    let gap = |i: usize| {
        let (before, here) = (around[(i + n - 1) % n].0, around[i].0);
        if i == 0 { here - before + TAU } else { here - before }
    };
    let start = (0..n).find(|&i| gap(i) > SAME_DIRECTION)?;
    around.rotate_left(start);
    let turn = around[0].0;
    around.iter_mut().for_each(|(angle, _)| *angle = (*angle - turn).rem_euclid(TAU));
    // A triangle that runs upwards has its front, and so no material, on the side of larger angles.
    let mut ordered: Vec<Side> = Vec::with_capacity(n);
    for group in around.chunk_by(|a, b| b.0 - a.0 <= SAME_DIRECTION) {
        let ends = group.iter().filter(|(_, side)| side.upwards);
        let begins = group.iter().filter(|(_, side)| !side.upwards);
        ordered.extend(ends.chain(begins).map(|(_, side)| *side));
    }
    if (0..n).any(|i| ordered[i].upwards == ordered[(i + 1) % n].upwards) {
        return None;
    }
    let begins = (0..n).filter(|&i| !ordered[i].upwards);
    Some(begins.map(|i| [ordered[i].triangle, ordered[(i + 1) % n].triangle]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sides around the z axis: degrees, and whether material is at smaller angles.
    fn paired(sides: &[(f32, bool)]) -> Option<Vec<[u32; 2]>> {
        let side = |(triangle, &(degrees, upwards)): (u32, &(f32, bool))| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Side { triangle, corner: Vec3::new(cos, sin, 0.3), upwards }
        };
        let mut pairs = wedges([Vec3::ZERO, Vec3::Z], &(0..).zip(sides).map(side).collect::<Vec<_>>())?;
        pairs.sort_unstable();
        Some(pairs)
    }

    #[test]
    fn each_wedge_of_material_is_a_pair() {
        // Two blocks with an edge in common, and two with a face in common, in any order of triangles.
        assert_eq!(
            paired(&[(0.0, false), (90.0, true), (180.0, false), (270.0, true)]),
            Some(vec![[0, 1], [2, 3]])
        );
        let face = paired(&[(90.0, true), (0.0, false), (0.0, true), (-90.0, false)]);
        assert_eq!(face, Some(vec![[1, 0], [3, 2]]));
        // The common face where angles begin again.
        let face = paired(&[(180.0, true), (-180.0, false), (90.0, false), (-90.0, true)]);
        assert_eq!(face, Some(vec![[1, 3], [2, 0]]));
    }

    #[test]
    fn overlaps_and_odd_numbers_are_left_alone() {
        assert_eq!(paired(&[(0.0, false), (30.0, false), (60.0, true), (90.0, true)]), None);
        assert_eq!(paired(&[(0.0, false), (90.0, true), (180.0, false)]), None);
        assert_eq!(paired(&[(0.0, true), (90.0, true)]), None);
        assert_eq!(paired(&[]), None);
    }
}
