//! A white page that shapes and text are drawn on.

use super::{FigureError, Raster, Rect, Rgb, check_size, text};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

/// Where a text stands against its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Align {
    Left,
    Center,
    Right,
}

/// Size and colour of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Type {
    pub size: f32,
    pub color: Rgb,
}

/// Colour, width and dashes (lengths of lines and gaps; empty is solid) of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ink {
    pub color: Rgb,
    pub width: f32,
    pub dashes: &'static [f32],
}

impl Ink {
    pub(super) fn solid(color: Rgb, width: f32) -> Self {
        Self { color, width, dashes: &[] }
    }
}

/// The page. Shapes are cut at the clip rectangle while there is one.
pub(super) struct Canvas {
    pixmap: Pixmap,
    clip: Option<Mask>,
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32) -> Result<Self, FigureError> {
        let size = FigureError::Size { width: width.into(), height: height.into() };
        check_size(width.into(), height.into())?;
        let mut pixmap = Pixmap::new(width, height).ok_or(size)?;
        pixmap.fill(Color::WHITE);
        Ok(Self { pixmap, clip: None })
    }

    pub(super) fn set_clip(&mut self, rect: Option<Rect>) {
        self.clip = rect.and_then(|rect| {
            let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
            mask.fill_path(&rectangle(rect)?, FillRule::Winding, false, Transform::identity());
            Some(mask)
        });
    }

    pub(super) fn fill_rect(&mut self, rect: Rect, color: Rgb) {
        if let Some(path) = rectangle(rect) {
            self.fill(&path, color, Transform::identity());
        }
    }

    /// The outline of a rectangle, one pixel wide, just outside of it.
    pub(super) fn border(&mut self, rect: Rect, color: Rgb) {
        let (x, y) = (rect.x.saturating_sub(1), rect.y.saturating_sub(1));
        let (width, height) = (rect.right() - x + 1, rect.bottom() - y + 1);
        for side in [
            Rect { x, y, width, height: 1 },
            Rect { x, y: rect.bottom(), width, height: 1 },
            Rect { x, y, width: 1, height },
            Rect { x: rect.right(), y, width: 1, height },
        ] {
            self.fill_rect(side, color);
        }
    }

    pub(super) fn polyline(&mut self, points: &[(f32, f32)], ink: Ink) {
        let mut builder = PathBuilder::new();
        for (i, &(x, y)) in points.iter().enumerate() {
            if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
        }
        let Some(path) = builder.finish() else { return };
        let stroke = Stroke {
            width: ink.width,
            line_cap: if ink.dashes.is_empty() { LineCap::Round } else { LineCap::Butt },
            line_join: LineJoin::Round,
            dash: StrokeDash::new(ink.dashes.to_vec(), 0.0),
            ..Stroke::default()
        };
        let paint = paint(ink.color);
        self.pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), self.clip.as_ref());
    }

    pub(super) fn disc(&mut self, x: f32, y: f32, radius: f32, color: Rgb) {
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            self.fill(&path, color, Transform::identity());
        }
    }

    /// A line of text, its baseline through `y`.
    pub(super) fn text(&mut self, x: f32, y: f32, align: Align, kind: Type, text: &str) {
        let x = x - before(align, text, kind.size);
        if let Some(path) = text::outline(text, kind.size) {
            self.fill(&path, kind.color, Transform::from_translate(x.round(), y.round()));
        }
    }

    /// A line of text that reads upwards, its baseline through `x`, its middle at `y`.
    pub(super) fn text_upwards(&mut self, x: f32, y: f32, kind: Type, text: &str) {
        let y = y + before(Align::Center, text, kind.size);
        if let Some(path) = text::outline(text, kind.size) {
            let turned = Transform::from_row(0.0, -1.0, 1.0, 0.0, x.round(), y.round());
            self.fill(&path, kind.color, turned);
        }
    }

    fn fill(&mut self, path: &Path, color: Rgb, transform: Transform) {
        self.pixmap.fill_path(path, &paint(color), FillRule::Winding, transform, self.clip.as_ref());
    }

    /// The finished page, with `inserts` copied onto it pixel by pixel at their left top corners.
    pub(super) fn finish(self, inserts: &[(u32, u32, &Raster)]) -> Raster {
        let (width, height) = (self.pixmap.width(), self.pixmap.height());
        let mut rgb: Vec<u8> =
            self.pixmap.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        let row = 3 * width as usize;
        for &(x, y, picture) in inserts {
            let columns = 3 * picture.width.min(width.saturating_sub(x)) as usize;
            let start = 3 * x as usize;
            let from = picture.rgb.chunks_exact(3 * picture.width as usize);
            for (to, from) in rgb.chunks_exact_mut(row).skip(y as usize).zip(from) {
                if columns > 0 {
                    to[start..start + columns].copy_from_slice(&from[..columns]);
                }
            }
        }
        Raster { width, height, rgb }
    }
}

/// How much of the text is left of its point.
fn before(align: Align, text: &str, size: f32) -> f32 {
    match align {
        Align::Left => 0.0,
        Align::Center => 0.5 * text::width(text, size),
        Align::Right => text::width(text, size),
    }
}

fn rectangle(rect: Rect) -> Option<Path> {
    let [x, y, width, height] = [rect.x, rect.y, rect.width, rect.height].map(|v| v as f32);
    tiny_skia::Rect::from_xywh(x, y, width, height).map(PathBuilder::from_rect)
}

fn paint(color: Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(color[0], color[1], color[2], 255);
    paint
}
