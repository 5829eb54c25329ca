//! The numbers of a run, for programs.

use super::{About, counts};
use crate::conformance::{Outcome, Verdict};
use serde_json::{Value, json};

/// Everything but the pictures.
pub fn json(about: &About, outcomes: &[Outcome]) -> Value {
    let [passed, inconclusive, failed, errors] = counts(outcomes);
    let cases: Vec<Value> = outcomes.iter().map(case).collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "renderer": about.renderer,
        "suite": about.suite,
        "spp_scale": about.spp_scale,
        "seed": about.seed,
        "seconds": about.seconds,
        "passed": passed,
        "inconclusive": inconclusive,
        "failed": failed,
        "errors": errors,
        "cases": cases,
    })
}

fn case(outcome: &Outcome) -> Value {
    let expectations: Vec<Value> = outcome
        .results()
        .map(|(expectation, finding)| {
            let diagnoses: Vec<&str> = finding.diagnoses.iter().map(|d| d.says.as_str()).collect();
            json!({
                "name": expectation.name,
                "region": outcome.case.region(expectation),
                "verdict": finding.judgement.verdict.name(),
                "expected": finding.expected.0,
                "expected_standard_error": finding.expected.1,
                "source": expectation.source,
                "tolerance": expectation.tolerance,
                "measured": finding.measured.mean,
                "measured_standard_error": finding.measured.standard_error,
                "allowed": finding.judgement.allowed,
                "z": finding.judgement.z,
                "diagnoses": diagnoses,
            })
        })
        .collect();
    json!({
        "name": outcome.case.name,
        "title": outcome.case.title,
        "tests": outcome.case.tests,
        "verdict": outcome.verdict.name(),
        "error": outcome.error,
        "spp": outcome.spp,
        "batches": outcome.batches,
        "seconds": outcome.seconds,
        "passed": outcome.verdict == Verdict::Passed,
        "expectations": expectations,
    })
}
