//! Animations: values against the formulas of the specification and against numpy, pointers, and what is malformed.

use glam::Vec3;

use super::*;

/// A triangle whose node 0 is animated by one channel.
fn animated(path: &str, interpolation: &str, times: &[f32], kind: &str, values: &[f32]) -> Builder {
    let mut b = Builder::triangle();
    let (input, output) = (b.floats("SCALAR", times), b.floats(kind, values));
    b.json["animations"] = json!([{
        "name": "move",
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
    }]);
    b
}

/// Makes the only channel one of a pointer.
fn point(b: &mut Builder, pointer: &str) {
    b.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    b.json["animations"][0]["channels"][0]["target"] =
        json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
}

fn open(b: &Builder) -> Asset {
    let bytes = b.document().to_string().into_bytes();
    Asset::from_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default()).expect("it opens")
}

#[track_caller]
fn at(b: &Builder, time: f64) -> Loaded {
    open(b).load(&Moment { animations: vec![0], time }).expect("it loads")
}

fn origin(loaded: &Loaded) -> Vec3 {
    (loaded.scene.origin + loaded.scene.instances[0].transform.translation.as_dvec3()).as_vec3()
}

#[test]
fn numpy_finds_the_same_vertices() {
    let bytes = include_bytes!("pose.gltf").to_vec();
    let document: Value = serde_json::from_slice(&bytes).expect("JSON");
    let mut asset =
        Asset::from_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default()).expect("it opens");
    let expected = document["extras"]["expected"].as_array().expect("an array");
    assert_eq!(expected.len(), 9);
    for moment in expected {
        let time = moment["time"].as_f64();
        let animations = if time.is_some() { vec![0] } else { Vec::new() };
        let loaded = asset.load(&Moment { animations, time: time.unwrap_or(0.0) }).expect("it loads");
        assert_eq!(loaded.scene.instances[0].transform, glam::Affine3A::IDENTITY);
        let found = &loaded.scene.meshes[0].positions;
        for (f, e) in found.iter().zip(moment["positions"].as_array().expect("an array")) {
            let e: [f32; 3] = serde_json::from_value(e.clone()).expect("three numbers");
            // Single precision, coordinates up to 5, sums of eight products; expected numbers have six digits.
            assert!((*f - Vec3::from(e)).length() < 3e-5, "at {time:?}: {f} is not {e:?}");
        }
    }
}

#[test]
fn the_three_interpolations_and_both_ends() {
    let values = [0.0, 0.0, 0.0, 2.0, 4.0, 6.0];
    for (interpolation, expected) in [("STEP", Vec3::ZERO), ("LINEAR", Vec3::new(0.5, 1.0, 1.5))] {
        let b = animated("translation", interpolation, &[1.0, 3.0], "VEC3", &values);
        assert_eq!(origin(&at(&b, 1.5)), expected);
        for (time, expected) in [(-5.0, 0.0), (1.0, 0.0), (3.0, 2.0), (99.0, 2.0), (f64::NAN, 0.0)] {
            assert_eq!(origin(&at(&b, time)).x, expected, "{interpolation} at {time}");
        }
    }
    // v0 = 1, out-tangent 2/s; v1 = 3, in-tangent −4/s; t_d = 2, s = 1/4:
    // 0.84375 · 1 + 2 · 0.140625 · 2 + 0.15625 · 3 + 2 · −0.046875 · −4 = 2.25
    let spline = [9.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, -4.0, 0.0, 0.0, 3.0, 0.0, 0.0, 9.0, 0.0, 0.0];
    let b = animated("translation", "CUBICSPLINE", &[1.0, 3.0], "VEC3", &spline);
    for (time, expected) in [(1.5, 2.25), (0.0, 1.0), (5.0, 3.0)] {
        assert_eq!(origin(&at(&b, time)).x, expected, "at {time}");
    }
}

