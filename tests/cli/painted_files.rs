//! Files of painted tetrahedra that are put together piece by piece, and what is in a GLB.

use super::util::Sandbox;
use serde_json::{Value, json};

/// A file of closed tetrahedra that is put together piece by piece.
pub struct Doc {
    pub json: Value,
    pub data: Vec<u8>,
}

/// Texture coordinates of the corners of the four faces: a quarter of the unit square each.
pub const APART: [[f32; 2]; 12] = [
    [0.05, 0.05],
    [0.45, 0.05],
    [0.05, 0.45],
    [0.55, 0.05],
    [0.95, 0.05],
    [0.55, 0.45],
    [0.05, 0.55],
    [0.45, 0.55],
    [0.05, 0.95],
    [0.55, 0.55],
    [0.95, 0.55],
    [0.55, 0.95],
];

impl Doc {
    pub fn new(materials: Value) -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [],
            "materials": materials, "meshes": [], "accessors": [], "bufferViews": [],
        });
        Self { json, data: Vec::new() }
    }

    pub fn list(&mut self, key: &str) -> &mut Vec<Value> {
        if self.json.get(key).is_none() {
            self.json[key] = json!([]);
        }
        self.json[key].as_array_mut().unwrap()
    }

    pub fn push(&mut self, key: &str, value: Value) -> usize {
        self.list(key).push(value);
        self.list(key).len() - 1
    }

    pub fn bytes(&mut self, bytes: &[u8]) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len() });
        self.data.extend(bytes);
        self.push("bufferViews", view)
    }

    pub fn floats(&mut self, values: &[f32], kind: &str, count: usize) -> usize {
        let view = self.bytes(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
        let mut accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        if kind == "VEC3" && values.len() == 36 {
            accessor["min"] = json!([-0.5, -0.5, -0.5]);
            accessor["max"] = json!([0.5, 0.5, 0.5]);
        }
        self.push("accessors", accessor)
    }

    /// A tetrahedron of twelve vertices; its primitive.
    pub fn primitive(
        &mut self,
        material: usize,
        uvs: Option<&[[f32; 2]; 12]>,
        faces: Option<[[f32; 4]; 4]>,
    ) -> Value {
        let c = [[0.5f32, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];
        let corners = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].concat();
        let positions: Vec<f32> = corners.iter().flat_map(|&i| c[i]).collect();
        let mut attributes = json!({ "POSITION": self.floats(&positions, "VEC3", 12) });
        if let Some(uvs) = uvs {
            attributes["TEXCOORD_0"] = json!(self.floats(&uvs.concat(), "VEC2", 12));
        }
        if let Some(faces) = faces {
            let colors: Vec<f32> = faces.iter().flat_map(|c| [*c; 3]).flatten().collect();
            attributes["COLOR_0"] = json!(self.floats(&colors, "VEC4", 12));
        }
        json!({ "attributes": attributes, "material": material })
    }

    pub fn object(&mut self, primitives: Vec<Value>, at: f32) {
        let mesh = self.push("meshes", json!({ "primitives": primitives }));
        let node = self.push("nodes", json!({ "mesh": mesh, "translation": [at, 0, 0] }));
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
    }

    /// A texture of one row.
    pub fn texture(&mut self, texels: &[[u8; 4]]) -> usize {
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, texels.len() as u32, 1);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&texels.concat()).unwrap();
        let view = self.bytes(&png);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        let sampler = self.push("samplers", json!({ "magFilter": 9728, "wrapS": 33071 }));
        self.push("textures", json!({ "source": image, "sampler": sampler }))
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.data.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut data = self.data.clone();
        data.resize(data.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(((28 + text.len() + data.len()) as u32).to_le_bytes());
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(text);
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(data);
        bytes
    }

    pub fn gltf(&self) -> String {
        use base64::Engine;
        let mut json = self.json.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.data);
        json["buffers"] = json!([{ "byteLength": self.data.len(), "uri": format!("data:application/octet-stream;base64,{data}") }]);
        format!("{json:#}")
    }
}

/// Document and binary chunk of a GLB.
pub fn open(sandbox: &Sandbox, name: &str) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(sandbox.path(name)).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(word(8), bytes.len());
    let end = 20 + word(12);
    (serde_json::from_slice(&bytes[20..end]).unwrap(), bytes[end + 8..end + 8 + word(end)].to_vec())
}
