//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views as compressed streams.
//!
//! Both have the same object; the second has version 1 of the attribute codec and the filter for colours besides. Files
//! in the wild mix them up, so all of it is read under either name. A buffer view names two buffers: the stream's, and
//! one for programs that lack the extension, which may hold nothing. Where a stream is broken, and there is something in
//! the other buffer, that is read.

mod attributes;
mod filters;
mod indices;

use super::Extension;
use crate::asset::{AssetError, Bytes, Json, Loader};
use filters::Filter;

/// The greatest number of bytes of an element.
const MOST_STRIDE: usize = 256;

/// One of the two extensions.
pub(super) struct Meshopt(pub &'static str);

impl Extension for Meshopt {
    fn name(&self) -> &str {
        self.0
    }

    fn decode_buffer_view(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        view: &Json<'_>,
    ) -> Result<Option<Bytes>, AssetError> {
        match decode(loader, own, view) {
            Ok(bytes) => Ok(Some(bytes.into())),
            Err(AssetError::Invalid { pointer, message, .. })
                if !loader.requires(self.0) && has_copy(loader, view)? =>
            {
                loader.invalid(&pointer, format!("{message}; the uncompressed copy is used"))?;
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

/// Whether the buffer for programs without the extension has bytes.
fn has_copy(loader: &Loader<'_>, view: &Json<'_>) -> Result<bool, AssetError> {
    let Some(buffer) = view.usize("buffer")? else { return Ok(false) };
    Ok(loader.entry("buffers", buffer, &view.pointer_to("buffer"))?.get("uri").is_some())
}

fn decode(loader: &mut Loader<'_>, own: &Json<'_>, view: &Json<'_>) -> Result<Vec<u8>, AssetError> {
    let need = |key: &str| own.usize(key)?.ok_or_else(|| own.error_at(key, "is missing"));
    let (buffer, length, stride, count) =
        (need("buffer")?, need("byteLength")?, need("byteStride")?, need("count")?);
    let offset = own.usize("byteOffset")?.unwrap_or(0);
    let mode = own.str("mode")?.ok_or_else(|| own.error_at("mode", "is missing"))?;
    let filter = own.str("filter")?.unwrap_or("NONE");
    let filter = Filter::named(filter).ok_or_else(|| own.error_at("filter", "is no filter of meshopt"))?;
    let fits = match mode {
        "ATTRIBUTES" => {
            (4..=MOST_STRIDE).contains(&stride) && stride.is_multiple_of(4) && filter.allows(stride)
        }
        "TRIANGLES" | "INDICES" => (stride == 2 || stride == 4) && filter == Filter::None,
        _ => return Err(own.error_at("mode", "is none of ATTRIBUTES, TRIANGLES and INDICES")),
    };
    if !fits {
        return Err(
            own.error_at("byteStride", format!("{stride} bytes are not possible for this mode and filter"))
        );
    }
    if mode == "TRIANGLES" && !count.is_multiple_of(3) {
        return Err(own.error_at("count", format!("{count} indices do not make whole triangles")));
    }
    let size = count.saturating_mul(stride);
    if let Some(promised) = view.usize("byteLength")?.filter(|&n| n != size) {
        let message =
            format!("{promised} bytes are promised, but {count} elements of {stride} bytes are {size}");
        loader.invalid(&view.pointer_to("byteLength"), message)?;
    }
    loader.spend_bytes(
        size as u64,
        own.pointer(),
        "the decompressed buffer view and all before, in bytes,",
    )?;
    let data = loader.buffer(buffer, &own.pointer_to("buffer"))?;
    let data = data.slice(offset, length).ok_or_else(|| {
        own.error(format!(
            "{length} bytes from {offset} on reach beyond the end of the buffer, which has {}",
            data.len()
        ))
    })?;
    let decoded = match mode {
        "ATTRIBUTES" => attributes::decode(&data, count, stride).map(|mut elements| {
            filter.apply(&mut elements, stride);
            elements
        }),
        "TRIANGLES" => indices::triangles(&data, count).map(|list| pack(&list, stride)),
        _ => indices::sequence(&data, count).map(|list| pack(&list, stride)),
    };
    decoded.map_err(|e| own.error(format!("the stream cannot be decoded: {e}")))
}

/// Indices of two or four bytes.
fn pack(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|i| i.to_le_bytes().into_iter().take(stride)).collect()
}
