//! Numbers that overflow. Documents that are mangled at random are in `tests/fuzz/`.

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

/// A hundred bytes a node that each take a copy of a mesh, and images that are one by another name.
#[test]
fn what_is_made_of_a_file_is_counted_and_shared() {
    let mut b = Builder::triangle();
    let stretched = |i: usize| json!({"mesh": 0, "scale": [1, 2, 1 + i]});
    b.json["nodes"] = (0..1000).map(stretched).collect();
    b.json["scenes"] = json!([{"nodes": (0..1000).collect::<Vec<_>>()}]);
    let mut limits = Limits::default();
    assert!(limits.set("hierarchy-bytes", 100_000));
    let options = LoadOptions { limits, ..LoadOptions::default() };
    let loaded = load_json(&b.document(), &options).expect("loads");
    let Err(error) = crate::scene::Scene::build(loaded.scene) else { panic!("copies are not counted") };
    assert!(
        error.to_string().contains("meshes, instances and their hierarchies, in bytes, needs "),
        "{error}"
    );
    assert!(error.advice().is_some_and(|advice| advice.contains("--limit hierarchy-bytes=N")));

    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    let mut b = Builder::triangle();
    b.json["images"] = (0..8).map(|_| json!({"uri": png})).collect();
    b.json["textures"] = (0..8).map(|i| json!({"source": i})).collect();
    let material = |i: usize| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
    b.json["materials"] = (0..8).map(material).collect();
    let scene = b.loaded().scene;
    assert_eq!((scene.textures.len(), scene.images.len()), (8, 1));
    assert!(scene.textures.iter().all(|t| t.image == 0));
    // One texel of 8 bits.
    let limits = Limits { image_bytes: 4, ..Limits::default() };
    assert!(load_json(&b.document(), &LoadOptions { limits, ..LoadOptions::default() }).is_ok());
}
