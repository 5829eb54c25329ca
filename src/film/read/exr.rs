//! Reading OpenEXR pictures: which channels are the picture, where the data window lies, and what colours its numbers are.

use super::super::Picture;
use super::blocks::Part;
use super::primaries::{Primaries, REC_709};
use super::{ReadError, check_size};
use crate::guard::guarded;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::{Text, Vec2};
use glam::{DMat3, DVec3, Vec3};
use std::collections::HashMap;

/// Last words of names of layers that are the picture: of Blender, of Nuke and others.
const PICTURES: [&str; 7] = ["combined", "composite", "beauty", "rgba", "rgb", "color", "main"];

/// What stands for infinity where other channels depend on it: the largest half float.
const LARGEST_HALF: f32 = 65504.0;

/// Channels that a message lists.
const MOST_LISTED: usize = 24;

/// The channels of a picture: R, G, B, or RY, Y, BY.
#[derive(Clone, Debug)]
struct Candidate {
    part: usize,
    /// The smaller, the likelier.
    rank: u32,
    is_luminance: bool,
    channels: [Option<usize>; 3],
}

fn broken(message: impl Into<String>) -> ReadError {
    ReadError::Decode(message.into())
}

/// A name from a file as a message can show it.
pub(super) fn shown(name: &Text) -> String {
    name.to_string().chars().take(60).flat_map(char::escape_debug).collect()
}

/// Reads a picture whose data and display windows have at most `most` pixels each.
pub(super) fn decode(bytes: &[u8], most: usize) -> Result<Picture, ReadError> {
    let mut rest = bytes;
    // The crate's own validation refuses channels with fewer samples than pixels, so what is needed is checked here.
    let parse = || MetaData::read_from_buffered(&mut rest, false).map_err(|e| e.to_string());
    let metadata = guarded(parse).map_err(ReadError::Decode)?;
    for header in &metadata.headers {
        check_size(header.layer_size.width(), header.layer_size.height(), most)?;
        if header.deep {
            return Err(broken("it has deep pixels, which are not read; flatten it"));
        }
    }
    let picture = choose(&metadata.headers)?;
    let header = &metadata.headers[picture.part];
    let display = header.shared_attributes.display_window.size;
    check_size(display.width(), display.height(), most)?;

    let several = metadata.requirements.has_multiple_layers;
    let mut offsets: &[u8] = &[];
    for header in &metadata.headers[..=picture.part] {
        let taken = header.chunk_count.checked_mul(8).and_then(|size| rest.split_off(..size));
        offsets = taken.ok_or_else(|| broken("the file ends in its table of blocks"))?;
    }
    let number = several.then_some(picture.part as u32);
    let mut pixels = Part { file: bytes, header, offsets, number }.pixels(picture.channels)?;
    to_rec_709(header, &picture, &mut pixels);
    place(header, pixels)
}

/// The likeliest picture of all parts and layers: plain channels, then layers that are called as pictures are, then the
/// only layer with colour.
fn choose(headers: &[Header]) -> Result<Candidate, ReadError> {
    let mut pictures: Vec<Candidate> = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        pictures.extend(pictures_of(part, header, headers.len() > 1));
    }
    let Some(best) = pictures.iter().map(|p| p.rank).min() else {
        return Err(ReadError::NoColour { channels: listed(headers) });
    };
    let mut first = pictures.iter().filter(|p| p.rank == best);
    match (first.next(), first.next()) {
        (Some(_), Some(_)) if best >= UNKNOWN => Err(broken(format!(
            "several layers could be the picture, and none is called Combined or has plain R, G and B; it has {}",
            listed(headers)
        ))),
        (Some(picture), _) => Ok(picture.clone()),
        (None, _) => Err(ReadError::NoColour { channels: listed(headers) }),
    }
}

/// Ranks from here on say nothing about which layer is the picture.
const UNKNOWN: u32 = 6;

