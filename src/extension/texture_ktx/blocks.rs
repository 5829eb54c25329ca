//! Pixels in blocks as graphics hardware reads them: BC1 to BC7, ETC2 and ASTC, by their numbers in Vulkan.

use crate::scene::ImagePixels;

/// Formats of the BC family: the size of a block and what is in it.
#[derive(Clone, Copy)]
enum Bc {
    One,
    Two,
    Three,
    Four,
    Five,
    Six { signed: bool },
    Seven,
}

fn bc(format: u32) -> Option<Bc> {
    Some(match format {
        131..=134 => Bc::One,
        135 | 136 => Bc::Two,
        137 | 138 => Bc::Three,
        139 => Bc::Four,
        141 => Bc::Five,
        143 => Bc::Six { signed: false },
        144 => Bc::Six { signed: true },
        145 | 146 => Bc::Seven,
        _ => return None,
    })
}

/// Sides of the blocks of ASTC, in the order of the formats from 157 on, two (linear and sRGB) each.
const ASTC: [(usize, usize); 14] = [
    (4, 4),
    (5, 4),
    (5, 5),
    (6, 5),
    (6, 6),
    (8, 5),
    (8, 6),
    (8, 8),
    (10, 5),
    (10, 6),
    (10, 8),
    (10, 10),
    (12, 10),
    (12, 12),
];

/// Unpacks an image; `None` if the format is not one of blocks.
pub(super) fn unpack(
    format: u32,
    width: usize,
    height: usize,
    data: &[u8],
) -> Option<Result<ImagePixels, String>> {
    if let Some(kind) = bc(format) {
        return Some(unpack_bc(kind, width, height, data));
    }
    let mut argb = Vec::new();
    let mut image = |decode: &dyn Fn(&mut [u32]) -> Result<(), &'static str>| {
        argb.resize(width * height, 0);
        decode(&mut argb).map_err(str::to_owned)?;
        let rgba = argb.iter().flat_map(|p| {
            let [b, g, r, a] = p.to_le_bytes();
            [r, g, b, a]
        });
        Ok(ImagePixels::Rgba8(rgba.collect()))
    };
    Some(match format {
        147 | 148 => image(&|out| texture2ddecoder::decode_etc2_rgb(data, width, height, out)),
        149 | 150 => image(&|out| texture2ddecoder::decode_etc2_rgba1(data, width, height, out)),
        151 | 152 => image(&|out| texture2ddecoder::decode_etc2_rgba8(data, width, height, out)),
        157..=184 => {
            let (w, h) = ASTC[(format as usize - 157) / 2];
            image(&|out| texture2ddecoder::decode_astc(data, width, height, w, h, out))
        }
        _ => return None,
    })
}

/// Sides of a block.
const SIDE: usize = 4;

fn unpack_bc(kind: Bc, width: usize, height: usize, data: &[u8]) -> Result<ImagePixels, String> {
    let (across, down) = (width.div_ceil(SIDE), height.div_ceil(SIDE));
    let size = if matches!(kind, Bc::One | Bc::Four) { 8 } else { 16 };
    let blocks = data.get(..size * across * down).ok_or("the image has too few bytes")?.chunks_exact(size);
    let place = |i: usize| (i % across * SIDE, i / across * SIDE);
    if let Bc::Six { signed } = kind {
        let mut out = vec![1.0; 4 * width * height];
        for (i, block) in blocks.enumerate() {
            let mut texels = [0.0; 3 * SIDE * SIDE];
            bcdec_rs::bc6h_float(block, &mut texels, 3 * SIDE, signed);
            copy(&mut out, width, height, place(i), |x, y| {
                let at = 3 * (y * SIDE + x);
                [texels[at], texels[at + 1], texels[at + 2], 1.0]
            });
        }
        return Ok(ImagePixels::Rgba32F(out));
    }
    let mut out = vec![0; 4 * width * height];
    for (i, block) in blocks.enumerate() {
        let mut texels = [0; 4 * SIDE * SIDE];
        match kind {
            Bc::Two => bcdec_rs::bc2(block, &mut texels, 4 * SIDE),
            Bc::Three => bcdec_rs::bc3(block, &mut texels, 4 * SIDE),
            Bc::Seven => bcdec_rs::bc7(block, &mut texels, 4 * SIDE),
            Bc::Four => bcdec_rs::bc4(block, &mut texels, SIDE, false),
            Bc::Five => bcdec_rs::bc5(block, &mut texels, 2 * SIDE, false),
            Bc::One | Bc::Six { .. } => bcdec_rs::bc1(block, &mut texels, 4 * SIDE),
        }
        copy(&mut out, width, height, place(i), |x, y| {
            let at = y * SIDE + x;
            match kind {
                Bc::Four => [texels[at], 0, 0, u8::MAX],
                Bc::Five => [texels[2 * at], texels[2 * at + 1], 0, u8::MAX],
                _ => std::array::from_fn(|k| texels[4 * at + k]),
            }
        });
    }
    Ok(ImagePixels::Rgba8(out))
}

/// Writes the texels of the block at `place` that lie in the image.
fn copy<T: Copy>(
    out: &mut [T],
    width: usize,
    height: usize,
    (left, top): (usize, usize),
    texel: impl Fn(usize, usize) -> [T; 4],
) {
    for y in 0..SIDE.min(height - top) {
        for x in 0..SIDE.min(width - left) {
            let at = 4 * ((top + y) * width + left + x);
            out[at..at + 4].copy_from_slice(&texel(x, y));
        }
    }
}
