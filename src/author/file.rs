//! A `.gltf` or `.glb` file whose document is to be changed and whose other bytes are not.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::text::{NotJson, Tree};
use crate::asset::container::{self, Parts};
use crate::asset::{AssetError, Limits, uri};

/// A file in memory, taken apart.
#[derive(Clone, Debug)]
pub struct AuthoredFile {
    bytes: Vec<u8>,
    parts: Parts,
    document: Value,
}

impl AuthoredFile {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it cannot be read, is no glTF container, holds no JSON, or is larger than the limits.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self, AssetError> {
        Self::new(uri::document(path, limits.file_bytes)?, limits)
    }

    /// Reads a file from a stream, such as standard input.
    ///
    /// # Errors
    /// As [`AuthoredFile::read`].
    pub fn from_stream(stream: impl std::io::Read, limits: &Limits) -> Result<Self, AssetError> {
        Self::new(uri::stream(stream, limits.file_bytes)?, limits)
    }

    /// Takes the bytes of a file apart.
    ///
    /// # Errors
    /// As [`AuthoredFile::read`].
    pub fn new(bytes: Vec<u8>, limits: &Limits) -> Result<Self, AssetError> {
        let parts = container::split(&bytes)?;
        let json = bytes.get(parts.json.clone()).unwrap_or_default();
        let document = container::parse(json, limits.json_values)?.document;
        Ok(Self { bytes, parts, document })
    }

    /// The document as data.
    pub fn document(&self) -> &Value {
        &self.document
    }

    /// The whole file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether it is a GLB.
    pub fn is_binary(&self) -> bool {
        self.bytes.starts_with(b"glTF")
    }

    /// The document as text that can be changed.
    ///
    /// # Errors
    /// Where it is not JSON in UTF-8.
    pub fn tree(&self) -> Result<Tree<'_>, AssetError> {
        let json = self.bytes.get(self.parts.json.clone()).unwrap_or_default();
        let broken = |message: String| AssetError::Container { message, advice: None };
        let text =
            std::str::from_utf8(json).map_err(|e| broken(format!("the document is not UTF-8: {e}")))?;
        Tree::parse(text).map_err(|NotJson { at }| broken(format!("the document is not JSON at byte {at}")))
    }

    /// The bytes of the same file with another document; the very same bytes if the text is the same. The chunks of a
    /// GLB that follow the document are copied.
    ///
    /// # Errors
    /// Where a GLB would be larger than its header can say, 4 GiB.
    pub fn with_document(&self, text: &str) -> Result<Vec<u8>, AssetError> {
        self.with_document_and_data(text, &[])
    }

    /// Length of the binary chunk of a GLB, if it has one.
    pub fn chunk_length(&self) -> Option<usize> {
        self.parts.bin.as_ref().map(|range| range.len())
    }

    /// As [`with_document`](Self::with_document), with `data` behind the binary chunk of a GLB, from a multiple of four on;
    /// without such a chunk it becomes one. A `.gltf` gets none of it.
    ///
    /// # Errors
    /// As [`with_document`](Self::with_document).
    pub fn with_document_and_data(&self, text: &str, data: &[u8]) -> Result<Vec<u8>, AssetError> {
        let json = &self.parts.json;
        if data.is_empty() && self.bytes.get(json.clone()) == Some(text.as_bytes()) {
            return Ok(self.bytes.clone());
        }
        if !self.is_binary() {
            let mut bytes = self.bytes[..json.start].to_vec();
            bytes.extend_from_slice(text.as_bytes());
            return Ok(bytes);
        }
        const HEADERS: usize = 20;
        let text = text.trim_end().as_bytes();
        let padding = text.len().wrapping_neg() & 3;
        let chunk = text.len() + padding;
        let rest = self.bytes.get((json.end + 3) & !3..self.declared_length()).unwrap_or_default();
        let mut longer = Vec::new();
        let rest = if data.is_empty() { rest } else { self.lengthen(rest, data, &mut longer)? };
        let total = HEADERS + chunk + rest.len();
        let mut bytes = Vec::with_capacity(total);
        bytes.extend_from_slice(&self.bytes[..8]);
        bytes.extend_from_slice(&size(total)?);
        bytes.extend_from_slice(&size(chunk)?);
        bytes.extend_from_slice(b"JSON");
        bytes.extend_from_slice(text);
        bytes.resize(HEADERS + chunk, b' ');
        bytes.extend_from_slice(rest);
        Ok(bytes)
    }

    /// The chunks behind the document, with `data` at the end of the first of them, in `out`.
    fn lengthen<'o>(&self, rest: &[u8], data: &[u8], out: &'o mut Vec<u8>) -> Result<&'o [u8], AssetError> {
        let old = self.parts.bin.clone().and_then(|range| self.bytes.get(range)).unwrap_or_default();
        let padded = old.len().next_multiple_of(4);
        let length = (padded + data.len()).next_multiple_of(4);
        out.extend_from_slice(&size(length)?);
        out.extend_from_slice(b"BIN\0");
        const HEADER: usize = 8;
        out.extend_from_slice(old);
        out.resize(HEADER + padded, 0);
        out.extend_from_slice(data);
        out.resize(HEADER + length, 0);
        let behind = if self.parts.bin.is_some() { HEADER + padded } else { 0 };
        out.extend_from_slice(rest.get(behind..).unwrap_or_default());
        Ok(out)
    }

    /// The length that the header of a GLB states, at most that of the file.
    fn declared_length(&self) -> usize {
        let stated = self.bytes.get(8..12).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        stated.map_or(self.bytes.len(), |n| self.bytes.len().min(n as usize))
    }

    /// Every `uri` of the document that names a file beside it, with its JSON pointer.
    pub fn resources(&self) -> Vec<(String, String)> {
        uri::named_in(&self.document)
    }
}

