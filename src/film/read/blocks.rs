//! Blocks of pixels of an OpenEXR file: found by the table of offsets, measured, decompressed, and taken apart.
//!
//! Every size that a file states is held against the bytes that are there and against what the data window needs before
//! anything is allocated. The decompressors are those of the `exr` crate, which trusts sizes inside of DWA blocks and counts every
//! channel as if it had a sample in each pixel; so blocks are handed to it one by one, with a header of their own.

use super::ReadError;
use crate::guard::guarded;
use ::exr::compression::Compression;
use ::exr::math::RoundingMode;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelList, IntegerBounds, LevelMode, SampleType, TileDescription};
use ::exr::meta::header::Header;
use ::exr::prelude::{LineOrder, Text, Vec2, f16};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Most bytes of a decompressed block: 256 lines of 16384 pixels with 16 channels of 4 bytes.
const MOST_BLOCK: usize = 1 << 28;

/// Most bytes of all decompressed blocks of a part. They are never there together, but take time.
const MOST_PART: usize = 1 << 34;

/// A part of a file.
pub(super) struct Part<'a> {
    /// The whole file.
    pub file: &'a [u8],
    pub header: &'a Header,
    /// The offsets of its blocks, 8 bytes each.
    pub offsets: &'a [u8],
    /// Its number, which every block repeats in files of several parts.
    pub number: Option<u32>,
}

/// A block in the file.
struct Block<'a> {
    columns: Range<usize>,
    rows: Range<usize>,
    data: &'a [u8],
}

fn broken(message: impl Into<String>) -> ReadError {
    ReadError::Decode(message.into())
}

/// Takes `N` bytes at `at`, which moves on.
fn take<const N: usize>(file: &[u8], at: &mut usize) -> Option<[u8; N]> {
    let bytes = file.get(*at..)?.first_chunk::<N>()?;
    *at += N;
    Some(*bytes)
}

fn number(file: &[u8], at: &mut usize) -> Option<usize> {
    usize::try_from(i32::from_le_bytes(take(file, at)?)).ok()
}

