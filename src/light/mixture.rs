//! A handful of alternatives with weights that depend on where they are seen from.
//!
//! The weights estimate unoccluded light. They say nothing about occlusion, so a share of the probability is spread
//! evenly over every alternative that is not impossible: p = (1 − δ) w/Σw + δ/k.

use crate::sampling::ONE_MINUS_EPSILON;

/// How many alternatives are weighed one by one; more of them need a table or a tree.
pub(super) const FEW: usize = 16;

/// Up to [`FEW`] weights; zero means impossible.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mixture {
    weights: [f32; FEW],
    len: usize,
    sum: f32,
    possible: u32,
    /// δ.
    defensive: f32,
}

impl Mixture {
    pub(super) fn new(defensive: f32, weights: impl IntoIterator<Item = f32>) -> Self {
        let mut mixture = Self { weights: [0.0; FEW], len: 0, sum: 0.0, possible: 0, defensive };
        for weight in weights.into_iter().take(FEW) {
            if weight > 0.0 && weight.is_finite() {
                mixture.weights[mixture.len] = weight;
                mixture.sum += weight;
                mixture.possible += 1;
            }
            mixture.len += 1;
        }
        mixture
    }

    /// The sum of the weights.
    pub(super) fn sum(&self) -> f32 {
        self.sum
    }

    pub(super) fn probability(&self, i: usize) -> f32 {
        let weight = self.weights[i];
        if weight <= 0.0 {
            0.0
        } else if self.possible == 1 {
            1.0
        } else {
            (1.0 - self.defensive) * (weight / self.sum) + self.defensive / self.possible as f32
        }
    }

    /// An alternative, its probability, and a uniform number made from what `u` has left; `None` if all are impossible.
    pub(super) fn sample(&self, u: f32) -> Option<(usize, f32, f32)> {
        let mut below = 0.0;
        let mut last = None;
        for i in 0..self.len {
            let p = self.probability(i);
            if p > 0.0 {
                if u < below + p {
                    return Some((i, p, ((u - below) / p).clamp(0.0, ONE_MINUS_EPSILON)));
                }
                last = Some((i, p, ONE_MINUS_EPSILON));
                below += p;
            }
        }
        last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, statistics::chi_square_z};

    #[test]
    fn frequencies_match_probabilities() {
        let mixture = Mixture::new(0.2, [1.0, 0.0, 7.0, f32::NAN, 1e-9]);
        assert_eq!(mixture.probability(1), 0.0);
        assert_eq!(mixture.probability(3), 0.0);
        assert!((mixture.probability(2) - (0.8 * 7.0 / 8.0 + 0.2 / 3.0)).abs() < 1e-6);
        let mut rng = SmallRng::new(1);
        let n = 200_000;
        let mut counts = [0u64; 5];
        let mut rests = [0u64; 32];
        for _ in 0..n {
            let (i, p, rest) = mixture.sample(rng.f32()).unwrap();
            assert_eq!(p, mixture.probability(i));
            counts[i] += 1;
            rests[(rest * 32.0) as usize] += 1;
        }
        let expected: Vec<f64> = (0..5).map(|i| f64::from(mixture.probability(i)) * f64::from(n)).collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "z = {z}");
        let z = chi_square_z(&rests, &[f64::from(n) / 32.0; 32]);
        assert!(z.abs() < 4.0, "rest: z = {z}");
        assert!(Mixture::new(0.2, [0.0, 0.0]).sample(0.5).is_none());
        assert_eq!(Mixture::new(0.2, [0.0, 1e-20]).sample(ONE_MINUS_EPSILON).unwrap().1, 1.0);
    }
}
