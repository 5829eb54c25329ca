//! Light for a walk that meets its boundary: its last event is connected to light again.
//!
//! A walk that meets the boundary does so in one direction, which light sampling there cannot change. The last event x
//! could as well have sent it in others. With π(ω) = p(ω) T(ω), the probability density that the walk turns to ω at x and
//! then reaches a surface, a walk that does has the direction ω* with density π(ω*)/P, P = ∫ π. Let C be the light found by
//! aiming from x ([`super::Aim`]), an estimate of what all directions find. Added at each event it would be full of the
//! chance of how often a walk comes near the boundary. Added where the boundary is met it has to be C/P. P is not known, but
//! for any density κ of directions
//!
//! ```text
//! E[κ(ω*)/π(ω*)] = ∫ (π/P) (κ/π) dω = 1/P,                                                           (1)
//! ```
//!
//! and as ω* tells nothing about C, κ(ω*)/π(ω*) · C is unbiased, if π > 0 wherever κ > 0: every direction meets something in
//! a closed object. It has little noise where κ looks like π.
//!
//! **The density.** Through a plane at the depth τ (in mean free paths), light under the cosine µ to its normal arrives
//! with e^{−τ/µ} ≈ e^{−τ} µ^τ for µ not too small, so
//!
//! ```text
//! κ(ω) = (τ + 1) µ^τ / (2π (1 − b^{τ+1})),   µ > b.                                                  (2)
//! ```
//!
//! Channels have a τ each, and are mixed as they share in the walk: T is the mixture that free flights are drawn from.

use super::spectral::Coefficients;
use crate::optics::HenyeyGreenstein;
use crate::sampling::fast_math;
use glam::{Vec3, Vec3A};
use std::f32::consts::TAU;

/// b. Measured: lower means more connections of less weight each.
const LOWEST: f32 = 0.6;
/// Mean of 1/µ above b.
const SLANT: f32 = 1.25;

/// The last event of a walk that has met a surface, in the units of the walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastEvent {
    /// Direction of travel before it.
    pub incoming: Vec3,
    /// Outward unit normal of the boundary near by.
    pub normal: Vec3,
    /// Its distance.
    pub depth: f32,
    pub phase: HenyeyGreenstein,
    sigma_t: Vec3A,
    /// Probability of each channel to draw the next free flight.
    channels: Vec3A,
}

impl LastEvent {
    /// `channels`: probability of each to draw the flight after the event; a boundary of that normal is at that depth.
    pub fn new(c: &Coefficients, channels: Vec3A, incoming: Vec3, (normal, depth): (Vec3, f32)) -> Self {
        Self { incoming, normal, depth, phase: c.phase, sigma_t: c.sigma_t, channels }
    }

    /// π: density to turn to `direction` and reach what is at a distance.
    pub fn density(&self, direction: Vec3, distance: f32) -> f32 {
        let through = fast_math::exp_negative(-self.sigma_t * distance);
        self.phase.eval_directions(self.incoming, direction) * (self.channels * through).element_sum()
    }

    /// Estimate of P: how often an event like this is connected.
    pub fn rate(&self) -> f32 {
        let facing = self.phase.eval_directions(self.incoming, self.normal);
        (TAU * (1.0 - LOWEST) * facing * self.reached().element_sum()).min(1.0)
    }

    /// κ/π for the direction that the walk took, and the distance of what it met.
    pub fn weight(&self, direction: Vec3, distance: f32) -> f32 {
        let mu = direction.dot(self.normal);
        if mu <= LOWEST {
            return 0.0;
        }
        let weight = self.kappa(mu) / self.density(direction, distance);
        if weight.is_finite() { weight } else { 0.0 }
    }

    /// How much of each channel reaches the boundary.
    fn reached(&self) -> Vec3A {
        self.channels * fast_math::exp_negative(-SLANT * self.sigma_t * self.depth)
    }

    /// (2) at the cosine `mu` > b.
    fn kappa(&self, mu: f32) -> f32 {
        let weights = self.reached();
        let tau = self.sigma_t * self.depth;
        let power =
            |base: f32, exponent: Vec3A| fast_math::exp_negative(exponent * fast_math::ln(base.min(1.0)));
        let each = (tau + 1.0) * power(mu, tau) / (Vec3A::ONE - power(LOWEST, tau + 1.0));
        (weights * each).element_sum() / (TAU * weights.element_sum())
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectral::draw_flight;
    use super::super::steps::redirect;
    use super::*;
    use crate::sampling::SmallRng;

    #[test]
    fn weights_of_arrivals_are_one_on_average() {
        // Σ over arrivals of κ/π, per event, is (1) times P: 1, for any distance, phase function and mixture of channels.
        // 4 standard errors.
        let channels = Vec3A::new(0.5, 0.3, 0.2);
        for (sigma_s, g, depth) in [
            (Vec3::new(1.0, 1.0, 1.0), 0.0, 0.3),
            (Vec3::new(1.0, 2.0, 6.0), 0.0, 1.2),
            (Vec3::new(3.0, 1.0, 0.5), 0.5, 0.7),
            (Vec3::new(2.0, 2.0, 2.0), -0.3, 0.01),
        ] {
            let c = Coefficients::new(Vec3::splat(0.1), sigma_s, g, 1.0);
            let incoming = Vec3::new(0.6, 0.0, 0.8);
            let last = LastEvent::new(&c, channels, incoming, (Vec3::Z, depth));
            let mut rng = SmallRng::new(11);
            const N: u32 = 2_000_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..N {
                let direction = redirect(c.phase, incoming, &mut rng);
                let (_, mean_free_path) = c.draw_channel(channels, &mut rng);
                let distance = depth / direction.z;
                if direction.z > 0.0 && draw_flight(&mut rng) * mean_free_path >= distance {
                    let weight = f64::from(last.weight(direction, distance));
                    sum += weight;
                    squares += weight * weight;
                }
            }
            let n = f64::from(N);
            let mean = sum / n;
            let error = ((squares / n - mean * mean) / n).sqrt();
            assert!((mean - 1.0).abs() < 4.0 * error, "{sigma_s} {g} {depth}: {mean} ± {error}");
            // The rarest of them arrives with one walk in a thousand.
            assert!(error < 0.02, "{sigma_s} {g} {depth}: ± {error}");
        }
    }
}