impl Part<'_> {
    fn width(&self) -> usize {
        self.header.layer_size.width()
    }

    fn height(&self) -> usize {
        self.header.layer_size.height()
    }

    /// Columns and rows of the largest block.
    fn block_size(&self) -> (usize, usize) {
        match self.header.blocks {
            BlockDescription::ScanLines => (self.width(), self.header.compression.scan_lines_per_block()),
            BlockDescription::Tiles(tiles) => (tiles.tile_size.width(), tiles.tile_size.height()),
        }
    }

    /// Bytes of a pixel that every channel has a sample of.
    fn pixel_bytes(&self) -> usize {
        self.header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample()).sum()
    }

    /// Bytes of a decompressed block.
    fn block_bytes(&self, columns: &Range<usize>, rows: &Range<usize>) -> usize {
        let samples =
            |range: &Range<usize>, step: usize| range.end.div_ceil(step) - range.start.div_ceil(step);
        let bytes = (self.header.channels.list.iter()).map(|c| {
            samples(columns, c.sampling.x())
                .saturating_mul(samples(rows, c.sampling.y()))
                .saturating_mul(c.sample_type.bytes_per_sample())
        });
        bytes.fold(0, usize::saturating_add)
    }

    /// What of the part can be known to be impossible from its header.
    fn check(&self) -> Result<(), ReadError> {
        let Vec2(x, y) = self.header.own_attributes.layer_position;
        let in_tiles = matches!(self.header.blocks, BlockDescription::Tiles(_));
        for channel in &self.header.channels.list {
            let Vec2(step_x, step_y) = channel.sampling;
            if in_tiles && (step_x, step_y) != (1, 1) {
                return Err(broken(format!(
                    "channel {} has fewer samples than pixels, which pictures in tiles must not have",
                    super::exr::shown(&channel.name)
                )));
            }
            let fits = |start: i32, size: usize, step: usize| {
                i64::try_from(step).is_ok_and(|s| s > 0 && i64::from(start) % s == 0)
                    && size.is_multiple_of(step)
            };
            if !fits(x, self.width(), step_x) || !fits(y, self.height(), step_y) {
                return Err(broken(format!(
                    "its data window does not begin and end at samples of channel {}",
                    super::exr::shown(&channel.name)
                )));
            }
        }
        let (columns, rows) = self.block_size();
        let (columns, rows) = (columns.min(self.width()), rows.min(self.height()));
        if columns == 0 || rows == 0 {
            return Err(broken("its blocks have no pixels"));
        }
        let pixel = self.pixel_bytes();
        let block = columns.saturating_mul(rows).saturating_mul(pixel);
        let all = self.width().saturating_mul(self.height()).saturating_mul(pixel);
        if block > MOST_BLOCK || all > MOST_PART {
            return Err(broken(format!(
                "{} channels of {} × {} pixels in blocks of {columns} × {rows} are more than is read; \
                 save the picture without the other layers",
                self.header.channels.list.len(),
                self.width(),
                self.height(),
            )));
        }
        Ok(())
    }

    /// The blocks of the largest level, each in its place once.
    fn blocks(&self) -> Result<Vec<Block<'_>>, ReadError> {
        let (columns, rows) = self.block_size();
        let (across, down) = (self.width().div_ceil(columns), self.height().div_ceil(rows));
        let count = across.saturating_mul(down);
        if count > self.offsets.len() / 8 {
            return Err(broken("its table of blocks is shorter than the data window needs"));
        }
        // The largest level comes first.
        let offsets = self.offsets.chunks_exact(8).take(count);
        let mut seen = vec![false; count];
        let mut blocks = Vec::with_capacity(count);
        for (i, offset) in offsets.enumerate() {
            let offset = u64::from_le_bytes(offset.try_into().unwrap_or_default());
            let found = usize::try_from(offset).ok().and_then(|at| self.block(at, across, down));
            let block = found.ok_or_else(|| {
                broken(format!("block {} of {count} is not in the file, which may be incomplete", i + 1))
            })?;
            let index = block.rows.start / rows * across + block.columns.start / columns;
            if std::mem::replace(&mut seen[index], true) {
                return Err(broken(format!("block {} of {count} is there twice", index + 1)));
            }
            blocks.push(block);
        }
        Ok(blocks)
    }

    /// The block that begins at `at`.
    fn block(&self, mut at: usize, across: usize, down: usize) -> Option<Block<'_>> {
        let file = self.file;
        if let Some(part) = self.number
            && u32::from_le_bytes(take(file, &mut at)?) != part
        {
            return None;
        }
        let (columns, rows) = self.block_size();
        let (column, row) = match self.header.blocks {
            BlockDescription::ScanLines => {
                let y = i64::from(i32::from_le_bytes(take(file, &mut at)?));
                let y = usize::try_from(y - i64::from(self.header.own_attributes.layer_position.y())).ok()?;
                y.is_multiple_of(rows).then_some((0, y / rows))?
            }
            BlockDescription::Tiles(_) => {
                let place = (number(file, &mut at)?, number(file, &mut at)?);
                let level: [u8; 8] = take(file, &mut at)?;
                (level == [0; 8]).then_some(place)?
            }
        };
        let size = number(file, &mut at)?;
        let data = file.get(at..)?.get(..size)?;
        if column >= across || row >= down {
            return None;
        }
        let columns = column * columns..(column * columns + columns).min(self.width());
        let rows = row * rows..(row * rows + rows).min(self.height());
        Some(Block { columns, rows, data })
    }

    /// Reads three channels into the components of pixels, `width * height` of the data window. A channel with fewer
    /// samples than pixels has them at those pixels whose coordinates are multiples of its sampling.
    pub fn pixels(&self, wanted: [Option<usize>; 3]) -> Result<Vec<Vec3>, ReadError> {
        self.check()?;
        let blocks = self.blocks()?;
        let mut pixels = Vec::new();
        let count = self.width() * self.height();
        pixels.try_reserve_exact(count).map_err(|_| ReadError::memory(self.width(), self.height()))?;
        pixels.resize(count, Vec3::ZERO);
        let largest = blocks.iter().map(|b| self.block_bytes(&b.columns, &b.rows)).max().unwrap_or(0).max(1);
        let together = (MOST_BLOCK / largest).clamp(1, 4 * rayon::current_num_threads());
        for batch in blocks.chunks(together) {
            let decoded: Vec<_> = batch.par_iter().map(|block| self.decompressed(block)).collect();
            for (block, bytes) in batch.iter().zip(decoded) {
                self.insert(block, &bytes?, wanted, &mut pixels)?;
            }
        }
        Ok(pixels)
    }

    /// The bytes of a block: row by row, in each row channel by channel.
    fn decompressed(&self, block: &Block<'_>) -> Result<Vec<u8>, ReadError> {
        let expected = self.block_bytes(&block.columns, &block.rows);
        let compression = self.header.compression;
        if block.data.len() == expected || compression == Compression::Uncompressed {
            return (block.data.len() == expected).then(|| block.data.to_vec()).ok_or_else(|| {
                broken(format!("a block has {} bytes where {expected} are expected", block.data.len()))
            });
        }
        if block.data.is_empty() {
            return Err(broken("a block has no bytes"));
        }
        let size = Vec2(block.columns.len(), block.rows.len());
        if matches!(compression, Compression::DWAA(_) | Compression::DWAB(_)) {
            check_dwa(block.data, &self.header.channels, size, expected)?;
        }
        if !expected.is_multiple_of(size.area()) {
            return Err(broken("channels of so few samples cannot be read from compressed files"));
        }
        // A picture of this one block, so that the crate knows its size.
        let tile = TileDescription {
            tile_size: size,
            level_mode: LevelMode::Singular,
            rounding_mode: RoundingMode::Down,
        };
        let mut header = Header::new(Text::from(""), size, self.header.channels.list.clone()).with_encoding(
            compression,
            BlockDescription::Tiles(tile),
            LineOrder::Increasing,
        );
        header.channels.bytes_per_pixel = expected / size.area();
        let window = IntegerBounds::from_dimensions(size);
        let decode = || {
            compression
                .decompress_image_section_from_le(&header, block.data.to_vec(), window, false)
                .map_err(|e| e.to_string())
        };
        match guarded(decode).map_err(ReadError::Decode)? {
            bytes if bytes.len() == expected => Ok(bytes),
            bytes => Err(broken(format!("a block has {} bytes where {expected} are expected", bytes.len()))),
        }
    }

    /// Puts the samples of the wanted channels where they belong.
    fn insert(
        &self,
        block: &Block<'_>,
        bytes: &[u8],
        wanted: [Option<usize>; 3],
        pixels: &mut [Vec3],
    ) -> Result<(), ReadError> {
        let mut rest = bytes;
        for y in block.rows.clone() {
            for (index, channel) in self.header.channels.list.iter().enumerate() {
                let Vec2(step, step_y) = channel.sampling;
                if !y.is_multiple_of(step_y) {
                    continue;
                }
                let size = channel.sample_type.bytes_per_sample();
                let columns = block.columns.start.next_multiple_of(step)..block.columns.end;
                let samples = columns.len().div_ceil(step);
                let line = rest.split_off(..samples * size).ok_or_else(|| broken("a block is too short"))?;
                let Some(component) = wanted.iter().position(|&w| w == Some(index)) else { continue };
                let row = &mut pixels[y * self.width()..][columns];
                for (pixel, sample) in row.iter_mut().step_by(step).zip(line.chunks_exact(size)) {
                    pixel[component] = value(channel.sample_type, sample);
                }
            }
        }
        Ok(())
    }
}

