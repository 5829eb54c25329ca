//! Line plots.

use super::axis::{Mapping, Ticks};
use super::canvas::{Align, Canvas, Ink, Type};
use super::{Axis, FigureError, PALETTE, Point, Raster, Rect, Rgb, Series, Style, text};

mod legend;

const TITLE: Type = Type { size: 24.0, color: BLACK };
const AXIS_TITLE: Type = Type { size: 18.0, color: BLACK };
const LABEL: Type = Type { size: 16.0, color: BLACK };
const BLACK: Rgb = [30; 3];
const GRID: Ink = Ink { color: [228; 3], width: 1.0, dashes: &[] };
/// Blank pixels around everything.
const MARGIN: f32 = 22.0;
/// Length of a tick, and the pixels between it and its label.
const TICK: f32 = 6.0;
const TICK_GAP: f32 = 5.0;
const LINE_WIDTH: f32 = 2.4;
const MARKER_RADIUS: f32 = 4.2;
/// Half the width of a whisker's ends.
const WHISKER_CAP: f32 = 5.0;
/// Smallest frame, in pixels.
const MIN_FRAME: [f32; 2] = [80.0, 60.0];

/// A line plot. The defaults make a linear plot of 1200 × 800 pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Line over the frame; may be empty.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The data, in the order of the legend. Markers are drawn over lines, later series over earlier ones.
    pub series: Vec<Series>,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Default for Plot {
    fn default() -> Self {
        let (x, y) = (Axis::default(), Axis::default());
        Self { title: String::new(), x, y, series: Vec::new(), width: 1200, height: 800 }
    }
}

/// Where things of a plot are.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The frame that data are drawn in.
    pub frame: Rect,
    x: Mapping,
    y: Mapping,
    x_ticks: Ticks,
    y_ticks: Ticks,
}

impl Layout {
    /// Where a point is, in pixels from the left top corner of the picture (the middle of the first pixel is at ½);
    /// outside of the frame if the axes do not reach it. Nothing for points that cannot be shown.
    pub fn pixel(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (x, y) = (self.x.position(x)?, self.y.position(y)?);
        let frame = self.frame;
        Some((
            f64::from(frame.x) + x * f64::from(frame.width),
            f64::from(frame.bottom()) - y * f64::from(frame.height),
        ))
    }

    /// First and last value of the horizontal and of the vertical axis.
    pub fn ranges(&self) -> [[f64; 2]; 2] {
        [[self.x.min, self.x.max], [self.y.min, self.y.max]]
    }

    pub(super) fn contains_column(&self, x: f64) -> bool {
        x >= f64::from(self.frame.x) && x <= f64::from(self.frame.right())
    }

    pub(super) fn contains(&self, (x, y): (f64, f64)) -> bool {
        self.contains_column(x) && y >= f64::from(self.frame.y) && y <= f64::from(self.frame.bottom())
    }
}

impl Plot {
    /// Where things will be drawn.
    pub fn layout(&self) -> Result<Layout, FigureError> {
        Ok(self.place_legend()?.0)
    }

    /// Draws the plot.
    pub fn draw(&self) -> Result<Raster, FigureError> {
        let mut canvas = Canvas::new(self.width, self.height)?;
        let (layout, legend) = self.place_legend()?;
        draw_grid(&mut canvas, &layout);
        canvas.set_clip(Some(layout.frame));
        for (i, series) in self.series.iter().enumerate() {
            self.draw_whiskers(&mut canvas, &layout, series, self.color(i));
            self.draw_lines(&mut canvas, &layout, i);
        }
        for (i, series) in self.series.iter().enumerate().filter(|(_, s)| s.style.has_markers()) {
            for (x, y) in series.markers(&layout) {
                canvas.disc(x, y, MARKER_RADIUS, self.color(i));
            }
        }
        canvas.set_clip(None);
        self.draw_axes(&mut canvas, &layout);
        if let Some(legend) = legend {
            self.draw_legend(&mut canvas, &legend);
        }
        Ok(canvas.finish(&[]))
    }

    fn color(&self, series: usize) -> Rgb {
        self.series[series].color.unwrap_or(PALETTE[series % PALETTE.len()])
    }

