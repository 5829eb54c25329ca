//! `nephrite edit --from-base-color`: textures of the right coefficients, white surfaces, and nothing else changed.

use super::painted_files::{APART, Doc, open};
use super::util::{Run, Sandbox};
use nephrite::optics::seen_color::seen_color;
use serde_json::{Value, json};

const OURS: &str = "NEPHRITE_materials_subsurface";

/// Texels of a PNG, as fractions.
fn texels(png: &[u8]) -> (usize, Vec<[f64; 3]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Sixteen));
    let of = |i: usize| f64::from(u16::from_be_bytes([bytes[2 * i], bytes[2 * i + 1]])) / 65535.0;
    (info.width as usize, (0..bytes.len() / 6).map(|t| [0, 1, 2].map(|c| of(3 * t + c))).collect())
}

/// The texels that a slot of a material's extension refers to.
fn coefficients(document: &Value, chunk: &[u8], material: usize, key: &str) -> (usize, Vec<[f64; 3]>) {
    let own = &document["materials"][material]["extensions"][OURS];
    let factor = &own[format!("{key}Coefficient")];
    let texture = own[format!("{key}Texture")]["index"].as_u64().unwrap() as usize;
    let image = &document["images"][document["textures"][texture]["source"].as_u64().unwrap() as usize];
    let view = &document["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let [from, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
    let (width, texels) = texels(&chunk[from..from + length]);
    (width, texels.iter().map(|t| [0, 1, 2].map(|c| t[c] * factor[c].as_f64().unwrap())).collect())
}

fn linear(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Asserts that coefficients show a colour, and have the extinction that was asked for.
#[track_caller]
fn shows(a: [f64; 3], s: [f64; 3], eta: f64, color: [f64; 3], sigma_t: f64) {
    for c in 0..3 {
        let seen = seen_color(s[c] / (a[c] + s[c]), 0.0, eta);
        // A step of 16 bits.
        assert!((seen - color[c]).abs() < 5e-4, "[{c}]: {seen} for {}", color[c]);
        assert!(((a[c] + s[c]) / sigma_t - 1.0).abs() < 2e-3, "[{c}]: {} 1/m", a[c] + s[c]);
    }
}

fn edit(sandbox: &Sandbox, from: &str, to: &str, more: &[&str]) -> Run {
    sandbox.run(&[&["edit", from, "-o", to, "--material", "*", "--from-base-color"], more].concat())
}

const HALF_MM: [&str; 4] = ["--mean-free-path", "0.5", "--unit", "mm"];

/// Two materials share one texture, with a transform; a third has none of it.
#[test]
fn a_texture_becomes_coefficients_and_nothing_else_changes() {
    let sandbox = Sandbox::new();
    let info = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": { "offset": [0.25, 0] } } });
    let painted = |factor: f64| {
        json!({ "name": format!("Skin {factor}"), "extras": { "keep": [1, 2.5] }, "pbrMetallicRoughness": {
            "baseColorFactor": [factor, factor, 1, 1], "baseColorTexture": info, "metallicFactor": 0, "roughnessFactor": 0.4 } })
    };
    let mut doc = Doc::new(json!([painted(0.5), painted(0.75), painted(0.5), { "name": "Steel" }]));
    doc.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    let texels = [[200, 30, 90, 255], [120, 240, 10, 255]];
    doc.texture(&texels);
    for i in 0..4 {
        let primitive = doc.primitive(i, Some(&APART), None);
        doc.object(vec![primitive], 2.0 * i as f32);
    }
    sandbox.file("a.glb", doc.glb());
    let args = ["edit", "a.glb", "-o", "b.glb", "-m", "0", "-m", "1", "-m", "2", "--from-base-color"];
    let run = sandbox.run(&[&args[..], &HALF_MM, &["--ior", "1.4"]].concat()).exits(0);
    run.check(!run.stderr.contains("warning"), "should have nothing to warn about");
    run.says(&["3 materials changed, 4 images added"]);
    let (before, chunk_before) = open(&sandbox, "a.glb");
    let (after, chunk) = open(&sandbox, "b.glb");
    assert!(chunk.starts_with(&chunk_before));
    for (material, factor) in [(0, 0.5), (1, 0.75)] {
        let (width, a) = coefficients(&after, &chunk, material, "absorption");
        let (_, s) = coefficients(&after, &chunk, material, "scattering");
        assert_eq!((width, a.len()), (2, 2));
        for (i, texel) in texels.iter().enumerate() {
            let color = [factor * linear(texel[0]), factor * linear(texel[1]), linear(texel[2])];
            shows(a[i], s[i], 1.4, color, 2000.0);
        }
        let own = &after["materials"][material]["extensions"][OURS];
        for key in ["absorptionTexture", "scatteringTexture"] {
            assert_eq!(own[key]["extensions"], info["extensions"]);
            let texture = &after["textures"][own[key]["index"].as_u64().unwrap() as usize];
            assert_eq!(texture["sampler"], json!(0));
        }
        let surface = &after["materials"][material]["pbrMetallicRoughness"];
        assert_eq!(*surface, json!({ "metallicFactor": 0, "roughnessFactor": 0.4 }));
    }
    // The same paint is the same textures.
    let slots = |i: usize| after["materials"][i]["extensions"][OURS].clone();
    assert_eq!(slots(0), slots(2));
    assert_ne!(slots(0)["absorptionTexture"], slots(1)["absorptionTexture"]);
    for key in ["accessors", "meshes", "nodes", "scenes", "samplers", "asset"] {
        assert_eq!(before[key], after[key], "{key}");
    }
    assert_eq!(before["materials"][3], after["materials"][3]);
    assert_eq!(after["materials"][0]["extras"], json!({ "keep": [1, 2.5] }));
    for key in ["images", "textures", "bufferViews"] {
        let (old, new) = (before[key].as_array().unwrap(), after[key].as_array().unwrap());
        assert_eq!(old[..], new[..old.len()], "{key}");
    }
    // Done twice there is no paint left; and what is written for other viewers goes with the medium.
    sandbox.run(&["edit", "b.glb", "-o", "c.glb", "-m", "0", "--from-base-color"]).exits(1).says(&[
        "/materials/0",
        "white",
        "no material has paint",
    ]);
    assert!(!sandbox.path("c.glb").exists());
    sandbox.run(&["edit", "b.glb", "-o", "d.glb", "-m", "0", "-m", "1", "-m", "2", "--remove"]).exits(0);
    let (removed, _) = open(&sandbox, "d.glb");
    assert!((0..3).all(|i| removed["materials"][i].get("extensions").is_none()), "{removed}");
    assert_eq!(removed["extensionsUsed"], json!(["KHR_texture_transform"]));
}

/// A `.gltf` gets files beside it; names that are taken by other files are not used.
#[test]
fn textures_are_files_beside_a_gltf() {
    let sandbox = Sandbox::new();
    let mut doc = Doc::new(
        json!([{ "name": "My Skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }]),
    );
    doc.texture(&[[255, 128, 0, 255], [20, 20, 20, 255]]);
    let primitive = doc.primitive(0, Some(&APART), None);
    doc.object(vec![primitive], 0.0);
    sandbox.file("a.gltf", doc.gltf());
    sandbox.file("b-My-Skin-absorption.png", "mine");
    edit(&sandbox, "a.gltf", "b.gltf", &HALF_MM).exits(0);
    let files = [
        "a.gltf",
        "b-My-Skin-absorption-2.png",
        "b-My-Skin-absorption.png",
        "b-My-Skin-scattering.png",
        "b.gltf",
    ];
    assert_eq!(sandbox.files(), files);
    assert_eq!(std::fs::read(sandbox.path("b-My-Skin-absorption.png")).unwrap(), b"mine");
    let after: Value = serde_json::from_slice(&std::fs::read(sandbox.path("b.gltf")).unwrap()).unwrap();
    assert_eq!(after["images"][1]["uri"], json!("b-My-Skin-absorption-2.png"));
    // White in blue's place is black: all of it is absorbed.
    let (_, a) = texels(&std::fs::read(sandbox.path("b-My-Skin-absorption-2.png")).unwrap());
    assert_eq!((a[0][2], a[1][0]), (1.0, 1.0));
    assert!(a[0][0] == 0.0, "white does not absorb");
    let run = sandbox.run(&["inspect", "b.gltf"]).exits(0);
    run.check(run.stderr.is_empty() || !run.stderr.contains("error"), "loads");
    // Again: the same files serve.
    edit(&sandbox, "a.gltf", "b.gltf", &HALF_MM).exits(0);
    assert_eq!(sandbox.files(), files);
    edit(&sandbox, "a.gltf", "c.gltf", &[]).exits(1).says(&["/materials/0", "--mean-free-path"]);
    assert_eq!(sandbox.files(), files);
}

const RED: [f32; 4] = [0.8, 0.1, 0.2, 1.0];
const GREEN: [f32; 4] = [0.1, 0.6, 0.3, 1.0];
const WHITE: [f32; 4] = [1.0; 4];

fn white_material() -> Value {
    json!([{ "name": "M", "pbrMetallicRoughness": { "metallicFactor": 0 } }])
}

#[test]
fn vertex_colours_are_baked_where_texels_are_free() {
    let sandbox = Sandbox::new();
    let mut doc = Doc::new(white_material());
    let primitive = doc.primitive(0, Some(&APART), Some([RED, GREEN, WHITE, RED]));
    doc.object(vec![primitive], 0.0);
    sandbox.file("a.glb", doc.glb());
    edit(&sandbox, "a.glb", "b.glb", &HALF_MM).exits(0);
    let (after, chunk) = open(&sandbox, "b.glb");
    assert!(after["meshes"][0]["primitives"][0]["attributes"].get("COLOR_0").is_none());
    let (width, a) = coefficients(&after, &chunk, 0, "absorption");
    let (_, s) = coefficients(&after, &chunk, 0, "scattering");
    let at = |u: f64, v: f64| (v * (a.len() / width) as f64) as usize * width + (u * width as f64) as usize;
    let [red, green] = [RED, GREEN].map(|c| [0, 1, 2].map(|i| f64::from(c[i])));
    for (place, color) in
        [(at(0.15, 0.15), red), (at(0.65, 0.15), green), (at(0.15, 0.65), [1.0; 3]), (at(0.65, 0.65), red)]
    {
        shows(a[place], s[place], 1.5, color, 2000.0);
    }
    // In the same quarter, so that one of two faces shows the colour of the other; outside of the unit square; on a point.
    let mut overlapping = APART;
    overlapping[3..6].copy_from_slice(&APART[0..3]);
    let far = APART.map(|[u, v]| [8.0 * u - 3.0, 8.0 * v]);
    let point = [[0.5, 0.5]; 12];
    let cases = [
        (None, ["/meshes/0/primitives/0/attributes/COLOR_0", "TEXCOORD_0", "unwrap"]),
        (Some(&overlapping), ["/meshes/0/primitives/0/attributes/COLOR_0", "25.0 %", "another colour"]),
        (Some(&far), ["/meshes/0/primitives/0/attributes/COLOR_0", "outside of 0 to 1", "unwrap"]),
        (Some(&point), ["/meshes/0/primitives/0/attributes/COLOR_0", "% of the surface", "smaller"]),
    ];
    for (uvs, texts) in cases {
        let mut doc = Doc::new(white_material());
        let primitive = doc.primitive(0, uvs, Some([RED, GREEN, WHITE, WHITE]));
        doc.object(vec![primitive], 0.0);
        sandbox.file("bad.glb", doc.glb());
        edit(&sandbox, "bad.glb", "no.glb", &HALF_MM).exits(1).says(&texts).says(&["--fix-surface"]);
        assert!(!sandbox.files().contains(&"no.glb".to_owned()));
        sandbox
            .run(&["edit", "bad.glb", "-o", "ok.glb", "-m", "0", "--preset", "jade"])
            .exits(0)
            .says(&["COLOR_0", "--from-base-color"]);
        let run = sandbox
            .run(&["edit", "bad.glb", "-o", "ok.glb", "-m", "0", "--preset", "jade", "--fix-surface"])
            .exits(0);
        run.check(!run.stderr.contains("warning"), "should have nothing to warn about");
        assert!(
            open(&sandbox, "ok.glb").0["meshes"][0]["primitives"][0]["attributes"].get("COLOR_0").is_none()
        );
    }
    // Tiles of one colour are no obstacle: nothing needs to be baked.
    let mut doc = Doc::new(white_material());
    let primitive = doc.primitive(0, Some(&far), Some([RED; 4]));
    doc.object(vec![primitive], 0.0);
    sandbox.file("one.glb", doc.glb());
    edit(&sandbox, "one.glb", "two.glb", &HALF_MM).exits(0);
    let own = open(&sandbox, "two.glb").0["materials"][0]["extensions"][OURS].clone();
    assert!(own.get("absorptionTexture").is_none());
    let triple = |key: &str| [0, 1, 2].map(|i| own[key][i].as_f64().unwrap());
    shows(triple("absorptionCoefficient"), triple("scatteringCoefficient"), 1.5, red, 2000.0);
}

/// Meshes share a material and have one colour each; parts of one mesh may, if each is a body of its own.
#[test]
fn objects_whose_colours_exclude_each_other_get_materials_of_their_own() {
    let sandbox = Sandbox::new();
    let mut doc = Doc::new(white_material());
    for (i, color) in [RED, GREEN, RED].into_iter().enumerate() {
        let primitive = doc.primitive(0, None, Some([color; 4]));
        doc.object(vec![primitive], 3.0 * i as f32);
    }
    sandbox.file("a.glb", doc.glb());
    edit(&sandbox, "a.glb", "b.glb", &HALF_MM).exits(0).says(&["/materials/0, /materials/1"]);
    let (after, _) = open(&sandbox, "b.glb");
    let used: Vec<&Value> = (0..3).map(|i| &after["meshes"][i]["primitives"][0]["material"]).collect();
    assert_eq!(used, [&json!(0), &json!(1), &json!(0)]);
    assert_eq!(
        (after["materials"].as_array().unwrap().len(), &after["materials"][1]["name"]),
        (2, &json!("M 2"))
    );
    for (material, color) in [RED, GREEN].into_iter().enumerate() {
        let own = &after["materials"][material]["extensions"][OURS];
        let triple = |key: &str| [0, 1, 2].map(|i| own[key][i].as_f64().unwrap());
        let color = [0, 1, 2].map(|i| f64::from(color[i]));
        shows(triple("absorptionCoefficient"), triple("scatteringCoefficient"), 1.5, color, 2000.0);
    }
    let mut doc = Doc::new(white_material());
    let parts = [RED, GREEN].map(|color| doc.primitive(0, None, Some([color; 4])));
    doc.object(parts.to_vec(), 0.0);
    sandbox.file("parts.glb", doc.glb());
    edit(&sandbox, "parts.glb", "c.glb", &HALF_MM).exits(0);
    assert_eq!(open(&sandbox, "c.glb").0["meshes"][0]["primitives"][1]["material"], json!(1));
    // Halves of one body: no medium could be in one of them.
    let mut doc = Doc::new(white_material());
    let halves = [RED, GREEN].into_iter().enumerate().map(|(i, color)| {
        let mut primitive = doc.primitive(0, None, Some([color; 4]));
        let view = doc.bytes(&[0u8, 1, 2, 3, 4, 5].map(|k| k + 6 * i as u8));
        let accessor = json!({ "bufferView": view, "componentType": 5121, "count": 6, "type": "SCALAR" });
        primitive["indices"] = json!(doc.push("accessors", accessor));
        primitive
    });
    let halves: Vec<Value> = halves.collect();
    doc.object(halves, 0.0);
    sandbox.file("halves.glb", doc.glb());
    edit(&sandbox, "halves.glb", "d.glb", &HALF_MM)
        .exits(1)
        .says(&["/meshes/0/primitives/", "not closed by itself"]);
}

/// What is cut out of a surface stays cut out.
#[test]
fn alpha_survives() {
    let sandbox = Sandbox::new();
    let material = |mode: &str| {
        json!([{ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 1, 0.8],
            "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }])
    };
    for mode in ["MASK", "BLEND", "OPAQUE"] {
        let mut doc = Doc::new(material(mode));
        doc.texture(&[[200, 30, 90, 255], [200, 30, 90, 51]]);
        let primitive = doc.primitive(0, Some(&APART), None);
        doc.object(vec![primitive], 0.0);
        sandbox.file("a.glb", doc.glb());
        edit(&sandbox, "a.glb", "b.glb", &HALF_MM).exits(0);
        let (after, chunk) = open(&sandbox, "b.glb");
        let surface = &after["materials"][0]["pbrMetallicRoughness"];
        if mode == "OPAQUE" {
            assert_eq!(*surface, json!({ "metallicFactor": 0 }));
            continue;
        }
        assert_eq!(surface["baseColorFactor"], json!([1, 1, 1, 0.8]));
        let texture = &after["textures"][surface["baseColorTexture"]["index"].as_u64().unwrap() as usize];
        let image = &after["images"][texture["source"].as_u64().unwrap() as usize];
        let view = &after["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let from = view["byteOffset"].as_u64().unwrap() as usize;
        let mut reader = png::Decoder::new(std::io::Cursor::new(&chunk[from..])).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes, [255, 255, 255, 255, 255, 255, 255, 51]);
        // Colour is the same everywhere, so that no texture has to say it.
        assert!(after["materials"][0]["extensions"][OURS].get("absorptionTexture").is_none());
        let run = sandbox.run(&["validate", "b.glb"]).exits(0);
        run.check(!run.stdout.contains("tints"), "white with alpha is no tint");
    }
}

#[test]
fn what_tints_and_hides_is_told_and_what_does_not_is_not() {
    let sandbox = Sandbox::new();
    let medium =
        json!({ OURS: { "absorptionCoefficient": [1, 2, 3], "scatteringCoefficient": [1000, 1000, 1000] } });
    let case = |surface: Value, texels: [[u8; 4]; 2], faces: [[f32; 4]; 4]| {
        let mut doc = Doc::new(json!([{ "extensions": medium, "pbrMetallicRoughness": surface }]));
        doc.texture(&texels);
        let primitive = doc.primitive(0, Some(&APART), Some(faces));
        doc.object(vec![primitive], 0.0);
        sandbox.file("a.glb", doc.glb());
        sandbox.run(&["validate", "a.glb"]).exits(0)
    };
    let base = json!({ "metallicFactor": 0, "baseColorTexture": { "index": 0 } });
    let metal = json!({ "metallicRoughnessTexture": { "index": 0 } });
    let (dark, white) = ([[200, 30, 90, 255]; 2], [[255; 4], [255, 255, 255, 0]]);
    let told = |run: &Run, text: &str, expected: bool| {
        run.check(run.stdout.contains(text) == expected, &format!("{text}: {expected}"));
    };
    let run = case(base.clone(), dark, [WHITE; 4]);
    told(&run, "/materials/0/pbrMetallicRoughness/baseColorTexture", true);
    told(&run, "--from-base-color", true);
    told(&case(base.clone(), white, [WHITE; 4]), "tint", false);
    let run = case(base, white, [WHITE, WHITE, RED, WHITE]);
    told(&run, "/meshes/0/primitives/0/attributes/COLOR_0", true);
    told(&run, "--fix-surface", true);
    // The factor of 1 is the default; the blue channel is metallic.
    told(&case(metal.clone(), [[255, 200, 0, 255]; 2], [WHITE; 4]), "metallic", false);
    told(
        &case(metal, [[255, 200, 200, 255]; 2], [WHITE; 4]),
        "/materials/0/pbrMetallicRoughness/metallicFactor",
        true,
    );
}

/// A primitive that another material also shows keeps its colours, unless that is changed, too.
#[test]
fn variants_are_asked_about() {
    let sandbox = Sandbox::new();
    let mut doc = Doc::new(json!([{ "pbrMetallicRoughness": { "metallicFactor": 0 } }, {}]));
    doc.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    doc.json["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "bare" }] } });
    let mut primitive = doc.primitive(0, None, Some([RED; 4]));
    primitive["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [0] }] } });
    doc.object(vec![primitive], 0.0);
    sandbox.file("a.glb", doc.glb());
    let args = ["edit", "a.glb", "-o", "b.glb", "-m", "0", "--from-base-color"];
    sandbox.run(&[&args[..], &HALF_MM].concat()).exits(1).says(&["/materials/1", "--material 1"]);
    edit(&sandbox, "a.glb", "b.glb", &HALF_MM).exits(0);
    assert!(open(&sandbox, "b.glb").0["meshes"][0]["primitives"][0]["attributes"].get("COLOR_0").is_none());
}
