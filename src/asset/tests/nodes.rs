//! Hierarchies, scenes, cameras.

use glam::{Quat, Vec3};

use super::*;
use crate::scene::{Clip, Projection};

#[test]
fn transforms_accumulate_and_mirror() {
    let mut b = Builder::triangle();
    let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    b.json["nodes"] = json!([
        {"translation": [10, 0, 0], "rotation": turn.to_array(), "scale": [2, 2, 2], "children": [1]},
        {"matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1], "mesh": 0, "name": "mirrored"},
    ]);
    let loaded = b.loaded();
    let instance = &loaded.scene.instances[0];
    assert_eq!((&*instance.name, &*instance.pointer), ("mirrored", "/nodes/1"));
    // (1, 0, 0) → mirrored (-1, 0, 3) → scaled (-2, 0, 6) → turned (0, -2, 6) → moved (10, -2, 6)
    let p = instance.transform.transform_point3(Vec3::X);
    assert!((p - Vec3::new(10.0, -2.0, 6.0)).length() < 1e-5, "{p}");
    assert!(instance.transform.matrix3.determinant() < 0.0);
}

#[test]
fn one_mesh_many_instances() {
    let mut b = Builder::triangle();
    b.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}, {"mesh": 0}]);
    b.json["scenes"] = json!([{"nodes": [0, 1]}]);
    let scene = b.loaded().scene;
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
}

#[test]
fn what_lies_in_the_place_of_another_is_left_out() {
    let mut b = Builder::triangle();
    let primitive = b.json["meshes"][0]["primitives"][0].clone();
    b.json["meshes"][0]["primitives"] = json!(vec![primitive; 50_000]);
    b.json["nodes"] = json!(vec![json!({"mesh": 0}); 100_000]);
    b.json["scenes"] = json!([{"nodes": (0..100_000).collect::<Vec<_>>()}]);
    let loaded = b.loaded();
    assert_eq!((loaded.scene.instances.len(), loaded.scene.meshes[0].triangles.len()), (1, 1));
    for (pointer, count) in [("/meshes", "49999 primitives"), ("/nodes", "99999 objects")] {
        let told = loaded.diagnostics.iter().find(|d| d.pointer == pointer).expect("a warning");
        assert!(told.severity == Severity::Warning && told.message.starts_with(count), "{told:?}");
    }
}

#[test]
fn the_right_scene_is_shown() {
    let mut b = Builder::triangle();
    b.json["nodes"] = json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "scale": [2, 2, 2]}]);
    b.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    let shown = |b: &Builder, scene| {
        let options = LoadOptions { scene, ..LoadOptions::default() };
        let loaded = b.load_with(&options)?;
        Ok::<_, AssetError>(loaded.scene.instances.iter().map(|i| i.name.clone()).collect::<String>())
    };
    b.json["scene"] = json!(1);
    assert_eq!(shown(&b, None).expect("default"), "b");
    assert_eq!(shown(&b, Some(0)).expect("chosen"), "a");
    assert!(shown(&b, Some(2)).is_err());
    b.json.as_object_mut().expect("an object").remove("scene");
    assert_eq!(shown(&b, None).expect("first"), "a");
    b.json.as_object_mut().expect("an object").remove("scenes");
    b.json["nodes"][0]["children"] = json!([1]);
    assert_eq!(shown(&b, None).expect("all"), "ab");
}

