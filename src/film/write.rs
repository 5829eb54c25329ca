//! Writing a picture to a file: the common entrance of all formats.

use super::{Format, Picture, ToneMap, UnknownFormat, atomic};
use std::io::{self, Write};
use std::path::Path;

/// How to write a picture.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// Tone map of the display formats.
    pub tone_map: ToneMap,
    /// Exposure of the display formats in stops: radiance is multiplied by 2^exposure before tone mapping. The
    /// linear formats are not touched by it.
    pub exposure: f32,
    /// EXR with 32 bit floats instead of half floats.
    pub float: bool,
    /// Name and value pairs recorded in the file (EXR attributes, PNG text chunks), in this order.
    pub attributes: Vec<(String, String)>,
}

/// What could not be stored as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// Pixels with a NaN or infinite channel; that channel is written as 0.
    pub non_finite: usize,
    /// Pixels brighter than the largest half float (65504), written as that.
    pub clamped_to_half: usize,
}

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The extension names no format.
    #[error(transparent)]
    UnknownFormat(#[from] UnknownFormat),
    /// The picture's vectors do not have the length that its size asks for.
    #[error("not an image: {0}")]
    Malformed(String),
    /// The format cannot hold the image.
    #[error("{0}")]
    Encoding(String),
    /// The file system said no.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Writes a picture in the format of the path's extension. The file appears complete or not at all
/// ([`atomic::write_atomically`]). The bytes are a function of the picture and the options alone.
pub fn write(path: &Path, picture: &Picture, options: &WriteOptions) -> Result<WriteReport, WriteError> {
    let format = Format::from_path(path)?;
    picture.check().map_err(WriteError::Malformed)?;
    if picture.width.max(picture.height) > format.max_side() {
        return Err(WriteError::Encoding(format!(
            "an image of {} × {} pixels is too large for this format, which ends at {} a side",
            picture.width,
            picture.height,
            format.max_side()
        )));
    }
    let mut report = WriteReport::default();
    atomic::write_atomically(path, |out: &mut dyn Write| {
        report = match format {
            Format::Exr => super::exr::encode(out, picture, options)?,
            Format::Png => super::display::encode_png(out, picture, options)?,
            Format::Jpeg => super::display::encode_jpeg(out, picture, options)?,
            Format::Hdr => super::hdr::encode(out, picture)?,
        };
        Ok::<(), WriteError>(())
    })?;
    Ok(report)
}

impl WriteReport {
    /// The worse of two reports, for one picture written to several files.
    pub fn max(self, other: Self) -> Self {
        Self {
            non_finite: self.non_finite.max(other.non_finite),
            clamped_to_half: self.clamped_to_half.max(other.clamped_to_half),
        }
    }
}

/// The number of pixels with a channel that is not finite.
pub(super) fn count_non_finite(picture: &Picture) -> usize {
    let alpha = |i: usize| picture.alpha.as_ref().is_none_or(|alpha| alpha[i].is_finite());
    picture.pixels.iter().enumerate().filter(|&(i, p)| !p.is_finite() || !alpha(i)).count()
}

/// The value, or 0 if it is not finite.
pub(super) fn finite_or_zero(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
