//! Numbers that overflow, and documents that were mangled at random: never a panic.

use super::*;

#[test]
fn ranges_are_checked_without_overflow() {
    let big = json!(9_223_372_036_854_775_807_u64);
    for (pointer, value) in [
        ("/accessors/0/count", big.clone()),
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/count", json!(4_611_686_018_427_387_906_u64)),
        ("/accessors/0/count", json!(-3)),
        ("/accessors/0/count", json!(1.5)),
        ("/accessors/0/byteOffset", json!(18_446_744_073_709_551_608_u64)),
        ("/accessors/0/byteOffset", json!(4)),
        ("/accessors/0/bufferView", json!(7)),
        ("/accessors/0/componentType", json!(5130)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/0/type", json!("VEC5")),
        ("/bufferViews/0/byteOffset", big.clone()),
        ("/bufferViews/0/byteLength", big.clone()),
        ("/bufferViews/0/byteLength", json!(37)),
        ("/bufferViews/0/byteStride", json!(4_294_967_292_u64)),
        ("/bufferViews/0/byteStride", big.clone()),
        ("/bufferViews/0/buffer", json!(5)),
        ("/buffers/0/byteLength", big),
        ("/buffers/0/byteLength", json!(-1)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9_007_199_254_740_993_u64)),
        ("/meshes/0/primitives/0/material", json!(0)),
        ("/nodes/0/mesh", json!(-1)),
        ("/nodes/0/mesh", json!(0.5)),
        ("/nodes/0", Value::Null),
        ("/scenes/0/nodes/0", json!(123_456_789)),
        ("/meshes", json!({})),
        ("/scene", json!("0")),
    ] {
        let mut json = Builder::triangle().document();
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        match json.pointer_mut(parent).expect("a parent") {
            Value::Object(object) => drop(object.insert(key.to_owned(), value.clone())),
            Value::Array(array) => array[key.parse::<usize>().expect("an index")] = value.clone(),
            _ => panic!("{parent} has no children"),
        }
        let result = load_json(&json, &LoadOptions::default());
        let error = result.map(|_| ()).expect_err(pointer);
        assert!(!error.pointer().is_empty(), "{pointer} = {value}: {error}");
    }
}

#[test]
fn sparse_ranges_are_checked() {
    let good = json!({
        "count": 1,
        "indices": {"bufferView": 1, "componentType": U8},
        "values": {"bufferView": 0},
    });
    for (pointer, value) in [
        ("/count", json!(4)),
        ("/count", json!(2_147_483_648_u64)),
        ("/indices/bufferView", json!(42)),
        ("/indices/byteOffset", json!(1)),
        ("/indices/componentType", json!(F32)),
        ("/indices/componentType", json!(U32)),
        ("/values/byteOffset", json!(25)),
        ("/values", Value::Null),
    ] {
        let mut b = Builder::triangle();
        b.view(&[0]);
        b.json["accessors"][0]["sparse"] = good.clone();
        b.loaded();
        let sparse = &mut b.json["accessors"][0]["sparse"];
        match pointer.rsplit_once('/').expect("a pointer") {
            ("", key) => sparse[key] = value.clone(),
            (parent, key) => sparse.pointer_mut(parent).expect("a parent")[key] = value.clone(),
        }
        assert!(b.load().is_err(), "{pointer} = {value}");
    }
}

#[test]
fn indices_beyond_the_vertices_are_refused() {
    for index in [3_u32, u32::MAX] {
        let mut b = Builder::triangle();
        let bytes = [0, 1, index].map(u32::to_le_bytes).concat();
        let accessor = b.accessor("SCALAR", U32, 3, &bytes);
        b.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
        assert!(refused(&b).starts_with("/meshes/0/primitives/0/indices: "));
    }
}

#[test]
fn zeros_cost_nothing_and_are_limited() {
    let mut b = Builder::triangle();
    b.json["accessors"][0] = json!({"type": "VEC3", "componentType": F32, "count": 1_u64 << 30});
    assert!(matches!(b.load(), Err(AssetError::Limit { .. })));
}

