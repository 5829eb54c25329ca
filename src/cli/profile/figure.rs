//! The figure: for each channel R(r) on the left, and each model over the random walk on the right.

use super::{Curve, Curves, Source};
use crate::film::figure::{Axis, FigureError, PALETTE, Plot, Point, REFERENCE, Raster, Series, Style};

/// Pixels of one plot.
const WIDTH: u32 = 1040;
const HEIGHT: u32 = 800;
/// Decades of R below its largest value that are shown at most.
const DECADES: i32 = 9;
/// Bins in which the walk is less certain than this, relatively, are not divided by.
const UNCERTAIN: f64 = 0.25;
/// Least and largest quotient that is shown.
const QUOTIENTS: [f64; 2] = [0.1, 10.0];

/// Draws all channels.
pub(super) fn draw(found: &[Curves]) -> Result<Raster, FigureError> {
    let rows: Result<Vec<_>, _> =
        found.iter().map(|curves| Ok(vec![profiles(curves).draw()?, quotients(curves).draw()?])).collect();
    Raster::grid(&rows?)
}

/// R(r) against the distance in millimetres.
fn profiles(curves: &Curves) -> Plot {
    let c = &curves.channel.coefficients;
    let unit = 1e3 * c.transport_mean_free_path();
    let scaled = |(r, value): (f64, f64)| (r * unit, value / (unit * unit));
    let mut series: Vec<Series> = curves
        .models
        .iter()
        .enumerate()
        .map(|(i, curve)| match curve.source {
            Source::ClosedForm => {
                line(i, curve.name.clone(), curve.line.iter().copied().map(scaled).map(Point::from))
            }
            Source::Measured => {
                let name = format!("{} (measured)", curve.name);
                points(i, name, curves, curve, unit)
            }
        })
        .collect();
    let walk = Series {
        style: Style::Markers,
        color: Some(REFERENCE),
        ..points(0, curves.walk.name.clone(), curves, &curves.walk, unit)
    };
    let values = walk.points.iter().map(|p| p.y).filter(|y| *y > 0.0);
    let (least, largest) = values.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), y| (a.min(y), b.max(y)));
    let y = Axis::log("R(r) / mm⁻²");
    let y = if largest > 0.0 {
        y.with_range((0.3 * least).max(largest * 10f64.powi(-DECADES)), 10.0 * largest)
    } else {
        y
    };
    series.push(walk);
    Plot {
        title: format!(
            "{}: σa {}, σs {} mm⁻¹, g {}, η {}",
            curves.channel.title,
            short(1e-3 * c.sigma_a),
            short(1e-3 * c.sigma_s),
            short(c.g),
            short(c.eta)
        ),
        x: range(Axis::log("distance r / mm"), curves, unit),
        y,
        series,
        width: WIDTH,
        height: HEIGHT,
    }
}

/// R(r) over that of the walk, against the distance in transport mean free paths.
fn quotients(curves: &Curves) -> Plot {
    let certain = |i: usize| {
        let walk = curves.walk.bins[i];
        walk.value > 0.0 && walk.standard_error < UNCERTAIN * walk.value
    };
    let over = |curve: &Curve, i: usize, error: f64| {
        let walk = curves.walk.bins[i].value;
        Point { x: middle(curves, i), y: curve.bins[i].value / walk, error: error / walk }
    };
    let bins = || (0..curves.walk.bins.len()).filter(|i| certain(*i));
    let mut series: Vec<Series> = curves
        .models
        .iter()
        .enumerate()
        .map(|(i, curve)| {
            let style = if curve.source == Source::Measured { Style::LineAndMarkers } else { Style::Line };
            let all = bins().map(|bin| over(curve, bin, 0.0));
            Series { style, ..line(i, String::new(), all) }
        })
        .collect();
    let walk = bins().map(|i| over(&curves.walk, i, curves.walk.bins[i].standard_error));
    series.push(Series {
        name: String::new(),
        points: walk.collect(),
        style: Style::Markers,
        color: Some(REFERENCE),
    });
    let total = curves.walk.total;
    Plot {
        title: format!(
            "over the random walk: 1/σt′ {} mm, reflectance {:.4} ± {:.4}",
            short(1e3 * curves.channel.coefficients.transport_mean_free_path()),
            total.value,
            total.standard_error
        ),
        x: range(Axis::log("distance r σt′, in transport mean free paths"), curves, 1.0),
        y: Axis::log("R(r) / R(r) of the random walk").with_range(QUOTIENTS[0], QUOTIENTS[1]),
        series,
        width: WIDTH,
        height: HEIGHT,
    }
}

fn range(axis: Axis, curves: &Curves, unit: f64) -> Axis {
    match curves.edges[..] {
        [first, .., last] => axis.with_range(unit * first, unit * last),
        _ => axis,
    }
}

fn line(i: usize, name: String, points: impl Iterator<Item = Point>) -> Series {
    Series { color: Some(PALETTE[i % PALETTE.len()]), ..Series::new(name, Style::Line, points) }
}

/// The bins of a measured curve.
fn points(i: usize, name: String, curves: &Curves, curve: &Curve, unit: f64) -> Series {
    let of = |(bin, share): (usize, &crate::transport::searchlight::Share)| Point {
        x: unit * middle(curves, bin),
        y: share.value / (unit * unit),
        error: share.standard_error / (unit * unit),
    };
    Series { style: Style::LineAndMarkers, ..line(i, name, curve.bins.iter().enumerate().map(of)) }
}

/// The middle of a bin, as the eye sees it on a logarithmic axis.
fn middle(curves: &Curves, bin: usize) -> f64 {
    (curves.edges[bin] * curves.edges[bin + 1]).sqrt()
}

/// A number with at most four digits.
fn short(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    let decimals = (3 - v.abs().log10().floor() as i32).clamp(0, 8) as usize;
    let text = format!("{v:.decimals$}").replace('-', "−");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (v, text) in
            [(0.0, "0"), (1.3, "1.3"), (0.0025, "0.0025"), (-0.25, "−0.25"), (1222.5, "1222"), (100.0, "100")]
        {
            assert_eq!(short(v), text);
        }
    }
}
