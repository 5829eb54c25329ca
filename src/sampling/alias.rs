//! Choosing among weights in constant time: the alias method (Walker 1974; Vose 1991 for the linear-time build).
//!
//! The map from the uniform number to the index is not monotone, so it breaks up stratification; where the order of
//! the entries means something (pixels of an image, triangles of a mesh) prefer [`super::Distribution1D`].

use super::ONE_MINUS_EPSILON;

/// A discrete distribution over `0..len` with constant-time sampling.
#[derive(Clone, Debug)]
pub struct AliasTable {
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Probability of keeping the bin's own index.
    keep: f32,
    /// The index otherwise.
    alias: u32,
    /// Probability of the bin's own index.
    pdf: f32,
}

impl AliasTable {
    /// Builds from weights ≥ 0; `None` if there are none, their sum is not positive and finite, one is negative or NaN, or
    /// there are more than `u32::MAX` of them.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let n = weights.len();
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let invalid = weights.iter().any(|&w| w.is_nan() || w < 0.0);
        if invalid || !(sum > 0.0 && sum.is_finite()) || u32::try_from(n).is_err() {
            return None;
        }
        let mut bins: Vec<Bin> = weights
            .iter()
            .enumerate()
            .map(|(i, &w)| Bin { keep: 1.0, alias: i as u32, pdf: (f64::from(w) / sum) as f32 })
            .collect();
        let mut scaled: Vec<f64> = weights.iter().map(|&w| f64::from(w) / sum * n as f64).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| scaled[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            bins[s].keep = scaled[s] as f32;
            bins[s].alias = l as u32;
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // What is left in either list is 1 up to rounding, except a zero weight, which must never be chosen.
        if let Some(heaviest) = (0..n).max_by(|&a, &b| weights[a].total_cmp(&weights[b])) {
            for i in small.into_iter().filter(|&i| weights[i] == 0.0) {
                bins[i].keep = 0.0;
                bins[i].alias = heaviest as u32;
            }
        }
        Some(Self { bins })
    }

    /// How many entries there are.
    pub fn len(&self) -> usize {
        self.bins.len()
    }

    /// Never: an empty table cannot be built.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// An index, its probability, and a number uniform in \[0, 1) made from what `u` has left.
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32, f32) {
        let scaled = u * self.bins.len() as f32;
        let i = (scaled as usize).min(self.bins.len() - 1);
        let rest = scaled - i as f32;
        let bin = self.bins[i];
        if rest < bin.keep {
            (i, bin.pdf, (rest / bin.keep).min(ONE_MINUS_EPSILON))
        } else {
            let alias = bin.alias as usize;
            (
                alias,
                self.bins[alias].pdf,
                ((rest - bin.keep) / (1.0 - bin.keep)).clamp(0.0, ONE_MINUS_EPSILON),
            )
        }
    }

    /// Probability of an index; zero outside the table.
    #[inline]
    pub fn pdf(&self, index: usize) -> f32 {
        self.bins.get(index).map_or(0.0, |bin| bin.pdf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, statistics::chi_square_z};

    #[test]
    fn frequencies_match_the_weights_and_the_rest_is_uniform() {
        let mut rng = SmallRng::new(11);
        let mut weights: Vec<f32> = (0..200).map(|_| rng.f32().powi(4)).collect();
        weights[7] = 0.0;
        weights[90] = 50.0;
        let table = AliasTable::new(&weights).unwrap();
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let n = 2_000_000;
        let mut counts = vec![0u64; 200];
        let mut rest_counts = vec![0u64; 64];
        for _ in 0..n {
            let (i, pdf, rest) = table.sample(rng.f32());
            assert_eq!(pdf, table.pdf(i));
            assert!((0.0..1.0).contains(&rest));
            counts[i] += 1;
            rest_counts[(rest * 64.0) as usize] += 1;
        }
        assert_eq!(counts[7], 0);
        let expected: Vec<f64> = weights.iter().map(|&w| f64::from(w) / sum * n as f64).collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "z = {z}");
        let z = chi_square_z(&rest_counts, &[n as f64 / 64.0; 64]);
        assert!(z.abs() < 4.0, "rest: z = {z}");
    }

    #[test]
    fn edges_of_the_unit_interval_and_of_the_input_are_safe() {
        let table = AliasTable::new(&[0.0, 3.0, 0.0]).unwrap();
        for u in [0.0, 0.3333333, 0.5, 0.6666667, ONE_MINUS_EPSILON] {
            let (i, pdf, rest) = table.sample(u);
            assert_eq!((i, pdf), (1, 1.0));
            assert!((0.0..1.0).contains(&rest));
        }
        for weights in [&[][..], &[0.0, 0.0], &[1.0, f32::NAN], &[f32::INFINITY], &[1.0, -1.0]] {
            assert!(AliasTable::new(weights).is_none());
        }
        assert_eq!(table.pdf(3), 0.0);
    }
}
