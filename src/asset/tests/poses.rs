//! Skins and morph targets, against hand computation and against numpy.

use glam::{Vec2, Vec3, Vec4};

use super::*;

/// The triangle with joints of the skin for each vertex and their weights; nodes are to be made.
fn skinned(joints: &[u8; 12], weights: &[f32; 12]) -> Builder {
    let mut b = Builder::triangle();
    let joints = b.accessor("VEC4", U8, 3, joints);
    let weights = b.floats("VEC4", weights);
    let attributes = &mut b.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    b
}

/// All of each vertex belongs to joint 0.
fn rigid() -> Builder {
    skinned(&[0; 12], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
}

#[track_caller]
fn close(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((*f - *e).length() < 1e-5, "{found:?} is not {expected:?}");
    }
}

#[test]
fn every_set_of_joints_counts_and_weights_are_normalised() {
    let mut b = skinned(
        &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0],
        &[0.25, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5, 0.5, 0.0, 0.0],
    );
    let more =
        b.accessor("VEC4", U16, 3, &[2_u16, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0].map(u16::to_le_bytes).concat());
    let weights = b.accessor("VEC4", U8, 3, &[191, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    b.json["accessors"][weights]["normalized"] = json!(true);
    let attributes = &mut b.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(more);
    attributes["WEIGHTS_1"] = json!(weights);
    b.json["skins"] = json!([{"joints": [1, 2, 3]}]);
    b.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "children": [1, 2, 3]},
        {"translation": [0, 0, 4]}, {"scale": [3, 1, 1]}, {"translation": [8, 0, 0]},
    ]);
    let loaded = b.loaded();
    // 1/4 of (0, 0, 4) and 191/255 of (8, 0, 0), over their sum; (1, 0, 0) scaled; 3/4 of (0, 1, 4), 1/4 of (0, 1, 0).
    let (a, b) = (0.25, 191.0 / 255.0);
    let first = Vec3::new(8.0 * b, 0.0, 4.0 * a) / (a + b);
    close(&loaded.scene.meshes[0].positions, &[first, Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 3.0)]);
    assert!(told(&loaded, Severity::Warning, "/meshes/0/primitives/0/attributes"), "weights of 2");
    assert_eq!(loaded.diagnostics.len(), 1, "{:?}", loaded.diagnostics);
}

#[test]
fn vertices_without_joints_stay_at_their_node() {
    let mut b = skinned(&[0; 12], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    b.json["skins"] = json!([{"joints": [1]}]);
    b.json["nodes"] = json!([{"mesh": 0, "skin": 0, "translation": [0, 0, 7], "children": [1]}, {}]);
    let loaded = b.loaded();
    let expected = [Vec3::new(0.0, 0.0, 7.0), Vec3::new(1.0, 0.0, 7.0), Vec3::new(0.0, 1.0, 7.0)];
    close(&loaded.scene.meshes[0].positions, &expected);
    assert!(told(&loaded, Severity::Warning, "/meshes/0/primitives/0/attributes"));
}

#[test]
fn joints_need_not_be_in_the_scene_but_must_be_somewhere() {
    let mut b = rigid();
    b.json["skins"] = json!([{"joints": [2]}]);
    b.json["nodes"] =
        json!([{"mesh": 0, "skin": 0}, {"scale": [2, 2, 2], "children": [2]}, {"translation": [1, 0, 0]}]);
    let loaded = b.loaded();
    let expected = [Vec3::new(2.0, 0.0, 0.0), Vec3::new(4.0, 0.0, 0.0), Vec3::new(2.0, 2.0, 0.0)];
    close(&loaded.scene.meshes[0].positions, &expected);
    assert!(told(&loaded, Severity::Warning, "/skins/0/joints/0"));
    // Joints in a circle: the skin is ignored.
    b.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"children": [2]}, {"children": [1]}]);
    let loaded = b.loaded();
    assert!(told(&loaded, Severity::Warning, "/skins/0/joints/0"));
    assert_eq!(loaded.scene.meshes[0].positions[1], Vec3::X);
    b.json["skins"] = json!([{"joints": [77]}]);
    assert!(refused(&b).starts_with("/skins/0/joints/0: "));
    b.json["skins"] = json!([{"joints": []}]);
    assert!(told(&b.loaded(), Severity::Warning, "/skins/0"));
}

#[test]
fn a_circle_of_many_joints_ends() {
    let mut b = rigid();
    let n = 100_000;
    let mut nodes = vec![json!({"mesh": 0, "skin": 0})];
    nodes.extend((1..=n).map(|i| json!({"children": [i % n + 1]})));
    b.json["nodes"] = json!(nodes);
    b.json["skins"] = json!([{"joints": (1..=n).collect::<Vec<usize>>()}]);
    assert!(told(&b.loaded(), Severity::Warning, "/skins/0/joints/0"));
}

