//! Compressed primitives and buffer views, manifold meshes and image-based lights, through the loader.

use glam::{Vec3, Vec4};
use serde_json::json;

use crate::asset::tests::{Builder, U16, refused, told};
use crate::asset::{LoadOptions, Severity};
use crate::scene::EnvironmentDescription;

/// A tetrahedron with colours of 8 bits, as Draco's sequential and edgebreaker encoders write it.
const DRACO: [&[u8]; 2] = [
    &[
        68, 82, 65, 67, 79, 2, 2, 1, 0, 0, 0, 4, 4, 1, 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 1, 2, 0, 9, 3, 0,
        0, 2, 2, 4, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 0, 0, 0,
        0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 1, 1, 0, 9, 3, 1, 16,
        1, 32, 19, 1, 16, 3, 0, 144, 144, 105, 128, 97, 198, 188, 44, 0, 0, 0, 0, 0, 255, 0, 0, 0,
    ],
    &[
        68, 82, 65, 67, 79, 2, 2, 1, 1, 0, 0, 0, 4, 4, 1, 3, 0, 0, 1, 47, 1, 1, 16, 255, 2, 102, 64, 2, 255,
        0, 0, 0, 0, 0, 1, 0, 9, 3, 0, 0, 0, 1, 2, 2, 4, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0,
        0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0,
        0, 0, 1, 1, 1, 0, 9, 7, 1, 16, 19, 1, 48, 3, 0, 56, 130, 102, 204, 205, 0, 101, 203, 204, 1, 33, 104,
        1, 203, 0, 0, 0, 0, 0, 255, 0, 0, 0,
    ],
];

fn draco(stream: &[u8]) -> Builder {
    let mut b = Builder::new();
    let view = b.view(stream);
    let position = b.push("accessors", json!({"componentType": 5126, "count": 4, "type": "VEC3"}));
    let color =
        b.push("accessors", json!({"componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"}));
    let index = b.push("accessors", json!({"componentType": 5123, "count": 12, "type": "SCALAR"}));
    b.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    b.json["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": position, "COLOR_0": color}, "indices": index,
        "extensions": {"KHR_draco_mesh_compression": {
            "bufferView": view, "attributes": {"POSITION": 0, "COLOR_0": 1},
        }},
    }]}]);
    b
}

#[test]
fn draco_streams_give_positions_colours_and_triangles() {
    for stream in DRACO {
        let loaded = draco(stream).loaded();
        assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
        let mesh = &loaded.scene.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 4));
        let fourth = Vec4::new(51.0, 102.0, 153.0, 0.0) / 255.0;
        for (p, c) in mesh.positions.iter().zip(&mesh.colors) {
            let expected = match p.to_array() {
                [0.0, 0.0, 0.0] => Vec4::new(1.0, 0.0, 0.0, 1.0),
                [1.0, 0.0, 0.0] => Vec4::new(0.0, 1.0, 0.0, 1.0),
                [0.0, 1.0, 0.0] => Vec4::new(0.0, 0.0, 1.0, 1.0),
                _ => fourth,
            };
            assert!((*c - expected).abs().max_element() < 1e-6, "{p}: {c}");
        }
        let volume: f32 = (mesh.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((volume - 1.0 / 6.0).abs() < 1e-6, "faces are turned outwards: {volume}");
    }
}

#[test]
fn broken_draco_streams_are_refused_or_replaced_by_the_copy() {
    let broken = &DRACO[1][..60];
    assert!(
        refused(&draco(broken)).starts_with("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression")
    );
    let mut b = draco(broken);
    let copy = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let primitive = &mut b.json["meshes"][0]["primitives"][0];
    primitive["attributes"] = json!({"POSITION": copy});
    primitive.as_object_mut().expect("an object").remove("indices");
    let loaded = b.loaded();
    assert_eq!(loaded.scene.meshes[0].triangles.len(), 1);
    assert!(loaded.diagnostics.iter().any(|d| d.message.contains("uncompressed copy")));

    for stream in DRACO {
        for at in 0..stream.len() {
            for value in [0, 1, 127, 128, 255] {
                let mut bad = stream.to_vec();
                bad[at] = value;
                let _ = draco(&bad).load();
            }
        }
    }
}

#[test]
fn draco_streams_keep_to_the_limits() {
    let mut options = LoadOptions::default();
    options.limits.triangles = 3;
    let error = draco(DRACO[0]).load_with(&options).expect_err("four triangles are too many");
    assert!(error.to_string().contains("limit"), "{error}");
}

/// Three vertices of twelve bytes by version 0 of mode ATTRIBUTES: each byte has a group of its own, all zero but for
/// the highest bytes of the two ones.
fn meshopt(fallback: serde_json::Value) -> Builder {
    let mut b = Builder::new();
    let sequence = b.view(&[0xd1, 0x00, 0x04, 0x04, 0x00, 0x00, 0x00, 0x00]);
    assert_eq!(sequence, 0);
    let positions = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let fallback_buffer = 1;
    let view = b.push(
        "bufferViews",
        json!({"buffer": fallback_buffer, "byteLength": 6, "extensions": {"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": 0, "byteLength": 8, "byteStride": 2, "mode": "INDICES", "count": 3,
        }}}),
    );
    let index =
        b.push("accessors", json!({"bufferView": view, "componentType": U16, "count": 3, "type": "SCALAR"}));
    b.json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    b.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}, "indices": index}]}]);
    b.json["fallback"] = fallback;
    b
}

