//! GLB and JSON: what is read, what is refused, what is only odd.

use super::*;

fn bytes(bytes: Vec<u8>) -> Result<Loaded, AssetError> {
    load_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default())
}

#[test]
fn glb_and_data_uri_give_the_same_scene() {
    let b = Builder::triangle();
    let (one, other) = (b.loaded(), bytes(b.glb()).expect("the GLB loads"));
    assert_eq!(one.scene.meshes[0].positions, other.scene.meshes[0].positions);
    assert_eq!(one.scene.meshes[0].triangles, [[0, 1, 2]]);
    assert!(other.diagnostics.is_empty(), "{:?}", other.diagnostics);
    assert_eq!(other.summary.triangles, 1);
}

#[test]
fn every_truncation_and_every_flipped_byte_of_a_glb_ends_well() {
    let b = Builder::with_material(json!({"extensions": {"NEPHRITE_materials_subsurface": {"ior": 1.3}}}));
    let whole = b.glb();
    for length in 0..whole.len() {
        assert!(bytes(whole[..length].to_vec()).is_err(), "cut to {length}");
    }
    for at in 0..whole.len() {
        for flip in [0x01, 0x80] {
            let mut broken = whole.clone();
            broken[at] ^= flip;
            let _ = bytes(broken);
        }
    }
}

#[test]
fn broken_containers() {
    let json = Builder::new().json.to_string().into_bytes();
    let mut version_1 = Builder::triangle().glb();
    version_1[4] = 1;
    let mut too_long = Builder::triangle().glb();
    too_long[8..12].fill(0xFF);
    for (name, file) in [
        ("empty", Vec::new()),
        ("text", b"hello".to_vec()),
        ("array", b"[]".to_vec()),
        ("null", b"null".to_vec()),
        ("two documents", b"{} {}".to_vec()),
        ("a number that is none", br#"{"asset":{"version":"2.0"},"x":NaN}"#.to_vec()),
        ("BIN before JSON", glb(&[(*b"BIN\0", vec![0; 4]), (*b"JSON", json.clone())])),
        ("no chunks", glb(&[])),
        ("empty JSON", glb(&[(*b"JSON", Vec::new())])),
        ("version 1", version_1),
        ("length 2^32 - 1", too_long),
    ] {
        assert!(bytes(file).is_err(), "{name}");
    }
    let document = Builder::triangle().document().to_string().into_bytes();
    let odd = glb(&[(*b"JSON", document), (*b"BIN\0", Vec::new()), (*b"ODD!", vec![1, 2, 3])]);
    assert!(bytes(odd).is_ok_and(|l| l.diagnostics.is_empty()), "unknown chunks are skipped");
}

#[test]
fn oddities_are_told_and_strict_refuses_them() {
    let text = Builder::triangle().document().to_string();
    let bom = [b"\xEF\xBB\xBF".to_vec(), text.clone().into_bytes()].concat();
    let twice = text.replacen('{', r#"{"materials":[],"#, 1).into_bytes();
    let mut trailing = Builder::triangle().glb();
    trailing.extend([1, 2, 3, 4]);
    for file in [bom, twice, trailing] {
        let loaded = bytes(file.clone()).expect("it loads");
        assert!(told(&loaded, Severity::Warning, ""), "{:?}", loaded.diagnostics);
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        assert!(matches!(load_bytes(file, Path::new(""), &strict), Err(AssetError::Strict(_))));
    }
}

/// Optional properties of the format and of extensions; some exporters write `null` where they have nothing to say.
const OPTIONAL: [&str; 44] = [
    "name",
    "extras",
    "extensions",
    "extensionsUsed",
    "extensionsRequired",
    "animations",
    "cameras",
    "skins",
    "images",
    "samplers",
    "textures",
    "skin",
    "camera",
    "mesh",
    "weights",
    "children",
    "matrix",
    "translation",
    "rotation",
    "scale",
    "byteOffset",
    "byteStride",
    "target",
    "normalized",
    "sparse",
    "indices",
    "material",
    "mode",
    "targets",
    "doubleSided",
    "alphaMode",
    "alphaCutoff",
    "emissiveFactor",
    "emissiveTexture",
    "normalTexture",
    "baseColorFactor",
    "baseColorTexture",
    "metallicRoughnessTexture",
    "thicknessTexture",
    "attenuationDistance",
    "transmissionTexture",
    "scatterAnisotropy",
    "scatterStrengthTexture",
    "multiscatterColorTexture",
];

fn fill_with_null(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.values_mut().for_each(fill_with_null);
            for key in OPTIONAL {
                object.entry(key).or_insert(Value::Null);
            }
        }
        Value::Array(array) => array.iter_mut().for_each(fill_with_null),
        _ => {}
    }
}

