//! What chance decides at the events of a walk, for eight events at once.
//!
//! Far from the boundary an event is little more than a free flight and a new direction, which depend on nothing that
//! happens: a logarithm, a square root, a sine and a cosine. Drawn one by one they are most of what an event costs,
//! drawn for eight events in vectors a small part of it. Directions are relative to the one before; where scattering is
//! isotropic they are just directions.

use crate::optics::HenyeyGreenstein;
use crate::sampling::lanes::{LANES, WideRng};
use crate::sampling::{SmallRng, fast_math};
use glam::Vec3;

/// The next events of a walk.
pub(super) struct Draws {
    phase: HenyeyGreenstein,
    rng: WideRng,
    next: usize,
    /// Free flights in mean free paths.
    flights: [f32; LANES],
    /// Coordinates of directions.
    directions: [[f32; LANES]; 3],
}

impl Draws {
    /// For a walk in a medium of that phase function.
    #[inline]
    pub fn new(phase: HenyeyGreenstein, rng: &mut SmallRng) -> Self {
        let (flights, directions) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let mut draws = Self { phase, rng: WideRng::new(rng), next: 0, flights, directions };
        draws.draw();
        draws
    }

    /// A free flight in mean free paths, with density e^{−t}, and the direction after it, where it was along the unit vector
    /// `before`.
    #[inline(always)]
    pub fn event(&mut self, before: Vec3) -> (f32, Vec3) {
        if self.next == LANES {
            self.draw();
            self.next = 0;
        }
        let i = self.next & (LANES - 1);
        self.next += 1;
        let [x, y, z] = &self.directions;
        let local = Vec3::new(x[i], y[i], z[i]);
        let direction = if self.phase.g == 0.0 {
            local
        } else {
            let (x, y) = before.any_orthonormal_pair();
            (x * local.x + y * local.y + before * local.z).normalize()
        };
        (self.flights[i], direction)
    }

    #[inline(never)]
    fn draw(&mut self) {
        // Loops: the compiler calls `map` as a function.
        let (way, height, turn) = (self.rng.open01(), self.rng.f32(), self.rng.f32());
        for (flight, way) in self.flights.iter_mut().zip(way) {
            *flight = -fast_math::ln(way);
        }
        let [x, y, z] = &mut self.directions;
        for i in 0..LANES {
            let (cos, sin) = self.phase.deflection(height[i]);
            let (sin_phi, cos_phi) = fast_math::sin_cos_turns(turn[i] - 0.5);
            (x[i], y[i], z[i]) = (sin * cos_phi, sin * sin_phi, cos);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of flights, of their squares, and of what directions share with the ones before; 4 standard errors.
    #[test]
    fn flights_are_exponential_and_directions_follow_the_phase_function() {
        for g in [0.0, 0.6, -0.3] {
            const N: u32 = 200_000;
            let mut draws = Draws::new(HenyeyGreenstein { g }, &mut SmallRng::new(3));
            let mut d = Vec3::X;
            let mut sums = [0.0_f64; 5];
            for _ in 0..N {
                let (t, next) = draws.event(d);
                assert!(t > 0.0 && (next.length() - 1.0).abs() < 1e-5, "{t} {next}");
                let cos = f64::from(next.dot(d));
                // What is left over is sideways of `d`, to no side more than to another.
                let side = f64::from(next.dot(d.any_orthonormal_vector()));
                for (sum, x) in sums.iter_mut().zip([f64::from(t), f64::from(t * t), cos, cos * cos, side]) {
                    *sum += x / f64::from(N);
                }
                d = next;
            }
            let g = f64::from(g);
            let expected = [(1.0, 1.0), (2.0, 20.0), (g, 0.4), ((1.0 + 2.0 * g * g) / 3.0, 0.15), (0.0, 0.4)];
            for (found, (mean, variance)) in sums.into_iter().zip(expected) {
                let error = (variance / f64::from(N)).sqrt();
                assert!((found - mean).abs() < 4.0 * error, "g {g}: {found} is not {mean}");
            }
        }
    }
}
