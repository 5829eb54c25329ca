//! Contact sheets: pictures side by side, each with its difference in false colour and a few lines of text.

use super::axis::superscript;
use super::canvas::{Align, Canvas, Ink, Type};
use super::{FigureError, Raster, Rect, Rgb, check_size, false_color, text};

const BLACK: Rgb = [30; 3];
const GREY: Rgb = [95; 3];
const BORDER: Rgb = [200; 3];
const TITLE: Type = Type { size: 26.0, color: BLACK };
const NAME: Type = Type { size: 18.0, color: BLACK };
const BODY: Type = Type { size: 14.0, color: GREY };
/// Blank pixels around everything, between cells, between the two pictures of a cell, and over its text.
const MARGIN: u32 = 28;
const GUTTER: u32 = 28;
const PICTURE_GAP: u32 = 8;
const TEXT_GAP: u32 = 10;
/// Pixels below the title, and between the cells, the scale and the footer.
const TITLE_GAP: u32 = 18;
const BLOCK_GAP: u32 = 24;
/// Below small pictures cells are wide enough for their names: at least and at most that wide.
const MIN_CELL: [u32; 2] = [200, 320];
/// Largest width of the scale, its height, and the height of its numbers.
const BAR_WIDTH: u32 = 420;
const BAR_HEIGHT: u32 = 16;
const BAR_NUMBERS: u32 = 24;
/// Shape that sheets come near to where the number of columns is free: width over height.
const SHAPE: f64 = 1.5;

/// Where the second picture of a cell is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// Below the first.
    #[default]
    Below,
    /// On the right of the first.
    Beside,
}

/// One entry of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The picture; pixels are copied as they are.
    pub picture: Raster,
    /// A second picture, as [`false_color::signed`] makes it.
    pub difference: Option<Raster>,
    /// What it shows.
    pub name: String,
    /// Further lines of text.
    pub lines: Vec<String>,
}

/// The scale of the false colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    /// The difference that has the full colour.
    pub full_scale: f32,
    /// Quantity and unit.
    pub label: String,
}

/// A contact sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Text over everything; may be empty.
    pub title: String,
    /// The entries, row by row. All cells are as large as the largest pictures ask for.
    pub cells: Vec<Cell>,
    /// Where the second pictures are.
    pub arrangement: Arrangement,
    /// Cells in a row; without, as many as make a sheet of a handy shape.
    pub columns: Option<usize>,
    /// The scale below the cells, if there is to be one.
    pub color_bar: Option<ColorBar>,
    /// Text below everything; may be empty.
    pub footer: String,
}

/// Where things of a sheet are.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetLayout {
    /// Columns of the whole.
    pub width: u32,
    /// Rows of the whole.
    pub height: u32,
    /// Each cell with its text.
    pub cells: Vec<Rect>,
    /// Each cell's picture.
    pub pictures: Vec<Rect>,
    /// Each cell's second picture.
    pub differences: Vec<Option<Rect>>,
    /// The coloured part of the scale.
    pub color_bar: Option<Rect>,
    title: Block,
    footer: Block,
    /// Lines of each cell: those of the name, and all others.
    texts: Vec<[Vec<String>; 2]>,
}

/// Lines of text and the row they start in.
#[derive(Clone, Debug, PartialEq)]
struct Block {
    top: u32,
    lines: Vec<String>,
}

impl Sheet {
    /// Draws the sheet.
    pub fn draw(&self) -> Result<Raster, FigureError> {
        let layout = self.layout()?;
        let mut canvas = Canvas::new(layout.width, layout.height)?;
        draw_lines(&mut canvas, MARGIN, layout.title.top, TITLE, &layout.title.lines);
        draw_lines(&mut canvas, MARGIN, layout.footer.top, BODY, &layout.footer.lines);
        let mut inserts = Vec::new();
        for (i, cell) in self.cells.iter().enumerate() {
            let (rect, picture, difference) = (layout.cells[i], layout.pictures[i], layout.differences[i]);
            canvas.border(picture, BORDER);
            inserts.push((picture.x, picture.y, &cell.picture));
            if let (Some(place), Some(shown)) = (difference, &cell.difference) {
                canvas.border(place, BORDER);
                inserts.push((place.x, place.y, shown));
            }
            let [name, body] = &layout.texts[i];
            let top = rect.bottom() - self.text_height(&layout);
            draw_lines(&mut canvas, rect.x, top, NAME, name);
            draw_lines(&mut canvas, rect.x, top + height_of(name, NAME), BODY, body);
        }
        let bar = self.color_bar.as_ref().zip(layout.color_bar);
        let gradient = bar.map(|(bar, place)| draw_bar(&mut canvas, bar, place)).transpose()?;
        if let (Some(place), Some(gradient)) = (layout.color_bar, &gradient) {
            inserts.push((place.x, place.y, gradient));
        }
        Ok(canvas.finish(&inserts))
    }

