//! What to do about a case that did not pass: the mistake that it looks like, what other mistakes would look like, or how
//! many more samples would tell.

use super::{digits, escape, put};
use crate::conformance::{Expectation, Finding, Outcome, Verdict, samples_needed};

/// Guesses that are shown for one expectation.
const MOST_GUESSES: usize = 3;

/// What is probably wrong with an expectation.
pub(super) fn likely(out: &mut String, outcome: &Outcome, expectation: &Expectation, finding: &Finding) {
    let place = match outcome.case.expectations.len() {
        1 => String::new(),
        _ => format!("{}: ", escape(&expectation.name)),
    };
    let says: Vec<String> =
        finding.diagnoses.iter().take(MOST_GUESSES).map(|diagnosis| escape(&diagnosis.says)).collect();
    if !says.is_empty() {
        put(
            out,
            format_args!("<p class=\"likely\"><b>Probably:</b> {place}{}</p>\n", says.join("; <b>or</b> ")),
        );
    } else if finding.judgement.verdict == Verdict::Failed {
        put(
            out,
            format_args!(
                "<p class=\"likely\"><b>Not recognized:</b> {place}no mistake that was computed for this case shows just \
                 this. It depends on {}: compare the cases that share these words.</p>\n",
                escape(&outcome.case.tests.join(", "))
            ),
        );
    }
}

/// How many more samples a case needs.
pub(super) fn too_noisy(out: &mut String, outcome: &Outcome) {
    let needed = outcome.results().map(|(expectation, finding)| {
        let (mean, error) = finding.expected;
        samples_needed(&finding.measured, mean, error, expectation.tolerance)
    });
    let needed = needed.collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(1.0, f64::max));
    let advice = match needed {
        Some(factor) => format!("about {factor:.1} times the samples would tell (<code>--spp-scale</code>)"),
        None => "its standard error is not known, or the reference is too noisy itself".to_owned(),
    };
    put(
        out,
        format_args!("<p class=\"likely\"><b>Too noisy:</b> an error of 2 % could hide; {advice}.</p>\n"),
    );
}

/// What known mistakes would show in a case, to compare with.
pub(super) fn mistakes(out: &mut String, outcome: &Outcome) {
    if outcome.case.expectations.iter().all(|expectation| expectation.symptoms.is_empty()) {
        return;
    }
    out.push_str(
        "<details><summary>What known mistakes would show here</summary>\n<table><tr><th>Region</th>\
         <th class=\"n\">Red</th><th class=\"n\">Green</th><th class=\"n\">Blue</th><th>Mistake</th></tr>\n",
    );
    for expectation in &outcome.case.expectations {
        for symptom in &expectation.symptoms {
            let mean = symptom.mean.map(|v| format!("<td class=\"n\">{}</td>", digits(v))).concat();
            let (name, says) = (escape(&expectation.name), escape(&symptom.says));
            put(out, format_args!("<tr><td>{name}</td>{mean}<td>{says}</td></tr>\n"));
        }
    }
    out.push_str("</table></details>\n");
}
