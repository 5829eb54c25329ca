//! The bodies of the targets.

use std::path::Path;

use base64::Engine;
use nephrite::asset::environment::decode_environment;
use nephrite::asset::{Asset, Limits, LoadOptions, Loaded, Moment};
use nephrite::author::{AuthoredFile, Form, check, khronos, medium, openpbr, text::Tree};
use nephrite::scene::{DerivedLimits, EnvironmentDescription, Scene, SceneDescription, auto_camera};
use nephrite::transport::{RenderOptions, render};
use serde_json::{Value, json};

use super::sound;

/// Most triangles and texels of a scene that is compiled and rendered: enough for every kind of scene, and fast.
const MOST_RENDERED: usize = 4096;

/// Limits under which a load takes some tens of megabytes at most.
pub fn limits() -> Limits {
    Limits {
        file_bytes: 8 << 20,
        json_values: 100_000,
        nodes: 10_000,
        instances: 10_000,
        vertices: 100_000,
        triangles: 100_000,
        image_bytes: 4 << 20,
        pose_elements: 1_000_000,
        derived: DerivedLimits {
            pyramid_bytes: 8 << 20,
            environment_bytes: 8 << 20,
            hierarchy_bytes: 16 << 20,
            light_bytes: 8 << 20,
        },
    }
}

fn options() -> LoadOptions {
    LoadOptions { limits: limits(), ..LoadOptions::default() }
}

/// A folder where no file is.
fn nowhere() -> &'static Path {
    Path::new("/nonexistent/nephrite")
}

/// Takes the bytes for a `.glb` or `.gltf` file: reads it at rest and at a moment of its animations, checks it as `validate`
/// does, writes it back as `edit` does, and renders it where it is small. Whether it could be read.
pub fn loader(bytes: &[u8]) -> bool {
    written_back(bytes);
    let Ok(mut asset) = Asset::from_bytes(bytes.to_vec(), nowhere(), &options()) else { return false };
    let animations: Vec<usize> = (0..asset.animation_names().len().min(4)).collect();
    let rest = asset.load(&Moment::default());
    if let Ok(file) = AuthoredFile::new(bytes.to_vec(), &limits()) {
        check::check(&file, rest.as_ref());
    }
    let moved = (!animations.is_empty()).then(|| asset.load(&Moment { animations, time: 0.25 }));
    let read = rest.is_ok();
    for loaded in [Some(rest), moved].into_iter().flatten().flatten() {
        show(loaded);
    }
    read
}

/// A file without changes keeps every byte.
fn written_back(bytes: &[u8]) {
    let Ok(file) = AuthoredFile::new(bytes.to_vec(), &limits()) else { return };
    let Ok(tree) = file.tree() else { return };
    let copy = file.with_document(&tree.to_string()).expect("it is no longer than it was");
    assert!(copy == bytes, "a file without changes is written back differently");
}

/// Holds a scene against what every scene must keep, and renders it where that is quick.
fn show(loaded: Loaded) -> bool {
    let scene = loaded.scene;
    sound::check(&scene);
    let texels: usize = scene.images.iter().map(|i| i.width as usize * i.height as usize).sum();
    let triangles: usize = scene.instances.iter().map(|i| scene.meshes[i.mesh].triangles.len()).sum();
    if texels <= MOST_RENDERED && triangles <= MOST_RENDERED {
        picture(scene);
    }
    true
}

/// Four pixels of a scene: finite numbers, none below zero.
fn picture(scene: SceneDescription) {
    let [min, max] = scene.bounds().unwrap_or_default();
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| auto_camera(min, max, 1.0));
    let Ok(scene) = Scene::build(scene) else { return };
    let options = RenderOptions::new(camera).with(|o| {
        o.view.width = 2;
        o.view.height = 2;
        o.samples.count = 1;
        o.threads = 1;
        o.settings.max_depth = 64;
    });
    let rendered = render(&scene, &options, &()).expect("the options are sound");
    sound::check_film(&rendered.picture);
}

/// A square with corners at ±1, texture coordinates and a texture of 2 × 2 texels, closed to a box where `closed`.
fn square(material: &Value) -> Value {
    const CORNERS: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let faces: [u8; 12] = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
    let mut bin: Vec<u8> = CORNERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bin.extend(CORNERS.iter().flat_map(|c| [c[0], c[1]]).flat_map(f32::to_le_bytes));
    bin.extend(faces);
    let data = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let bin = data(&bin);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": 92, "uri": format!("data:application/octet-stream;base64,{bin}")}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-1, -1, -1], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5121, "count": 12, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0},
        ]}],
        "images": [{"uri": image()}],
        "textures": [{"source": 0}],
        "materials": [material],
    })
}

/// A small image as a URI.
pub fn image() -> String {
    format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(PNG))
}

/// 2 × 2 pixels: red, green, blue, white.
const PNG: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0, 0, 0, 253,
    212, 154, 115, 0, 0, 0, 22, 73, 68, 65, 84, 120, 218, 99, 248, 207, 192, 192, 240, 159, 129, 145, 129,
    225, 255, 255, 255, 12, 0, 30, 246, 4, 253, 11, 49, 124, 9, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

