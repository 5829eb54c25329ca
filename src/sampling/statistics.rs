//! Test statistics shared by the tests of this crate: all return a standard normal z under the null hypothesis.

/// Pearson's χ² of counts against expectations as a z score (Wilson & Hilferty 1931). Cells with an expectation
/// below five are pooled; `expected` need not be normalised to the total count by the caller beyond rounding.
pub(crate) fn chi_square_z(counts: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(counts.len(), expected.len());
    let (mut statistic, mut cells) = (0.0, 0usize);
    let (mut pooled_count, mut pooled_expected) = (0.0, 0.0);
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            pooled_count += count as f64;
            pooled_expected += expected;
        } else {
            statistic += (count as f64 - expected).powi(2) / expected;
            cells += 1;
        }
    }
    if pooled_expected >= 5.0 {
        statistic += (pooled_count - pooled_expected).powi(2) / pooled_expected;
        cells += 1;
    } else {
        let surplus = (pooled_count - pooled_expected).max(0.0);
        assert!(
            surplus < 5.0 + 4.0 * 5.0f64.sqrt(),
            "{pooled_count} samples where {pooled_expected} expected"
        );
    }
    if cells < 2 {
        return 0.0;
    }
    let k = (cells - 1) as f64;
    let variance = 2.0 / (9.0 * k);
    ((statistic / k).cbrt() - (1.0 - variance)) / variance.sqrt()
}

/// Running mean and variance of a Monte Carlo estimate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Estimate {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Estimate {
    pub(crate) fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    pub(crate) fn mean(&self) -> f64 {
        self.sum / self.count
    }

    pub(crate) fn standard_error(&self) -> f64 {
        let mean = self.mean();
        ((self.squares / self.count - mean * mean).max(0.0) / (self.count - 1.0)).sqrt()
    }

    /// Deviation from a known value in standard errors; rounding of the samples is allowed for by a relative 1e-5.
    pub(crate) fn z(&self, truth: f64) -> f64 {
        (self.mean() - truth) / self.standard_error().hypot(1e-5 * truth.abs())
    }
}

#[test]
fn chi_square_tells_fair_from_loaded() {
    let expected = [1000.0; 6];
    assert!(chi_square_z(&[1010, 985, 1003, 1021, 978, 1003], &expected).abs() < 4.0);
    assert!(chi_square_z(&[1200, 960, 960, 960, 960, 960], &expected) > 4.0);
}
