//! Containers built by hand.

use super::*;
use crate::asset::LoadOptions;

/// A container of one level; `layers` of 0 is one image that is no array.
fn ktx([width, height, layers]: [u32; 3], format: u32, scheme: u32, inflated: u64, level: &[u8]) -> Vec<u8> {
    let mut keys = Vec::new();
    for pair in [&b"KTXorientation\0ru\0"[..], b"KTXswizzle\0rgb1\0"] {
        keys.extend((pair.len() as u32).to_le_bytes());
        keys.extend(pair);
        keys.resize(keys.len().next_multiple_of(4), 0);
    }
    let (dfd, dfd_length, keys_length) = (104_u32, 44_u32, keys.len() as u32);
    let start = dfd + dfd_length + keys_length;
    let mut file = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    let header =
        [format, 1, width, height, 0, layers, 1, 1, scheme, dfd, dfd_length, dfd + dfd_length, keys_length];
    file.extend(header.iter().flat_map(|v| v.to_le_bytes()));
    file.extend([0; 16]);
    file.extend([u64::from(start), level.len() as u64, inflated].iter().flat_map(|v| v.to_le_bytes()));
    file.resize((dfd + dfd_length) as usize, 0);
    file.extend(keys);
    file.extend(level);
    file
}

fn image(file: &[u8], layer: usize) -> Result<ImageData, String> {
    TextureKtx("KHR_texture_ktx")
        .decode_image(file, layer, &LoadOptions::default().limits)
        .expect("it is KTX")
}

#[test]
fn layers_orientation_and_swizzle_are_kept() {
    let level: Vec<u8> = (0..24).collect();
    let file = ktx([1, 2, 4], 23, 0, 24, &level);
    for layer in 0..4 {
        let image = image(&file, layer).expect("it decodes");
        let ImagePixels::Rgba8(pixels) = image.pixels else { panic!("8 bits") };
        let first = 6 * layer as u8;
        let rows = [[first + 3, first + 4, first + 5, 255], [first, first + 1, first + 2, 255]];
        assert_eq!(pixels.as_chunks::<4>().0, rows, "the last row comes first, alpha is one");
    }
    assert!(image(&file, 4).is_err());
}

/// A Zstandard frame with one raw block (RFC 8878 §3.1.1).
#[test]
fn zstandard_levels_are_inflated() {
    let texels = [7_u8, 8, 9];
    let frame = [&[0x28, 0xB5, 0x2F, 0xFD, 0x20, 3, 0x19, 0, 0][..], &texels].concat();
    let decoded = image(&ktx([1, 1, 0], 23, 2, 3, &frame), 0).expect("it decodes");
    let ImagePixels::Rgba8(pixels) = decoded.pixels else { panic!("8 bits") };
    assert_eq!(pixels, [7, 8, 9, 255]);
    let lie = ktx([1, 1, 0], 23, 2, u64::MAX, &frame);
    assert!(image(&lie, 0).is_err_and(|e| e.contains("image_bytes")));
}

/// Values of the Vulkan and OpenGL specifications' packed floats.
#[test]
fn floats_and_words_keep_their_values() {
    let floats = |format: u32, level: &[u8]| match image(&ktx([1, 1, 0], format, 0, 0, level), 0) {
        Ok(ImageData { pixels: ImagePixels::Rgba32F(p), .. }) => p,
        other => panic!("{other:?}"),
    };
    // Exponent 16 scales mantissas by 2^(16 − 15 − 9).
    let shared = 16_u32 << 27 | 1 << 18 | 256 << 9 | 511;
    assert_eq!(floats(123, &shared.to_le_bytes()), [511.0 / 256.0, 1.0, 1.0 / 256.0, 1.0]);
    // 1 is exponent 15, mantissa 0; 0.5 is exponent 14; 1.5 has half of the mantissa.
    let small = (15_u32 << 6 | 32) | (14 << 6) << 11 | (15 << 5) << 22;
    assert_eq!(floats(122, &small.to_le_bytes()), [1.5, 0.5, 1.0, 1.0]);
    assert_eq!(floats(76, &0x3800_u16.to_le_bytes()), [0.5, 0.0, 0.0, 1.0]);
    assert_eq!(floats(103, &[2.0_f32, -3.0].map(f32::to_le_bytes).concat()), [2.0, -3.0, 0.0, 1.0]);
    let words = image(&ktx([1, 1, 0], 77, 0, 0, &[1, 2, 3, 4]), 0).expect("it decodes");
    assert!(matches!(words.pixels, ImagePixels::Rgba16(p) if p == [0x201, 0x403, 0, 0xffff]));
}

/// BC1 with equal ends is one colour of 5, 6 and 5 bits; BC4 and BC5 likewise have one or two channels.
#[test]
fn blocks_are_cut_to_the_image() {
    let red = [0x00, 0xf8, 0x00, 0xf8, 0, 0, 0, 0];
    let four = [77, 77, 0, 0, 0, 0, 0, 0];
    for (format, level, expected) in [
        (133, red.repeat(2), [255, 0, 0, 255]),
        (139, four.repeat(2), [77, 0, 0, 255]),
        (141, four.repeat(4), [77, 77, 0, 255]),
    ] {
        let decoded = image(&ktx([5, 3, 0], format, 0, 0, &level), 0).expect("it decodes");
        let ImagePixels::Rgba8(pixels) = decoded.pixels else { panic!("8 bits") };
        assert_eq!(pixels, expected.repeat(15), "format {format}");
        assert!(image(&ktx([9, 3, 0], format, 0, 0, &level), 0).is_err(), "three blocks across");
    }
}

#[test]
fn broken_containers_are_refused() {
    let good = ktx([2, 2, 0], 23, 0, 12, &[1; 12]);
    assert!(image(&good, 0).is_ok());
    for end in 12..good.len() {
        assert!(image(&good[..end], 0).is_err(), "{end} bytes");
    }
    for at in 12..good.len() {
        for value in [0, 1, 127, 255] {
            let mut bad = good.clone();
            bad[at] = value;
            let _ = image(&bad, 0);
        }
    }
}