/// The pictures of a part, layer by layer; of `several` parts the name counts.
fn pictures_of(part: usize, header: &Header, several: bool) -> Vec<Candidate> {
    const ROLES: [&[&str]; 7] =
        [&["R", "red"], &["G", "green"], &["B", "blue"], &["RY"], &["Y"], &["BY"], &["X"]];
    let mut layers: Vec<(String, [Option<usize>; 7])> = Vec::new();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    // Upper case goes first: where a layer has both R and r, r is something else.
    for exact in [true, false] {
        for (index, channel) in header.channels.list.iter().enumerate() {
            let name = channel.name.to_string();
            let (layer, last) = name.rsplit_once('.').unwrap_or(("", &name));
            let same = |role: &&str| if exact { *role == last } else { role.eq_ignore_ascii_case(last) };
            let Some(role) = ROLES.iter().position(|names| names.iter().any(same)) else {
                continue;
            };
            let at = *by_name.entry(layer.to_owned()).or_insert_with(|| {
                layers.push((layer.to_owned(), [None; 7]));
                layers.len() - 1
            });
            layers[at].1[role].get_or_insert(index);
        }
    }
    // The name of the only part says nothing.
    let part_name = header.own_attributes.layer_name.as_ref().filter(|_| several);
    let part_name = part_name.map(Text::to_string).unwrap_or_default();
    let picture = |(layer, roles): (String, [Option<usize>; 7])| {
        let sampling = |i: Option<usize>| i.map(|i| header.channels.list[i].sampling);
        let full = |i: Option<usize>| sampling(i) == Some(Vec2(1, 1));
        // Z beside Y is depth; X makes both of them coordinates.
        let [r, g, b, ry, y, by, x] = roles;
        let has_chroma = ry.is_some() && by.is_some() && sampling(ry) == sampling(by);
        let (is_luminance, channels) = if full(r) && full(g) && full(b) {
            (false, [r, g, b])
        } else if r.or(g).or(b).is_some() || !full(y) || x.is_some() {
            return None;
        } else {
            (true, if has_chroma { [ry, y, by] } else { [None, y, None] })
        };
        let name = if layer.is_empty() { &part_name } else { &layer };
        let last = name.rsplit('.').next().unwrap_or_default();
        let is_known = PICTURES.iter().any(|p| p.eq_ignore_ascii_case(last));
        let rank = match (layer.is_empty(), is_known || name.is_empty(), is_luminance) {
            (true, true, false) => 0,
            (false, true, false) => 1,
            // Luminance beside a picture in colour is something else.
            (true, true, true) => 2,
            (false, true, true) => 3,
            (true, false, _) => 4 + u32::from(is_luminance),
            (false, false, _) => UNKNOWN + u32::from(is_luminance),
        };
        Some(Candidate { part, rank, is_luminance, channels })
    };
    layers.into_iter().filter_map(picture).collect()
}

/// The channels of all parts, for messages.
fn listed(headers: &[Header]) -> String {
    let all = headers.iter().flat_map(|header| {
        let part = header.own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1);
        let part = part.map(|name| format!("{}: ", shown(name))).unwrap_or_default();
        header.channels.list.iter().map(move |channel| format!("{part}{}", shown(&channel.name)))
    });
    let count: usize = headers.iter().map(|h| h.channels.list.len()).sum();
    let names: Vec<String> = all.take(MOST_LISTED).collect();
    let more = if count > MOST_LISTED { format!(" and {} more", count - MOST_LISTED) } else { String::new() };
    format!("{}{more}", names.join(", "))
}

/// Makes colours of luminance and chroma, and Rec. 709 of other primaries.
fn to_rec_709(header: &Header, picture: &Candidate, pixels: &mut [Vec3]) {
    let point = |Vec2(x, y): Vec2<f32>| [f64::from(x), f64::from(y)];
    let primaries = header.shared_attributes.chromaticities.map_or(REC_709, |c| Primaries {
        red: point(c.red),
        green: point(c.green),
        blue: point(c.blue),
        white: point(c.white),
    });
    let mut matrix = primaries.to_rec_709();
    if picture.is_luminance {
        match picture.channels[0].map(|i| header.channels.list[i].sampling) {
            Some(sampling) => {
                spread_chroma(pixels, header.layer_size.width(), sampling);
                let shares = primaries.luminance().or(REC_709.luminance()).unwrap_or(DVec3::ONE / 3.0);
                pixels.iter_mut().for_each(|pixel| *pixel = from_chroma(*pixel, shares));
            }
            None => {
                pixels.iter_mut().for_each(|pixel| *pixel = Vec3::splat(pixel.y));
                matrix = None;
            }
        }
    }
    if let Some(matrix) = matrix {
        // What is not finite stays what it is, so that it is found later; beside it are the colours of the largest number.
        let convert = |m: &DMat3, p: Vec3| {
            let number = if p.is_finite() { p } else { p.min(Vec3::splat(LARGEST_HALF)) };
            let converted = (*m * number.as_dvec3()).as_vec3().max(Vec3::ZERO);
            Vec3::select(p.is_finite_mask(), converted, p)
        };
        pixels.iter_mut().for_each(|pixel| *pixel = convert(&matrix, *pixel));
    }
}