/// A document with something of everything.
fn rich() -> Value {
    let mut b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {
            "offset": [0.5, 0.5], "rotation": 1, "scale": [2, 2], "texCoord": 0}}}},
        "normalTexture": {"index": 0}, "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0]},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 0}},
            "NEPHRITE_materials_subsurface": {"scatteringCoefficient": [1, 2, 3], "priority": 1, "densityFactor": 2},
        },
    }));
    let index = b.accessor("SCALAR", U8, 3, &[0, 1, 2]);
    let color = b.accessor("VEC4", U8, 3, &[255; 12]);
    let view = b.view(b"\x89PNG\r\n\x1a\n and no more");
    b.json["meshes"][0]["primitives"][0]["indices"] = json!(index);
    b.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(color);
    b.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(color);
    b.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    b.json["meshes"][0]["weights"] = json!([1]);
    b.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    b.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    b.json["samplers"] = json!([{"wrapS": 33071}]);
    b.json["skins"] = json!([{"joints": [1, 2]}]);
    b.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 3, "range": 10, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}]}});
    let (times, rotations) = (b.floats("SCALAR", &[0.0, 1.0]), b.floats("VEC4", &[0.5; 24]));
    let visible = b.accessor("SCALAR", U8, 2, &[1, 1]);
    b.json["animations"] = json!([{
        "channels": [
            {"sampler": 0, "target": {"node": 1, "path": "rotation"}},
            {"sampler": 1, "target": {"node": 0, "path": "weights"}},
            {"sampler": 2, "target": {"path": "pointer", "extensions": {
                "KHR_animation_pointer": {"pointer": "/nodes/1/extensions/KHR_node_visibility/visible"}}}},
            {"sampler": 1, "target": {"path": "pointer", "extensions": {
                "KHR_animation_pointer": {"pointer": "/meshes/0/weights/0"}}}},
        ],
        "samplers": [
            {"input": times, "output": rotations, "interpolation": "CUBICSPLINE"},
            {"input": times, "output": times},
            {"input": times, "output": visible, "interpolation": "STEP"},
        ],
    }]);
    b.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2], "scale": [1, 2, 3]},
        {"camera": 0, "rotation": [0, 0, 0, 1], "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"extensions": {"KHR_lights_punctual": {"light": 0},
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}, "mesh": 0, "skin": 0},
    ]);
    b.document()
}

fn pointers(value: &Value, here: String, all: &mut Vec<String>) {
    match value {
        Value::Object(o) => o.iter().for_each(|(k, v)| pointers(v, format!("{here}/{k}"), all)),
        Value::Array(a) => a.iter().enumerate().for_each(|(i, v)| pointers(v, format!("{here}/{i}"), all)),
        _ => {}
    }
    all.push(here);
}

#[test]
fn any_value_anywhere_ends_well() {
    let good = rich();
    let loaded = load_json(&good, &LoadOptions::default()).expect("the unaltered document loads");
    let animation = &loaded.summary.animations[0];
    assert_eq!((animation.channels, animation.ignored), (4, 0), "{:?}", loaded.diagnostics);
    let mut all = Vec::new();
    pointers(&good, String::new(), &mut all);
    let odd = [
        Value::Null,
        json!(true),
        json!(-1),
        json!(0),
        json!(2.5),
        json!(1e300),
        json!(u64::MAX),
        json!(4_294_967_295_u64),
        json!("../../odd"),
        json!([]),
        json!([[[]]]),
        json!([1e39, -1e39, 0, 1]),
        json!({}),
    ];
    for pointer in &all {
        for value in &odd {
            let mut json = good.clone();
            *json.pointer_mut(pointer).expect("it is there") = value.clone();
            let bytes = json.to_string().into_bytes();
            let asset = Asset::from_bytes(bytes, Path::new("/nowhere"), &LoadOptions::default());
            let Ok(mut asset) = asset else { continue };
            for moment in [Moment::default(), Moment { animations: vec![0], time: 0.25 }] {
                if let Ok(loaded) = asset.load(&moment) {
                    check(&loaded.scene);
                }
            }
        }
    }
}

/// What every scene must keep, whatever the file said.
fn check(scene: &crate::scene::SceneDescription) {
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
        assert!(
            [mesh.normals.len(), mesh.tangents.len(), mesh.colors.len()].iter().all(|&l| l == 0 || l == n)
        );
        assert!(mesh.uvs.iter().all(|set| set.len() == n));
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        let materials = scene.materials.len() as u32;
        assert!(mesh.triangle_materials.iter().all(|&m| m < materials || m == crate::scene::NO_MATERIAL));
    }
    for instance in &scene.instances {
        assert!(instance.mesh < scene.meshes.len());
        assert!(instance.transform.is_finite() && instance.transform.inverse().is_finite());
    }
    for material in &scene.materials {
        assert!(material.ior >= 1.0 && material.emission.is_finite() && material.base_color.is_finite());
        for texture in material.textures() {
            assert!(scene.textures[texture.texture].image < scene.images.len());
            assert!(texture.transform.is_finite());
        }
        if let Some(m) = &material.medium {
            assert!(m.sigma_a.is_finite() && m.sigma_a.min_element() >= 0.0, "{}", m.sigma_a);
            assert!(m.sigma_s.is_finite() && m.sigma_s.min_element() >= 0.0, "{}", m.sigma_s);
            assert!(m.anisotropy.abs() < 1.0 && m.ior >= 1.0);
        }
    }
    for light in &scene.lights {
        assert!(light.intensity.is_finite() && light.position.is_finite() && light.direction.is_normalized());
    }
}