    fn ink(&self, series: usize) -> Ink {
        const DASHES: [&[f32]; 3] = [&[], &[9.0, 5.0], &[2.5, 4.0]];
        let round = series / PALETTE.len() + usize::from(self.series[series].style == Style::Dashed);
        Ink { color: self.color(series), width: LINE_WIDTH, dashes: DASHES[round % DASHES.len()] }
    }

    /// Places of everything, with so many columns on the right left free.
    fn layout_beside(&self, reserved: f32) -> Result<Layout, FigureError> {
        let points = || self.series.iter().flat_map(|s| &s.points);
        let x = self.x.mapping(points().filter(|p| p.y.is_finite()).map(|p| p.x))?;
        let ends = |p: &Point| {
            let error = if p.error.is_finite() { p.error.max(0.0) } else { 0.0 };
            [p.y, p.y + error, p.y - error]
        };
        let y = self.y.mapping(points().filter(|p| p.x.is_finite()).flat_map(ends))?;

        let line = |kind: Type, used: bool| if used { kind.size * text::LEADING } else { 0.0 };
        let title = line(TITLE, !self.title.is_empty());
        let below = TICK + TICK_GAP + LABEL.size + line(AXIS_TITLE, !self.x.title.is_empty());
        let top = (MARGIN + title).round();
        let bottom = (self.height as f32 - MARGIN - below).round();
        let y_ticks = choose_ticks(&y, bottom - top, 50.0, |_| 1.3 * LABEL.size);
        let factor = if y_ticks.factor.is_some() { line(LABEL, true).round() } else { 0.0 };
        let top = top + factor;

        let widest = labels(&y_ticks).map(|l| text::width(l, LABEL.size)).fold(0.0, f32::max);
        let y_title = line(AXIS_TITLE, !self.y.title.is_empty());
        let left = (MARGIN + y_title + widest + TICK + TICK_GAP).round();
        let right = (self.width as f32 - (MARGIN + reserved).max(MARGIN + 14.0)).round();
        let [wide, high] = [right - left, bottom - top];
        if !(wide >= MIN_FRAME[0] && high >= MIN_FRAME[1]) {
            return Err(FigureError::Size { width: self.width.into(), height: self.height.into() });
        }
        let x_ticks = choose_ticks(&x, wide, 90.0, |l| text::width(l, LABEL.size) + 16.0);
        let frame = Rect { x: left as u32, y: top as u32, width: wide as u32, height: high as u32 };
        Ok(Layout { frame, x, y, x_ticks, y_ticks })
    }

    fn draw_whiskers(&self, canvas: &mut Canvas, layout: &Layout, series: &Series, color: Rgb) {
        let ink = Ink::solid(color, 1.4);
        for (x, [top, bottom]) in series.whiskers(layout) {
            canvas.polyline(&[(x, top), (x, bottom)], ink);
            for end in [top, bottom] {
                canvas.polyline(&[(x - WHISKER_CAP, end), (x + WHISKER_CAP, end)], ink);
            }
        }
    }

    fn draw_lines(&self, canvas: &mut Canvas, layout: &Layout, i: usize) {
        let series = &self.series[i];
        if series.style.has_line() {
            for line in series.lines(layout) {
                canvas.polyline(&line, self.ink(i));
            }
            for (x, y) in series.islands(layout) {
                canvas.disc(x, y, LINE_WIDTH, self.color(i));
            }
        }
    }