#[test]
fn graphs_that_are_no_trees() {
    let mut b = Builder::triangle();
    b.json["nodes"] = json!([{"children": [1]}, {"children": [0]}]);
    assert!(refused(&b).contains("/nodes/1/children/0"), "{}", refused(&b));
    b.json["nodes"] = json!([{"children": [1, 1]}, {"mesh": 0}]);
    let loaded = b.loaded();
    assert_eq!(loaded.scene.instances.len(), 1);
    assert!(told(&loaded, Severity::Warning, "/nodes/0/children/1"));
    let diamond: Vec<Value> = (0..64).map(|i| json!({"children": [i + 1, i + 1]})).collect();
    b.json["nodes"] = json!(diamond);
    b.json["nodes"].as_array_mut().expect("an array").push(json!({"mesh": 0}));
    assert_eq!(b.loaded().scene.instances.len(), 1);
    b.json["nodes"] = json!([{"children": [7]}]);
    assert_eq!(refused(&b), "/nodes/0/children/0: refers to nodes/7, but the file has 1 nodes");
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes() {
    let mut b = Builder::triangle();
    let mut nodes: Vec<Value> =
        (1..100_000).map(|i| json!({"children": [i], "translation": [1, 0, 0]})).collect();
    nodes.push(json!({"mesh": 0}));
    b.json["nodes"] = json!(nodes);
    let scene = b.loaded().scene;
    assert_eq!(scene.origin.x + f64::from(scene.instances[0].transform.translation.x), 99_999.0);
}

#[test]
fn transforms_that_leave_nothing_or_a_plane() {
    let mut b = Builder::triangle();
    for (node, instances) in [
        (json!({"mesh": 0, "scale": [0, 0, 0]}), 0),
        (json!({"mesh": 0, "scale": [1, 0, 1]}), 0),
        (json!({"mesh": 0, "scale": [2, 1, 0]}), 1),
        (json!({"mesh": 0, "scale": [1e-6, 1e-6, 1e-6]}), 1),
        (json!({"mesh": 0, "translation": [1e30, 0, 0]}), 0),
        (json!({"mesh": 0, "rotation": [0, 0, 0, 0]}), 1),
    ] {
        b.json["nodes"] = json!([node]);
        let loaded = b.loaded();
        assert_eq!(loaded.scene.instances.len(), instances, "{node}");
        let inverses = loaded.scene.instances.iter().map(|i| i.transform.inverse());
        assert!(inverses.into_iter().all(|i| i.is_finite()));
    }
}

#[test]
fn cameras_lose_their_scale_but_not_their_lens() {
    let mut b = Builder::triangle();
    b.json["cameras"] = json!([
        {"type": "perspective", "name": "eye", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5}},
        {"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2, "znear": 0, "zfar": 1}},
    ]);
    let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    b.json["nodes"] = json!([
        {"camera": 0, "scale": [3, 3, 3], "rotation": turn.to_array(), "translation": [1, 2, 3]},
        {"camera": 1, "name": "plan", "scale": [1, -1, 1]},
        {"camera": 1, "scale": [0, 0, 0]},
    ]);
    b.json["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    let loaded = b.loaded();
    let cameras = &loaded.scene.cameras;
    assert_eq!(cameras.len(), 2);
    assert_eq!((&*cameras[0].name, &*cameras[1].name), ("eye", "plan"));
    assert!(matches!(cameras[0].projection, Projection::Perspective { yfov: 0.5, aspect: Some(1.5) }));
    assert!(matches!(cameras[1].projection, Projection::Orthographic { ymag: 2.0, aspect: Some(2.0) }));
    let view = cameras[0].transform.transform_vector3(Vec3::NEG_Z);
    assert!((view - Vec3::NEG_X).length() < 1e-6, "{view}");
    for camera in cameras {
        let m = camera.transform.matrix3;
        assert!((m.determinant() - 1.0).abs() < 1e-5);
    }
    assert!(told(&loaded, Severity::Warning, "/nodes/2"));
    assert_eq!(loaded.summary.cameras[0].name, "eye");
    for lens in
        [json!({"yfov": 0, "znear": 1}), json!({"yfov": "wide"}), json!({"znear": 1}), json!({"yfov": 3.2})]
    {
        b.json["cameras"][0]["perspective"] = lens;
        assert!(refused(&b).starts_with("/cameras/0/perspective/yfov: "));
    }
}

#[test]
fn clipping_planes_are_those_of_the_file_where_they_leave_something_between_them() {
    let clip = |kind: &str, near: f64, far: Option<f64>| {
        let mut b = Builder::triangle();
        let mut lens = json!({"yfov": 1, "xmag": 1, "ymag": 1, "znear": near});
        if let Some(far) = far {
            lens["zfar"] = json!(far);
        }
        b.json["cameras"] = json!([{"type": kind, kind: lens}]);
        b.json["nodes"] = json!([{"camera": 0}]);
        let loaded = b.loaded();
        let complaint = |key| told(&loaded, Severity::Warning, &format!("/cameras/0/{kind}/{key}"));
        (loaded.scene.cameras[0].clip, complaint("znear"), complaint("zfar"))
    };
    let never = f32::INFINITY;
    let (lens, plan) = ("perspective", "orthographic");
    // Without `zfar` a projection is infinite.
    assert_eq!(clip(lens, 0.5, None), (Clip { near: 0.5, far: never }, false, false));
    assert_eq!(clip(lens, 0.5, Some(2.0)), (Clip { near: 0.5, far: 2.0 }, false, false));
    assert_eq!(clip(plan, 0.0, Some(2.0)), (Clip { near: 0.0, far: 2.0 }, false, false));
    assert_eq!(clip(lens, -1.0, Some(2.0)), (Clip { near: 0.0, far: 2.0 }, true, false));
    assert_eq!(clip(plan, -1.0, Some(2.0)), (Clip { near: -1.0, far: 2.0 }, true, false));
    assert_eq!(clip(lens, 2.0, Some(1.0)), (Clip::NONE, false, true));
    assert_eq!(clip(lens, 1.0, Some(1.0)), (Clip::NONE, false, true));
    assert_eq!(clip(lens, 1e300, None), (Clip::NONE, false, false));
    assert_eq!(clip(plan, 1.0, Some(1e300)), (Clip { near: 1.0, far: never }, false, false));
}
