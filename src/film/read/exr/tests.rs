use super::*;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, SmallVec, WritableImage, f16,
};

/// An attribute of a header.
fn attribute(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(value.len() as u32).to_le_bytes(), value].concat()
}

fn window([x, y, w, h]: [i32; 4]) -> Vec<u8> {
    [x, y, x + w - 1, y + h - 1].iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// An uncompressed file of floats: channels in alphabetical order with their samplings, windows as x, y, width, height, and
/// the value of each channel at each pixel.
struct Raw<'a> {
    channels: &'a [(&'a str, i32)],
    data: [i32; 4],
    display: [i32; 4],
    more: Vec<u8>,
    value: fn(usize, i32, i32) -> f32,
}

impl Raw<'_> {
    fn bytes(&self) -> Vec<u8> {
        let mut channels = Vec::new();
        for (name, sampling) in self.channels {
            channels.extend([name.as_bytes(), b"\0"].concat());
            channels.extend([2, 0, *sampling, *sampling].iter().flat_map(|v: &i32| v.to_le_bytes()));
        }
        channels.push(0);
        let mut bytes = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
        bytes.extend(attribute("channels", "chlist", &channels));
        bytes.extend(attribute("compression", "compression", &[0]));
        bytes.extend(attribute("dataWindow", "box2i", &window(self.data)));
        bytes.extend(attribute("displayWindow", "box2i", &window(self.display)));
        bytes.extend(attribute("lineOrder", "lineOrder", &[0]));
        bytes.extend(attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes()));
        bytes.extend(attribute("screenWindowCenter", "v2f", &[0; 8]));
        bytes.extend(attribute("screenWindowWidth", "float", &1_f32.to_le_bytes()));
        bytes.extend(&self.more);
        bytes.push(0);
        let [x, y, w, h] = self.data;
        let mut lines = Vec::new();
        for y in y..y + h {
            let mut line = Vec::new();
            for (index, (_, sampling)) in self.channels.iter().enumerate() {
                if y % sampling == 0 {
                    let samples = (x..x + w).filter(|x| x % sampling == 0);
                    line.extend(samples.flat_map(|x| (self.value)(index, x, y).to_le_bytes()));
                }
            }
            lines.push([&y.to_le_bytes()[..], &(line.len() as u32).to_le_bytes(), &line].concat());
        }
        let mut at = bytes.len() + 8 * lines.len();
        for line in &lines {
            bytes.extend((at as u64).to_le_bytes());
            at += line.len();
        }
        bytes.extend(lines.concat());
        bytes
    }

    fn picture(&self) -> Result<Picture, ReadError> {
        decode(&self.bytes(), 1000)
    }
}

