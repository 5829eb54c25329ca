//! Text as outlines, set in DejaVu Sans at any size, with kerning.

use std::sync::LazyLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// The built-in font; `None` would mean that it is damaged.
static FACE: LazyLock<Option<Face<'static>>> = LazyLock::new(|| Face::parse(dejavu::sans::regular(), 0).ok());

/// Height of a capital over the font size.
pub(super) const CAP_HEIGHT: f32 = 0.729;
/// Characters of a cut text at most.
const LONGEST: usize = 500;
/// Distance of two lines over the font size.
pub(super) const LEADING: f32 = 1.35;

/// The outline of a line of text that starts at the origin, baseline at 0, y down, in pixels; nothing for blanks.
pub(super) fn outline(text: &str, size: f32) -> Option<Path> {
    let face = FACE.as_ref()?;
    let mut pen = Pen { path: PathBuilder::new(), x: 0.0, scale: size / f32::from(face.units_per_em()) };
    for (glyph, x) in place(face, text).0 {
        pen.x = x * pen.scale;
        face.outline_glyph(glyph, &mut pen);
    }
    pen.path.finish()
}

/// The width of a line of text in pixels.
pub(super) fn width(text: &str, size: f32) -> f32 {
    FACE.as_ref().map_or(0.0, |face| place(face, text).1 * size / f32::from(face.units_per_em()))
}

/// The text, cut with an ellipsis if it is wider than `limit` pixels.
pub(super) fn fit(text: &str, size: f32, limit: f32) -> String {
    if width(text, size) <= limit {
        return text.to_owned();
    }
    let mut kept: String = text.chars().take(LONGEST).collect();
    while kept.pop().is_some() {
        let cut = format!("{}…", kept.trim_end());
        if width(&cut, size) <= limit {
            return cut;
        }
    }
    String::new()
}

/// The text in lines of at most `limit` pixels, broken at blanks; words that are wider are cut.
pub(super) fn wrap(text: &str, size: f32, limit: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if width(&longer, size) <= limit {
                line = longer;
            } else {
                if !line.is_empty() {
                    lines.push(line);
                }
                line = fit(word, size, limit);
            }
        }
        lines.push(line);
    }
    lines
}

/// Glyphs with their positions, and the end of the line, in font units.
fn place(face: &Face, text: &str) -> (Vec<(GlyphId, f32)>, f32) {
    let mut glyphs: Vec<(GlyphId, f32)> = Vec::new();
    let mut x = 0.0;
    for c in text.chars() {
        let c = if c.is_control() { ' ' } else { c };
        let glyph = face.glyph_index(c).unwrap_or_default();
        if let Some((previous, _)) = glyphs.last() {
            x += kerning(face, *previous, glyph);
        }
        glyphs.push((glyph, x));
        x += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0));
    }
    (glyphs, x)
}

fn kerning(face: &Face, left: GlyphId, right: GlyphId) -> f32 {
    let Some(table) = face.tables().kern else { return 0.0 };
    let horizontal = table.subtables.into_iter().filter(|t| t.horizontal && !t.has_state_machine);
    horizontal.filter_map(|t| t.glyphs_kerning(left, right)).map(f32::from).sum()
}

/// Draws glyphs, which are y up, at a place on the line.
struct Pen {
    path: PathBuilder,
    x: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_font_has_what_figures_need() {
        let face = FACE.as_ref().expect("the font is readable");
        for c in "AZaz09 ×·−±²³⁰¹⁴⁵⁶⁷⁸⁹⁻…°√∞≤ασηρµ".chars() {
            assert!(face.glyph_index(c).is_some(), "{c} is missing");
        }
    }

    #[test]
    fn lines_are_cut_and_wrapped_to_their_width() {
        let text = "relative mean squared error 0.00123, 12.3 seconds";
        for limit in [0.0, 5.0, 60.0, 150.0, 1000.0] {
            assert!(width(&fit(text, 14.0, limit), 14.0) <= limit);
            let lines = wrap(text, 14.0, limit);
            assert!(lines.iter().all(|l| width(l, 14.0) <= limit), "{lines:?}");
        }
        assert_eq!(wrap(text, 14.0, 150.0).join(" "), text);
        assert_eq!(wrap("one\ntwo", 14.0, 1000.0), ["one", "two"]);
        assert!(outline(" \u{0}\n", 14.0).is_none());
    }
}