#[test]
fn a_property_that_is_null_is_absent() {
    let b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [0.5, 0.5, 0.5]},
            "KHR_materials_scatter": {"multiscatterColorFactor": [0.5, 0.5, 0.5]},
            "NEPHRITE_materials_subsurface": {"ior": 1.3},
        },
    }));
    let plain = b.loaded();
    let mut filled = b.document();
    fill_with_null(&mut filled);
    let loaded = load_json(&filled, &LoadOptions::default()).expect("it loads");
    assert_eq!(format!("{:?}", loaded.scene), format!("{:?}", plain.scene));
    let (notes, rest): (Vec<_>, Vec<_>) =
        loaded.diagnostics.into_iter().partition(|d| d.message.contains("counts as absent: `"));
    assert_eq!((notes.len(), notes[0].severity), (1, Severity::Note));
    assert_eq!(rest, plain.diagnostics);
    // Of two the last counts, also where it is null.
    let twice = br#"{"asset":{"version":"2.0"},"scene":7,"scene":null}"#.to_vec();
    assert!(bytes(twice).is_ok());
    let twice = br#"{"asset":{"version":"2.0"},"scene":null,"scene":7}"#.to_vec();
    assert!(bytes(twice).is_err());
    // In a time that grows with their number: one by one these took minutes.
    let begun = std::time::Instant::now();
    let mut many = String::from(r#"{"asset":{"version":"2.0"},"extras":{"#);
    for value in ["0", "null"] {
        (0..200_000).for_each(|i| many.push_str(&format!("\"k{i}\":{value},")));
    }
    many.push_str(r#""end":0}}"#);
    assert!(bytes(many.into_bytes()).is_ok());
    assert!(begun.elapsed().as_secs() < 20);
}

#[test]
fn only_version_2() {
    for (asset, ok) in [
        (json!({"version": "2.0"}), true),
        (json!({"version": "2.1"}), true),
        (json!({"version": 2}), true),
        (json!({"version": "2.0", "minVersion": "3.0"}), false),
        (json!({"version": "1.0"}), false),
        (json!({"version": null}), false),
        (json!({}), false),
        (json!("2.0"), false),
    ] {
        let mut b = Builder::triangle();
        b.json["asset"] = asset.clone();
        assert_eq!(b.load().is_ok(), ok, "{asset}");
    }
}

#[test]
fn limits_are_kept() {
    let b = Builder::triangle();
    let with = |limits| b.load_with(&LoadOptions { limits, ..LoadOptions::default() }).map(|_| ());
    assert!(with(Limits::default()).is_ok());
    let full = Limits::default();
    for (name, limits) in [
        ("vertices", Limits { vertices: 2, ..full }),
        ("triangles", Limits { triangles: 0, ..full }),
        ("nodes", Limits { nodes: 0, ..full }),
        ("instances", Limits { instances: 0, ..full }),
        ("json_values", Limits { json_values: 10, ..full }),
    ] {
        match with(limits) {
            Err(AssetError::Limit { field, .. }) => assert_eq!(field, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn required_extensions_are_named_all_at_once() {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!(["A_x", "KHR_lights_punctual", "B_y", "C_z"]);
    b.json["extensionsRequired"] = json!(["A_x", "KHR_lights_punctual", "B_y"]);
    match b.load() {
        Err(AssetError::RequiredExtension { names }) => assert_eq!(names, ["A_x", "B_y"]),
        other => panic!("{other:?}"),
    }
    b.json["extensionsRequired"] = json!([]);
    let loaded = b.loaded();
    assert!(told(&loaded, Severity::Note, "/extensionsUsed"));
    let ignored: Vec<_> =
        loaded.summary.extensions.iter().filter(|e| !e.supported).map(|e| &*e.name).collect();
    assert_eq!(ignored, ["A_x", "B_y", "C_z"]);
}

#[test]
fn the_summary_is_json() {
    let loaded = Builder::triangle().loaded();
    let text = serde_json::to_value(&loaded.summary).expect("serialises");
    assert_eq!(text["triangles"], 1);
    assert_eq!(text["meshes"][0]["instances"], 1);
}
