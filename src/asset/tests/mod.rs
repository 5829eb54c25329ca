//! Tests of the loader on files that are built here, in code.

mod animations;
mod containers;
mod far;
mod hostile;
mod materials;
mod meshes;
mod nodes;
mod oracle;
mod poses;
mod uris;

use std::path::Path;

use base64::Engine;
use serde_json::{Value, json};

use super::*;

/// A document under construction, with one buffer.
pub(crate) struct Builder {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Component codes of glTF.
pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

impl Builder {
    /// An empty document.
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [], "materials": [], "accessors": [], "bufferViews": [],
        });
        Self { json, bin: Vec::new() }
    }

    /// One triangle with corners at the origin, +X and +Y, of material 0 if there is one.
    pub fn triangle() -> Self {
        let mut b = Self::new();
        let position = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        b.json["accessors"][position]["min"] = json!([0, 0, 0]);
        b.json["accessors"][position]["max"] = json!([1, 1, 0]);
        b.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
        b
    }

    /// A triangle with one material.
    pub fn with_material(material: Value) -> Self {
        let mut b = Self::triangle();
        b.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        b.json["materials"] = json!([material]);
        b
    }

    /// Appends an entry to a top-level array and returns its index.
    pub fn push(&mut self, array: &str, entry: Value) -> usize {
        if self.json[array].is_null() {
            self.json[array] = json!([]);
        }
        let list = self.json[array].as_array_mut().expect("an array");
        list.push(entry);
        list.len() - 1
    }

    /// Appends bytes as a buffer view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Appends an accessor with a buffer view of its own.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let entry = json!({"bufferView": view, "type": kind, "componentType": component, "count": count});
        self.push("accessors", entry)
    }

    /// Appends an accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(kind, F32, values.len() / width, &floats(values))
    }

    /// The document with its buffer as a data URI.
    pub fn document(&self) -> Value {
        let mut json = self.json.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        let uri = format!("data:application/octet-stream;base64,{data}");
        json["buffers"] = json!([{"byteLength": self.bin.len(), "uri": uri}]);
        json
    }

    /// The document and its buffer as GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        glb(&[(*b"JSON", json.to_string().into_bytes()), (*b"BIN\0", self.bin.clone())])
    }

    /// Loads the document.
    pub fn load(&self) -> Result<Loaded, AssetError> {
        self.load_with(&LoadOptions::default())
    }

    /// Loads the document with options.
    pub fn load_with(&self, options: &LoadOptions) -> Result<Loaded, AssetError> {
        load_json(&self.document(), options)
    }

    /// Loads the document, which must work.
    #[track_caller]
    pub fn loaded(&self) -> Loaded {
        self.load().expect("it loads")
    }
}

/// A GLB of given chunks, padded as the format asks.
pub(crate) fn glb(chunks: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        let size = data.len().next_multiple_of(4);
        body.extend_from_slice(&(size as u32).to_le_bytes());
        body.extend_from_slice(kind);
        body.extend_from_slice(data);
        let padding = if kind == b"JSON" { b' ' } else { 0 };
        body.extend(std::iter::repeat_n(padding, size - data.len()));
    }
    let mut file = b"glTF".to_vec();
    file.extend_from_slice(&2_u32.to_le_bytes());
    file.extend_from_slice(&(12 + body.len() as u32).to_le_bytes());
    file.extend_from_slice(&body);
    file
}

pub(crate) fn load_json(json: &Value, options: &LoadOptions) -> Result<Loaded, AssetError> {
    load_bytes(json.to_string().into_bytes(), Path::new("/nowhere"), options)
}

/// Whether something was told at a pointer, with at least that severity.
pub(crate) fn told(loaded: &Loaded, severity: Severity, pointer: &str) -> bool {
    loaded.diagnostics.iter().any(|d| d.severity >= severity && d.pointer == pointer)
}

/// The pointer and the text of the error that a document must give.
#[track_caller]
pub(crate) fn refused(b: &Builder) -> String {
    b.load().expect_err("it must not load").to_string()
}
