//! Sweeps as small line plots in SVG: what is expected as lines, what was measured as points.

use super::{digits, escape, put};
use crate::conformance::Outcome;

/// Size of a plot, and room around the frame, in pixels.
const SIZE: [f64; 2] = [420.0, 260.0];
const LEFT: f64 = 52.0;
const BOTTOM: f64 = 40.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 26.0;
/// Colors of the channels.
const COLORS: [&str; 3] = ["#c0392b", "#1e8449", "#2455a4"];
/// Where the values of one sweep span more than this factor, its axis is logarithmic.
const DECADES: f64 = 8.0;

/// One point of a sweep.
struct Point {
    x: f64,
    expected: f64,
    measured: f64,
    error: f64,
}

/// A plot for each sweep, in the order of its first case.
pub(super) fn sweeps(outcomes: &[Outcome]) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for sweep in outcomes.iter().filter_map(|o| o.case.sweep.as_ref()) {
        if !names.contains(&sweep.name.as_str()) {
            names.push(&sweep.name);
        }
    }
    names.into_iter().filter_map(|name| plot(name, outcomes)).collect()
}

fn plot(name: &str, outcomes: &[Outcome]) -> Option<String> {
    let mut curves: Vec<Vec<Point>> = (0..3).map(|_| Vec::new()).collect();
    let mut parameter = "";
    let mut across_channels = false;
    for outcome in outcomes {
        let Some(sweep) = outcome.case.sweep.as_ref().filter(|s| s.name == name) else { continue };
        let Some(finding) = outcome.findings.first() else { continue };
        parameter = &sweep.parameter;
        across_channels = sweep.values.len() == 3;
        for c in 0..3 {
            let point = Point {
                x: sweep.values[if across_channels { c } else { 0 }],
                expected: finding.expected.0[c],
                measured: finding.measured.mean[c],
                error: finding.measured.standard_error.map_or(0.0, |e| e[c]),
            };
            curves[if across_channels { 0 } else { c }].push(point);
        }
    }
    curves.retain(|curve| !curve.is_empty());
    curves.iter_mut().for_each(|curve| curve.sort_by(|a, b| a.x.total_cmp(&b.x)));
    (!curves.is_empty()).then(|| draw(parameter, &curves, across_channels))
}

/// From values to pixels.
struct Axes {
    x: [f64; 2],
    y: [f64; 2],
    logarithmic: bool,
}

impl Axes {
    fn of(curves: &[Vec<Point>]) -> Self {
        let all = || curves.iter().flatten();
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values
                .filter(|v| v.is_finite())
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
        };
        let [x0, x1] = range(&mut all().map(|p| p.x));
        let [y0, y1] = range(&mut all().flat_map(|p| [p.expected, p.measured]));
        let logarithmic = x0 > 0.0 && x1 / x0 > DECADES;
        let x = if logarithmic { [x0.ln(), x1.ln()] } else { [x0, x1] };
        Self { x: pad(x), y: pad([y0.min(y1), y1]), logarithmic }
    }

    fn x(&self, value: f64) -> f64 {
        let v = if self.logarithmic { value.ln() } else { value };
        LEFT + (v - self.x[0]) / (self.x[1] - self.x[0]) * (SIZE[0] - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        SIZE[1] - BOTTOM - (value - self.y[0]) / (self.y[1] - self.y[0]) * (SIZE[1] - BOTTOM - TOP)
    }
}

/// A range with some room on both sides, never empty.
fn pad([low, high]: [f64; 2]) -> [f64; 2] {
    let room = 0.08 * (high - low).max(0.02 * high.abs()).max(1e-6);
    [low - room, high + room]
}

fn draw(parameter: &str, curves: &[Vec<Point>], across_channels: bool) -> String {
    let axes = Axes::of(curves);
    let [width, height] = SIZE;
    let mut out = format!(
        "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{0}\">\
         <rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{1}\" height=\"{2}\" class=\"frame\"/>",
        escape(parameter),
        width - LEFT - RIGHT,
        height - BOTTOM - TOP,
    );
    put(
        &mut out,
        format_args!(
            "<text x=\"{}\" y=\"{}\" class=\"mid\">{}</text>",
            (LEFT + width - RIGHT) / 2.0,
            height - 6.0,
            escape(parameter)
        ),
    );
    for i in 0..=4 {
        let value = axes.y[0] + (axes.y[1] - axes.y[0]) * f64::from(i) / 4.0;
        let y = axes.y(value);
        put(
            &mut out,
            format_args!(
                "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\" class=\"grid\"/>\
                 <text x=\"{}\" y=\"{:.1}\" class=\"end\">{value:.3}</text>",
                width - RIGHT,
                LEFT - 5.0,
                y + 4.0
            ),
        );
    }
    for point in &curves[0] {
        put(
            &mut out,
            format_args!(
                "<text x=\"{:.1}\" y=\"{}\" class=\"mid\">{}</text>",
                axes.x(point.x),
                height - BOTTOM + 15.0,
                trim(point.x)
            ),
        );
    }
    for (i, curve) in curves.iter().enumerate() {
        let color = if across_channels { "#333" } else { COLORS[i % 3] };
        let line: Vec<String> =
            curve.iter().map(|p| format!("{:.1},{:.1}", axes.x(p.x), axes.y(p.expected))).collect();
        put(
            &mut out,
            format_args!("<polyline points=\"{}\" class=\"line\" stroke=\"{color}\"/>", line.join(" ")),
        );
        for (c, point) in curve.iter().enumerate().filter(|(_, p)| p.measured.is_finite()) {
            let color = if across_channels { COLORS[c % 3] } else { color };
            let (x, y) = (axes.x(point.x), axes.y(point.measured));
            let bar = (axes.y(point.measured - point.error) - y).abs().min(height);
            put(
                &mut out,
                format_args!(
                    "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\"/>\
                     <circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"><title>measured {}, expected {}</title></circle>",
                    y - bar,
                    y + bar,
                    digits(point.measured),
                    digits(point.expected)
                ),
            );
        }
    }
    put(&mut out, format_args!("<text x=\"{LEFT}\" y=\"16\">line: expected; points: measured</text></svg>"));
    out
}

/// A number as it was written.
fn trim(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_everything_and_are_never_empty() {
        let point = |x, y| Point { x, expected: y, measured: y, error: 0.0 };
        for curves in [
            vec![vec![point(1.0, 1.0)]],
            vec![vec![point(0.2, 0.0), point(8.0, 0.5)]],
            vec![vec![point(0.0, f64::NAN), point(1.0, 2.0)]],
        ] {
            let axes = Axes::of(&curves);
            for point in curves.iter().flatten().filter(|p| p.expected.is_finite()) {
                let (x, y) = (axes.x(point.x), axes.y(point.expected));
                assert!((LEFT..=SIZE[0] - RIGHT).contains(&x), "{x}");
                assert!((TOP..=SIZE[1] - BOTTOM).contains(&y), "{y}");
            }
        }
        assert_eq!((trim(1.0), trim(0.25), trim(-0.5)), ("1".into(), "0.25".into(), "-0.5".into()));
    }
}
