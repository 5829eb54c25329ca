//! Is a point inside a closed mesh?
//!
//! The winding number (Jacobson et al. 2013 in its integer form) is the sum of signed crossings along any ray. A ray
//! through an edge, or one that grazes, can count wrongly, so three rays vote, and more where they disagree. Points in
//! a cavity (a reversed surface inside another) have winding number zero and are outside of the material.

use super::mesh::MeshGeometry;
use super::ray::{MeshHit, Ray};
use glam::Vec3;

/// Directions without rational relation to each other or to the axes, normalised where used.
pub(super) const DIRECTIONS: [Vec3; 7] = [
    Vec3::new(0.302_775_6, 0.618_034, 0.725_493_1),
    Vec3::new(-0.741_657_4, 0.236_068, 0.627_871_9),
    Vec3::new(0.414_213_6, -0.732_050_8, -0.540_827_3),
    Vec3::new(-0.571_428_3, -0.449_489_7, 0.686_540_6),
    Vec3::new(0.845_299_5, 0.316_624_8, -0.430_501_6),
    Vec3::new(-0.162_277_7, 0.874_032_1, -0.458_257_6),
    Vec3::new(0.099_019_5, -0.358_898_9, 0.928_128_7),
];

impl MeshGeometry {
    /// Whether a closed mesh encloses the point: its winding number about it is not zero.
    ///
    /// On the surface either answer may come. For a mesh that is not closed it is the majority's opinion.
    pub fn contains(&self, p: Vec3) -> bool {
        self.winding_number(p) != 0
    }

    /// How often a closed mesh winds about the point: 0 outside, 1 in a solid, 2 where two parts overlap, −1 in one that is
    /// inside out.
    ///
    /// As with [`Self::contains`], an answer on the surface means nothing, and that of an open mesh is the majority's.
    pub fn winding_number(&self, p: Vec3) -> i32 {
        if !self.bounds().contains(p) {
            return 0;
        }
        let mut hits = Vec::new();
        let mut answers = DIRECTIONS.map(|_| 0);
        for (i, direction) in DIRECTIONS.iter().enumerate() {
            answers[i] = self.winding(p, direction.normalize(), &mut hits);
            if i == 2 && answers[0] == answers[1] && answers[1] == answers[2] {
                return answers[0];
            }
        }
        answers.sort_unstable();
        answers[DIRECTIONS.len() / 2]
    }

    /// Signed crossings of triangles along a ray: +1 on leaving through a front, −1 on entering.
    fn winding(&self, p: Vec3, direction: Vec3, hits: &mut Vec<MeshHit>) -> i32 {
        self.intersect_all(&Ray::new(p, direction), hits);
        let sign =
            |hit: &MeshHit| if self.geometric_normal(hit.triangle).dot(direction) > 0.0 { 1 } else { -1 };
        hits.iter().map(sign).sum()
    }
}

/// The answer of three directions if they agree, else the majority's of seven.
pub(super) fn vote(mut ask: impl FnMut(Vec3) -> bool) -> bool {
    let mut yes = 0;
    for (i, direction) in DIRECTIONS.iter().enumerate() {
        yes += usize::from(ask(direction.normalize()));
        if i == 2 && (yes == 0 || yes == 3) {
            return yes == 3;
        }
    }
    2 * yes > DIRECTIONS.len()
}
