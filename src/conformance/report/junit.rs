//! JUnit XML, which continuous integration reads: a test case for each case of the suite.

use super::{About, counts, digits, escape, put};
use crate::conformance::{Outcome, Verdict};

/// The run as one test suite. What could not be rendered is an error; what is too noisy to tell is a failure, since it shows
/// nothing.
pub fn junit(about: &About, outcomes: &[Outcome]) -> String {
    let [_, inconclusive, failed, errors] = counts(outcomes);
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    put(
        &mut out,
        format_args!(
            "<testsuites>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{errors}\" time=\"{:.3}\">\n",
            escape(&about.suite),
            outcomes.len(),
            failed + inconclusive,
            about.seconds
        ),
    );
    for outcome in outcomes {
        put(
            &mut out,
            format_args!(
                "<testcase classname=\"conformance\" name=\"{}\" time=\"{:.3}\"",
                escape(&outcome.case.name),
                outcome.seconds
            ),
        );
        let text = escape(&explain(outcome));
        let message = escape(&outcome.case.title);
        match outcome.verdict {
            Verdict::Passed => out += "/>\n",
            Verdict::Error => {
                put(&mut out, format_args!(">\n<error message=\"{message}\">{text}</error>\n</testcase>\n"))
            }
            _ => put(
                &mut out,
                format_args!(">\n<failure message=\"{message}\">{text}</failure>\n</testcase>\n"),
            ),
        }
    }
    out + "</testsuite>\n</testsuites>\n"
}

/// What is wrong with a case, in lines.
fn explain(outcome: &Outcome) -> String {
    let mut lines: Vec<String> = outcome.error.iter().cloned().collect();
    for (expectation, finding) in outcome.results().filter(|(_, f)| f.judgement.verdict != Verdict::Passed) {
        let list = |values: [f64; 3]| values.map(digits).join(" ");
        lines.push(format!(
            "{}: {}: measured {}, expected {}, at most {} off",
            expectation.name,
            finding.judgement.verdict.name(),
            list(finding.measured.mean),
            list(finding.expected.0),
            list(finding.judgement.allowed)
        ));
        lines.extend(finding.diagnoses.iter().take(1).map(|d| format!("probably: {}", d.says)));
    }
    lines.join("\n")
}
