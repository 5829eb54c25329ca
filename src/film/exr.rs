//! OpenEXR (`.exr`): linear radiance, half floats by default.
//!
//! One part: the beauty is its plain `R`, `G`, `B` (and `A`, premultiplied); further channels are `layer.channel`.
//! Zip-compressed scan lines and Rec. 709 chromaticities, so that any reader is content. Attributes are written in
//! alphabetical order: the crate keeps them in a randomly ordered map, and equal pictures shall be equal files.

use super::write::{count_non_finite, finite_or_zero};
use super::{Picture, WriteError, WriteOptions, WriteReport};
use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use ::exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use ::exr::prelude::{Compression, LayerAttributes, SmallVec, Vec2, WritableImage, f16};
use std::io::{Cursor, Write};

/// The primaries and the white point D65 of Rec. 709.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

pub(super) fn encode(
    out: &mut dyn Write,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let samples = |values: &mut dyn Iterator<Item = f32>| -> FlatSamples {
        if options.float {
            FlatSamples::F32(values.map(finite_or_zero).collect())
        } else {
            FlatSamples::F16(values.map(to_half).collect())
        }
    };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(AnyChannel::new(name, samples(&mut picture.pixels.iter().map(|p| p[i]))));
    }
    if let Some(alpha) = &picture.alpha {
        channels.push(AnyChannel::new("A", samples(&mut alpha.iter().copied())));
    }
    for layer in &picture.layers {
        for channel in &layer.channels {
            let name = text(&format!("{}.{}", layer.name, channel.name))?;
            channels.push(AnyChannel::new(name, samples(&mut channel.values.iter().copied())));
        }
    }

    let mut attributes = LayerAttributes {
        software_name: Some(text(concat!("nephrite ", env!("CARGO_PKG_VERSION")))?),
        ..LayerAttributes::default()
    };
    for (name, value) in &options.attributes {
        attributes.other.insert(text(name)?, AttributeValue::Text(text(value)?));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = Vec2(picture.width as usize, picture.height as usize);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(REC_709);

    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|e| match e {
        ::exr::error::Error::Io(e) => WriteError::Io(e),
        e => WriteError::Encoding(e.to_string()),
    })?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    out.write_all(&bytes)?;

    let above = |p: &&glam::Vec3| p.is_finite() && p.max_element() > f16::MAX.to_f32();
    Ok(WriteReport {
        non_finite: count_non_finite(picture),
        clamped_to_half: if options.float { 0 } else { picture.pixels.iter().filter(above).count() },
    })
}

/// The nearest half float, but never infinity.
fn to_half(value: f32) -> f16 {
    let max = f16::MAX.to_f32();
    f16::from_f32(finite_or_zero(value).clamp(-max, max))
}

/// Text as UTF-8, without the zero bytes that end names in the format.
fn text(string: &str) -> Result<Text, WriteError> {
    if string.contains('\0') {
        return Err(WriteError::Encoding(format!("a zero byte in the name or attribute {string:?}")));
    }
    Ok(Text::from_slice_unchecked(string.as_bytes()))
}

/// Brings the attributes of a single-part file into alphabetical order, in place. The layout is that of "OpenEXR
/// File Layout", section Header: magic number and version (4 bytes each), then per attribute its name and its type,
/// each ended by a zero byte, a 32 bit little-endian size, and the value; a lone zero byte ends the list. Every
/// offset in the file stays valid, since the header keeps its length. Bytes of another layout are left alone.
fn sort_attributes(file: &mut [u8]) {
    const START: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = START;
    while file.get(at).is_some_and(|&byte| byte != 0) {
        let Some(length) = attribute_length(&file[at..]) else { return };
        attributes.push(&file[at..at + length]);
        at += length;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[START..at].copy_from_slice(&sorted);
}

/// The bytes that the attribute at the beginning of `bytes` takes, name, type, size and value together.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&b| b == 0)? + 1;
    let kind = bytes[name..].iter().position(|&b| b == 0)? + 1;
    let value = name + kind + 4;
    let size = u32::from_le_bytes(bytes.get(value - 4..value)?.try_into().ok()?) as usize;
    (bytes.len() >= value + size).then_some(value + size)
}
