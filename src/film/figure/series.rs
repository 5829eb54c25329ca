//! The data of a plot, and its paths in pixels.

use super::{Layout, Rgb};

/// Pixels outside of the frame that lines are followed to, so that their ends are cut by it.
const BEYOND: f64 = 20.0;

/// One measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Along the horizontal axis.
    pub x: f64,
    /// Along the vertical axis.
    pub y: f64,
    /// Standard error of `y`; a whisker from `y − error` to `y + error` is drawn if it is finite and above zero.
    pub error: f64,
}

impl From<(f64, f64)> for Point {
    fn from((x, y): (f64, f64)) -> Self {
        Self { x, y, error: 0.0 }
    }
}

impl From<(f64, f64, f64)> for Point {
    fn from((x, y, error): (f64, f64, f64)) -> Self {
        Self { x, y, error }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// Discs.
    Markers,
    /// A line with discs.
    LineAndMarkers,
}

impl Style {
    pub(super) fn has_line(self) -> bool {
        self != Self::Markers
    }

    pub(super) fn has_markers(self) -> bool {
        matches!(self, Self::Markers | Self::LineAndMarkers)
    }
}

/// Points that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; a series without one is not listed.
    pub name: String,
    /// The points, in the order of the line. A point that cannot be shown (not finite; not above zero on a logarithmic
    /// axis) is left out and interrupts the line.
    pub points: Vec<Point>,
    /// How they are drawn.
    pub style: Style,
    /// Their colour; without, the one of [`PALETTE`](super::PALETTE) that its place among the series gives.
    pub color: Option<Rgb>,
}

impl Series {
    /// A series in its default colour.
    pub fn new<P: Into<Point>>(
        name: impl Into<String>,
        style: Style,
        points: impl IntoIterator<Item = P>,
    ) -> Self {
        let points = points.into_iter().map(Into::into).collect();
        Self { name: name.into(), points, style, color: None }
    }

    /// The lines that are near the frame, in pixels.
    pub(super) fn lines(&self, layout: &Layout) -> Vec<Vec<(f32, f32)>> {
        let mut lines: Vec<Vec<(f32, f32)>> = Vec::new();
        let mut previous: Option<(f64, f64)> = None;
        for point in &self.points {
            let here = layout.pixel(point.x, point.y);
            if let (Some(a), Some(b)) = (previous, here)
                && let Some((a, b)) = clip(a, b, layout)
            {
                match lines.last_mut() {
                    Some(line) if line.last() == Some(&a) => line.push(b),
                    _ => lines.push(vec![a, b]),
                }
            }
            previous = here;
        }
        lines
    }

    /// Places of the points that are in the frame, in pixels.
    pub(super) fn markers(&self, layout: &Layout) -> Vec<(f32, f32)> {
        let places = self.points.iter().filter_map(|p| layout.pixel(p.x, p.y));
        places.filter(|p| layout.contains(*p)).map(narrow).collect()
    }

    /// Places of points that no line reaches, since both neighbours are left out.
    pub(super) fn islands(&self, layout: &Layout) -> Vec<(f32, f32)> {
        let places: Vec<_> = self.points.iter().map(|p| layout.pixel(p.x, p.y)).collect();
        let left_out = |i: usize| places.get(i).copied().flatten().is_none();
        let alone = |i: usize| left_out(i.wrapping_sub(1)) && left_out(i + 1);
        let islands = (0..places.len()).filter(|i| alone(*i)).filter_map(|i| places[i]);
        islands.filter(|p| layout.contains(*p)).map(narrow).collect()
    }

    /// The whiskers as (x, ends from top to bottom), in pixels; ends beyond the frame are where it is cut.
    pub(super) fn whiskers(&self, layout: &Layout) -> Vec<(f32, [f32; 2])> {
        let bottom = f64::from(layout.frame.bottom()) + BEYOND;
        let top = f64::from(layout.frame.y) - BEYOND;
        let mut whiskers = Vec::new();
        for p in self.points.iter().filter(|p| p.error > 0.0 && p.error.is_finite()) {
            let Some((x, _)) = layout.pixel(p.x, p.y) else { continue };
            if !layout.contains_column(x) {
                continue;
            }
            let end =
                |y: f64, beyond: f64| layout.pixel(p.x, y).map_or(beyond, |(_, y)| y).clamp(top, bottom);
            whiskers.push((x as f32, [end(p.y + p.error, top) as f32, end(p.y - p.error, bottom) as f32]));
        }
        whiskers
    }
}

/// The part of a segment that is in the frame or near it (Liang & Barsky 1984).
fn clip(a: (f64, f64), b: (f64, f64), layout: &Layout) -> Option<((f32, f32), (f32, f32))> {
    let frame = layout.frame;
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (step, room) in [
        (-dx, a.0 - (f64::from(frame.x) - BEYOND)),
        (dx, f64::from(frame.right()) + BEYOND - a.0),
        (-dy, a.1 - (f64::from(frame.y) - BEYOND)),
        (dy, f64::from(frame.bottom()) + BEYOND - a.1),
    ] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step > 0.0 {
            to = to.min(room / step);
        } else {
            from = from.max(room / step);
        }
    }
    let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
    (from <= to).then(|| {
        let start = if from == 0.0 { a } else { at(from) };
        let end = if to == 1.0 { b } else { at(to) };
        (narrow(start), narrow(end))
    })
}

fn narrow((x, y): (f64, f64)) -> (f32, f32) {
    (x as f32, y as f32)
}
