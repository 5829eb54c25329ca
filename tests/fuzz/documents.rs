//! Documents generated from scratch: the structure of glTF, with references, ranges and numbers that may be wrong.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use serde_json::{Value, json};

use super::{bounded, fuzzing};

/// A light profile of one plane.
const IES: &str = "data:,TILT=NONE%0A1 1 1 2 1 1 2 0 0 0 1 1 0 0 90 0 5 1";

/// Documents that are tried.
const CASES: u32 = 512;

/// Mostly `right`, an index that fits, else another.
fn index(right: usize) -> impl Strategy<Value = usize> {
    prop_oneof![60 => Just(right), 1 => 0..6_usize, 1 => Just(usize::MAX)]
}

/// A number as files have them, and some as they should not.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -2.0..2.0_f64,
        2 => Just(0.0),
        1 => any::<f32>().prop_filter("JSON has no such numbers", |x| x.is_finite()).prop_map(f64::from),
    ]
}

fn numbers(count: usize) -> impl Strategy<Value = Value> {
    prop_oneof![
        40 => vec(number(), count).prop_map(|v| json!(v)),
        1 => vec(number(), 0..6).prop_map(|v| json!(v)),
    ]
}

/// An object with some of these members.
fn some_of(members: Vec<(&'static str, BoxedStrategy<Value>)>) -> impl Strategy<Value = Value> {
    let options: Vec<_> = members.into_iter().map(|(k, s)| (Just(k), proptest::option::of(s))).collect();
    options.prop_map(|members| {
        let there = members.into_iter().filter_map(|(k, v)| Some((k.to_owned(), v?)));
        Value::Object(there.collect())
    })
}

fn node() -> impl Strategy<Value = Value> {
    some_of(vec![
        ("mesh", index(0).prop_map(|i| json!(i)).boxed()),
        ("camera", Just(json!(0)).boxed()),
        ("skin", Just(json!(0)).boxed()),
        ("translation", numbers(3).boxed()),
        ("rotation", numbers(4).boxed()),
        ("scale", numbers(3).boxed()),
    ])
}

fn texture() -> impl Strategy<Value = Value> {
    (index(0), numbers(2), number(), 0..3_u32).prop_map(|(index, pair, rotation, set)| {
        json!({"index": index, "texCoord": set, "extensions": {"KHR_texture_transform": {
            "offset": pair, "scale": pair, "rotation": rotation}}})
    })
}

fn material() -> impl Strategy<Value = Value> {
    let seed = any::<u64>();
    let surface = some_of(vec![
        ("baseColorFactor", numbers(4).boxed()),
        ("metallicFactor", number().prop_map(|x| json!(x)).boxed()),
        ("roughnessFactor", number().prop_map(|x| json!(x)).boxed()),
        ("baseColorTexture", texture().boxed()),
        ("metallicRoughnessTexture", texture().boxed()),
    ]);
    let rest = some_of(vec![
        ("normalTexture", texture().boxed()),
        ("emissiveFactor", numbers(3).boxed()),
        (
            "alphaMode",
            prop_oneof![20 => Just("MASK"), 20 => Just("BLEND"), 1 => Just("GLASS")]
                .prop_map(|s| json!(s))
                .boxed(),
        ),
        ("doubleSided", any::<bool>().prop_map(|b| json!(b)).boxed()),
    ]);
    (seed, 0..4_usize, surface, rest).prop_map(|(seed, extensions, surface, mut material)| {
        let mut random = fuzzing::mutate::Random(seed);
        material["pbrMetallicRoughness"] = surface;
        for _ in 0..extensions {
            let (name, mut own) = fuzzing::dictionary::material_extension(&mut random);
            if random.once_in(4) {
                fuzzing::mutate::some_changes(&mut own, &mut random);
            }
            material["extensions"][name] = own;
        }
        material
    })
}

/// Accessors of all kinds over 256 bytes.
fn accessor() -> impl Strategy<Value = Value> {
    let component = prop_oneof![Just(5120), Just(5121), Just(5122), Just(5123), Just(5125), Just(5126)];
    let kind = prop_oneof![Just("SCALAR"), Just("VEC2"), Just("VEC3"), Just("VEC4"), Just("MAT4")];
    (component, kind, 0..24_usize, 0..8_usize, any::<bool>(), proptest::option::of((0..4_usize, 0..3_usize))).prop_map(
        |(component, kind, count, offset, normalized, sparse)| {
            let mut accessor = json!({"bufferView": 0, "byteOffset": 4 * offset, "componentType": component, "type": kind,
                "count": count, "normalized": normalized});
            if let Some((count, view)) = sparse {
                accessor["sparse"] = json!({"count": count, "indices": {"bufferView": view, "componentType": 5121},
                    "values": {"bufferView": view}});
            }
            accessor
        },
    )
}

fn primitive() -> impl Strategy<Value = Value> {
    let attribute = |right: usize| proptest::option::weighted(0.4, index(right));
    (index(0), attribute(0), attribute(2), attribute(3), attribute(1), 0..16_u32, index(0)).prop_map(
        |(position, normal, uv, color, indices, mode, material)| {
            let mut primitive = json!({"attributes": {"POSITION": position}, "material": material});
            // Mostly triangles.
            if mode < 7 {
                primitive["mode"] = json!(mode);
            }
            for (name, value) in [("NORMAL", normal), ("TEXCOORD_0", uv), ("COLOR_0", color)] {
                if let Some(value) = value {
                    primitive["attributes"][name] = json!(value);
                }
            }
            if let Some(indices) = indices {
                primitive["indices"] = json!(indices);
            }
            primitive
        },
    )
}

/// The accessors that primitives, skins and animations refer to where they are right.
fn fitting() -> [Value; 5] {
    let of = |view: u32, component: u32, kind: &str, count: u32| json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
    [
        of(0, 5126, "VEC3", 12),
        of(1, 5121, "SCALAR", 12),
        of(0, 5126, "VEC2", 12),
        of(0, 5126, "VEC4", 12),
        of(0, 5126, "SCALAR", 12),
    ]
}

fn document() -> impl Strategy<Value = (Value, Vec<u8>)> {
    let floats = vec(prop_oneof![60 => -2.0..2.0_f32, 1 => any::<f32>()], 64);
    let indices = vec(prop_oneof![200 => 0..12_u8, 1 => any::<u8>()], 64);
    let bin = (floats, indices).prop_map(|(floats, indices)| {
        floats.iter().flat_map(|x| x.to_le_bytes()).chain(indices).collect::<Vec<u8>>()
    });
    let lists =
        (vec(node(), 1..6), vec(vec(primitive(), 1..3), 1..3), vec(accessor(), 0..4), vec(material(), 1..3));
    let light = (0..4_usize, numbers(3), number(), number(), number());
    let moving = (index(4), index(3), 0..4_usize, 0..5_usize, vec(0..30_usize, 8));
    (lists, bin, numbers(16), light, moving).prop_map(
        |((mut nodes, meshes, others, materials), bin, matrix, (kind, color, intensity, inner, outer), moving)| {
            let accessors: Vec<Value> = fitting().into_iter().chain(others).collect();
            let (input, output, interpolation, path, children) = moving;
            // A chain, and now and then a child that has another parent, or is its own.
            for i in 1..nodes.len() {
                let child = if children[i] < nodes.len() { children[i] } else { i };
                nodes[i - 1]["children"] = json!([child]);
            }
            let meshes: Vec<Value> = meshes.into_iter().map(|p| json!({"primitives": p})).collect();
            let path = ["translation", "rotation", "scale", "weights", "size"][path];
            let interpolation = ["LINEAR", "STEP", "CUBICSPLINE", "NEAREST"][interpolation];
            let kind = ["point", "spot", "directional", "area"][kind];
            let mut document = json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes, "meshes": meshes,
                "accessors": accessors, "materials": materials, "buffers": [{"byteLength": 320}],
                "bufferViews": [{"buffer": 0, "byteLength": 256}, {"buffer": 0, "byteOffset": 256, "byteLength": 64},
                    {"buffer": 0, "byteOffset": 128, "byteLength": 128, "byteStride": 16}],
                "cameras": [{"type": "perspective", "perspective": {"yfov": outer, "znear": 0.1, "aspectRatio": inner}}],
                "skins": [{"joints": [0]}], "images": [{"uri": fuzzing::bodies::image()}], "textures": [{"source": 0}],
                "animations": [{"channels": [{"sampler": 0, "target": {"node": 0,
                    "path": path}}],
                    "samplers": [{"input": input, "output": output,
                        "interpolation": interpolation}]}],
                "extensions": {"KHR_lights_punctual": {"lights": [{"type": kind, "color": color, "intensity": intensity,
                    "spot": {"innerConeAngle": inner, "outerConeAngle": outer}}]},
                    "EXT_lights_area": {"lights": [{"type": if inner > outer { "disk" } else { "rect" }, "color": color,
                        "intensity": intensity, "size": outer, "rect": {"aspect": inner}}]},
                    "EXT_lights_ies": {"lights": [{"bufferView": 0, "mimeType": "application/x-ies-lm-63"},
                        {"uri": IES}]}},
            });
            // One kind of light each, since most numbers are wrong for one of them.
            let (name, used) = [
                ("KHR_lights_punctual", json!({"light": 0})),
                ("EXT_lights_area", json!({"light": 0})),
                ("EXT_lights_ies", json!({"light": usize::from(kind != "area"), "multiplier": intensity, "color": color})),
            ][children[7] % 3]
                .clone();
            document["nodes"][0]["extensions"][name] = used;
            if children[6] % 3 == 0 {
                document["cameras"][0]["extensions"]["EXT_camera_physical"] = json!({"focalLength": outer,
                    "sensorSize": [inner, outer], "fStop": intensity, "focusDistance": inner});
            }
            if kind == "area" {
                let node = document["nodes"][0].as_object_mut().expect("an object");
                node.retain(|key, _| !["translation", "rotation", "scale"].contains(&key.as_str()));
                document["nodes"][0]["matrix"] = matrix;
            }
            (document, bin)
        },
    )
}

#[test]
fn generated_documents_load_or_err() {
    let mut runner = TestRunner::new(ProptestConfig {
        cases: CASES,
        // The same documents in every run.
        rng_seed: RngSeed::Fixed(4),
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let read = std::cell::Cell::new(0);
    let result = runner.run(&document(), |(document, bin)| {
        let file = fuzzing::mutate::glb(document.to_string().into_bytes(), &bin);
        read.set(read.get() + u32::from(bounded("a generated document", || fuzzing::loader(&file))));
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    let read = read.get();
    println!("{read} of {CASES} documents are read");
    assert!(read > CASES / 5 && read < CASES, "{read} of {CASES} documents are read");
}