/// A length as a GLB has it.
fn size(n: usize) -> Result<[u8; 4], AssetError> {
    u32::try_from(n).map(u32::to_le_bytes).map_err(|_| AssetError::Container {
        message: format!("{n} bytes do not fit into a GLB"),
        advice: Some("keep the document in a .gltf beside its buffers".to_owned()),
    })
}

/// The path, relative to `folder`, of the file that a URI of a document there names, and its content.
///
/// # Errors
/// Where the URI leads out of the folder or names no file.
pub fn resource(
    folder: &Path,
    pointer: &str,
    uri: &str,
    limit: u64,
) -> Result<(PathBuf, Vec<u8>), AssetError> {
    let payload = uri::file(folder, pointer, uri, false, limit)?;
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let mut path = PathBuf::new();
    for part in decoded.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    Ok((path, payload.bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &str, rest: &[u8]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend_from_slice(&((20 + json.len() + rest.len()) as u32).to_le_bytes());
        bytes.extend_from_slice(&(json.len() as u32).to_le_bytes());
        bytes.extend_from_slice(b"JSON");
        bytes.extend_from_slice(json.as_bytes());
        bytes.extend_from_slice(rest);
        bytes
    }

    #[test]
    fn the_other_chunks_of_a_glb_are_copied_and_lengths_are_right() {
        let rest = b"\x04\0\0\0BIN\0abcd\x04\0\0\0ABCDwxyz";
        let bytes = glb("{\"a\":1} ", rest);
        let file = AuthoredFile::new(bytes.clone(), &Limits::default()).unwrap();
        let unchanged = file.tree().unwrap().to_string();
        assert_eq!(file.with_document(&unchanged).unwrap(), bytes);
        for text in ["{}", "{\"a\":1}", "{\"a\":12345}"] {
            let changed = file.with_document(text).unwrap();
            assert!(changed.ends_with(rest) && changed.len().is_multiple_of(4));
            let again = AuthoredFile::new(changed, &Limits::default()).unwrap();
            assert_eq!(again.document(), &serde_json::from_str::<Value>(text).unwrap());
            assert!(again.parts.oddities.is_empty() && again.parts.bin.is_some());
        }
    }

    #[test]
    fn resources_are_found_wherever_they_are_and_data_is_none() {
        let text = r#"{"buffers":[{"uri":"a%20b.bin"},{"uri":"data:,x"}],"extensions":{"X":{"things":[{"uri":"c.dat"}]}}}"#;
        let file = AuthoredFile::new(text.into(), &Limits::default()).unwrap();
        let found = file.resources();
        let expected = [("/buffers/0/uri", "a%20b.bin"), ("/extensions/X/things/0/uri", "c.dat")];
        assert_eq!(found.len(), 2);
        assert!(expected.iter().all(|e| found.iter().any(|f| (&*f.0, &*f.1) == *e)), "{found:?}");
    }
}