#[test]
fn sparse_keyframes_are_found_singly() {
    for indices in [[1_u8, 3], [3, 1]] {
        let mut b = animated("translation", "STEP", &[0.0, 1.0, 2.0, 3.0], "VEC3", &[5.0; 12]);
        let indices = b.view(&indices);
        let values = b.view(&floats(&[7.0, 0.0, 0.0, 8.0, 0.0, 0.0]));
        b.json["accessors"][2]["sparse"] = json!({
            "count": 2, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values},
        });
        let mut expected = [5.0, 7.0, 5.0, 8.0];
        if b.bin[b.json["bufferViews"][indices]["byteOffset"].as_u64().expect("an offset") as usize] == 3 {
            expected.swap(1, 3);
        }
        for (time, x) in expected.into_iter().enumerate() {
            assert_eq!(origin(&at(&b, time as f64)).x, x, "at {time}");
        }
        b.json["accessors"][2].as_object_mut().expect("an object").remove("bufferView");
        assert_eq!([0.0, 2.0].map(|t| origin(&at(&b, t)).x), [0.0, 0.0], "what is not sparse is zero");
    }
}

#[test]
fn rotations_are_slerped_the_shorter_way() {
    let turn = |degrees: f32| glam::Quat::from_rotation_z(degrees.to_radians()).to_array();
    let keys = [turn(0.0), turn(90.0).map(|x| -x)].concat();
    let b = animated("rotation", "LINEAR", &[0.0, 1.0], "VEC4", &keys);
    let x = at(&b, 1.0 / 3.0).scene.instances[0].transform.transform_vector3(Vec3::X);
    assert!((x - Vec3::new(0.75_f32.sqrt(), 0.5, 0.0)).length() < 1e-6, "{x} is not turned by 30°");
}

#[test]
fn at_rest_nothing_moves_and_a_note_says_so() {
    let b = animated("translation", "LINEAR", &[0.0], "VEC3", &[5.0, 0.0, 0.0]);
    let loaded = b.loaded();
    assert_eq!(origin(&loaded), Vec3::ZERO);
    assert!(told(&loaded, Severity::Note, "/animations"));
    let moving = at(&b, 0.0);
    assert_eq!(origin(&moving).x, 5.0);
    assert!(moving.diagnostics.is_empty(), "{:?}", moving.diagnostics);
    let summary = &loaded.summary.animations[0];
    assert_eq!((&*summary.name, summary.channels, summary.ignored), ("move", 1, 0));
    assert_eq!(summary.properties, ["translation"]);
    assert!(open(&b).load(&Moment { animations: vec![1], time: 0.0 }).is_err());
}

#[test]
fn several_animations_play_together_and_the_last_wins() {
    let mut b = animated("translation", "STEP", &[0.0], "VEC3", &[5.0, 0.0, 0.0]);
    let input = b.floats("SCALAR", &[0.0]);
    let (moved, scaled) = (b.floats("VEC3", &[7.0, 0.0, 0.0]), b.floats("VEC3", &[2.0, 2.0, 2.0]));
    b.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
                         {"sampler": 1, "target": {"node": 0, "path": "scale"}}],
            "samplers": [{"input": input, "output": moved}, {"input": input, "output": scaled}],
        }),
    );
    let mut asset = open(&b);
    assert_eq!(asset.animation_names(), [Some("move"), None]);
    for (animations, x) in [(vec![0, 1], 7.0), (vec![1, 0], 5.0)] {
        let loaded = asset.load(&Moment { animations, time: 0.0 }).expect("it loads");
        assert_eq!(origin(&loaded).x, x);
        assert_eq!(loaded.scene.instances[0].transform.transform_vector3(Vec3::X), 2.0 * Vec3::X);
        assert!(told(&loaded, Severity::Note, "/animations"));
    }
}