/// R, G, B of RY = (R − Y)/Y, Y and BY = (B − Y)/Y, where Y is luminance (OpenEXR, `ImfRgbaYca.h`).
fn from_chroma(pixel: Vec3, shares: DVec3) -> Vec3 {
    let p = pixel.as_dvec3();
    let (r, b) = ((p.x + 1.0) * p.y, (p.z + 1.0) * p.y);
    DVec3::new(r, (p.y - shares.x * r - shares.z * b) / shares.y, b).as_vec3()
}

/// Fills in chroma between its samples, linearly along rows and then along columns.
fn spread_chroma(pixels: &mut [Vec3], width: usize, Vec2(step_x, step_y): Vec2<usize>) {
    let height = pixels.len() / width;
    let between = |a: Vec3, b: Vec3, t: f32, y: f32| {
        let mixed = a + (b - a) * t;
        Vec3::new(mixed.x, y, mixed.z)
    };
    for y in (0..height).step_by(step_y) {
        let row = &mut pixels[y * width..][..width];
        for x in 0..width {
            let start = x - x % step_x;
            let next = if start + step_x < width { start + step_x } else { start };
            row[x] = between(row[start], row[next], (x - start) as f32 / step_x as f32, row[x].y);
        }
    }
    for y in (0..height).filter(|y| y % step_y != 0) {
        let start = y - y % step_y;
        let next = if start + step_y < height { start + step_y } else { start };
        let t = (y - start) as f32 / step_y as f32;
        for x in 0..width {
            let (above, below) = (pixels[start * width + x], pixels[next * width + x]);
            let pixel = &mut pixels[y * width + x];
            *pixel = between(above, below, t, pixel.y);
        }
    }
}

/// Puts the data window where it lies in the display window; what it leaves open is black.
fn place(header: &Header, pixels: Vec<Vec3>) -> Result<Picture, ReadError> {
    let window = header.shared_attributes.display_window;
    let (data, display) = (header.layer_size, window.size);
    let Vec2(x, y) = header.own_attributes.layer_position;
    let (dx, dy) =
        (i64::from(x) - i64::from(window.position.x()), i64::from(y) - i64::from(window.position.y()));
    let (width, height) = (display.width() as u32, display.height() as u32);
    if (dx, dy) == (0, 0) && data == display {
        return Ok(Picture { width, height, pixels, ..Picture::default() });
    }
    // Where the data begin, in both windows, and how many columns or rows the windows share.
    let shared = |offset: i64, data: usize, display: usize| {
        let start = offset.max(0);
        let end = (offset + data as i64).min(display as i64);
        (start as usize, (start - offset) as usize, usize::try_from(end - start).unwrap_or(0))
    };
    let (to_x, from_x, columns) = shared(dx, data.width(), display.width());
    let (to_y, from_y, rows) = shared(dy, data.height(), display.height());
    if columns == 0 || rows == 0 {
        return Err(broken("its data window lies outside of its display window: there is nothing to see"));
    }
    let mut placed = Vec::new();
    let count = display.area();
    placed.try_reserve_exact(count).map_err(|_| ReadError::memory(display.width(), display.height()))?;
    placed.resize(count, Vec3::ZERO);
    for row in 0..rows {
        let from = &pixels[(from_y + row) * data.width() + from_x..][..columns];
        placed[(to_y + row) * display.width() + to_x..][..columns].copy_from_slice(from);
    }
    Ok(Picture { width, height, pixels: placed, ..Picture::default() })
}

#[cfg(test)]
mod tests;
