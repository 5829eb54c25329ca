//! Weights of the techniques that find the same light: the power heuristic (Veach & Guibas 1995, eq. 15).
//!
//! Light that reaches a vertex from direction ω_o is found by up to three techniques:
//!
//! | | technique | density |
//! | --- | --- | --- |
//! | a | light sampling at the vertex | `light` |
//! | b | a scattered ray that happens to meet the light | `chance` |
//! | c | the vertex is a boundary met from inside, and the direction to it was aimed ([`crate::subsurface::Aim`]) | r × a where aiming samples light, r × b where it scatters on |
//!
//! Where every path has its aimed connection, light that chance can find is not sampled at the boundary, too
//! (`Aimed::alone`): a shadow ray for nearly nothing.
//!
//! Densities are relative to that of the path up to the vertex, which all share but for the ratio r.

use crate::subsurface::Aimed;
use glam::Vec3;

/// The densities of the techniques.
#[derive(Clone, Copy, Debug)]
pub(super) struct Techniques {
    light: f32,
    chance: f32,
    aimed: f32,
}

impl Techniques {
    /// For light from the unit direction `outside`. Where the scattering is a delta, or lights are not sampled, `light` is
    /// 0 and `chance` 1.
    #[inline]
    pub fn new(aimed: &Aimed, outside: Vec3, light: f32, chance: f32) -> Self {
        let base = if aimed.samples_light() { light } else { chance };
        let ratio = if aimed.is_none() { 0.0 } else { aimed.ratio(outside) };
        let light = if aimed.alone && chance > 0.0 { 0.0 } else { light };
        Self { light, chance, aimed: base * ratio }
    }

    /// The weight of light sampling.
    #[inline]
    pub fn weigh_light(&self) -> f32 {
        self.weigh(self.light)
    }

    /// The weight of a scattered ray.
    #[inline]
    pub fn weigh_chance(&self) -> f32 {
        self.weigh(self.chance)
    }

    /// The weight of an aimed direction.
    #[inline]
    pub fn weigh_aimed(&self) -> f32 {
        self.weigh(self.aimed)
    }

    #[inline]
    fn weigh(&self, used: f32) -> f32 {
        // Relative to the largest, so that no square overflows.
        let scale = self.light.max(self.chance).max(self.aimed).recip();
        let square = |d: f32| (d * scale) * (d * scale);
        square(used) / (square(self.light) + square(self.chance) + square(self.aimed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_survive_extremes() {
        for light in [0.0, 1e-30, 0.3, 1e30] {
            for chance in [1e-30, 1.0, 1e30] {
                let t = Techniques::new(&Aimed::default(), Vec3::Z, light, chance);
                let sum = t.weigh_light() + t.weigh_chance() + t.weigh_aimed();
                assert!((sum - 1.0).abs() < 1e-6, "{t:?}: {sum}");
                let t = Techniques { light, chance, aimed: 7.0 };
                let sum = t.weigh_light() + t.weigh_chance() + t.weigh_aimed();
                assert!((sum - 1.0).abs() < 1e-6, "{t:?}: {sum}");
            }
        }
    }
}