/// Takes the bytes for the JSON of a material: reads it through the registry of extensions, renders it, takes its medium
/// to every other form and back, and holds it against the schema. Whether it could be read.
pub fn extensions(bytes: &[u8]) -> bool {
    let Ok(material) = serde_json::from_slice::<Value>(bytes) else { return false };
    let read = material.is_object() && load(&square(&material)).is_some_and(show);
    if let Ok(text) = std::str::from_utf8(bytes) {
        converted(&material, text);
    }
    read
}

/// Takes the medium of a material to every form, each of which has to be JSON again.
fn converted(material: &Value, text: &str) {
    if let Some(own) = material.pointer("/extensions/NEPHRITE_materials_subsurface") {
        nephrite::author::nephrite::violations(own);
    }
    let Some(reading) = medium::read(material) else { return };
    for form in [Form::Nephrite, Form::KhrScatter, Form::OpenPbr] {
        let mut tree = Tree::parse(text).expect("it has been parsed before");
        match form {
            Form::Nephrite => nephrite::author::nephrite::write(tree.root_mut(), &reading.medium),
            Form::KhrScatter => khronos::write(tree.root_mut(), &reading.medium, 1.0, true),
            Form::OpenPbr => openpbr::write(tree.root_mut(), &reading.medium),
        }
        let written = tree.to_string();
        let value: Value = serde_json::from_str(&written).expect("what is written is JSON");
        medium::read(&value);
    }
}

/// Kinds of compressed bytes, told by the first byte of the input.
pub const PAYLOADS: usize = 3;

/// Takes the first byte for a kind and the rest for compressed data: a Draco stream, a meshopt stream (after four bytes
/// of parameters), or an image. Whether it could be decoded.
pub fn payloads(bytes: &[u8]) -> bool {
    let Some((&kind, data)) = bytes.split_first() else { return false };
    let document = match usize::from(kind) % PAYLOADS {
        0 => draco(data),
        1 => match data.split_first_chunk() {
            Some((parameters, data)) => meshopt(*parameters, data),
            None => return false,
        },
        _ => texture(data),
    };
    let Some(Loaded { scene, .. }) = load(&document) else { return false };
    sound::check(&scene);
    !scene.images.is_empty()
}

/// Most texels of an environment, so that a header of a few bytes takes a megabyte at most.
const MOST_TEXELS: usize = 1 << 16;

/// Takes the bytes for a Radiance or OpenEXR picture and puts it around a scene. Whether it could be read.
pub fn environments(bytes: &[u8]) -> bool {
    let Ok(read) = decode_environment(bytes, MOST_TEXELS) else { return false };
    sound::check_environment(&read.environment);
    let EnvironmentDescription::Map { pixels, .. } = &read.environment else { return true };
    if pixels.len() <= MOST_RENDERED
        && let Some(Loaded { mut scene, .. }) =
            load(&square(&json!({"pbrMetallicRoughness": {"metallicFactor": 0}})))
    {
        scene.environment = read.environment;
        picture(scene);
    }
    true
}

fn load(document: &Value) -> Option<Loaded> {
    let bytes = document.to_string().into_bytes();
    Asset::from_bytes(bytes, nowhere(), &options()).ok()?.load(&Moment::default()).ok()
}

/// The square's document with another buffer beside its own, in buffer view 3.
fn with_buffer(data: &[u8]) -> Value {
    let mut document = square(&json!({}));
    let uri = base64::engine::general_purpose::STANDARD.encode(data);
    let uri = format!("data:application/octet-stream;base64,{uri}");
    let list = |key: &str, entry: Value, document: &mut Value| {
        if let Some(list) = document[key].as_array_mut() {
            list.push(entry);
        }
    };
    list("buffers", json!({"byteLength": data.len(), "uri": uri}), &mut document);
    list("bufferViews", json!({"buffer": 1, "byteLength": data.len()}), &mut document);
    document
}

fn draco(data: &[u8]) -> Value {
    let mut document = with_buffer(data);
    document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    document["extensionsRequired"] = document["extensionsUsed"].clone();
    document["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {
        "bufferView": 3, "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 2},
    }});
    document
}

/// The positions, or the indices, come from a meshopt stream; `parameters` are mode and filter, stride, and count.
fn meshopt([how, stride, low, high]: [u8; 4], data: &[u8]) -> Value {
    let mut document = with_buffer(data);
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(how & 3) % 3];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][usize::from(how >> 2) % 5];
    let count = u16::from_le_bytes([low, high]);
    let size = usize::from(count) * usize::from(stride);
    document["extensionsUsed"] = json!(["KHR_meshopt_compression"]);
    document["bufferViews"][3] = json!({
        "buffer": 0, "byteLength": size, "extensions": {"KHR_meshopt_compression": {
            "buffer": 1, "byteLength": data.len(), "byteStride": stride, "count": count, "mode": mode, "filter": filter,
        }},
    });
    let which = if mode == "ATTRIBUTES" { 0 } else { 2 };
    document["accessors"][which]["bufferView"] = json!(3);
    document["accessors"][which]["count"] = json!(count);
    if which == 2 {
        document["accessors"][which]["componentType"] = json!(if stride == 2 { 5123 } else { 5125 });
    }
    document
}

/// The base colour is an image of whatever kind its first bytes say.
fn texture(data: &[u8]) -> Value {
    let mut document = with_buffer(data);
    document["images"] = json!([{"bufferView": 3, "mimeType": "image/png"}]);
    document["materials"][0] = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    document
}
