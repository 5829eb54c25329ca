//! Modes 1 and 2 of meshopt compression: triangles as codes of a byte that refer to recent edges and vertices, and plain
//! sequences of indices as differences to one of two earlier ones. After Appendix A of KHR_meshopt_compression.

/// Entries that a queue remembers.
const REMEMBERED: usize = 16;
/// Bytes of the table that ends a stream of triangles.
const TABLE: usize = 16;
/// Bytes that end a stream of indices.
const PADDING: usize = 4;

/// The last few things, most recent first.
struct Recent<T> {
    entries: [Option<T>; REMEMBERED],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new() -> Self {
        Self { entries: [None; REMEMBERED], next: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next % REMEMBERED] = Some(entry);
        self.next = (self.next + 1) % REMEMBERED;
    }

    fn get(&self, back: u8) -> Result<T, String> {
        let at = (self.next + 2 * REMEMBERED - 1 - usize::from(back)) % REMEMBERED;
        self.entries[at].ok_or_else(|| "the stream refers to something that was never there".to_owned())
    }
}

/// Bytes yet to be read, and the index that differences refer to.
struct Extra<'d> {
    bytes: &'d [u8],
    last: u32,
}

impl Extra<'_> {
    fn byte(&mut self) -> Result<u8, String> {
        let (&byte, rest) = self.bytes.split_first().ok_or("the stream ends too early")?;
        self.bytes = rest;
        Ok(byte)
    }

    /// A number in groups of seven bits, least significant first.
    fn number(&mut self) -> Result<u32, String> {
        let mut number = 0_u32;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 127).checked_shl(shift).unwrap_or(0);
            if byte < 128 {
                return Ok(number);
            }
        }
        Err("a number has more than five bytes".to_owned())
    }

    fn index(&mut self) -> Result<u32, String> {
        self.last = self.last.wrapping_add(unfold(self.number()?));
        Ok(self.last)
    }
}

/// Signed numbers are stored with their sign in the lowest bit.
fn unfold(v: u32) -> u32 {
    v >> 1 ^ (v & 1).wrapping_neg()
}

/// Decodes a list of `count` indices of triangles, a multiple of three.
pub(super) fn triangles(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let codes = count / 3;
    if data.first() != Some(&0xe1) {
        return Err("the stream is not version 1 of mode TRIANGLES".to_owned());
    }
    let end = data.len().checked_sub(TABLE).filter(|&end| end > codes);
    let end = end.ok_or("the stream is too short for its triangles")?;
    let table = &data[end..];
    let mut extra = Extra { bytes: &data[1 + codes..end], last: 0 };
    let (mut edges, mut vertices) = (Recent::<(u32, u32)>::new(), Recent::<u32>::new());
    let mut unused = 0_u32;
    let mut fresh = |reset: bool| {
        if reset {
            unused = 0;
            return 0;
        }
        let index = unused;
        unused = unused.wrapping_add(1);
        index
    };
    let mut out = Vec::with_capacity(3 * codes);
    for &code in &data[1..=codes] {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            let (a, b) = edges.get(high)?;
            let c = match low {
                0 => fresh(false),
                1..=12 => vertices.get(low)?,
                13 | 14 => {
                    extra.last =
                        if low == 13 { extra.last.wrapping_sub(1) } else { extra.last.wrapping_add(1) };
                    extra.last
                }
                _ => extra.index()?,
            };
            edges.push((c, b));
            edges.push((a, c));
            if !(1..=12).contains(&low) {
                vertices.push(c);
            }
            out.extend([a, b, c]);
            continue;
        }
        let (pair, explicit) =
            if low < 14 { (table[usize::from(low)], false) } else { (extra.byte()?, true) };
        if explicit && pair == 0 {
            fresh(true);
        }
        let a = if low == 15 { extra.index()? } else { fresh(false) };
        let mut other = |nibble: u8| match nibble {
            0 => Ok(fresh(false)),
            15 if explicit => extra.index(),
            n => vertices.get(n - 1),
        };
        let (z, w) = (pair >> 4, pair & 15);
        let (b, c) = (other(z)?, other(w)?);
        edges.push((b, a));
        edges.push((c, b));
        edges.push((a, c));
        vertices.push(a);
        for (nibble, index) in [(z, b), (w, c)] {
            if nibble == 0 || (explicit && nibble == 15) {
                vertices.push(index);
            }
        }
        out.extend([a, b, c]);
    }
    if extra.bytes.is_empty() { Ok(out) } else { Err(format!("{} bytes are left over", extra.bytes.len())) }
}

/// Decodes a sequence of `count` indices.
pub(super) fn sequence(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    if data.first() != Some(&0xd1) {
        return Err("the stream is not version 1 of mode INDICES".to_owned());
    }
    let end = data.len().checked_sub(PADDING).filter(|&end| end > count);
    let end = end.ok_or("the stream is too short for its indices")?;
    let mut extra = Extra { bytes: &data[1..end], last: 0 };
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = extra.number()?;
        let last = &mut last[(v & 1) as usize];
        *last = last.wrapping_add(unfold(v >> 1));
        out.push(*last);
    }
    if extra.bytes.is_empty() { Ok(out) } else { Err(format!("{} bytes are left over", extra.bytes.len())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What meshoptimizer's own tests hold its encoder to.
    #[test]
    fn streams_of_the_reference_encoder() {
        let stream = [
            0xe1, 0xf0, 0x10, 0xfe, 0x1f, 0x3d, 0x00, 0x0a, 0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86,
            0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0x00, 0x00,
        ];
        let expected = [0, 1, 2, 2, 1, 3, 0, 1, 2, 2, 1, 5, 2, 1, 4];
        assert_eq!(triangles(&stream, 15).as_deref(), Ok(&expected[..]));
        let stream = [0xd1, 0x00, 0x04, 0xcd, 0x01, 0x04, 0x07, 0x98, 0x1f, 0x00, 0x00, 0x00, 0x00];
        assert_eq!(sequence(&stream, 6).as_deref(), Ok(&[0, 1, 51, 2, 49, 1000][..]));
        for count in [0, 3, 7, 1 << 40] {
            assert!(sequence(&stream, count).is_err(), "{count}");
        }
    }

    #[test]
    fn entries_that_were_never_there_are_refused() {
        for code in [0x00, 0x01, 0x10, 0xf2] {
            let mut stream = vec![0xe1, code];
            stream
                .extend([0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0]);
            stream.push(0);
            assert!(triangles(&stream, 3).is_err(), "{code:x}");
        }
    }

    /// The specification's third example, 0x1fd005, is in the order of bytes that its first two and its reference
    /// encoder do not have.
    #[test]
    fn numbers_of_the_specification() {
        for (bytes, number) in [(&[0x7f][..], 0x7f), (&[0x81, 0x04], 0x201), (&[0xff, 0xa0, 0x05], 0x1507f)] {
            let mut extra = Extra { bytes, last: 0 };
            assert_eq!(extra.number(), Ok(number), "{bytes:x?}");
        }
    }
}
