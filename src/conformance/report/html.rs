//! One page that says what passed, what failed, and what is probably wrong.

use super::hints;
use super::page::{FOOT, HEAD, READING};
use super::patterns::{properties, suspects};
use super::pictures::pictures;
use super::plot::sweeps;
use super::{About, counts, digits, escape, put};
use crate::conformance::{Outcome, Verdict};

/// Suspects that are listed at the top.
const MOST_SUSPECTS: usize = 6;

/// The whole page, self-contained.
pub fn html(about: &About, outcomes: &[Outcome]) -> String {
    let title = format!("Conformance of {}", about.renderer);
    let mut out = format!("{}{}{}", HEAD[0], escape(&title), HEAD[1]);
    head(&mut out, about, outcomes);
    common(&mut out, outcomes);
    out += READING;
    summary(&mut out, outcomes);
    let plots = sweeps(outcomes);
    if !plots.is_empty() {
        out += "<h2>Sweeps</h2>\n<p class=\"muted small\">Red, green and blue points are the three channels. In a sweep over \
                several cases each channel is a curve of its own; otherwise the channels are the points of one curve.</p>\n<div class=\"plots\">";
        out.extend(plots);
        out += "</div>\n";
    }
    out += "<h2>Cases</h2>\n";
    let mut order: Vec<&Outcome> = outcomes.iter().collect();
    order.sort_by_key(|outcome| std::cmp::Reverse(outcome.verdict));
    order.into_iter().for_each(|outcome| case(&mut out, outcome));
    out + FOOT
}

fn head(out: &mut String, about: &About, outcomes: &[Outcome]) {
    let [passed, inconclusive, failed, errors] = counts(outcomes);
    put(out, format_args!("<h1>Conformance of {}</h1>\n", escape(&about.renderer)));
    let total = outcomes.len();
    put(
        out,
        format_args!(
            "<p><b>{passed} of {total} cases passed</b>, {failed} failed, {inconclusive} inconclusive, {errors} without a picture. \
             <span class=\"muted\">{:.1} s; suite {}; samples × {}; seed {}; measured by nephrite {}.</span></p>\n",
            about.seconds,
            escape(&about.suite),
            about.spp_scale as f32,
            about.seed,
            env!("CARGO_PKG_VERSION")
        ),
    );
}

/// What failures have in common.
fn common(out: &mut String, outcomes: &[Outcome]) {
    if outcomes.iter().all(|outcome| outcome.verdict <= Verdict::Inconclusive) {
        return;
    }
    let suspects = suspects(outcomes);
    if !suspects.is_empty() {
        out.push_str("<h2>What is probably wrong</h2>\n<table><tr><th>Mistake</th><th class=\"n\">Cases</th><th>that show just this</th></tr>\n");
        for suspect in suspects.iter().take(MOST_SUSPECTS) {
            let links: Vec<String> = suspect.cases.iter().map(|name| link(name)).collect();
            put(
                out,
                format_args!(
                    "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"small\">{}</td></tr>\n",
                    escape(&suspect.says),
                    suspect.cases.len(),
                    links.join(", ")
                ),
            );
        }
        out.push_str("</table>\n");
    }
    out.push_str(
        "<h2>Where failures gather</h2>\n<p class=\"muted small\">Cases by what they depend on, \
         in the order in which that tells failed cases from passed ones: a property whose cases all fail, while cases \
         without it pass, is the place to look.</p>\n<table>\n",
    );
    for property in properties(outcomes) {
        put(
            out,
            format_args!(
                "<tr><td>{}</td><td class=\"n\">{} of {} failed</td><td><span class=\"bar\" style=\"width:{}px\"></span>\
                 <span class=\"rest\" style=\"width:{}px\"></span></td></tr>\n",
                escape(&property.name),
                property.wrong,
                property.all,
                10 * property.wrong,
                10 * (property.all - property.wrong)
            ),
        );
    }
    out.push_str("</table>\n");
}

fn summary(out: &mut String, outcomes: &[Outcome]) {
    out.push_str(
        "<h2>Summary</h2>\n<table><tr><th>Case</th><th></th><th>Verdict</th><th class=\"n\">worst z</th>\
         <th class=\"n\">worst deviation</th><th class=\"n\">seconds</th></tr>\n",
    );
    for outcome in outcomes {
        let deviations = outcome.findings.iter().flat_map(|finding| {
            (0..3).map(|c| (finding.measured.mean[c] / finding.expected.0[c] - 1.0) * 100.0)
        });
        let worst = deviations.fold(0.0, |w: f64, d| if d.abs() > w.abs() || d.is_nan() { d } else { w });
        let (z, deviation) = match outcome.findings.is_empty() {
            true => ("–".to_owned(), "–".to_owned()),
            false => (format!("{:+.1}", outcome.worst_z()), format!("{worst:+.2} %")),
        };
        put(
            out,
            format_args!(
                "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{z}</td><td class=\"n\">{deviation}</td><td class=\"n\">{:.2}</td></tr>\n",
                link(&outcome.case.name),
                escape(&outcome.case.title),
                badge(outcome.verdict),
                outcome.seconds
            ),
        );
    }
    out.push_str("</table>\n");
}