fn plain<'a>(channels: &'a [(&'a str, i32)]) -> Raw<'a> {
    Raw {
        channels,
        data: [0, 0, 2, 1],
        display: [0, 0, 2, 1],
        more: Vec::new(),
        value: |channel, x, _| (10 * channel as i32 + x) as f32,
    }
}

/// The channels whose values the pixels are, told by what [`plain`] gives them.
fn chosen(names: &[&str]) -> Result<[usize; 3], String> {
    let channels: Vec<(&str, i32)> = names.iter().map(|name| (*name, 1)).collect();
    let picture = plain(&channels).picture().map_err(|e| e.to_string())?;
    assert_eq!(picture.pixels[1], picture.pixels[0] + 1.0);
    Ok(picture.pixels[0].to_array().map(|c| c as usize / 10))
}

#[test]
fn the_picture_is_found_among_channels() {
    assert_eq!(chosen(&["A", "B", "G", "R"]), Ok([3, 2, 1]));
    assert_eq!(chosen(&["a", "b", "g", "r"]), Ok([3, 2, 1]));
    assert_eq!(chosen(&["B", "G", "R", "b", "g", "r"]), Ok([2, 1, 0]));
    assert_eq!(
        chosen(&["ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R"]),
        Ok([2, 1, 0])
    );
    let blender =
        ["DiffCol.B", "DiffCol.G", "DiffCol.R", "V.Combined.B", "V.Combined.G", "V.Combined.R", "V.Depth.Z"];
    assert_eq!(chosen(&blender), Ok([5, 4, 3]));
    assert_eq!(chosen(&["B", "G", "R", "beauty.B", "beauty.G", "beauty.R"]), Ok([2, 1, 0]));
    // Luminance beside colour is not the picture.
    assert_eq!(chosen(&["V.Combined.B", "V.Combined.G", "V.Combined.R", "Y"]), Ok([2, 1, 0]));
    assert_eq!(chosen(&["sky.blue", "sky.green", "sky.red"]), Ok([2, 1, 0]));
    assert_eq!(chosen(&["Y", "Z.Z"]), Ok([0, 0, 0]));
    // Z is depth.
    assert_eq!(chosen(&["A", "Y", "Z"]), Ok([1, 1, 1]));
    assert_eq!(chosen(&["N.X", "N.Y", "N.Z", "sky.y"]), Ok([3, 3, 3]));
}

#[test]
fn without_a_picture_the_channels_are_listed() {
    let error = chosen(&["ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"]).unwrap_err();
    assert!(error.contains("it has ViewLayer.Normal.X, ViewLayer.Normal.Y, ViewLayer.Normal.Z"), "{error}");
    let error = chosen(&["B", "G"]).unwrap_err();
    assert!(error.contains("it has B, G"), "{error}");
    let two = ["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"];
    let error = chosen(&two).unwrap_err();
    assert!(error.contains("several layers") && error.contains("b.R"), "{error}");
    let many: Vec<String> = (10..60).map(|i| format!("c{i}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    assert!(chosen(&many).unwrap_err().contains("c33 and 26 more"));
}

#[test]
fn the_data_window_lies_in_the_display_window() {
    let channels = [("B", 1), ("G", 1), ("R", 1)];
    let raw =
        |data, display| Raw { data, display, value: |_, x, y| (100 + 10 * y + x) as f32, ..plain(&channels) };
    let picture = raw([-1, 2, 4, 2], [-2, 1, 8, 4]).picture().unwrap();
    assert_eq!((picture.width, picture.height), (8, 4));
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i as i32 % 8 - 2, i as i32 / 8 + 1);
        let inside = (-1..3).contains(&x) && (2..4).contains(&y);
        let expected = if inside { (100 + 10 * y + x) as f32 } else { 0.0 };
        assert_eq!(*pixel, Vec3::splat(expected), "{x} {y}");
    }
    // What hangs over is cut off.
    let picture = raw([-3, -3, 9, 9], [1, 1, 2, 1]).picture().unwrap();
    assert_eq!(picture.pixels, [Vec3::splat(111.0), Vec3::splat(112.0)]);
    let error = raw([0, 0, 2, 2], [5, 0, 2, 2]).picture().unwrap_err().to_string();
    assert!(error.contains("outside of its display window"), "{error}");
    let large = raw([0, 0, 2, 2], [0, 0, 1 << 20, 1 << 20]).picture();
    assert!(matches!(large, Err(ReadError::TooLarge { .. })), "{large:?}");
}

#[test]
fn luminance_and_chroma_become_colours() {
    // 1, 0.5, 0.25 in Rec. 709 everywhere.
    const SHARES: Vec3 = Vec3::new(0.212_64, 0.715_17, 0.072_19);
    let value = |channel: usize, _: i32, _: i32| {
        let y = SHARES.dot(Vec3::new(1.0, 0.5, 0.25));
        [(0.25 - y) / y, (1.0 - y) / y, y][channel]
    };
    for sampling in [1, 2, 4] {
        let channels = [("BY", sampling), ("RY", sampling), ("Y", 1)];
        let picture =
            Raw { data: [4, -8, 8, 4], display: [4, -8, 8, 4], value, ..plain(&channels) }.picture().unwrap();
        assert_eq!(picture.pixels.len(), 32);
        for pixel in &picture.pixels {
            assert!((*pixel - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 1e-4, "{pixel}");
        }
    }
    // Chroma that rises along both axes is linear between its samples and constant beyond the last.
    let channels = [("BY", 2), ("RY", 2), ("Y", 1)];
    let value = |channel: usize, x: i32, y: i32| [0.0, (x + y) as f32, 1.0][channel];
    let picture =
        Raw { data: [0, 0, 4, 4], display: [0, 0, 4, 4], value, ..plain(&channels) }.picture().unwrap();
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let expected = (i % 4).min(2) + (i / 4).min(2);
        assert!((pixel.x - 1.0 - expected as f32).abs() < 1e-5, "{i}: {pixel}");
    }
    let uneven = Raw { data: [0, 0, 3, 4], display: [0, 0, 3, 4], ..plain(&channels) }.picture().unwrap_err();
    assert!(uneven.to_string().contains("channel BY"), "{uneven}");
}

#[test]
fn other_primaries_are_converted() {
    let channels = [("B", 1), ("G", 1), ("R", 1)];
    let rec_2020 = [0.708_f32, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329];
    let value: Vec<u8> = rec_2020.iter().flat_map(|v| v.to_le_bytes()).collect();
    let more = attribute("chromaticities", "chromaticities", &value);
    let red = |channel, _, _| if channel == 2 { 1.0 } else { 0.0 };
    let picture = Raw { more: more.clone(), value: red, ..plain(&channels) }.picture().unwrap();
    assert!((picture.pixels[0] - Vec3::new(1.6605, 0.0, 0.0)).length() < 1e-3, "{}", picture.pixels[0]);
    let picture = Raw { more: more.clone(), value: |_, _, _| 3.0, ..plain(&channels) }.picture().unwrap();
    assert!((picture.pixels[0] - 3.0).length() < 1e-3, "{}", picture.pixels[0]);
    // Infinite red of these primaries leaves nothing of green and blue in Rec. 709.
    let infinite = |channel, _, _| if channel == 2 { f32::INFINITY } else { 1.0 };
    let picture = Raw { more, value: infinite, ..plain(&channels) }.picture().unwrap();
    assert_eq!(picture.pixels[0], Vec3::new(f32::INFINITY, 0.0, 0.0));
}

/// A picture of that size in blocks of some kind, at an odd place.
fn encoded(
    compression: Compression,
    blocks: Blocks,
    float: bool,
    size: (usize, usize),
) -> (Vec<u8>, Vec<Vec3>) {
    let value = |i: usize, c: usize| 0.25 + ((i % size.0) as f32 * 0.03 + c as f32).sin().abs();
    let count = size.0 * size.1;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (c, name) in ["A", "B", "G", "R"].into_iter().enumerate() {
        let values = (0..count).map(|i| value(i, c));
        channels.push(AnyChannel::new(
            name,
            if float {
                FlatSamples::F32(values.collect())
            } else {
                FlatSamples::F16(values.map(f16::from_f32).collect())
            },
        ));
    }
    let attributes = LayerAttributes::named("sky").with_position(Vec2(-3, 5));
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(channels)));
    image.attributes.display_window.position = Vec2(-3, 5);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let stored = |v: f32| if float { v } else { f16::from_f32(v).to_f32() };
    let pixel = |i| Vec3::new(value(i, 3), value(i, 2), value(i, 1)).map(stored);
    (bytes.into_inner(), (0..count).map(pixel).collect())
}