fn load(b: &Builder) -> Result<crate::asset::Loaded, crate::asset::AssetError> {
    let mut document = b.document();
    document["buffers"].as_array_mut().expect("buffers").push(b.json["fallback"].clone());
    crate::asset::tests::load_json(&document, &LoadOptions::default())
}

#[test]
fn meshopt_views_need_no_fallback_and_fall_back_where_there_is_one() {
    let empty = json!({"byteLength": 6, "extensions": {"EXT_meshopt_compression": {"fallback": true}}});
    let loaded = load(&meshopt(empty.clone())).expect("it loads");
    assert_eq!(loaded.scene.meshes[0].triangles, [[0, 1, 2]]);

    let own = |b: &mut Builder, key: &str, value: serde_json::Value| {
        b.json["bufferViews"][2]["extensions"]["EXT_meshopt_compression"][key] = value;
    };
    let copy = json!({"byteLength": 6, "uri": "data:application/octet-stream;base64,AQACAAAA"});
    for (key, value) in [
        ("count", json!(4)),
        ("count", json!(1_u64 << 50)),
        ("byteStride", json!(3)),
        ("byteLength", json!(7)),
        ("byteOffset", json!(1)),
        ("mode", json!("TRIANGLES")),
        ("mode", json!("LINES")),
        ("filter", json!("OCTAHEDRAL")),
        ("filter", json!("SHARPEN")),
        ("buffer", json!(7)),
    ] {
        let mut b = meshopt(empty.clone());
        own(&mut b, key, value.clone());
        let error = load(&b).map(|_| ()).expect_err(key);
        assert!(error.pointer().starts_with("/bufferViews/2/extensions"), "{key}: {error}");
        let mut b = meshopt(copy.clone());
        own(&mut b, key, value);
        let mut required = meshopt(copy.clone());
        required.json = b.json.clone();
        required.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
        assert!(load(&required).is_err(), "{key}: the copy is no substitute for what is required");
        match load(&b) {
            Ok(loaded) => {
                assert_eq!(loaded.scene.meshes[0].triangles, [[1, 2, 0]], "{key}");
                assert!(loaded.diagnostics.iter().any(|d| d.message.contains("uncompressed copy")));
            }
            Err(error) => assert!(error.to_string().contains("limit"), "{key}: {error}"),
        }
    }
}

/// Two tetrahedra that touch at the origin: equal positions, but vertices of their own.
#[test]
fn manifold_meshes_are_verified() {
    let mut positions = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    positions.extend(positions.clone().iter().map(|x| -x));
    // One corner of the first is stored twice.
    positions.extend([1.0, 0.0, 0.0]);
    let triangles: [u16; 24] = [0, 2, 1, 0, 8, 3, 1, 2, 3, 2, 0, 3, 4, 5, 6, 4, 7, 5, 5, 7, 6, 6, 7, 4];
    let bytes: Vec<u8> = triangles.iter().flat_map(|i| i.to_le_bytes()).collect();
    let build = |stands_for: u8| {
        let mut b = Builder::new();
        let position = b.floats("VEC3", &positions);
        let indices = b.accessor("SCALAR", U16, 24, &bytes);
        let manifold = b.accessor("SCALAR", U16, 24, &bytes);
        let (places, values) = (b.view(&[4]), b.view(&[stands_for, 0]));
        b.json["accessors"][manifold]["sparse"] = json!({
            "count": 1, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values},
        });
        b.json["extensionsUsed"] = json!(["EXT_mesh_manifold"]);
        b.json["meshes"] = json!([{
            "primitives": [{"attributes": {"POSITION": position}, "indices": indices}],
            "extensions": {"EXT_mesh_manifold": {"manifoldPrimitive": {
                "attributes": {"POSITION": position}, "indices": manifold,
            }}},
        }]);
        b.loaded()
    };
    let good = build(1);
    let merged = &good.scene.meshes[0].merged;
    assert_eq!((merged.len(), merged[1]), (8, [0, 1, 3]));
    assert!(!told(&good, Severity::Warning, "/meshes/0/extensions"));
    let bad = build(2);
    assert!(bad.scene.meshes[0].merged.is_empty(), "vertex 8 is not where vertex 2 is");
    assert!(told(&bad, Severity::Warning, "/meshes/0/extensions"));
}

#[test]
fn image_based_lights_become_the_environment() {
    let mut b = Builder::triangle();
    let mut rows = vec![json!([0, 0, 0]); 9];
    // π · 2√π is the irradiance coefficient of radiance 1.
    let level = std::f64::consts::PI * 2.0 * std::f64::consts::PI.sqrt();
    rows[0] = json!([level, 2.0 * level, 0]);
    b.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    b.json["extensions"] = json!({"EXT_lights_image_based": {"lights": [
        {"intensity": 3, "irradianceCoefficients": rows, "specularImages": [], "specularImageSize": 1},
    ]}});
    b.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    let EnvironmentDescription::Map { pixels, scale, .. } = b.loaded().scene.environment else {
        panic!("no map")
    };
    for pixel in pixels {
        assert!((pixel * scale - Vec3::new(3.0, 6.0, 0.0)).abs().max_element() < 1e-5, "{pixel}");
    }
    b.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 1}});
    assert!(told(&b.loaded(), Severity::Warning, "/scenes/0/extensions/EXT_lights_image_based/light"));
}