#[test]
fn normals_and_tangents_follow_uneven_and_mirrored_joints() {
    let normals = |scale: [f32; 3]| {
        let mut b = rigid();
        let slanted = Vec3::new(1.0, 0.0, 1.0).normalize();
        let normal = b.floats("VEC3", &[slanted.to_array(); 3].concat());
        b.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normal);
        b.json["skins"] = json!([{"joints": [1]}]);
        b.json["nodes"] = json!([{"mesh": 0, "skin": 0, "children": [1]}, {"scale": scale}]);
        let mesh = b.loaded().scene.meshes[0].clone();
        let [p, q, r] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        (mesh.normals[0], (q - p).cross(r - p).normalize())
    };
    // The inverse transpose of diag(4, 1, 2): (1/4, 0, 1/2).
    let (normal, face) = normals([4.0, 1.0, 2.0]);
    assert!((normal - Vec3::new(1.0, 0.0, 2.0).normalize()).length() < 1e-6, "{normal}");
    assert_eq!(face, Vec3::Z);
    // Mirrored in x: outside stays outside, as with a mirrored node.
    let (normal, face) = normals([-1.0, 1.0, 1.0]);
    assert!((normal - Vec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-6, "{normal}");
    assert_eq!(face, Vec3::Z);
}

#[test]
fn morph_targets_of_texture_coordinates_and_colours() {
    let mut b = Builder::triangle();
    let uv = b.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let color = b.floats("VEC4", &[0.5; 12]);
    let uv_by = b.accessor("VEC2", 5120, 3, &[127, 0, 0, 0, 0, 129]);
    b.json["accessors"][uv_by]["normalized"] = json!(true);
    let color_by = b.floats("VEC3", &[1.0, 0.0, -4.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3]);
    let primitive = &mut b.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uv);
    primitive["attributes"]["COLOR_0"] = json!(color);
    primitive["targets"] =
        json!([{"TEXCOORD_0": uv_by, "COLOR_0": color_by, "_MINE": 0, "TEXCOORD_9": uv_by}]);
    b.json["meshes"][0]["weights"] = json!([0.5]);
    let loaded = b.loaded();
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(mesh.uvs[0], [Vec2::new(0.5, 0.0), Vec2::X, Vec2::new(0.0, 0.5)]);
    assert_eq!(mesh.colors[0], Vec4::new(1.0, 0.5, 0.0, 0.5), "clamped to [0, 1], alpha as it is");
    assert!((mesh.colors[2] - Vec4::new(0.55, 0.6, 0.65, 0.5)).length() < 1e-6);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
}

#[test]
fn flat_normals_are_those_of_the_morphed_shape_and_weights_of_nodes_win() {
    let mut b = Builder::triangle();
    let by = b.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    b.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": by}]);
    b.json["meshes"][0]["weights"] = json!([0.5]);
    b.json["nodes"] = json!([{"mesh": 0, "weights": [1]}]);
    let mesh = &b.loaded().scene.meshes[0];
    assert_eq!(mesh.positions[1], Vec3::new(1.0, 0.0, 1.0));
    assert!(mesh.normals.is_empty(), "flat shading takes the normals of the triangles");
}

#[test]
fn targets_that_do_not_fit_are_told_of_and_ignored() {
    for weight in [0.0, 1.0] {
        let mut b = Builder::triangle();
        let by = b.floats("VEC3", &[1.0; 6]);
        b.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": by}]);
        b.json["meshes"][0]["weights"] = json!([weight]);
        let loaded = b.loaded();
        assert!(told(&loaded, Severity::Warning, "/meshes/0/primitives/0/targets/0/POSITION"));
        assert_eq!(loaded.scene.meshes[0].positions[0], Vec3::ZERO);
    }
}

#[test]
fn targets_without_end_meet_a_limit() {
    let mut b = Builder::new();
    let position = b.push("accessors", json!({"type": "VEC3", "componentType": F32, "count": 1 << 20}));
    let targets: Vec<Value> = (0..1100).map(|_| json!({"POSITION": position})).collect();
    b.json["meshes"] = json!([{
        "primitives": [{"attributes": {"POSITION": position}, "targets": targets}], "weights": vec![1; 1100],
    }]);
    let limits = Limits { pose_elements: 10_000_000, ..Limits::default() };
    let result = b.load_with(&LoadOptions { limits, ..LoadOptions::default() });
    assert!(matches!(result, Err(AssetError::Limit { field: "pose_elements", .. })));
}