    /// Where things will be drawn.
    pub fn layout(&self) -> Result<SheetLayout, FigureError> {
        let first = self.largest(|c| Some(&c.picture));
        let second = self.largest(|c| c.difference.as_ref());
        let gap = if second == [0, 0] { 0 } else { PICTURE_GAP };
        let pictures = match self.arrangement {
            Arrangement::Below => [first[0].max(second[0]), first[1] + gap + second[1]],
            Arrangement::Beside => [first[0] + gap + second[0], first[1].max(second[1])],
        };
        let names = self.cells.iter().map(|c| text::width(&c.name, NAME.size).ceil() as u32);
        let cell_width = pictures[0].max(names.max().unwrap_or(0).clamp(MIN_CELL[0], MIN_CELL[1]));
        let texts: Vec<_> = self.cells.iter().map(|c| c.wrapped(cell_width)).collect();
        let text_height = texts.iter().map(text_height).max().unwrap_or(0);
        let cell_height = pictures[1] + text_height;
        let columns = self.columns(cell_width, cell_height);

        let columns_wide = u64::from(cell_width + GUTTER) * columns as u64 - u64::from(GUTTER);
        let rows = self.cells.len().div_ceil(columns) as u64;
        let rows_high = (u64::from(cell_height + GUTTER) * rows).saturating_sub(GUTTER.into());
        let width = columns_wide + 2 * u64::from(MARGIN);
        check_size(width, rows_high.max(1))?;
        let (width, content) = (width as u32, columns_wide as u32);

        let mut y = MARGIN;
        let title = block(&mut y, &self.title, TITLE, content);
        let cells: Vec<Rect> = (0..self.cells.len() as u32)
            .map(|i| (i % columns as u32, i / columns as u32))
            .map(|(column, row)| (column * (cell_width + GUTTER), row * (cell_height + GUTTER)))
            .map(|(dx, dy)| Rect { x: MARGIN + dx, y: y + dy, width: cell_width, height: cell_height })
            .collect();
        y += rows_high as u32 + if rows > 0 { BLOCK_GAP } else { 0 };
        let color_bar = self.color_bar.as_ref().map(|_| {
            let place = bar_place(y, content);
            y = place.bottom() + BAR_NUMBERS + BLOCK_GAP;
            place
        });
        let footer = block(&mut y, &self.footer, BODY, content);
        let height = u64::from(y - if y > MARGIN { BLOCK_GAP } else { 0 }) + u64::from(MARGIN);
        check_size(width.into(), height)?;

        let place = |cell: &Rect, at: [u32; 2], room: [u32; 2], picture: &Raster| Rect {
            x: cell.x + at[0] + (room[0] - picture.width) / 2,
            y: cell.y + at[1] + (room[1] - picture.height) / 2,
            width: picture.width,
            height: picture.height,
        };
        // Cells that are wider than their pictures keep them on the left, over the text.
        let (room, other, at) = match self.arrangement {
            Arrangement::Below => ([pictures[0], first[1]], [pictures[0], second[1]], [0, first[1] + gap]),
            Arrangement::Beside => ([first[0], pictures[1]], [second[0], pictures[1]], [first[0] + gap, 0]),
        };
        let both = || cells.iter().zip(&self.cells);
        Ok(SheetLayout {
            width,
            height: height as u32,
            pictures: both().map(|(rect, cell)| place(rect, [0, 0], room, &cell.picture)).collect(),
            differences: both()
                .map(|(rect, cell)| cell.difference.as_ref().map(|d| place(rect, at, other, d)))
                .collect(),
            cells,
            color_bar,
            title,
            footer,
            texts,
        })
    }

