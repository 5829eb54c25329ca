//! Is what was measured what was expected?
//!
//! A channel passes where |measured − expected| ≤ tolerance · expected + 3 √(se² + se_truth²). The same bound says what a
//! case could have noticed at all: where it exceeds 2 % of what is expected, a pass would mean little, and the case is
//! inconclusive instead. So an error of 2 % fails wherever a case passes, unless noise happens to hide it.

use super::Estimate;

/// Standard errors that noise is allowed.
pub const CONFIDENCE: f64 = 3.0;
/// The error, relative to what is expected, that must not pass.
pub const POWER: f64 = 0.02;
/// Relative standard error below which z scores are not trusted: half of a half float's last place, since that is what
/// pictures are written in.
const ROUNDING: f64 = 1.0 / 4096.0;

/// What came of an expectation or a case; later ones are worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// As expected.
    Passed,
    /// Too noisy to tell.
    Inconclusive,
    /// Not as expected.
    Failed,
    /// There is no picture to judge.
    Error,
}

impl Verdict {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Inconclusive => "inconclusive",
            Self::Failed => "failed",
            Self::Error => "error",
        }
    }
}

/// A judged mean.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    /// The worst of the channels.
    pub verdict: Verdict,
    /// (measured − expected) over the standard error of both; without a standard error, over a third of the tolerance.
    pub z: [f64; 3],
    /// The largest deviation that passes, absolute.
    pub allowed: [f64; 3],
}

/// Compares a measured mean with an expected one and its standard error; `tolerance` is relative.
pub fn judge(measured: &Estimate, expected: [f64; 3], error: [f64; 3], tolerance: f64) -> Judgement {
    let mut judgement = Judgement { verdict: Verdict::Passed, z: [0.0; 3], allowed: [0.0; 3] };
    for c in 0..3 {
        let deviation = measured.mean[c] - expected[c];
        let margin = tolerance * expected[c].abs();
        let noise = measured.standard_error.map_or(error[c], |own| own[c].hypot(error[c]));
        let allowed = margin + CONFIDENCE * noise;
        let unit = if measured.standard_error.is_some() { noise } else { margin / CONFIDENCE };
        judgement.z[c] =
            deviation / unit.max(ROUNDING * expected[c].abs().max(measured.mean[c].abs())).max(1e-30);
        judgement.allowed[c] = allowed;
        // A comparison with NaN is false, and NaN must not pass.
        let passes = deviation.abs() <= allowed;
        let verdict = match passes {
            false => Verdict::Failed,
            true if allowed > POWER * expected[c].abs() => Verdict::Inconclusive,
            true => Verdict::Passed,
        };
        judgement.verdict = judgement.verdict.max(verdict);
    }
    judgement
}

/// How many times the samples would bring the noise down to where an error of [`POWER`] shows; 1 or less if it does already.
/// `None` where no number would do: the error of the render is not known, or the truth itself is too uncertain.
pub fn samples_needed(
    measured: &Estimate,
    expected: [f64; 3],
    error: [f64; 3],
    tolerance: f64,
) -> Option<f64> {
    let own = measured.standard_error?;
    let needed = (0..3).map(|c| {
        let room = (POWER - tolerance) * expected[c].abs() / CONFIDENCE;
        // Negative where the tolerance leaves no room at all.
        let variance = room * room.abs() - error[c] * error[c];
        if variance > 0.0 { own[c] * own[c] / variance } else { f64::INFINITY }
    });
    Some(needed.fold(0.0, f64::max)).filter(|factor| factor.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(mean: f64, error: Option<f64>) -> Verdict {
        let measured = Estimate { mean: [1.0, 1.0, mean], standard_error: error.map(|e| [0.0, 0.0, e]) };
        judge(&measured, [1.0; 3], [0.0; 3], 0.005).verdict
    }

    #[test]
    fn tolerance_and_noise_add_up() {
        assert_eq!(judged(1.0049, None), Verdict::Passed);
        assert_eq!(judged(1.0051, None), Verdict::Failed);
        assert_eq!(judged(1.013, Some(0.003)), Verdict::Passed);
        assert_eq!(judged(0.985, Some(0.003)), Verdict::Failed);
        assert_eq!(judged(1.02, Some(0.003)), Verdict::Failed);
    }

    #[test]
    fn what_would_hide_two_per_cent_is_inconclusive() {
        assert_eq!(judged(1.0, Some(0.0051)), Verdict::Inconclusive);
        assert_eq!(judged(1.5, Some(0.0051)), Verdict::Failed);
    }

    #[test]
    fn the_samples_that_are_needed_make_it_conclusive() {
        let needed = |error, truth| {
            let measured = Estimate { mean: [1.0; 3], standard_error: Some([0.0, 0.0, error]) };
            samples_needed(&measured, [1.0; 3], [truth; 3], 0.005)
        };
        // (0.02 − 0.005)/3 is the most noise that a tolerance of 0.005 leaves room for.
        let factor = needed(0.02, 0.0).expect("a number");
        assert!((factor - 16.0).abs() < 1e-9, "{factor}");
        assert_eq!(judged(1.0, Some(0.02 / 1.01 / factor.sqrt())), Verdict::Passed);
        assert_eq!(judged(1.0, Some(0.02 * 1.01 / factor.sqrt())), Verdict::Inconclusive);
        assert_eq!(needed(0.001, 0.0051), None);
    }

    #[test]
    fn pictures_that_are_not_finite_fail() {
        for value in [f64::NAN, f64::INFINITY] {
            assert_eq!(judged(value, Some(0.001)), Verdict::Failed);
            assert_eq!(judged(value, Some(f64::NAN)), Verdict::Failed);
        }
    }

    #[test]
    fn z_is_in_standard_errors_of_both() {
        let measured = Estimate { mean: [1.05, 1.0, 1.0], standard_error: Some([0.003; 3]) };
        let judgement = judge(&measured, [1.0; 3], [0.004; 3], 0.0);
        assert!((judgement.z[0] - 10.0).abs() < 1e-9, "{:?}", judgement.z);
    }
}
