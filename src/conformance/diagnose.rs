//! What is probably wrong where an expectation fails.
//!
//! First the symptoms of the case: the mean that a known mistake would show, computed by a closed form or a simulation of
//! that mistake. Otherwise what any picture may suffer from: channels in another order, a factor that all of them share,
//! black, or numbers that are not finite.

use super::{Estimate, Expectation};
use std::f64::consts::PI;

/// A symptom is recognized within this part of its value: simulated ones are known to one per cent, and a real renderer
/// has noise of its own.
const RECOGNIZED: f64 = 0.03;
/// A factor is recognized within this part of it.
const FACTOR: f64 = 0.015;
/// A factor without a name is worth a word from this far from 1 on: smaller ones have many causes.
const NOTABLE: f64 = 0.05;

/// A guess, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// The mistake.
    pub says: String,
    /// Distance from what that mistake would show, in parts of what is recognized: 0 is exactly that, 1 hardly.
    pub distance: f64,
}

/// The best guesses, most probable first; empty if what is seen is like nothing known.
pub fn diagnose(measured: &Estimate, expected: [f64; 3], expectation: &Expectation) -> Vec<Diagnosis> {
    let seen = measured.mean;
    if seen.iter().any(|v| !v.is_finite()) {
        return vec![found("pixels that are not finite (NaN or infinity)", 0.0)];
    }
    let error = measured.standard_error.unwrap_or_default();
    let bright = expected.iter().copied().fold(0.0, f64::max);
    let near = |mean: [f64; 3]| {
        (0..3)
            .map(|c| {
                let room = RECOGNIZED * mean[c].abs().max(0.05 * bright) + 3.0 * error[c];
                (seen[c] - mean[c]).abs() / room
            })
            .fold(0.0, f64::max)
    };
    let mut guesses: Vec<Diagnosis> =
        expectation.symptoms.iter().map(|symptom| found(&symptom.says, near(symptom.mean))).collect();
    guesses.extend(swapped(expected).into_iter().map(|(mean, says)| found(says, near(mean))));
    guesses.retain(|guess| guess.distance <= 1.0);
    guesses.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    if guesses.is_empty() {
        guesses.extend(common_factor(seen, expected));
    }
    guesses
}

fn found(says: &str, distance: f64) -> Diagnosis {
    Diagnosis { says: says.to_owned(), distance }
}

/// Means with the channels in another order, where that changes something.
fn swapped([r, g, b]: [f64; 3]) -> Vec<([f64; 3], &'static str)> {
    let orders = [
        ([b, g, r], "red and blue are swapped"),
        ([g, r, b], "red and green are swapped"),
        ([r, b, g], "green and blue are swapped"),
        ([g, b, r], "channels are rotated: each shows the next one"),
        ([b, r, g], "channels are rotated: each shows the one before"),
    ];
    let differs = |a: f64, b: f64| (a - b).abs() > 2.0 * RECOGNIZED * a.abs().max(b.abs());
    let all = [r, g, b];
    orders.into_iter().filter(|(o, _)| (0..3).any(|c| differs(o[c], all[c]))).collect()
}

/// A factor that all channels share.
fn common_factor(seen: [f64; 3], expected: [f64; 3]) -> Option<Diagnosis> {
    let bright = expected.iter().copied().fold(0.0, f64::max);
    if seen.iter().all(|v| v.abs() < 1e-3 * bright) {
        return Some(found("everything is black: the body, or the light, is not there", 0.0));
    }
    let ratio: Vec<f64> = (0..3).map(|c| seen[c] / expected[c]).collect();
    let mean = ratio.iter().sum::<f64>() / 3.0;
    if !mean.is_finite() || ratio.iter().any(|r| (r / mean - 1.0).abs() > FACTOR) {
        return None;
    }
    let known = [
        (2.0, "2"),
        (0.5, "1/2"),
        (4.0, "4"),
        (0.25, "1/4"),
        (PI, "π"),
        (1.0 / PI, "1/π"),
        (2.0 * PI, "2π"),
        (0.5 / PI, "1/2π"),
        (4.0 * PI, "4π"),
        (0.25 / PI, "1/4π"),
        (2.25, "1.5², η² of glass"),
        (1.0 / 2.25, "1/1.5², 1/η² of glass"),
        (1.7689, "1.33², η² of water"),
        (1.0 / 1.7689, "1/1.33², 1/η² of water"),
    ];
    let name = known.iter().find(|(k, _)| (mean / k - 1.0).abs() < FACTOR);
    // Few digits, so that cases with the same factor say the same.
    let text = match name {
        Some((_, name)) => format!("all channels are off by the same factor, {name}"),
        None if (mean - 1.0).abs() < NOTABLE => return None,
        None => format!("all channels are off by the same factor, about {mean:.2}"),
    };
    Some(found(&text, 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::Symptom;

    const EXPECTED: [f64; 3] = [0.2, 0.4, 0.6];

    fn guess(mean: [f64; 3]) -> Vec<String> {
        let symptom = Symptom { mean: [0.1, 0.5, 0.7], says: "a mistake".to_owned() };
        let expectation = Expectation {
            name: String::new(),
            region: None,
            mean: Some(EXPECTED),
            standard_error: [0.0; 3],
            source: String::new(),
            tolerance: 0.0,
            why: String::new(),
            symptoms: vec![symptom],
        };
        let measured = Estimate { mean, standard_error: Some([0.0; 3]) };
        diagnose(&measured, EXPECTED, &expectation).into_iter().map(|d| d.says).collect()
    }

    #[test]
    fn symptoms_are_recognized_and_nothing_else_is_said() {
        assert_eq!(guess([0.102, 0.495, 0.71]), ["a mistake"]);
        assert!(guess([0.11, 0.495, 0.71]).is_empty());
    }

    #[test]
    fn channels_and_factors_are_recognized() {
        assert_eq!(guess([0.6, 0.4, 0.2]), ["red and blue are swapped"]);
        assert!(guess(EXPECTED.map(|v| v * PI))[0].contains("same factor, π"));
        assert!(guess(EXPECTED.map(|v| v * 1.2))[0].contains("about 1.20"));
        assert!(guess(EXPECTED.map(|v| v * 1.04)).is_empty(), "a few per cent have many causes");
        assert!(guess([0.0; 3])[0].contains("black"));
        assert!(guess([f64::NAN, 0.4, 0.6])[0].contains("not finite"));
    }
}