    fn draw_axes(&self, canvas: &mut Canvas, layout: &Layout) {
        let frame = layout.frame;
        canvas.border(frame, BLACK);
        let [left, top, right, bottom] = [frame.x, frame.y, frame.right(), frame.bottom()].map(|v| v as f32);
        let (middle_x, middle_y) = (0.5 * (left + right), 0.5 * (top + bottom));
        let ink = Ink::solid(BLACK, 1.0);
        for tick in &layout.x_ticks.ticks {
            let Some(x) = layout.x.position(tick.value).map(|p| crisp(left + p as f32 * (right - left)))
            else {
                continue;
            };
            let length = if tick.label.is_some() { TICK } else { 0.5 * TICK };
            canvas.polyline(&[(x, bottom + 0.5), (x, bottom + length)], ink);
            if let Some(label) = &tick.label {
                let y = bottom + TICK + TICK_GAP + LABEL.size * text::CAP_HEIGHT;
                canvas.text(x, y, Align::Center, LABEL, label);
            }
        }
        for tick in &layout.y_ticks.ticks {
            let Some(y) = layout.y.position(tick.value).map(|p| crisp(bottom - p as f32 * (bottom - top)))
            else {
                continue;
            };
            let length = if tick.label.is_some() { TICK } else { 0.5 * TICK };
            canvas.polyline(&[(left - 0.5, y), (left - length, y)], ink);
            if let Some(label) = &tick.label {
                let baseline = y + 0.5 * LABEL.size * text::CAP_HEIGHT;
                canvas.text(left - TICK - TICK_GAP, baseline, Align::Right, LABEL, label);
            }
        }
        let last_line = self.height as f32 - MARGIN - 0.2 * AXIS_TITLE.size;
        if let Some(factor) = &layout.x_ticks.factor {
            canvas.text(right, last_line, Align::Right, LABEL, factor);
        }
        if let Some(factor) = &layout.y_ticks.factor {
            canvas.text(left, top - 8.0, Align::Left, LABEL, factor);
        }
        let fit = |title: &str, kind: Type, room: f32| text::fit(title, kind.size, room);
        let x_title = fit(&self.x.title, AXIS_TITLE, (right - left) - 160.0);
        canvas.text(middle_x, last_line, Align::Center, AXIS_TITLE, &x_title);
        let y_title = fit(&self.y.title, AXIS_TITLE, bottom - top);
        canvas.text_upwards(MARGIN + AXIS_TITLE.size * text::CAP_HEIGHT, middle_y, AXIS_TITLE, &y_title);
        let title = fit(&self.title, TITLE, right - left);
        canvas.text(middle_x, MARGIN + TITLE.size * text::CAP_HEIGHT, Align::Center, TITLE, &title);
    }
}

fn draw_grid(canvas: &mut Canvas, layout: &Layout) {
    let frame = layout.frame;
    let [left, top, right, bottom] = [frame.x, frame.y, frame.right(), frame.bottom()].map(|v| v as f32);
    let labelled =
        |t: &Ticks| -> Vec<f64> { t.ticks.iter().filter(|t| t.label.is_some()).map(|t| t.value).collect() };
    for x in labelled(&layout.x_ticks).into_iter().filter_map(|v| layout.x.position(v)) {
        let x = crisp(left + x as f32 * (right - left));
        canvas.polyline(&[(x, top), (x, bottom)], GRID);
    }
    for y in labelled(&layout.y_ticks).into_iter().filter_map(|v| layout.y.position(v)) {
        let y = crisp(bottom - y as f32 * (bottom - top));
        canvas.polyline(&[(left, y), (right, y)], GRID);
    }
}

/// The middle of the pixel, where a line one pixel wide is sharp.
fn crisp(v: f32) -> f32 {
    v.floor() + 0.5
}

fn labels(ticks: &Ticks) -> impl Iterator<Item = &String> {
    ticks.ticks.iter().filter_map(|t| t.label.as_ref())
}

/// As many ticks as there is room for: one every `spacing` pixels, and no label (with its `extent`) on another.
fn choose_ticks(axis: &Mapping, pixels: f32, spacing: f32, extent: impl Fn(&str) -> f32) -> Ticks {
    let most = ((pixels / spacing) as usize).clamp(2, 40);
    let fits = |ticks: &Ticks| {
        let labelled = ticks.ticks.iter().filter_map(|t| Some((axis.position(t.value)?, t.label.as_ref()?)));
        let spans: Vec<(f32, f32)> =
            labelled.map(|(at, label)| (at as f32 * pixels, 0.5 * extent(label))).collect();
        spans.windows(2).all(|pair| pair[0].0 + pair[0].1 <= pair[1].0 - pair[1].1)
    };
    (2..=most).rev().map(|n| axis.ticks(n)).find(fits).unwrap_or_else(|| axis.ticks(2))
}
