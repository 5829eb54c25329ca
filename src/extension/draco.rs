//! `KHR_draco_mesh_compression`: attributes and triangles of a primitive from a Draco stream.
//!
//! The stream is decoded by `draco-core`, which is safe Rust and keeps to ceilings of triangles and bytes; both are set
//! from the [`Limits`](crate::asset::Limits) before it starts. A broken stream gives way to the uncompressed copy where
//! the file has one. Draco gives a list of triangles, also where the primitive's `mode` says strip.

use std::collections::BTreeMap;

use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute};

use super::Extension;
use crate::asset::{AssetError, DecodedPrimitive, Json, Loader, Topology, guarded};

/// Bytes of the attributes of one stream. Draco stores equal values in next to nothing, so that the size of a stream
/// says little about what is in it.
const MOST_BYTES: u64 = 1 << 30;

/// Bytes that a vertex takes while its attribute is decoded.
const BYTES_OF_VALUE: u64 = 16;

pub(super) struct Draco;

impl Extension for Draco {
    fn name(&self) -> &str {
        "KHR_draco_mesh_compression"
    }

    fn decode_primitive(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        primitive: &Json<'_>,
    ) -> Result<Option<DecodedPrimitive>, AssetError> {
        match decode(loader, own, primitive) {
            Ok(decoded) => Ok(Some(decoded)),
            Err(AssetError::Invalid { pointer, message, .. })
                if !loader.requires(self.name()) && has_copy(loader, primitive)? =>
            {
                loader.invalid(&pointer, format!("{message}; the uncompressed copy is used"))?;
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

/// Whether the accessors of a primitive have data of their own.
fn has_copy(loader: &Loader<'_>, primitive: &Json<'_>) -> Result<bool, AssetError> {
    let Some(attributes) = primitive.object("attributes")? else { return Ok(false) };
    let Some(position) = attributes.usize("POSITION")? else { return Ok(false) };
    let accessor = loader.entry("accessors", position, &attributes.pointer_to("POSITION"))?;
    Ok(accessor.get("bufferView").is_some())
}

fn decode(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    primitive: &Json<'_>,
) -> Result<DecodedPrimitive, AssetError> {
    let pointer = own.pointer_to("bufferView");
    let view = own.usize("bufferView")?.ok_or_else(|| own.error_at("bufferView", "is missing"))?;
    let bytes = loader.buffer_view(view, &pointer)?;
    let ids = own.object("attributes")?.ok_or_else(|| own.error_at("attributes", "is missing"))?;
    let names = ids.as_object()?.keys().filter(|name| !name.starts_with('_'));
    let (vertices, triangles) = loader.room();
    let values = vertices.saturating_mul(BYTES_OF_VALUE).saturating_mul(ids.as_object()?.len() as u64);
    let limits = DecodeLimits::default()
        .with_max_points(vertices)
        .with_max_faces(triangles)
        .with_max_decoded_bytes(values.min(MOST_BYTES));
    let mesh = guarded(|| {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(&bytes).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|e| match e.kind() {
            ErrorKind::LimitExceeded => format!("{}, which the limits do not allow", e.message()),
            _ => e.message().to_owned(),
        })?;
        Ok(mesh)
    });
    let mesh =
        mesh.map_err(|e| AssetError::invalid(&pointer, format!("the Draco stream cannot be decoded: {e}")))?;
    let count = mesh.num_points();
    Loader::within(count as u64, vertices, &pointer, "the Draco stream, in vertices,", "vertices")?;

    let mut attributes = BTreeMap::new();
    let accessors = primitive.object("attributes")?;
    for name in names {
        let id = ids.usize(name)?.and_then(|id| u32::try_from(id).ok());
        let Some(attribute) = id.and_then(|id| mesh.attribute_by_unique_id(id)) else {
            let message = "the Draco stream has no attribute of that number; it is ignored";
            loader.invalid(&ids.pointer_to(name), message)?;
            continue;
        };
        let Some(accessors) = accessors.as_ref().filter(|a| a.get(name).is_some()) else {
            loader.invalid(&ids.pointer_to(name), "is no attribute of the primitive; it is ignored")?;
            continue;
        };
        let mut normalized = name.starts_with("COLOR");
        if let Some(index) = accessors.usize(name)? {
            let accessor = loader.entry("accessors", index, &accessors.pointer_to(name))?;
            normalized |= accessor.bool("normalized")?.unwrap_or(false);
            if let Some(promised) = accessor.usize("count")?.filter(|&n| n != count) {
                let message = format!("{promised} elements are promised, but the Draco stream has {count}");
                loader.invalid(&accessor.pointer_to("count"), message)?;
            }
        }
        attributes.insert(name.clone(), elements(attribute, count, normalized));
    }
    let indices = mesh.faces().iter().flatten().map(|point| point.0).collect();
    Ok(DecodedPrimitive { attributes, indices: Some(indices), topology: Some(Topology::Triangles) })
}

/// An attribute as the loader wants it: up to four numbers for each of `count` vertices.
fn elements(attribute: &PointAttribute, count: usize, normalized: bool) -> (usize, Vec<[f32; 4]>) {
    let width = usize::from(attribute.num_components()).clamp(1, 4);
    let top = match attribute.data_type() {
        DataType::Int8 => f32::from(i8::MAX),
        DataType::Uint8 => f32::from(u8::MAX),
        DataType::Int16 => f32::from(i16::MAX),
        DataType::Uint16 => f32::from(u16::MAX),
        _ => 1.0,
    };
    let scaled = |value: f32| if normalized && top > 1.0 { (value / top).max(-1.0) } else { value };
    let values = attribute.read_f32s(count, width);
    let element = |v: &[f32]| std::array::from_fn(|k| v.get(k).map_or(0.0, |&x| scaled(x)));
    (width, values.chunks_exact(width).map(element).collect())
}