fn case(out: &mut String, outcome: &Outcome) {
    let case = &outcome.case;
    let class = if outcome.verdict > Verdict::Inconclusive { " class=\"bad\"" } else { "" };
    put(
        out,
        format_args!(
            "<article id=\"{0}\"{class}>\n<h3>{1} {0}</h3>\n<p>{2} <span class=\"muted small\">({3}; {4} × {5} pixels, {6} samples a pixel in {7} renders, {8:.2} s)</span></p>\n",
            escape(&case.name),
            badge(outcome.verdict),
            escape(&case.title),
            escape(&case.tests.join(", ")),
            case.width,
            case.height,
            outcome.spp,
            outcome.batches,
            outcome.seconds,
        ),
    );
    if let Some(error) = &outcome.error {
        put(out, format_args!("<pre>{}</pre>\n", escape(error)));
    }
    for (expectation, finding) in outcome.results() {
        hints::likely(out, outcome, expectation, finding);
    }
    if outcome.verdict == Verdict::Inconclusive {
        hints::too_noisy(out, outcome);
    }
    show(out, outcome);
    if !outcome.findings.is_empty() {
        numbers(out, outcome);
    }
    if outcome.verdict == Verdict::Failed {
        hints::mistakes(out, outcome);
    }
    if let Some(text) = &case.same_as {
        put(
            out,
            format_args!(
                "<p class=\"small\">Must look like {}: what differs is how the same body is described.</p>\n",
                link(text)
            ),
        );
    }
    if let Some(text) = &case.other_renderers {
        put(out, format_args!("<p class=\"small\"><b>Other renderers:</b> {}</p>\n", escape(text)));
    }
    out.push_str("</article>\n");
}

fn show(out: &mut String, outcome: &Outcome) {
    let Some(shown) = pictures(outcome) else { return };
    let name = escape(&outcome.case.name);
    let scale = shown.full_scale;
    put(
        out,
        format_args!(
            "<div class=\"pictures\">\
             <figure><img src=\"{}\" alt=\"{name}, rendered\"><figcaption>rendered (white: {})</figcaption></figure>\
             <figure><img src=\"{}\" alt=\"{name}, expected\"><figcaption>expected</figcaption></figure>\
             <figure><img src=\"{}\" alt=\"{name}, difference\"><div class=\"scale\"></div><figcaption>difference of luminance, −{scale} to +{scale}: red is too bright</figcaption></figure></div>\n",
            shown.rendered,
            digits(f64::from(shown.white)),
            shown.expected,
            shown.difference,
        ),
    );
}

fn numbers(out: &mut String, outcome: &Outcome) {
    out.push_str(
        "<table><tr><th>Region</th><th>Channel</th><th class=\"n\">Measured</th><th class=\"n\">Expected</th>\
         <th class=\"n\">Deviation</th><th class=\"n\">Passes up to</th><th class=\"n\">z</th></tr>\n",
    );
    for (expectation, finding) in outcome.results() {
        for (c, channel) in ["red", "green", "blue"].into_iter().enumerate() {
            let (expected, error) = (finding.expected.0[c], finding.expected.1[c]);
            let measured = finding.measured.mean[c];
            let own = finding.measured.standard_error.map_or("no error known".to_owned(), |e| digits(e[c]));
            let sure = if error > 0.0 { format!(" ± {}", digits(error)) } else { String::new() };
            let name = if c == 0 { escape(&expectation.name) } else { String::new() };
            put(
                out,
                format_args!(
                    "<tr><td>{name}</td><td>{channel}</td><td class=\"n\">{} ± {own}</td><td class=\"n\">{}{sure}</td><td class=\"n\">{:+.2} %</td><td class=\"n\">{:.2} %</td><td class=\"n\">{:+.1}</td></tr>\n",
                    digits(measured),
                    digits(expected),
                    100.0 * (measured / expected - 1.0),
                    100.0 * finding.judgement.allowed[c] / expected.abs(),
                    finding.judgement.z[c],
                ),
            );
        }
    }
    out.push_str("</table>\n");
    let mut sources: Vec<String> = Vec::new();
    for expectation in &outcome.case.expectations {
        let text = format!(
            "Expected: {}. Tolerance {:.2} %: {}",
            expectation.source,
            100.0 * expectation.tolerance,
            expectation.why
        );
        if !sources.contains(&text) {
            sources.push(text);
        }
    }
    if let Some(made) = &outcome.case.reference {
        sources.push(format!(
            "Reference: nephrite {}, {} samples a pixel in {} renders from seed {}.",
            made.version, made.spp, made.batches, made.seed
        ));
    }
    put(out, format_args!("<p class=\"small muted\">{}</p>\n", escape(&sources.join(" "))));
}

fn badge(verdict: Verdict) -> String {
    format!("<span class=\"verdict {0}\">{0}</span>", verdict.name())
}

fn link(case: &str) -> String {
    format!("<a href=\"#{0}\">{0}</a>", escape(case))
}
