//! The legend: in a corner of the frame that no data reach, or else beside the frame.

use super::{Ink, LABEL, Layout, MARGIN, MARKER_RADIUS, Plot, WHISKER_CAP};
use crate::film::figure::canvas::{Align, Canvas};
use crate::film::figure::{FigureError, Rect, text};

/// Length of a sample of the line, and pixels between it and the name, and around everything.
const SAMPLE: f32 = 36.0;
const GAP: f32 = 10.0;
const PADDING: f32 = 12.0;
/// Height of an entry.
const ROW: f32 = 26.0;
/// Pixels between the legend and the frame.
const DISTANCE: f32 = 14.0;
/// Widest name, over the width of the picture.
const WIDEST: f32 = 0.35;

/// Entries and their place.
pub(super) struct Legend {
    rect: Rect,
    entries: Vec<(Option<usize>, String)>,
}

impl Plot {
    /// The legend, if there are names and the picture is large enough for it, and the layout that leaves room for it.
    pub(super) fn place_legend(&self) -> Result<(Layout, Option<Legend>), FigureError> {
        let layout = self.layout_beside(0.0)?;
        let room = ((layout.frame.height as f32 - 2.0 * (PADDING + DISTANCE)) / ROW).max(1.0) as usize;
        let entries = self.entries(room);
        if entries.is_empty() {
            return Ok((layout, None));
        }
        let names = entries.iter().map(|(_, name)| text::width(name, LABEL.size)).fold(0.0, f32::max);
        let width = (2.0 * PADDING + SAMPLE + GAP + names).ceil();
        let height = (2.0 * PADDING + entries.len() as f32 * ROW).ceil();
        if let Some(rect) = self.free_corner(&layout, width, height) {
            return Ok((layout, Some(Legend { rect, entries })));
        }
        let Ok(beside) = self.layout_beside(width + DISTANCE) else {
            return Ok((layout, None));
        };
        let (x, y) = (beside.frame.right() + DISTANCE as u32, beside.frame.y);
        let rect = Rect { x, y, width: width as u32, height: height as u32 };
        Ok((beside, Some(Legend { rect, entries })))
    }

    /// Names with their series; what there is no room for is counted.
    fn entries(&self, room: usize) -> Vec<(Option<usize>, String)> {
        let limit = WIDEST * self.width as f32 - MARGIN;
        let named = self.series.iter().enumerate().filter(|(_, s)| !s.name.is_empty());
        let mut entries: Vec<_> =
            named.map(|(i, s)| (Some(i), text::fit(&s.name, LABEL.size, limit))).collect();
        if entries.len() > room {
            let hidden = entries.len() - (room - 1);
            entries.truncate(room - 1);
            entries.push((None, format!("{hidden} more")));
        }
        entries
    }

    /// A corner of the frame where the legend covers no data.
    fn free_corner(&self, layout: &Layout, width: f32, height: f32) -> Option<Rect> {
        let frame = layout.frame;
        let [left, top, right, bottom] = [frame.x, frame.y, frame.right(), frame.bottom()].map(|v| v as f32);
        let (far_x, far_y) = (right - DISTANCE - width, bottom - DISTANCE - height);
        let (near_x, near_y) = (left + DISTANCE, top + DISTANCE);
        if far_x < near_x || far_y < near_y {
            return None;
        }
        let drawn = self.drawn_pixels(layout);
        let free = |&(x, y): &(f32, f32)| {
            let clear = MARKER_RADIUS + 4.0;
            let hit = |&(px, py): &(f32, f32)| {
                px > x - clear && px < x + width + clear && py > y - clear && py < y + height + clear
            };
            !drawn.iter().any(hit)
        };
        let corners = [(far_x, near_y), (near_x, far_y), (near_x, near_y), (far_x, far_y)];
        corners.into_iter().find(free).map(|(x, y)| Rect {
            x: x as u32,
            y: y as u32,
            width: width as u32,
            height: height as u32,
        })
    }

    /// Pixels of the data, a few apart.
    fn drawn_pixels(&self, layout: &Layout) -> Vec<(f32, f32)> {
        const APART: f32 = 5.0;
        let mut pixels = Vec::new();
        let mut segment = |a: (f32, f32), b: (f32, f32)| {
            let n = ((b.0 - a.0).hypot(b.1 - a.1) / APART).ceil().max(1.0);
            pixels.extend(
                (0..=n as usize)
                    .map(|i| i as f32 / n)
                    .map(|t| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))),
            );
        };
        for series in &self.series {
            for line in series.lines(layout).iter().filter(|_| series.style.has_line()) {
                line.windows(2).for_each(|ends| segment(ends[0], ends[1]));
            }
            for (x, [top, bottom]) in series.whiskers(layout) {
                segment((x, top), (x, bottom));
            }
            series.markers(layout).into_iter().for_each(|p| segment(p, p));
        }
        pixels
    }

    pub(super) fn draw_legend(&self, canvas: &mut Canvas, legend: &Legend) {
        canvas.fill_rect(legend.rect, [255; 3]);
        canvas.border(legend.rect, [190; 3]);
        let left = legend.rect.x as f32 + PADDING;
        for (row, (series, name)) in legend.entries.iter().enumerate() {
            let y = legend.rect.y as f32 + PADDING + (row as f32 + 0.5) * ROW;
            let baseline = y + 0.5 * LABEL.size * text::CAP_HEIGHT;
            canvas.text(left + SAMPLE + GAP, baseline, Align::Left, LABEL, name);
            let Some(i) = *series else { continue };
            let (series, middle) = (&self.series[i], left + 0.5 * SAMPLE);
            if series.style.has_line() {
                canvas.polyline(&[(left, y), (left + SAMPLE, y)], self.ink(i));
            }
            if series.points.iter().any(|p| p.error > 0.0) {
                let (ink, half) = (Ink::solid(self.color(i), 1.4), 0.36 * ROW);
                canvas.polyline(&[(middle, y - half), (middle, y + half)], ink);
                for end in [y - half, y + half] {
                    canvas.polyline(&[(middle - WHISKER_CAP, end), (middle + WHISKER_CAP, end)], ink);
                }
            }
            if series.style.has_markers() {
                canvas.disc(middle, y, MARKER_RADIUS, self.color(i));
            }
        }
    }
}
