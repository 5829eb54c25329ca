//! Tests of the drafts that bring OpenPBR to glTF, through the loader.

use glam::Vec3;
use serde_json::{Value, json};
use std::path::Path;

use crate::asset::tests::{Builder, told};
use crate::asset::{Asset, LoadOptions, Loaded, Moment, Severity};
use crate::scene::{Layers, MaterialDescription};

const PNG: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";

fn builder(extensions: &Value) -> Builder {
    let mut b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions,
    }));
    let mut names: Vec<&str> =
        extensions.as_object().expect("an object").keys().map(String::as_str).collect();
    names.push("KHR_texture_transform");
    b.json["extensionsUsed"] = json!(names);
    b.push("images", json!({"uri": PNG}));
    b.push("textures", json!({"source": 0}));
    b
}

fn loaded(extensions: Value) -> Loaded {
    builder(&extensions).loaded()
}

fn first(loaded: &Loaded) -> &MaterialDescription {
    &loaded.scene.materials[0]
}

fn layers(loaded: &Loaded) -> &Layers {
    first(loaded).layers.as_ref().expect("layers")
}

fn texture() -> Value {
    json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 3]}}})
}

#[test]
fn a_coat_is_read() {
    let mut normal = texture();
    normal["scale"] = json!(2);
    let all = loaded(json!({"KHR_materials_coat": {
        "coatFactor": 0.5, "coatTexture": texture(), "coatRoughnessFactor": 0.25, "coatRoughnessTexture": texture(),
        "coatNormalTexture": normal, "coatIor": 1.75, "coatColorFactor": [0.9, 0.5, 0.1], "coatColorTexture": texture(),
        "coatDarkeningFactor": 0.375, "coatAnisotropyStrength": 0.6, "coatAnisotropyRotation": 1.5,
        "coatAnisotropyTexture": texture(),
    }}));
    let coat = layers(&all).coat.as_ref().expect("a coat");
    assert_eq!((coat.factor, coat.roughness, coat.normal_scale, coat.ior), (0.5, 0.25, 2.0, 1.75));
    assert_eq!((coat.color, coat.darkening), (Vec3::new(0.9, 0.5, 0.1), 0.375));
    let brushed = coat.anisotropy.as_ref().expect("brushing");
    assert_eq!((brushed.strength, brushed.rotation), (0.6, 1.5));
    assert_eq!(first(&all).textures().count(), 5);
    for t in first(&all).textures() {
        let to = t.transform.transform_point2(glam::Vec2::ONE);
        assert!((to - glam::Vec2::new(2.25, 3.5)).length() < 1e-6, "{to}");
    }
    assert_eq!(all.summary.materials[0].layers, ["coat"]);
    assert!(!all.scene.meshes[0].tangents.is_empty(), "brushed coats and their normals need tangents");
    // Brushing alone needs them too.
    let brushed = loaded(json!({"KHR_materials_coat": {"coatFactor": 1, "coatAnisotropyStrength": 1}}));
    assert!(!brushed.scene.meshes[0].tangents.is_empty());
    let plain = loaded(json!({"KHR_materials_coat": {"coatFactor": 1}}));
    let coat = layers(&plain).coat.as_ref().expect("a coat");
    assert_eq!((coat.roughness, coat.ior, coat.color, coat.darkening), (0.0, 1.5, Vec3::ONE, 1.0));
    assert!(coat.anisotropy.is_none() && first(&plain).textures().count() == 0);
    assert!(first(&loaded(json!({"KHR_materials_coat": {"coatColorFactor": [1, 0, 0]}}))).layers.is_none());
}

#[test]
fn fuzz_is_read() {
    let all = loaded(json!({"KHR_materials_fuzz": {
        "fuzzFactor": 0.75, "fuzzTexture": texture(), "fuzzColorFactor": [0, 0.5, 1], "fuzzColorTexture": texture(),
        "fuzzRoughnessFactor": 0.25, "fuzzRoughnessTexture": texture(),
    }}));
    let fuzz = layers(&all).fuzz.as_ref().expect("fuzz");
    assert_eq!((fuzz.factor, fuzz.color, fuzz.roughness), (0.75, Vec3::new(0.0, 0.5, 1.0), 0.25));
    assert_eq!(first(&all).textures().count(), 3);
    assert_eq!(all.summary.materials[0].layers, ["fuzz"]);
    let plain = loaded(json!({"KHR_materials_fuzz": {"fuzzFactor": 1}}));
    let fuzz = layers(&plain).fuzz.as_ref().expect("fuzz");
    assert_eq!((fuzz.color, fuzz.roughness), (Vec3::ONE, 0.5));
    assert!(told(&plain, Severity::Note, "/materials/0/extensions/KHR_materials_fuzz"), "no roughness");
    assert!(first(&loaded(json!({"KHR_materials_fuzz": {}}))).layers.is_none());
}

