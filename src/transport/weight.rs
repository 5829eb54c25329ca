//! Weights of the techniques that find the same light: the power heuristic (Veach & Guibas 1995, eq. 15).
//!
//! Light that reaches a vertex from direction ω_o is found by up to three techniques:
//!
//! | | technique | density |
//! | --- | --- | --- |
//! | a | light sampling at the vertex | `light` |
//! | b | a scattered ray that happens to meet the light | `chance` |
//! | c | the vertex is a boundary met from inside, and the direction to it was aimed ([`crate::subsurface::Aim`]) | r × that of choosing the point of the light at the event, where aiming samples light; r × b where it scatters on |
//!
//! Where every path has its aimed connection, light that chance can find is not sampled at the boundary, too
//! (`Aimed::alone`): a shadow ray for nearly nothing.
//!
//! Densities are relative to that of the path up to the vertex, which all share but for the ratio r.

use super::path::PathTracer;
use super::state::Vertex;
use crate::light::LightPoint;
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
    /// Where the scattering is a delta, or lights are not sampled, `light` is 0 and `chance` 1. Densities that
    /// overflowed are the largest.
    #[inline]
    pub fn new(light: f32, chance: f32, aimed: f32) -> Self {
        let [light, chance, aimed] = [light, chance, aimed].map(|density| density.min(f32::MAX));
        Self { light, chance, aimed }
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
        if used <= 0.0 {
            return 0.0;
        }
        // Relative to the largest, so that no square overflows.
        let scale = self.light.max(self.chance).max(self.aimed).recip();
        let square = |d: f32| (d * scale) * (d * scale);
        square(used) / (square(self.light) + square(self.chance) + square(self.aimed))
    }
}

impl PathTracer<'_> {
    /// The density of technique c for a point of a light that is seen from `from`; that of a scattered ray is `chance`.
    #[inline]
    pub(super) fn aimed_density(
        &self,
        aimed: &Aimed,
        point: Option<&LightPoint>,
        from: Vec3,
        chance: f32,
    ) -> f32 {
        let Some(anchor) = aimed.anchor() else { return aimed.scattered_on() * chance };
        let lights = &self.scene.lights;
        let Some(point) = point else { return 0.0 };
        let density = lights.density_at(&anchor, point, from);
        if density <= 0.0 {
            return 0.0;
        }
        let Some(outside) = lights.direction_to(point, anchor.point) else { return 0.0 };
        density * self.resolved(*aimed, outside).ratio()
    }

    /// The weight of light that a ray from a vertex has met by chance; no point of a light is light that is never sampled.
    #[inline]
    pub(super) fn weigh_chance(&self, v: &Vertex, point: Option<LightPoint>) -> f32 {
        let (light, chance) = match &point {
            // Left to aiming.
            Some(_) if v.connected && v.aimed.alone => (0.0, v.pdf),
            Some(point) if v.connected => {
                (v.lights * self.scene.lights.density_at(&v.anchor, point, v.point), v.pdf)
            }
            _ => (0.0, 1.0),
        };
        let aimed = self.aimed_density(&v.aimed, point.as_ref(), v.point, chance);
        Techniques::new(light, chance, aimed).weigh_chance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_survive_extremes() {
        for light in [0.0, 1e-30, 0.3, 1e30, f32::INFINITY] {
            for chance in [1e-30, 1.0, 1e30, f32::INFINITY] {
                let t = Techniques::new(light, chance, 0.0);
                let sum = t.weigh_light() + t.weigh_chance() + t.weigh_aimed();
                assert!((sum - 1.0).abs() < 1e-6, "{t:?}: {sum}");
                let t = Techniques::new(light, chance, 7.0);
                let sum = t.weigh_light() + t.weigh_chance() + t.weigh_aimed();
                assert!((sum - 1.0).abs() < 1e-6, "{t:?}: {sum}");
            }
        }
    }
}
