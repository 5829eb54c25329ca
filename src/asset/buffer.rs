//! Buffers and buffer views (glTF 2.0 §3.6.1): bytes, checked before they are used.

use std::ops::{Deref, Range};
use std::sync::Arc;

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::uri;

/// A shared, read-only run of bytes.
#[derive(Clone, Debug)]
pub struct Bytes {
    data: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl From<Vec<u8>> for Bytes {
    fn from(data: Vec<u8>) -> Self {
        let range = 0..data.len();
        Self { data: Arc::new(data), range }
    }
}

impl Deref for Bytes {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.data[self.range.clone()]
    }
}

impl Bytes {
    /// `length` bytes from `offset` on; `None` if they are not all there.
    pub fn slice(&self, offset: usize, length: usize) -> Option<Self> {
        let start = self.range.start.checked_add(offset)?;
        let end = start.checked_add(length).filter(|&end| end <= self.range.end)?;
        Some(Self { data: Arc::clone(&self.data), range: start..end })
    }
}

impl Loader<'_> {
    /// The bytes that a URI at `pointer` stands for.
    ///
    /// # Errors
    /// Where the URI is broken, refused, or names no readable file.
    pub fn read_uri(&mut self, pointer: &str, uri: &str) -> Result<Bytes, AssetError> {
        let payload = match uri::data(pointer, uri) {
            Some(payload) => payload?,
            None => {
                let left = self.options.limits.file_bytes.saturating_sub(self.totals.file_bytes);
                let folder = self.folder.ok_or_else(|| uri::without_folder(pointer, uri))?;
                let payload = uri::file(folder, pointer, uri, self.options.allow_outside, left)?;
                self.totals.file_bytes += payload.bytes.len() as u64;
                payload
            }
        };
        if let Some(oddity) = payload.oddity {
            self.invalid(pointer, oddity)?;
        }
        Ok(payload.bytes.into())
    }

    /// The bytes of buffer `index`, exactly `byteLength` of them; `from` is the place that refers to it.
    ///
    /// # Errors
    /// Where there is no such buffer, or not as many bytes as it promises.
    pub fn buffer(&mut self, index: usize, from: &str) -> Result<Bytes, AssetError> {
        if let Some(bytes) = self.cache.buffers.get(&index) {
            return Ok(bytes.clone());
        }
        let json = self.entry("buffers", index, from)?;
        let length = json.usize("byteLength")?.ok_or_else(|| json.error_at("byteLength", "is missing"))?;
        let all = match json.str("uri")? {
            Some(uri) => self.read_uri(&json.pointer_to("uri"), uri)?,
            None if index == 0 => {
                let none = || json.error("has no `uri`, and the file has no binary chunk");
                self.bin.clone().ok_or_else(none)?
            }
            None => return Err(json.error("has no `uri`")),
        };
        let bytes = all.slice(0, length).ok_or_else(|| {
            json.error_at(
                "byteLength",
                format!("{length} bytes are promised, but there are only {}", all.len()),
            )
        })?;
        self.cache.buffers.insert(index, bytes.clone());
        Ok(bytes)
    }

    /// The bytes of buffer view `index`, decompressed where an extension says so; `from` refers to it.
    ///
    /// # Errors
    /// Where there is no such view, or it reaches beyond its buffer.
    pub fn buffer_view(&mut self, index: usize, from: &str) -> Result<Bytes, AssetError> {
        if let Some(bytes) = self.cache.views.get(&index) {
            return Ok(bytes.clone());
        }
        let json = self.entry("bufferViews", index, from)?;
        let bytes = match self.decode_view(&json)? {
            Some(bytes) => bytes,
            None => {
                let buffer = json.usize("buffer")?.ok_or_else(|| json.error_at("buffer", "is missing"))?;
                let offset = json.usize("byteOffset")?.unwrap_or(0);
                let length =
                    json.usize("byteLength")?.ok_or_else(|| json.error_at("byteLength", "is missing"))?;
                let buffer = self.buffer(buffer, &json.pointer_to("buffer"))?;
                buffer.slice(offset, length).ok_or_else(|| {
                    json.error(format!(
                        "{length} bytes from {offset} on reach beyond the end of the buffer, which has {}",
                        buffer.len()
                    ))
                })?
            }
        };
        self.cache.views.insert(index, bytes.clone());
        Ok(bytes)
    }

    fn decode_view(&mut self, json: &Json<'_>) -> Result<Option<Bytes>, AssetError> {
        if json.get("extensions").is_none() {
            return Ok(None);
        }
        for extension in self.options.registry.iter() {
            if let Some(own) = json.extension(extension.name())
                && let Some(bytes) = extension.decode_buffer_view(self, &own, json)?
            {
                return Ok(Some(bytes));
            }
        }
        Ok(None)
    }
}