/// A little-endian sample.
fn value(kind: SampleType, bytes: &[u8]) -> f32 {
    match (kind, bytes) {
        (SampleType::F16, &[a, b]) => f16::from_le_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
        _ => 0.0,
    }
}

/// Holds the sizes at the beginning of a DWA block against those that its window can need. The order is that of
/// `internal_dwa_compressor.h` of OpenEXR: version, then bytes or counts of the sections, then the kind of entropy coding.
fn check_dwa(data: &[u8], channels: &ChannelList, size: Vec2<usize>, bytes: usize) -> Result<(), ReadError> {
    let mut counters = [0_u64; 11];
    for (counter, bytes) in counters.iter_mut().zip(data.chunks_exact(8)) {
        *counter = u64::from_le_bytes(bytes.try_into().unwrap_or_default());
    }
    if data.len() < 8 * counters.len() {
        return Err(broken("a DWA block is shorter than its header"));
    }
    let [_, raw, raw_packed, ac_packed, dc_packed, rle_packed, rle, rle_raw, ac, dc, _] = counters;
    // Cosines are taken of squares of 8 × 8 pixels, each of which has a mean and at most 63 other coefficients and an end.
    let squares = (size.width().div_ceil(8) * size.height().div_ceil(8)).saturating_mul(channels.list.len());
    let most = [
        (raw, bytes),
        (rle_raw, bytes),
        (rle, bytes.saturating_mul(2).saturating_add(128)),
        (dc, squares),
        (ac, squares.saturating_mul(64)),
        (raw_packed, data.len()),
        (ac_packed, data.len()),
        (dc_packed, data.len()),
        (rle_packed, data.len()),
    ];
    match most.iter().find(|&&(stated, most)| stated > most as u64) {
        Some((stated, most)) => Err(broken(format!(
            "a DWA block of {} × {} pixels states a size of {stated} where {most} is the most that it can need",
            size.width(),
            size.height()
        ))),
        None => Ok(()),
    }
}
