//! Cones of directions: where lights shine (Conty Estevez & Kulla 2018, §4.1; the union of two cones is that of Pharr,
//! Jakob & Humphreys, 4th ed., §3.8.4).

use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// All directions within `axes` + `spread` of an axis: every light's own axis is within the first angle, and it shines
/// within the second of its own axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Unit vector.
    pub axis: Vec3,
    /// Radians, in \[0, π\].
    pub axes: f32,
    /// Radians, in \[0, π\].
    pub spread: f32,
    /// Whether it shines in the opposite directions as well.
    pub two_sided: bool,
}

impl Cone {
    /// All directions.
    pub const SPHERE: Self = Self { axis: Vec3::Y, axes: PI, spread: FRAC_PI_2, two_sided: false };

    /// A cone that holds both.
    pub fn union(&self, other: &Self) -> Self {
        let (spread, two_sided) = (self.spread.max(other.spread), self.two_sided || other.two_sided);
        let cone = |axis, axes| Self { axis, axes, spread, two_sided };
        let opposed = self.axis.dot(other.axis) < 0.0 && two_sided;
        let other_axis = if opposed { -other.axis } else { other.axis };
        let between = self.axis.angle_between(other_axis);
        if (between + other.axes).min(PI) <= self.axes {
            // Turning the axis of a one-sided cone is allowed here, too: the union shines to both sides.
            return cone(self.axis, self.axes);
        }
        if (between + self.axes).min(PI) <= other.axes {
            return cone(other_axis, other.axes);
        }
        let axes = 0.5 * (self.axes + between + other.axes);
        let turn = self.axis.cross(other_axis).normalize_or_zero();
        if axes >= PI || turn == Vec3::ZERO {
            return cone(self.axis, PI);
        }
        cone(Quat::from_axis_angle(turn, axes - self.axes) * self.axis, axes)
    }

    /// How much of space it lights, for weighing splits (Conty Estevez & Kulla 2018, eq. 1): the solid angle of the axes,
    /// and beyond it what spreads, falling off with the cosine.
    pub fn measure(&self) -> f32 {
        let Self { axes, spread, .. } = *self;
        let widest = (axes + spread).min(PI);
        let (sin, cos) = axes.sin_cos();
        2.0 * PI * (1.0 - cos)
            + FRAC_PI_2 * (2.0 * widest * sin - (axes - 2.0 * widest).cos() - 2.0 * axes * sin + cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, warp};

    #[test]
    fn a_union_holds_what_its_parts_hold() {
        let mut rng = SmallRng::new(3);
        for _ in 0..2000 {
            let mut draw = || Cone {
                axis: warp::uniform_sphere(rng.vec2()),
                axes: PI * rng.f32() * rng.f32(),
                spread: FRAC_PI_2 * rng.f32(),
                two_sided: rng.f32() < 0.3,
            };
            let parts = [draw(), draw()];
            let union = parts[0].union(&parts[1]);
            for part in parts {
                let d = warp::uniform_sphere(rng.vec2());
                let inside = |c: &Cone, d: Vec3, slack: f32| {
                    let cos = if c.two_sided { c.axis.dot(d).abs() } else { c.axis.dot(d) };
                    cos.clamp(-1.0, 1.0).acos() <= c.axes + c.spread + slack
                };
                assert!(!inside(&part, d, 0.0) || inside(&union, d, 1e-3), "{d} {part:?} {union:?}");
            }
        }
    }

    #[test]
    fn measures_are_known_integrals() {
        // A Lambertian patch: ∫ cos over its hemisphere. A sphere of patches: 4π.
        let flat = Cone { axes: 0.0, ..Cone::SPHERE };
        assert!((flat.measure() - PI).abs() < 1e-5, "{}", flat.measure());
        assert!((Cone::SPHERE.measure() - 4.0 * PI).abs() < 1e-5, "{}", Cone::SPHERE.measure());
    }
}
