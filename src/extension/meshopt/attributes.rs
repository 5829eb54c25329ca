//! Mode 0 of meshopt compression, versions 0 and 1: elements of `stride` bytes as differences, byte by byte.
//!
//! After Appendix A of KHR_meshopt_compression. Elements come in blocks of up to 256. In a block the first bytes of all
//! elements come first, then all second ones, and so on; they are packed in groups of 16 with as few bits as their
//! differences need, and values that do not fit follow their group as whole bytes (*sentinels*). Version 1 adds a way to
//! pack each byte of the element, and differences of two and four bytes.

/// Elements of a group.
const GROUP: usize = 16;
/// Elements of a block.
const MOST_ELEMENTS: usize = 256;
/// Bytes of a block.
const MOST_BYTES: usize = 8192;
/// The least bytes that end a stream, for each version.
const LEAST_TAIL: [usize; 2] = [32, 24];

/// The number of bits of packed values, by the two bits that say it.
type Widths = [u32; 4];
const WIDTHS_0: Widths = [0, 2, 4, 8];
const WIDTHS_1: [Widths; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// How differences of four neighbouring bytes are made.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Words,
    /// Exclusive or, after turning by this many bits.
    Xor(u32),
}

/// Bytes yet to be read.
struct Cursor<'d>(&'d [u8]);

impl<'d> Cursor<'d> {
    fn take(&mut self, count: usize) -> Result<&'d [u8], String> {
        let (head, rest) = self.0.split_at_checked(count).ok_or("the stream ends too early")?;
        self.0 = rest;
        Ok(head)
    }
}

/// Decodes `count` elements of `stride` bytes, a multiple of 4 up to 256. The caller has checked that their product is
/// no more than it wants to have.
pub(super) fn decode(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let version = match data.first() {
        Some(0xa0) => 0,
        Some(0xa1) => 1,
        _ => return Err("the stream is neither version 0 nor 1 of mode ATTRIBUTES".to_owned()),
    };
    let tail = stride + if version == 1 { stride / 4 } else { 0 };
    let end = (data.len()).checked_sub(tail.max(LEAST_TAIL[version])).filter(|&end| end >= 1);
    let end = end.ok_or("the stream is too short for its last block")?;
    let (mut last, modes) = {
        let (baseline, modes) = data[data.len() - tail..].split_at(stride);
        (baseline.to_vec(), modes)
    };
    let mut channels = modes.iter().map(|&mode| channel(mode)).collect::<Result<Vec<_>, _>>()?;
    channels.resize(stride / 4, Channel::Bytes);

    let block = ((MOST_BYTES / stride) & !(GROUP - 1)).min(MOST_ELEMENTS);
    let mut body = Cursor(&data[1..end]);
    let least = if version == 1 { stride / 4 } else { stride * block.div_ceil(4 * GROUP) };
    if (count / block).saturating_mul(least) > body.0.len() {
        return Err("the stream is too short for its elements".to_owned());
    }
    let mut out = Vec::with_capacity(count * stride);
    let mut columns = vec![[0_u8; MOST_ELEMENTS]; stride];
    while out.len() < count * stride {
        let elements = (count - out.len() / stride).min(block);
        let packing = if version == 1 { body.take(stride / 4)? } else { &[] };
        for (k, column) in columns.iter_mut().enumerate() {
            let widths = match packing.get(k / 4).map(|byte| byte >> (2 * (k % 4)) & 3) {
                None => WIDTHS_0,
                Some(mode @ (0 | 1)) => WIDTHS_1[usize::from(mode)],
                Some(2) => {
                    column.fill(0);
                    continue;
                }
                Some(_) => {
                    column[..elements].copy_from_slice(body.take(elements)?);
                    continue;
                }
            };
            unpack(&mut body, widths, &mut column[..elements.next_multiple_of(GROUP)])?;
        }
        for i in 0..elements {
            for ((bytes, columns), channel) in
                last.chunks_exact_mut(4).zip(columns.chunks_exact(4)).zip(&channels)
            {
                let delta = [columns[0][i], columns[1][i], columns[2][i], columns[3][i]];
                let next = channel.add([bytes[0], bytes[1], bytes[2], bytes[3]], delta);
                bytes.copy_from_slice(&next);
            }
            out.extend_from_slice(&last);
        }
    }
    if body.0.is_empty() { Ok(out) } else { Err(format!("{} bytes are left over", body.0.len())) }
}

fn channel(mode: u8) -> Result<Channel, String> {
    match (mode & 15, mode >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Words),
        (2, turn) => Ok(Channel::Xor(u32::from(turn))),
        _ => Err(format!("there is no channel mode {mode}")),
    }
}

