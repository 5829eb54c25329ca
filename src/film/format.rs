//! Which file format a path asks for, by its extension.

use std::path::{Path, PathBuf};

/// A file format [`write()`](super::write()) knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: linear, half or float, alpha, layers, attributes.
    Exr,
    /// PNG: tone mapped, 8 bit sRGB, alpha.
    Png,
    /// JPEG: tone mapped, 8 bit sRGB.
    Jpeg,
    /// Radiance RGBE: linear, 8 bit mantissas with a shared exponent.
    Hdr,
}

/// The extension of a path names no format that can be written.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
#[error("cannot tell the image format of {}: {}; known are {}", path.display(), found(path), known())]
pub struct UnknownFormat {
    /// The path as given.
    pub path: PathBuf,
}

/// Extensions in lower case and what they mean; the first of a format is its usual one.
const EXTENSIONS: [(&str, Format); 5] = [
    ("exr", Format::Exr),
    ("png", Format::Png),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("hdr", Format::Hdr),
];

impl Format {
    /// The format of a path by its extension, in any case.
    pub fn from_path(path: &Path) -> Result<Self, UnknownFormat> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        EXTENSIONS
            .iter()
            .find(|(name, _)| extension.as_deref() == Some(name))
            .map(|&(_, format)| format)
            .ok_or_else(|| UnknownFormat { path: path.to_owned() })
    }

    /// Whether the format holds linear radiance, so that tone mapping and exposure do not apply.
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Exr | Self::Hdr)
    }

    /// The longest side the format can hold, in pixels.
    pub fn max_side(self) -> u32 {
        match self {
            Self::Jpeg => u32::from(u16::MAX),
            Self::Exr | Self::Png | Self::Hdr => i32::MAX as u32,
        }
    }
}

fn found(path: &Path) -> String {
    match path.extension() {
        Some(extension) => format!("“.{}” is not one of them", extension.to_string_lossy()),
        None => "it has no extension".to_owned(),
    }
}

fn known() -> String {
    EXTENSIONS.map(|(name, _)| format!(".{name}")).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_read_in_any_case_and_unknown_ones_list_the_known() {
        assert_eq!(Format::from_path(Path::new("a/b.EXR")), Ok(Format::Exr));
        assert_eq!(Format::from_path(Path::new("b.v2.jpeg")), Ok(Format::Jpeg));
        let message = Format::from_path(Path::new("picture.bmp")).unwrap_err().to_string();
        for word in ["picture.bmp", ".bmp", ".exr", ".png", ".jpg", ".hdr"] {
            assert!(message.contains(word), "{message}");
        }
        assert!(Format::from_path(Path::new("png")).unwrap_err().to_string().contains("no extension"));
    }
}
