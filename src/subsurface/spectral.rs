//! Free flights through a homogeneous medium whose channels differ: spectral multiple importance sampling.
//!
//! A channel c is drawn with probability p_c = β_c/Σβ and keeps to be used for a stretch of a few events:
//! free flights come from σt_c e^{−σt_c t}. n collisions and a length L in all, the last part of which may end at a
//! boundary instead of a collision, then have density σt_c^n e^{−σt_c L}, and the balance heuristic over the channels
//! (spectral MIS) weighs the stretch with
//!
//! ```text
//! β_k ← β_k σs_k^n e^{−σt_k L} / Σ_c p_c σt_c^n e^{−σt_c L}
//! ```
//!
//! With p_c ∝ β_c the sum Σβ never grows. A stretch costs one weight, however many events it has; it is short where albedo
//! is low, so that Russian roulette comes in time, and where the channels differ by more than powers of their ratio
//! can express.

use crate::optics::HenyeyGreenstein;
use crate::sampling::{SmallRng, fast_math};
use glam::{Vec3, Vec3A};

/// Most events of a stretch.
pub(super) const LONGEST_STRETCH: usize = 32;
/// Albedo to the power of a stretch's events is at least this.
const STRETCH_SURVIVAL: f32 = 0.5;
/// Ratio of extinctions beyond which every event is a stretch of its own.
const LARGEST_CONTRAST: f32 = 1e3;
/// Powers of that ratio that a stretch may come to.
const LARGEST_POWER: f32 = 1e24;

/// Coefficients of a homogeneous medium in the units of the walk.
#[derive(Clone, Copy)]
pub(super) struct Coefficients {
    pub sigma_t: Vec3A,
    /// √(3 (1 − α)(1 − gα)): reciprocal of the diffusion length in mean free paths.
    pub inverse_diffusion_length: Vec3A,
    mean_free_path: [f32; 3],
    /// Powers of σs and σt, relative to the largest σt.
    scattering: [Vec3A; LONGEST_STRETCH + 1],
    extinction: [Vec3A; LONGEST_STRETCH + 1],
    /// Events of a stretch.
    pub stretch: usize,
    pub phase: HenyeyGreenstein,
}

impl Coefficients {
    pub fn new(sigma_a: Vec3, sigma_s: Vec3, g: f32, scale: f32) -> Self {
        let sigma_t = (sigma_a + sigma_s) * scale;
        let largest = sigma_t.max_element();
        let least = Vec3::select(sigma_t.cmpgt(Vec3::ZERO), sigma_t, Vec3::INFINITY).min_element();
        let albedo =
            Vec3::select(sigma_t.cmpgt(Vec3::ZERO), sigma_s * scale / sigma_t, Vec3::ZERO).max_element();
        let stretch = if largest > LARGEST_CONTRAST * least {
            1
        } else {
            let expressible = LARGEST_POWER.ln() / (largest / least).ln();
            // Where nothing is absorbed the logarithm is zero, which is not a reason for short stretches.
            let surviving = STRETCH_SURVIVAL.ln() / albedo.min(1.0 - f32::EPSILON).ln();
            (surviving.min(expressible) as usize).clamp(1, LONGEST_STRETCH)
        };
        let inverse_diffusion_length = std::array::from_fn(|i| {
            let albedo = if sigma_t[i] > 0.0 { sigma_s[i] * scale / sigma_t[i] } else { 0.0 };
            (3.0 * (1.0 - albedo).max(0.0) * (1.0 - g * albedo)).sqrt()
        });
        let mut scattering = [Vec3A::ONE; LONGEST_STRETCH + 1];
        let mut extinction = scattering;
        for n in 1..=LONGEST_STRETCH {
            scattering[n] = scattering[n - 1] * Vec3A::from(sigma_s * scale / largest);
            extinction[n] = extinction[n - 1] * Vec3A::from(sigma_t / largest);
        }
        Self {
            sigma_t: sigma_t.into(),
            inverse_diffusion_length: Vec3A::from_array(inverse_diffusion_length),
            mean_free_path: sigma_t.recip().to_array(),
            scattering,
            extinction,
            stretch,
            phase: HenyeyGreenstein { g },
        }
    }

    /// As [`Coefficients::new`], for at most one event at a time.
    pub fn of_one_event(sigma_a: Vec3, sigma_s: Vec3, g: f32) -> Self {
        let sigma_t = sigma_a + sigma_s;
        let largest = sigma_t.max_element().recip();
        let (mut scattering, mut extinction) =
            ([Vec3A::ONE; LONGEST_STRETCH + 1], [Vec3A::ONE; LONGEST_STRETCH + 1]);
        scattering[1] = Vec3A::from(sigma_s * largest);
        extinction[1] = Vec3A::from(sigma_t * largest);
        Self {
            sigma_t: sigma_t.into(),
            inverse_diffusion_length: Vec3A::ZERO,
            mean_free_path: sigma_t.recip().to_array(),
            scattering,
            extinction,
            stretch: 1,
            phase: HenyeyGreenstein { g },
        }
    }

    /// A channel drawn from the mixture, and its mean free path.
    #[inline]
    pub fn draw_channel(&self, throughput: Vec3A, rng: &mut SmallRng) -> (usize, f32) {
        let channel = pick_channel(throughput, rng.f32());
        (channel, self.mean_free_path[channel])
    }

