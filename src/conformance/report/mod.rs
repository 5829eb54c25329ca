//! What a run found: as a page for people (`html`), for continuous integration (`junit`), and for programs (`json`).

mod hints;
mod html;
mod json;
mod junit;
mod page;
mod patterns;
mod pictures;
mod plot;

pub use html::html;
pub use json::json;
pub use junit::junit;

use super::{Outcome, Verdict};
use std::fmt::Write;

/// What a report says of the run as a whole.
#[derive(Clone, Debug)]
pub struct About {
    /// Who rendered, in words.
    pub renderer: String,
    /// The folder of the suite.
    pub suite: String,
    /// Multiplies the samples of each case.
    pub spp_scale: f64,
    /// Seed.
    pub seed: u32,
    /// Wall-clock seconds of everything.
    pub seconds: f64,
}

/// How many cases came to each verdict: passed, inconclusive, failed, error.
pub fn counts(outcomes: &[Outcome]) -> [usize; 4] {
    [Verdict::Passed, Verdict::Inconclusive, Verdict::Failed, Verdict::Error]
        .map(|verdict| outcomes.iter().filter(|outcome| outcome.verdict == verdict).count())
}

/// Text with what means something in HTML and XML replaced; characters that XML forbids become spaces.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c if c.is_control() && !matches!(c, '\n' | '\t') => out.push(' '),
            '\u{fffe}' | '\u{ffff}' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A number with as many digits as one can compare.
fn digits(value: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - magnitude).clamp(0.0, 7.0) as usize;
    format!("{value:.decimals$}")
}

/// Appends to a text; writing to a string cannot fail.
fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = out.write_fmt(text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_safe_in_a_page() {
        assert_eq!(escape("<a href='x'>&\"\u{1}b"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot; b");
    }

    #[test]
    fn numbers_have_four_digits() {
        for (value, text) in
            [(0.0, "0"), (1.0, "1.000"), (0.012344, "0.01234"), (12_345.6, "12346"), (1e-7, "1.000e-7")]
        {
            assert_eq!(digits(value), text);
        }
        assert_eq!(digits(f64::NAN), "NaN");
    }
}