impl Channel {
    /// The bytes that come after `last`, given their difference.
    fn add(self, last: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|k| {
                let d = delta[k];
                last[k].wrapping_add(d >> 1 ^ (d & 1).wrapping_neg())
            }),
            Self::Words => {
                let word = |v: [u8; 4], k: usize| u16::from_le_bytes([v[k], v[k + 1]]);
                let next = |k: usize| {
                    let d = word(delta, k);
                    word(last, k).wrapping_add(d >> 1 ^ (d & 1).wrapping_neg()).to_le_bytes()
                };
                let ([a, b], [c, d]) = (next(0), next(2));
                [a, b, c, d]
            }
            Self::Xor(turn) => {
                (u32::from_le_bytes(last) ^ u32::from_le_bytes(delta).rotate_right(turn)).to_le_bytes()
            }
        }
    }
}

/// Unpacks whole groups: two bits for each say how wide its values are.
fn unpack(body: &mut Cursor<'_>, widths: Widths, out: &mut [u8]) -> Result<(), String> {
    let header = body.take(out.len().div_ceil(4 * GROUP))?;
    for (g, group) in out.chunks_exact_mut(GROUP).enumerate() {
        let width = widths[usize::from(header[g / 4] >> (2 * (g % 4)) & 3)];
        match width {
            0 => group.fill(0),
            8 => group.copy_from_slice(body.take(GROUP)?),
            _ => {
                let packed = body.take(GROUP * width as usize / 8)?;
                let sentinel = (1_u8 << width) - 1;
                let a_byte = 8 / width as usize;
                for (i, value) in group.iter_mut().enumerate() {
                    let place = (i % a_byte) as u32 * width;
                    // Single bits start at the low end of a byte, wider values at the high one.
                    let shift = if width == 1 { place } else { 8 - width - place };
                    *value = packed[i / a_byte] >> shift & sentinel;
                    if *value == sentinel {
                        *value = body.take(1)?[0];
                    }
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification: 16 differences in 4 bits each, two of them too large for that.
    #[test]
    fn the_example_of_the_specification() {
        let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut group = [0; GROUP];
        let mut header = vec![2];
        header.extend(bytes);
        let mut body = Cursor(&header);
        unpack(&mut body, WIDTHS_0, &mut group).expect("it unpacks");
        assert!(body.0.is_empty());
        let expected = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0_i8];
        for (delta, expected) in group.into_iter().zip(expected) {
            assert_eq!(Channel::Bytes.add([0; 4], [delta; 4]), [expected as u8; 4]);
        }
    }

    /// What meshoptimizer's own tests hold its encoder to: four vertices of six 16-bit and two 8-bit numbers.
    #[test]
    fn streams_of_the_reference_encoder() {
        let mut version_0 = vec![
            0xa0, 0x01, 0x3f, 0, 0, 0, 0x58, 0x57, 0x58, 0x01, 0x26, 0, 0, 0, 0x01, 0x0c, 0, 0, 0, 0x58,
            0x01, 0x08, 0, 0, 0, 0, 0, 0, 0, 0x01, 0x3f, 0, 0, 0, 0x17, 0x18, 0x17, 0x01, 0x26, 0, 0, 0,
            0x01, 0x0c, 0, 0, 0, 0x17, 0x01, 0x08, 0, 0, 0,
        ];
        version_0.resize(85, 0);
        let mut version_1 =
            vec![0xa1, 0xee, 0xaa, 0xee, 0, 0x4b, 0x4b, 0x4b, 0, 0, 0x4b, 0, 0, 0x7d, 0x7d, 0x7d, 0, 0, 0x7d];
        version_1.resize(44, 0);
        version_1[41] = 0x62;
        version_1[43] = 0x62;
        let vertices: [[u16; 6]; 4] =
            [[0; 6], [300, 0, 0, 0, 500, 0], [0, 300, 0, 0, 0, 500], [300, 300, 0, 0, 500, 500]];
        let expected: Vec<u8> = vertices.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        for stream in [version_0, version_1] {
            assert_eq!(decode(&stream, 4, 12).as_ref(), Ok(&expected));
            for end in 0..stream.len() {
                assert_ne!(decode(&stream[..end], 4, 12).as_ref(), Ok(&expected), "{end} bytes");
            }
            let _ = decode(&stream, usize::MAX / 256, 256).expect_err("far too few bytes");
        }
    }

    #[test]
    fn differences_wrap_around() {
        assert_eq!(Channel::Bytes.add([0, 255, 3, 4], [1, 2, 0, 3]), [255, 0, 3, 2]);
        let words = Channel::Words.add([0, 0, 255, 255], [1, 0, 2, 0]);
        assert_eq!(words, [255, 255, 0, 0]);
        let xor = Channel::Xor(8).add(0xff00_ff00_u32.to_le_bytes(), 0x1234_5678_u32.to_le_bytes());
        assert_eq!(u32::from_le_bytes(xor), 0xff00_ff00 ^ 0x7812_3456);
    }
}