    /// The largest width and height of some pictures.
    fn largest<'a>(&'a self, of: impl Fn(&'a Cell) -> Option<&'a Raster>) -> [u32; 2] {
        let sizes = self.cells.iter().filter_map(of).map(|p| [p.width, p.height]);
        sizes.fold([0, 0], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }

    fn text_height(&self, layout: &SheetLayout) -> u32 {
        layout.texts.iter().map(text_height).max().unwrap_or(0).saturating_sub(TEXT_GAP)
    }

    /// Cells in a row: near to [`SHAPE`], with few places left empty.
    fn columns(&self, width: u32, height: u32) -> usize {
        let n = self.cells.len().max(1);
        let cost = |columns: usize| {
            let rows = n.div_ceil(columns);
            let shape = (columns as f64 * f64::from(width)) / (rows as f64 * f64::from(height.max(1)));
            (shape / SHAPE).ln().abs() + (rows * columns - n) as f64 / n as f64
        };
        let best = || (1..=n).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(1);
        self.columns.map_or_else(best, |c| c.clamp(1, n))
    }
}

impl Cell {
    fn wrapped(&self, width: u32) -> [Vec<String>; 2] {
        let wrap = |text: &str, kind: Type| text::wrap(text, kind.size, width as f32);
        [wrap(&self.name, NAME), self.lines.iter().flat_map(|line| wrap(line, BODY)).collect()]
    }
}

fn text_height([name, body]: &[Vec<String>; 2]) -> u32 {
    let height = height_of(name, NAME) + height_of(body, BODY);
    if height > 0 { height + TEXT_GAP } else { 0 }
}

fn line_height(kind: Type) -> u32 {
    (kind.size * text::LEADING).round() as u32
}

fn height_of(lines: &[String], kind: Type) -> u32 {
    lines.len() as u32 * line_height(kind)
}

/// Text as wide as the sheet; `y` moves on to what follows.
fn block(y: &mut u32, text: &str, kind: Type, width: u32) -> Block {
    let block = Block { top: *y, lines: text::wrap(text, kind.size, width as f32) };
    if !block.lines.is_empty() {
        *y += height_of(&block.lines, kind) + if kind.size == TITLE.size { TITLE_GAP } else { BLOCK_GAP };
    }
    block
}

fn draw_lines(canvas: &mut Canvas, x: u32, top: u32, kind: Type, lines: &[String]) {
    for (i, line) in lines.iter().enumerate() {
        let middle = (top + i as u32 * line_height(kind)) as f32 + 0.5 * line_height(kind) as f32;
        canvas.text(x as f32, middle + 0.5 * text::CAP_HEIGHT * kind.size, Align::Left, kind, line);
    }
}

/// Place of the scale below its label.
fn bar_place(y: u32, content: u32) -> Rect {
    let width = BAR_WIDTH.min(content);
    Rect { x: MARGIN, y: y + line_height(BODY) + 4, width, height: BAR_HEIGHT }
}

/// Draws label, frame and numbers of the scale, and gives its colours.
fn draw_bar(canvas: &mut Canvas, bar: &ColorBar, place: Rect) -> Result<Raster, FigureError> {
    let [x, width] = [place.x as f32, place.width as f32];
    let dark = Type { color: BLACK, ..BODY };
    canvas.border(place, BORDER);
    let label = text::fit(&bar.label, BODY.size, width);
    draw_lines(canvas, place.x, place.y - line_height(BODY) - 4, dark, &[label]);
    let bottom = place.bottom() as f32;
    let widest = text::width(&number(-bar.full_scale), dark.size).max(text::width("−0.25", dark.size));
    let halves = if 5.0 * (widest + 8.0) < width { 0.5 } else { 1.0 };
    for (t, align) in [
        (-1.0, Align::Left),
        (-halves, Align::Center),
        (0.0, Align::Center),
        (halves, Align::Center),
        (1.0_f32, Align::Right),
    ] {
        if t.abs() == 1.0 && align == Align::Center {
            continue;
        }
        let at = x + 0.5 * (t + 1.0) * width;
        let tick = (at - 0.5 * (t + 1.0)).floor() + 0.5;
        canvas.polyline(&[(tick, bottom + 0.5), (tick, bottom + 5.0)], Ink::solid(GREY, 1.0));
        canvas.text(at, bottom + BAR_NUMBERS as f32 - 4.0, align, dark, &number(t * bar.full_scale));
    }
    let along = |i: u32| false_color::diverging(2.0 * (i as f32 + 0.5) / width - 1.0);
    let row: Vec<u8> = (0..place.width).flat_map(along).collect();
    Raster::from_rgb(place.width, place.height, row.repeat(place.height as usize))
}

/// A signed number with two digits.
fn number(v: f32) -> String {
    let magnitude = v.abs();
    let sign = if v > 0.0 { "+" } else { "−" };
    if v == 0.0 {
        "0".to_owned()
    } else if !v.is_finite() {
        "?".to_owned()
    } else if (1e-3..1e4).contains(&magnitude) {
        let decimals = (1 - magnitude.log10().floor() as i32).max(0) as usize;
        let digits = format!("{magnitude:.decimals$}");
        let digits =
            if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { &digits };
        format!("{sign}{digits}")
    } else {
        let digits = format!("{magnitude:.1e}");
        let (mantissa, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
        let mantissa = mantissa.trim_end_matches(".0");
        format!("{sign}{mantissa}×10{}", superscript(exponent.parse().unwrap_or(0)))
    }
}