    /// The throughput after `collisions` (at most one stretch's) on the way of a length, in one stretch.
    #[inline]
    pub fn weigh(&self, throughput: Vec3A, collisions: usize, length: f32) -> Vec3A {
        let carried = throughput * self.relative_transmittance(throughput, length);
        let density = (carried * self.extinction[collisions]).element_sum();
        carried * self.scattering[collisions] * (throughput.element_sum() / density)
    }

    /// The mean free path of a channel drawn from the mixture.
    #[inline]
    pub fn draw_mean_free_path(&self, throughput: Vec3A, rng: &mut SmallRng) -> f32 {
        self.draw_channel(throughput, rng).1
    }

    /// As [`Coefficients::weigh`], where the density is `ways` times that of the plain walk in each channel.
    #[inline]
    pub fn weigh_ways(&self, throughput: Vec3A, collisions: usize, length: f32, ways: Vec3A) -> Vec3A {
        let carried = throughput * self.relative_transmittance(throughput, length);
        let density = (carried * self.extinction[collisions] * ways).element_sum();
        carried * self.scattering[collisions] * (throughput.element_sum() / density)
    }

    /// With which probability each channel has been drawn for this stretch, given its collisions and length so far.
    #[inline]
    pub fn channels(&self, throughput: Vec3A, collisions: usize, length: f32) -> Vec3A {
        let carried = throughput * self.relative_transmittance(throughput, length);
        let density = carried * self.extinction[collisions];
        density / density.element_sum()
    }

    /// The probability to reach `t` without a collision, under the mixture over channels.
    #[inline]
    pub fn arrival_probability(&self, throughput: Vec3A, t: f32) -> f32 {
        (throughput * self.transmittance(t)).element_sum() / throughput.element_sum()
    }

    #[inline]
    pub fn transmittance(&self, t: f32) -> Vec3A {
        fast_math::exp_negative(-self.sigma_t * t)
    }

    /// e^{−σt t} up to a common factor, which weights cancel: relative to the clearest channel that still carries
    /// light, so that the sum cannot underflow.
    #[inline]
    fn relative_transmittance(&self, throughput: Vec3A, t: f32) -> Vec3A {
        let carried = Vec3A::select(throughput.cmpgt(Vec3A::ZERO), self.sigma_t, Vec3A::INFINITY);
        let least = Vec3A::splat(carried.min_element());
        fast_math::exp_negative((least - self.sigma_t).min(Vec3A::ZERO) * t)
    }
}

/// A free flight in mean free paths.
#[inline]
pub(super) fn draw_flight(rng: &mut SmallRng) -> f32 {
    rng.exponential()
}

/// A channel drawn with probability proportional to `weights`.
#[inline]
fn pick_channel(weights: Vec3A, u: f32) -> usize {
    let u = u * weights.element_sum();
    usize::from(u >= weights.x) + usize::from(u >= weights.x + weights.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long where light lasts, one event beside nearly nothing else, never so long that powers leave what floats hold.
    #[test]
    fn stretches_are_as_long_as_light_and_floats_last() {
        let stretch = |a: Vec3, s: Vec3| {
            let c = Coefficients::new(a, s, 0.0, 1.0);
            let powers = (0..=c.stretch).flat_map(|n| [c.scattering[n], c.extinction[n]]);
            assert!(powers.into_iter().all(|p| p.min_element() >= f32::MIN_POSITIVE), "{a} {s}");
            c.stretch
        };
        assert_eq!(stretch(Vec3::ZERO, Vec3::splat(3.0)), LONGEST_STRETCH);
        assert_eq!(stretch(Vec3::new(0.0, 1.0, 2.0), Vec3::new(3.0, 2.0, 1.0)), LONGEST_STRETCH);
        assert_eq!(stretch(Vec3::splat(0.001), Vec3::ONE), LONGEST_STRETCH);
        // 0.9⁶ > ½ > 0.9⁷.
        assert_eq!(stretch(Vec3::splat(0.1), Vec3::splat(0.9)), 6);
        assert_eq!(stretch(Vec3::splat(0.9), Vec3::splat(0.1)), 1);
        assert_eq!(stretch(Vec3::ZERO, Vec3::new(1.0, 100.0, 900.0)), 8);
        assert_eq!(stretch(Vec3::ZERO, Vec3::new(1.0, 1.0, 1001.0)), 1);
    }

    /// However a stretch is cut, its weight is the same for a gray medium, and powers of the albedo.
    #[test]
    fn long_stretches_weigh_as_many_short_ones() {
        let c = Coefficients::new(Vec3::splat(0.001), Vec3::splat(0.999), 0.0, 1.0);
        let once = c.weigh(Vec3A::ONE, 32, 30.0);
        let often = (0..32).fold(Vec3A::ONE, |beta, _| c.weigh(beta, 1, 30.0 / 32.0));
        // 32 products, each rounded a few times.
        assert!((once / often - 1.0).abs().max_element() < 1e-5, "{once} {often}");
        assert!((once.x / 0.999_f32.powi(32) - 1.0).abs() < 1e-5, "{once}");
    }
}