#[test]
fn tiles_of_channels_with_fewer_samples_are_refused() {
    let channels = [("BY", 4), ("RY", 4), ("Y", 1)];
    let tiles = [&1_u32.to_le_bytes()[..], &1_u32.to_le_bytes(), &[0]].concat();
    let more = attribute("tiles", "tiledesc", &tiles);
    let mut bytes = Raw { data: [0, 0, 4, 4], display: [0, 0, 4, 4], more, ..plain(&channels) }.bytes();
    // The flag of a part in tiles.
    bytes[5] |= 2;
    let error = decode(&bytes, 16).unwrap_err().to_string();
    assert!(error.contains("channel BY") && error.contains("in tiles"), "{error}");
}

#[test]
fn every_compression_is_read() {
    use Compression::*;
    for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)] {
        let lossy = matches!(compression, B44 | B44A | DWAA(_) | DWAB(_));
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 40))] {
            for float in [false, true] {
                let (bytes, expected) = encoded(compression, blocks, float, (37, 67));
                let picture =
                    decode(&bytes, 37 * 67).unwrap_or_else(|e| panic!("{compression:?} {blocks:?}: {e}"));
                // Lossless: what was written. PXR24 keeps 24 bits of a float, 15 of them of the mantissa; the others are made
                // for less than a per cent of smooth pictures, and this one has steps.
                let tolerance = if lossy {
                    0.05
                } else if compression == PXR24 && float {
                    1.3 / 32_768.0
                } else {
                    0.0
                };
                for (found, expected) in picture.pixels.iter().zip(&expected) {
                    let error = (*found - *expected).abs().max_element();
                    assert!(error <= tolerance, "{compression:?} {blocks:?}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn sizes_in_dwa_blocks_are_held_against_the_window() {
    let (bytes, _) = encoded(Compression::DWAA(None), Blocks::ScanLines, false, (64, 32));
    // Every block begins with the version, 2.
    let header = bytes.windows(8).position(|w| w == 2_u64.to_le_bytes()).unwrap();
    // Every count and size in turn, 2.2 TB and less.
    let mut refused = 0;
    for counter in 1..10 {
        for stated in [1_u64 << 41, u64::MAX, 1 << 24] {
            let mut bytes = bytes.clone();
            bytes[header + 8 * counter..][..8].copy_from_slice(&stated.to_le_bytes());
            let error = decode(&bytes, 64 * 32).unwrap_err().to_string();
            refused += usize::from(error.contains(&format!("states a size of {stated}")));
        }
    }
    assert_eq!(refused, 27);
}

#[test]
fn truncated_and_repeated_blocks_are_told() {
    let (bytes, _) = encoded(Compression::ZIP16, Blocks::ScanLines, true, (37, 67));
    for length in (0..bytes.len()).step_by(7) {
        assert!(decode(&bytes[..length], 37 * 67).is_err(), "{length} of {} bytes", bytes.len());
    }
    let raw = Raw { data: [0, 0, 2, 2], display: [0, 0, 2, 2], ..plain(&[("Y", 1)]) };
    let good = raw.bytes();
    let table = good.len() - 2 * (8 + 8 + 8);
    let mut twice = good.clone();
    twice.copy_within(table..table + 8, table + 8);
    let error = decode(&twice, 4).unwrap_err().to_string();
    assert!(error.contains("block 1 of 2 is there twice"), "{error}");
    let mut unfinished = good;
    unfinished[table..table + 8].fill(0);
    let error = decode(&unfinished, 4).unwrap_err().to_string();
    assert!(error.contains("may be incomplete"), "{error}");
}