#[test]
fn weights_of_morph_targets_move() {
    let mut b = animated("weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 0.0, 1.0, 2.0]);
    let by = b.floats("VEC3", &[0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    b.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": by}, {"POSITION": by}]);
    assert_eq!(at(&b, 0.25).scene.meshes[0].positions[0].z, 3.0);
    // One weight by pointer; the other one is the mesh's.
    b.json["meshes"][0]["weights"] = json!([0.5, 0.0]);
    let one = b.floats("SCALAR", &[1.0, 3.0]);
    b.json["animations"][0]["samplers"][0]["output"] = json!(one);
    for pointer in ["/nodes/0/weights/1", "/meshes/0/weights/1"] {
        point(&mut b, pointer);
        assert_eq!(at(&b, 0.5).scene.meshes[0].positions[0].z, 2.0 + 8.0, "{pointer}");
    }
    point(&mut b, "/meshes/0/weights/2");
    assert!(told(&at(&b, 0.5), Severity::Warning, TARGET));
}

const TARGET: &str = "/animations/0/channels/0/target/extensions/KHR_animation_pointer";

#[test]
fn pointers_reach_materials_lights_cameras_and_nodes() {
    let mut b = animated("", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    b.json["materials"] = json!([{
        "pbrMetallicRoughness": {},
        "extensions": {
            "KHR_materials_ior": {},
            "NEPHRITE_materials_subsurface": {"scatteringCoefficient": [1, 2, 3]},
        },
    }]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}});
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["nodes"] = json!([
        {"mesh": 0, "camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}, "children": [1]},
        {"mesh": 0, "translation": [1, 0, 0], "extensions": {"KHR_node_visibility": {}}},
    ]);
    let scalar = |b: &mut Builder, pointer: &str| {
        point(b, pointer);
        let loaded = at(b, 0.25);
        let warnings = loaded.diagnostics.iter().filter(|d| d.pointer.starts_with("/animations"));
        assert_eq!(warnings.count(), 0, "{pointer}: {:?}", loaded.diagnostics);
        loaded.scene
    };
    let roughness = "/materials/0/pbrMetallicRoughness/roughnessFactor";
    assert_eq!(scalar(&mut b, roughness).materials[0].roughness, 0.25);
    let ior = "/materials/0/extensions/KHR_materials_ior/ior";
    let plain = b.json["animations"][0]["samplers"][0]["output"].clone();
    b.json["animations"][0]["samplers"][0]["output"] = json!(b.floats("SCALAR", &[1.0, 2.0]));
    assert_eq!(scalar(&mut b, ior).materials[0].ior, 1.25);
    let media = b.json["materials"].clone();
    b.json["materials"] = json!([{"extensions": {"KHR_materials_ior": {"ior": 0}}}]);
    assert!(scalar(&mut b, ior).materials[0].ior > 1e3, "an infinite index stays infinite");
    b.json["materials"] = media;
    b.json["animations"][0]["samplers"][0]["output"] = plain;
    let intensity = "/extensions/KHR_lights_punctual/lights/0/intensity";
    assert_eq!(scalar(&mut b, intensity).lights[0].intensity, Vec3::splat(0.25));
    let projection = scalar(&mut b, "/cameras/0/perspective/yfov").cameras[0].projection;
    assert!(matches!(projection, crate::scene::Projection::Perspective { yfov: 0.25, .. }));
    let g = "/materials/0/extensions/NEPHRITE_materials_subsurface/scatterAnisotropy";
    assert_eq!(scalar(&mut b, g).materials[0].medium.as_ref().map(|m| m.anisotropy), Some(0.25));
    let density = "/materials/0/extensions/NEPHRITE_materials_subsurface/densityFactor";
    let medium = scalar(&mut b, density).materials[0].medium.clone().expect("a medium");
    assert_eq!(medium.sigma_s, Vec3::new(0.25, 0.5, 0.75));

    let color = b.floats("VEC3", &[0.0, 0.0, 0.0, 4.0, 8.0, 12.0]);
    b.json["animations"][0]["samplers"][0]["output"] = json!(color);
    let absorption = "/materials/0/extensions/NEPHRITE_materials_subsurface/absorptionCoefficient";
    let medium = scalar(&mut b, absorption).materials[0].medium.clone().expect("a medium");
    assert_eq!(medium.sigma_a, Vec3::new(1.0, 2.0, 3.0));

    let visible = b.accessor("SCALAR", U8, 2, &[1, 0]);
    b.json["animations"][0]["samplers"][0] = json!({"input": 1, "output": visible, "interpolation": "STEP"});
    point(&mut b, "/nodes/1/extensions/KHR_node_visibility/visible");
    assert_eq!([0.5, 1.0].map(|t| at(&b, t).scene.instances.len()), [2, 1]);
}

#[test]
fn pointers_to_textures_of_any_material_extension() {
    let mut b = animated("", "LINEAR", &[0.0, 1.0], "VEC2", &[0.0, 0.0, 1.0, 0.5]);
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    b.push("images", json!({"uri": png}));
    b.push("textures", json!({"source": 0}));
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": {}}});
    b.json["materials"] =
        json!([{"extensions": {"KHR_materials_transmission": {"transmissionTexture": info}}}]);
    let texture = "/materials/0/extensions/KHR_materials_transmission/transmissionTexture";
    point(&mut b, &format!("{texture}/extensions/KHR_texture_transform/offset"));
    let mut asset = open(&b);
    let mut load = |time| asset.load(&Moment { animations: vec![0], time }).expect("it loads").scene;
    let (first, second) = (load(0.5), load(1.0));
    let offset = |scene: &crate::scene::SceneDescription| {
        scene.materials[0].transmission_texture.expect("a texture").transform.translation
    };
    assert_eq!([offset(&first), offset(&second)], [glam::Vec2::new(0.5, 0.25), glam::Vec2::new(1.0, 0.5)]);
    assert!(std::sync::Arc::ptr_eq(&first.images[0], &second.images[0]), "images are decoded once");
}

#[test]
fn bad_pointers_are_told_of_and_ignored() {
    let mut b = animated("", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    b.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
    b.json["textures"] = json!([{}]);
    for pointer in [
        "",
        "nodes/0/scale",
        "/nodes/0/mesh",
        "/nodes/7/rotation",
        "/nodes/0/matrix",
        "/nodes/0/children/0",
        "/materials/0/pbrMetallicRoughness/roughnessFactor",
        "/materials/0/doubleSided",
        "/nodes/0/scale/0",
        "/materials/99999999999999999999/alphaCutoff",
        "/scene",
        "/materials/0/normalTexture/offset",
        "/nodes/0/rotation",
        "/nodes/0/weights/0",
        "/accessors/0/count",
    ] {
        point(&mut b, pointer);
        let loaded = at(&b, 0.5);
        let warned = loaded.diagnostics.iter().any(|d| {
            d.severity == Severity::Warning && (d.pointer == TARGET || d.pointer.starts_with("/accessors/"))
        });
        assert!(warned, "{pointer}: {:?}", loaded.diagnostics);
        assert_eq!(loaded.summary.animations[0].ignored, 1, "{pointer}");
    }
}

#[test]
fn matrices_beside_animated_properties_are_taken_apart() {
    let mut b = animated("translation", "STEP", &[0.0], "VEC3", &[5.0, 0.0, 0.0]);
    b.json["nodes"][0]["matrix"] = json!([0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1, 0, 1, 1, 1, 1]);
    let loaded = at(&b, 0.0);
    let transform = loaded.scene.instances[0].transform;
    assert!((transform.transform_point3(Vec3::X) - Vec3::new(5.0, 2.0, 0.0)).length() < 1e-5);
    assert!((transform.transform_point3(Vec3::Y) - Vec3::new(2.0, 0.0, 0.0)).length() < 1e-5);
    assert!(told(&loaded, Severity::Warning, "/animations/0/channels/0/target/node"));
}

#[test]
fn malformed_samplers_are_told_of_and_ignored() {
    let good = || animated("translation", "LINEAR", &[0.0, 1.0], "VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let cases: Vec<Builder> = vec![
        animated("translation", "LINEAR", &[0.0, f32::NAN], "VEC3", &[1.0; 6]),
        animated("translation", "LINEAR", &[1.0, 0.0], "VEC3", &[1.0; 6]),
        animated("translation", "CUBIC", &[0.0, 1.0], "VEC3", &[1.0; 6]),
        animated("translation", "CUBICSPLINE", &[0.0, 1.0], "VEC3", &[1.0; 6]),
        animated("translation", "LINEAR", &[0.0, 1.0], "VEC4", &[1.0; 8]),
        animated("translation", "LINEAR", &[0.0, 1.0, 2.0], "VEC3", &[1.0; 6]),
        animated("rotation", "LINEAR", &[0.0, 1.0], "VEC3", &[1.0; 6]),
        animated("weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[1.0; 2]),
        animated("visibility", "LINEAR", &[0.0, 1.0], "SCALAR", &[1.0; 2]),
        animated("translation", "LINEAR", &[0.0, 1.0], "VEC3", &[f32::INFINITY; 6]),
    ];
    for (i, b) in cases.iter().enumerate() {
        let loaded = at(b, 0.5);
        assert!(loaded.diagnostics.iter().any(|d| d.severity == Severity::Warning), "case {i}");
        assert_eq!(origin(&loaded), Vec3::ZERO, "case {i}");
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        let bytes = b.document().to_string().into_bytes();
        let mut asset = Asset::from_bytes(bytes, Path::new("/nowhere"), &strict).expect("it opens");
        assert!(asset.load(&Moment { animations: vec![0], time: 0.5 }).is_err(), "case {i}");
    }
    for (pointer, value) in [
        ("/channels/0/sampler", json!(3)),
        ("/channels/0/target/node", json!(999)),
        ("/channels/0/target", json!(0)),
        ("/channels", json!({})),
        ("/samplers", json!(7)),
        ("/samplers/0", json!([])),
        ("/samplers/0/input", json!(999)),
        ("/samplers/0/output", json!(-1)),
        ("/channels/0/target/path", json!(1)),
    ] {
        let mut b = good();
        *b.json["animations"][0].pointer_mut(pointer).expect("it is there") = value;
        let loaded = at(&b, 0.5);
        assert!(loaded.diagnostics.iter().any(|d| d.severity == Severity::Warning), "{pointer}");
        assert_eq!(origin(&loaded), Vec3::ZERO, "{pointer}");
    }
    assert_eq!(origin(&at(&good(), 0.5)), Vec3::splat(1.5));
}

#[test]
fn a_million_keyframes_are_searched_not_read() {
    let n = 1_000_000;
    let times: Vec<f32> = (0..n).map(|i| i as f32 / 1024.0).collect();
    let values: Vec<f32> = (0..n).flat_map(|i| [i as f32, 0.0, 0.0]).collect();
    let mut b = animated("translation", "LINEAR", &times, "VEC3", &values);
    let channel = b.json["animations"][0]["channels"][0].clone();
    b.json["animations"][0]["channels"] = json!(vec![channel; 1000]);
    let mut asset =
        Asset::from_bytes(b.glb(), Path::new("/nowhere"), &LoadOptions::default()).expect("it opens");
    for (time, x) in [(100.0, 102_400.0), (500.0 + 0.5 / 1024.0, 512_000.5), (1e9, 999_999.0)] {
        let loaded = asset.load(&Moment { animations: vec![0], time }).expect("it loads");
        assert_eq!(origin(&loaded).x, x, "at {time}");
    }
    let limits = Limits { pose_elements: 1000, ..Limits::default() };
    let options = LoadOptions { limits, ..LoadOptions::default() };
    let result = Asset::from_bytes(b.glb(), Path::new("/nowhere"), &options)
        .expect("it opens")
        .load(&Moment::default());
    assert!(matches!(result, Err(AssetError::Limit { field: "pose_elements", .. })));
}