#[test]
fn diffuse_roughness_is_read_under_both_names() {
    for name in ["KHR_materials_diffuse_roughness", "EXT_materials_diffuse_roughness"] {
        let own = json!({"diffuseRoughnessFactor": 0.75, "diffuseRoughnessTexture": texture()});
        let all = loaded(json!({name: own}));
        let rough = layers(&all).diffuse_roughness.as_ref().expect("diffuse facets");
        assert_eq!((rough.factor, first(&all).textures().count()), (0.75, 1));
        assert_eq!(all.summary.materials[0].layers, ["diffuse roughness"]);
        assert!(all.diagnostics.iter().all(|d| !d.pointer.contains("roughness")), "{:?}", all.diagnostics);
        let none = loaded(json!({name: {}}));
        assert!(first(&none).layers.is_none());
        assert!(told(&none, Severity::Note, &format!("/materials/0/extensions/{name}")));
    }
    let both = loaded(json!({
        "KHR_materials_diffuse_roughness": {"diffuseRoughnessFactor": 0.25},
        "EXT_materials_diffuse_roughness": {"diffuseRoughnessFactor": 0.75},
    }));
    assert_eq!(layers(&both).diffuse_roughness.as_ref().map(|d| d.factor), Some(0.25));
}

#[test]
fn they_take_the_place_of_the_older_ones() {
    let clear = json!({"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5});
    let sheen = json!({"sheenColorFactor": [1, 1, 1]});
    let with = |coat: f64, fuzz: f64| {
        loaded(json!({
            "KHR_materials_clearcoat": clear, "KHR_materials_sheen": sheen,
            "KHR_materials_coat": {"coatFactor": coat, "coatRoughnessFactor": 0.25},
            "KHR_materials_fuzz": {"fuzzFactor": fuzz, "fuzzRoughnessFactor": 0.25},
        }))
    };
    let all = with(0.5, 0.5);
    let l = layers(&all);
    assert_eq!(l.coat.as_ref().map(|c| (c.factor, c.roughness)), Some((0.5, 0.25)));
    assert!(l.fuzz.is_some() && l.sheen.is_none());
    for older in ["KHR_materials_clearcoat", "KHR_materials_sheen"] {
        assert!(told(&all, Severity::Note, &format!("/materials/0/extensions/{older}")), "{older}");
    }
    let off = with(0.0, 0.0);
    assert!(layers(&off).names().is_empty(), "also where they are off");
}

#[test]
fn what_the_drafts_exclude_and_what_is_out_of_range_is_told() {
    let drafts = [
        ("KHR_materials_coat", json!({"coatFactor": 1})),
        ("KHR_materials_fuzz", json!({"fuzzFactor": 1, "fuzzRoughnessFactor": 0.5})),
        ("KHR_materials_diffuse_roughness", json!({"diffuseRoughnessFactor": 1})),
        ("EXT_materials_diffuse_roughness", json!({"diffuseRoughnessFactor": 1})),
    ];
    for (name, own) in drafts {
        let pointer = format!("/materials/0/extensions/{name}");
        assert!(!told(&loaded(json!({name: own})), Severity::Warning, &pointer), "{name} alone");
        for other in ["KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness"] {
            let b = builder(&json!({name: own, other: {}}));
            assert!(told(&b.loaded(), Severity::Warning, &pointer), "{name} beside {other}");
            let strict = LoadOptions { strict: true, ..LoadOptions::default() };
            assert!(b.load_with(&strict).is_err_and(|e| e.pointer() == pointer), "{name} beside {other}");
        }
    }
    let wrong = [
        ("KHR_materials_coat", "coatFactor", json!(2)),
        ("KHR_materials_coat", "coatRoughnessFactor", json!(-1)),
        ("KHR_materials_coat", "coatIor", json!(0.5)),
        ("KHR_materials_coat", "coatDarkeningFactor", json!(1.5)),
        ("KHR_materials_coat", "coatAnisotropyStrength", json!(-0.1)),
        ("KHR_materials_fuzz", "fuzzFactor", json!(1.01)),
        ("KHR_materials_fuzz", "fuzzRoughnessFactor", json!(7)),
        ("KHR_materials_diffuse_roughness", "diffuseRoughnessFactor", json!(-3)),
    ];
    for (name, key, value) in wrong {
        let found = loaded(json!({name: {key: value}}));
        assert!(told(&found, Severity::Warning, &format!("/materials/0/extensions/{name}/{key}")), "{key}");
    }
    for (name, key) in [
        ("KHR_materials_coat", "coatFactor"),
        ("KHR_materials_coat", "coatColorFactor"),
        ("KHR_materials_coat", "coatIor"),
        ("KHR_materials_coat", "coatAnisotropyRotation"),
        ("KHR_materials_coat", "coatNormalTexture"),
        ("KHR_materials_fuzz", "fuzzTexture"),
        ("KHR_materials_diffuse_roughness", "diffuseRoughnessFactor"),
    ] {
        let error = builder(&json!({name: {key: "much"}})).load().expect_err("a string");
        assert!(error.pointer().contains(key), "{error}");
    }
}

/// KHR_animation_pointer: half-way between two keys.
#[test]
fn their_properties_can_be_animated() {
    let moved = |pointer: &str, kind: &str, from: &[f32], to: &[f32]| -> MaterialDescription {
        let mut b = builder(&json!({
            "KHR_materials_coat": {"coatFactor": 1, "coatAnisotropyStrength": 1, "coatNormalTexture": {"index": 0}},
            "KHR_materials_fuzz": {"fuzzFactor": 1, "fuzzRoughnessFactor": 0.5, "fuzzColorTexture": texture()},
            "KHR_materials_diffuse_roughness": {"diffuseRoughnessFactor": 1},
        }));
        let (input, output) = (b.floats("SCALAR", &[0.0, 1.0]), b.floats(kind, &[from, to].concat()));
        b.json["animations"] = json!([{
            "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer":
                {"pointer": format!("/materials/0/extensions/{pointer}")}}}}],
            "samplers": [{"input": input, "output": output}],
        }]);
        let bytes = b.document().to_string().into_bytes();
        let mut asset =
            Asset::from_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default()).expect("opens");
        let loaded = asset.load(&Moment { animations: vec![0], time: 0.5 }).expect("it loads");
        loaded.scene.materials[0].clone()
    };
    let number = |pointer: &str| moved(pointer, "SCALAR", &[0.25], &[0.75]).layers.expect("layers");
    let coat = |key: &str| number(&format!("KHR_materials_coat/{key}")).coat.expect("a coat");
    assert_eq!(coat("coatFactor").factor, 0.5);
    assert_eq!(coat("coatRoughnessFactor").roughness, 0.5);
    assert_eq!(coat("coatNormalTexture/scale").normal_scale, 0.5);
    assert_eq!(coat("coatDarkeningFactor").darkening, 0.5);
    assert_eq!(coat("coatAnisotropyStrength").anisotropy.expect("brushing").strength, 0.5);
    assert_eq!(coat("coatAnisotropyRotation").anisotropy.expect("brushing").rotation, 0.5);
    let index = moved("KHR_materials_coat/coatIor", "SCALAR", &[1.25], &[1.75]);
    assert_eq!(index.layers.expect("layers").coat.expect("a coat").ior, 1.5);
    let fuzz = |key: &str| number(&format!("KHR_materials_fuzz/{key}")).fuzz.expect("fuzz");
    assert_eq!((fuzz("fuzzFactor").factor, fuzz("fuzzRoughnessFactor").roughness), (0.5, 0.5));
    let rough = number("KHR_materials_diffuse_roughness/diffuseRoughnessFactor").diffuse_roughness;
    assert_eq!(rough.expect("diffuse facets").factor, 0.5);
    for (pointer, get) in
        [("KHR_materials_coat/coatColorFactor", true), ("KHR_materials_fuzz/fuzzColorFactor", false)]
    {
        let layers = moved(pointer, "VEC3", &[0.0, 0.5, 1.0], &[1.0, 0.5, 0.0]).layers.expect("layers");
        let color = if get { layers.coat.expect("a coat").color } else { layers.fuzz.expect("fuzz").color };
        assert_eq!(color, Vec3::splat(0.5), "{pointer}");
    }
    let turned = "KHR_materials_fuzz/fuzzColorTexture/extensions/KHR_texture_transform/offset";
    let fuzz = moved(turned, "VEC2", &[0.0, 0.0], &[1.0, 0.5]).layers.expect("layers").fuzz.expect("fuzz");
    let offset = fuzz.color_texture.expect("a texture").transform.translation;
    assert_eq!(offset, glam::Vec2::new(0.5, 0.25));
}
