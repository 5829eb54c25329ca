//! Small scenes from glTF documents.

use base64::Engine;
use nephrite::asset::{LoadOptions, load_bytes};
use nephrite::scene::SceneDescription;
use serde_json::{Value, json};

/// A square floor, 40 m wide, at y = 0 that faces up, of material 0 with that colour, and nodes beside it.
pub fn floor(color: f32, metallic: f32, extensions: Value, nodes: &[Value]) -> SceneDescription {
    let corners = [[-20f32, 0.0, -20.0], [-20.0, 0.0, 20.0], [20.0, 0.0, 20.0], [20.0, 0.0, -20.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode([bytes, indices].concat());
    let roughness = 1.0 - metallic;
    let mut used: Vec<&str> =
        extensions.as_object().into_iter().flatten().map(|(name, _)| name.as_str()).collect();
    used.push("KHR_materials_specular");
    let all = [&[json!({"mesh": 0})], nodes].concat();
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": (0..=nodes.len()).collect::<Vec<_>>()}],
        "extensionsUsed": used,
        "extensions": extensions,
        "nodes": all,
        "materials": [{
            "pbrMetallicRoughness": {"baseColorFactor": [color, color, color, 1], "metallicFactor": metallic,
                "roughnessFactor": roughness},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
        }],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-20, 0, -20], "max": [20, 0, 20]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": format!("data:application/octet-stream;base64,{data}")}],
    });
    let bytes = document.to_string().into_bytes();
    let loaded = load_bytes(bytes, "/nowhere".as_ref(), &LoadOptions::default()).expect("loads");
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    loaded.scene
}

/// The rotation that turns −Z to straight down, and +Y to −Z.
pub const DOWN: [f32; 4] = [-std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];

/// A node with a light of an extension.
pub fn light(extension: &str, place: [f32; 3], rotation: [f32; 4]) -> Value {
    json!({"translation": place, "rotation": rotation, "extensions": {extension: {"light": 0}}})
}
