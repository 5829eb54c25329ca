//! The KTX 2.0 container: header, index of levels, data format descriptor, keys and values.
//!
//! After the KTX File Format Specification 2.0, §3. Only what is needed of the first level is read.

use std::io::Read;

/// «KTX 20» between the bytes that reveal mangled line ends.
const MAGIC: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes of a level beyond those that the decoded image takes are not believed.
const LARGEST_SIDE: u32 = 1 << 16;
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;

/// A container that has been looked at.
pub(super) struct Container<'b> {
    /// A `VkFormat`; 0 for those of Basis Universal.
    pub format: u32,
    /// Colour model of the data format descriptor.
    pub model: u8,
    pub width: usize,
    pub height: usize,
    /// At least 1.
    pub layers: usize,
    /// 6 for cubes, else 1.
    pub faces: usize,
    /// Bytes of the first level once it is inflated.
    pub inflated: u64,
    scheme: u32,
    first_level: &'b [u8],
    keys: &'b [u8],
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}

fn range(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    let end = start.checked_add(usize::try_from(length).ok()?)?;
    bytes.get(start..end)
}

impl<'b> Container<'b> {
    /// Reads the header; `None` if the bytes are not KTX 2.0.
    pub fn new(bytes: &'b [u8]) -> Option<Result<Self, String>> {
        bytes.starts_with(MAGIC).then(|| Self::read(bytes).ok_or("the KTX container is broken")?)
    }

    fn read(bytes: &'b [u8]) -> Option<Result<Self, String>> {
        let [format, _, width, height, depth, layers, faces, _, scheme, dfd, dfd_length, keys, keys_length] = {
            let mut header = [0; 13];
            for (i, field) in header.iter_mut().enumerate() {
                *field = word(bytes, 12 + 4 * i)?;
            }
            header
        };
        let descriptor = range(bytes, dfd.into(), dfd_length.into())?;
        let (offset, length, inflated) = (long(bytes, 80)?, long(bytes, 88)?, long(bytes, 96)?);
        let container = Self {
            format,
            model: descriptor.get(12).copied().unwrap_or(0),
            width: width as usize,
            height: height.max(1) as usize,
            layers: layers.max(1) as usize,
            faces: faces.max(1) as usize,
            inflated: if scheme == ZSTANDARD { inflated } else { length },
            scheme,
            first_level: range(bytes, offset, length)?,
            keys: range(bytes, keys.into(), keys_length.into()).unwrap_or_default(),
        };
        if width == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
            return Some(Err(format!("{width} × {height} pixels are not possible")));
        }
        if depth > 1 || (faces != 1 && faces != 6) {
            return Some(Err("only images of two dimensions can be textures".to_owned()));
        }
        if scheme > ZSTANDARD || (scheme == BASIS_LZ && format != 0) {
            return Some(Err(format!("supercompression scheme {scheme} is not supported")));
        }
        Some(Ok(container))
    }

    /// Bytes that one image takes once it is decoded.
    pub fn decoded_bytes(&self) -> u64 {
        let per_pixel = match self.format {
            70..=97 => 8,
            100..=123 | 143 | 144 => 16,
            _ => 4,
        };
        self.width as u64 * self.height as u64 * per_pixel
    }

    /// The first level, inflated.
    pub fn level(&self) -> Result<std::borrow::Cow<'b, [u8]>, String> {
        if self.scheme != ZSTANDARD {
            return Ok(self.first_level.into());
        }
        let mut level = Vec::new();
        let stream = ruzstd::StreamingDecoder::new(self.first_level).map_err(|e| e.to_string())?;
        stream.take(self.inflated).read_to_end(&mut level).map_err(|e| e.to_string())?;
        Ok(level.into())
    }

    /// The value of a key, without the zero that ends it.
    fn value(&self, wanted: &[u8]) -> Option<&'b [u8]> {
        let mut rest = self.keys;
        while let Some(length) = word(rest, 0) {
            let pair = rest.get(4..)?.get(..length as usize)?;
            let (key, value) = pair.split_at(pair.iter().position(|&b| b == 0)?);
            if key == wanted {
                return Some(value[1..].strip_suffix(&[0]).unwrap_or(&value[1..]));
            }
            rest = rest.get(4 + (length as usize).next_multiple_of(4)..).unwrap_or_default();
        }
        None
    }

    /// Where the channels of a pixel come from, if not from themselves.
    pub fn swizzle(&self) -> Option<[u8; 4]> {
        let swizzle = self.value(b"KTXswizzle")?.try_into().ok()?;
        (&swizzle != b"rgba").then_some(swizzle)
    }

    /// Whether the first row is the lowest.
    pub fn is_upside_down(&self) -> bool {
        self.value(b"KTXorientation").is_some_and(|v| v.get(1) == Some(&b'u'))
    }
}
