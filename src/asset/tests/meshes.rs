//! Accessors, primitives and what becomes of them.

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::scene::NO_MATERIAL;

/// Positions of `n` points on a line, x = 0, 1, 2, …, bent so that no three are collinear.
fn points(n: usize) -> Vec<f32> {
    (0..n).flat_map(|i| [i as f32, (i * i) as f32, 0.0]).collect()
}

fn primitive(b: &mut Builder) -> &mut Value {
    &mut b.json["meshes"][0]["primitives"][0]
}

#[test]
fn indices_of_every_type_and_every_topology() {
    let indices: [u8; 5] = [4, 3, 2, 1, 0];
    let wide = |width: usize| -> Vec<u8> {
        indices.iter().flat_map(|&i| (0..width).map(move |k| if k == 0 { i } else { 0 })).collect()
    };
    for (component, width) in [(U8, 1), (U16, 2), (U32, 4)] {
        for (mode, expected) in [
            (4, vec![[4, 3, 2]]),
            (5, vec![[4, 3, 2], [3, 1, 2], [2, 1, 0]]),
            (6, vec![[3, 2, 4], [2, 1, 4], [1, 0, 4]]),
        ] {
            let mut b = Builder::triangle();
            let position = b.floats("VEC3", &points(5));
            let index = b.accessor("SCALAR", component, 5, &wide(width));
            *primitive(&mut b) =
                json!({"attributes": {"POSITION": position}, "indices": index, "mode": mode});
            assert_eq!(b.loaded().scene.meshes[0].triangles, expected, "{component} mode {mode}");
        }
    }
}

#[test]
fn interleaved_and_offset_accessors() {
    let mut b = Builder::triangle();
    let rows: Vec<f32> = (0..3)
        .flat_map(|i| {
            let p = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]][i];
            [99.0, p[0], p[1], p[2], 0.0, 0.0, 2.0]
        })
        .collect();
    let view = b.view(&floats(&rows));
    b.json["bufferViews"][view]["byteStride"] = json!(28);
    let mut accessor = |offset: usize| {
        let entry = json!({
            "bufferView": view, "byteOffset": offset, "type": "VEC3", "componentType": F32, "count": 3,
        });
        b.push("accessors", entry)
    };
    let (position, normal) = (accessor(4), accessor(16));
    primitive(&mut b)["attributes"] = json!({"POSITION": position, "NORMAL": normal});
    let mesh = &b.loaded().scene.meshes[0];
    assert_eq!(mesh.positions[1], Vec3::new(1.0, 0.0, 5.0));
    assert_eq!(mesh.normals, [Vec3::Z; 3], "normals are normalised");
}

#[test]
fn normalised_integers_as_the_specification_has_them() {
    let mut b = Builder::triangle();
    let entry = |b: &mut Builder, component: u32, bytes: &[u8], stride: usize| {
        let accessor = b.accessor("VEC3", component, 3, bytes);
        let view = b.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        b.json["bufferViews"][view]["byteStride"] = json!(stride);
        b.json["accessors"][accessor]["normalized"] = json!(true);
        accessor
    };
    let i8s = [127_u8, 0, 129, 0, 0, 128, 0, 0, 0, 64, 0, 0];
    let position = entry(&mut b, 5120, &i8s, 4);
    let u16s: Vec<u8> =
        [65535_u16, 0, 13107, 0, 0, 0, 0, 0, 0, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let color = entry(&mut b, U16, &u16s, 8);
    b.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    primitive(&mut b)["attributes"] = json!({"POSITION": position, "COLOR_0": color});
    let loaded = b.loaded();
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(mesh.positions[0], Vec3::new(1.0, 0.0, -1.0));
    assert_eq!(mesh.positions[1], Vec3::new(0.0, -1.0, 0.0), "-128 and -127 are both -1");
    assert_eq!(mesh.colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0), "VEC3 colours are opaque");
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    b.json["extensionsUsed"] = json!([]);
    assert!(told(&b.loaded(), Severity::Warning, "/meshes/0/primitives/0/attributes/POSITION"));
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    for base in [true, false] {
        let mut b = Builder::triangle();
        let accessor = b.floats("VEC3", &[0.0, 0.0, 7.0, 0.0, 0.0, 7.0, 0.0, 0.0, 7.0]);
        let indices = b.view(&[1, 2]);
        let values = b.view(&floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        let entry = &mut b.json["accessors"][accessor];
        entry["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        if !base {
            entry.as_object_mut().expect("an object").remove("bufferView");
        }
        primitive(&mut b)["attributes"]["POSITION"] = json!(accessor);
        let first = if base { Vec3::new(0.0, 0.0, 7.0) } else { Vec3::ZERO };
        assert_eq!(b.loaded().scene.meshes[0].positions, [first, Vec3::X, Vec3::Y]);
    }
}

#[test]
fn a_mesh_merges_its_primitives() {
    let mut b = Builder::triangle();
    b.json["materials"] = json!([{}, {}]);
    let position = b.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0]);
    let normal = b.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let uv = b.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.5, 0.25]);
    let second = json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv}, "material": 1,
    });
    b.json["meshes"][0]["primitives"].as_array_mut().expect("an array").push(second);
    let loaded = b.loaded();
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.triangle_materials, [NO_MATERIAL, 1]);
    assert_eq!(mesh.normals, [Vec3::Z; 6], "the first primitive got flat normals");
    assert_eq!(mesh.uvs[0][5], Vec2::new(0.5, 0.25));
    assert_eq!(mesh.uvs[0][..3], [Vec2::ZERO; 3]);
    assert_eq!(loaded.scene.meshes.len(), 1);
}

#[test]
fn normals_stay_empty_where_there_are_none() {
    assert!(Builder::triangle().loaded().scene.meshes[0].normals.is_empty());
}

#[test]
fn normals_without_direction_become_those_of_a_face() {
    let mut b = Builder::triangle();
    let normal = b.floats("VEC3", &[0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0, 1e30]);
    primitive(&mut b)["attributes"]["NORMAL"] = json!(normal);
    let loaded = b.loaded();
    assert_eq!(loaded.scene.meshes[0].normals, [Vec3::Z; 3]);
    assert!(told(&loaded, Severity::Warning, "/meshes/0/primitives/0/attributes/NORMAL"));
}

#[test]
fn triangles_that_cannot_be_drawn_are_dropped() {
    let mut b = Builder::triangle();
    let p = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, f32::NAN, 0.0, 0.0, 3e38, 0.0, 0.0];
    let position = b.floats("VEC3", &p);
    let index = b.accessor("SCALAR", U8, 12, &[0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 1]);
    *primitive(&mut b) = json!({"attributes": {"POSITION": position}, "indices": index});
    let loaded = b.loaded();
    assert_eq!(loaded.scene.meshes[0].triangles, [[0, 1, 2]]);
    assert!(loaded.scene.meshes[0].positions.iter().all(|p| p.is_finite()));
    assert!(told(&loaded, Severity::Warning, "/meshes/0/primitives/0"));
}

#[test]
fn tangents_are_made_where_a_normal_map_needs_them() {
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    let mut b = Builder::with_material(json!({"normalTexture": {"index": 0}}));
    b.push("textures", json!({"source": 0}));
    b.push("images", json!({"uri": png}));
    let uv = b.floats("VEC2", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    let normal = b.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    primitive(&mut b)["attributes"]["TEXCOORD_0"] = json!(uv);
    primitive(&mut b)["attributes"]["NORMAL"] = json!(normal);
    let loaded = b.loaded();
    assert!(loaded.scene.materials[0].normal_texture.is_some(), "{:?}", loaded.diagnostics);
    // u grows along +Y, so the tangent is +Y; v grows along +X, so what is up in the picture, and green in the map, is -X:
    // cross(N, T) w = -X needs w = 1.
    for tangent in &loaded.scene.meshes[0].tangents {
        assert!((*tangent - Vec4::new(0.0, 1.0, 0.0, 1.0)).length() < 1e-6, "{tangent}");
    }
    b.json["materials"] = json!([{}]);
    assert!(b.loaded().scene.meshes[0].tangents.is_empty());
}

/// A bump of a normal map stays a bump, however KHR_texture_transform turns or mirrors the picture of it.
#[test]
fn tangents_that_are_made_turn_with_the_picture_and_those_of_the_file_do_not() {
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    let tangents = |material: Value, given: bool| {
        let mut b = Builder::with_material(material);
        b.push("textures", json!({"source": 0}));
        b.push("images", json!({"uri": png}));
        // The picture is upright: u grows along +X, v along −Y.
        let uv = b.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        let normal = b.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        primitive(&mut b)["attributes"]["TEXCOORD_0"] = json!(uv);
        primitive(&mut b)["attributes"]["NORMAL"] = json!(normal);
        if given {
            let tangent = b.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
            primitive(&mut b)["attributes"]["TANGENT"] = json!(tangent);
        }
        let extensions = ["KHR_texture_transform", "KHR_materials_clearcoat", "KHR_materials_anisotropy"];
        b.json["extensionsUsed"] = json!(extensions);
        b.loaded().scene.meshes[0].tangents.clone()
    };
    let slots: [fn(Value) -> Value; 3] = [
        |texture| json!({"normalTexture": texture}),
        |texture| json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatNormalTexture": texture}}}),
        |texture| json!({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyTexture": texture}}}),
    ];
    let (sin, cos) = 0.4_f32.sin_cos();
    for (transform, expected) in [
        (json!({"offset": [0.3, 0.7], "scale": [3, 0.5]}), Vec4::new(1.0, 0.0, 0.0, 1.0)),
        // Rotated by r, u is cos r of the old u and sin r of the old v (row-major (cos, sin; −sin, cos)).
        (json!({"rotation": 0.4}), Vec4::new(cos, -sin, 0.0, 1.0)),
        (json!({"rotation": std::f64::consts::PI, "offset": [1, 1]}), Vec4::new(-1.0, 0.0, 0.0, 1.0)),
        (json!({"rotation": std::f64::consts::FRAC_PI_2}), Vec4::new(0.0, -1.0, 0.0, 1.0)),
        // A mirrored picture: what is up in it stays, what is right in it is left; and the other way round.
        (json!({"scale": [-1, 1]}), Vec4::new(-1.0, 0.0, 0.0, -1.0)),
        (json!({"scale": [1, -2]}), Vec4::new(1.0, 0.0, 0.0, -1.0)),
        (json!({"scale": [-3, -3]}), Vec4::new(-1.0, 0.0, 0.0, 1.0)),
        // Scaled before it is turned: u' = 2 u cos r + v sin r grows along (2 cos r, −sin r) at equal v' = v cos r − 2 u sin r.
        (json!({"scale": [2, 1], "rotation": 0.4}), Vec4::new(cos, -2.0 * sin, 0.0, 1.0)),
        (json!({"scale": [0, 1]}), Vec4::new(1.0, 0.0, 0.0, 1.0)),
    ] {
        let direction = expected.truncate().normalize().extend(expected.w);
        for slot in slots {
            let texture = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
            for tangent in tangents(slot(texture.clone()), false) {
                assert!((tangent - direction).length() < 1e-6, "{transform}: {tangent} is not {direction}");
            }
            for tangent in tangents(slot(texture), true) {
                assert_eq!(tangent, Vec4::new(1.0, 0.0, 0.0, 1.0), "{transform}");
            }
        }
    }
}

#[test]
fn morph_targets_at_their_default_weights() {
    let mut b = Builder::triangle();
    let target = b.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0]);
    primitive(&mut b)["targets"] = json!([{"POSITION": target}, {"POSITION": target}]);
    b.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    b.json["nodes"] = json!([{"children": [1, 2]}, {"mesh": 0}, {"mesh": 0, "weights": [0, 0]}]);
    let loaded = b.loaded();
    assert_eq!(loaded.scene.meshes.len(), 2, "poses are meshes of their own");
    assert_eq!(loaded.scene.meshes[0].positions[2], Vec3::new(0.0, 1.0, 2.25));
    assert_eq!(loaded.scene.meshes[1].positions[2], Vec3::Y);
}

#[test]
fn skins_at_rest() {
    let mut b = Builder::triangle();
    let joints = b.accessor("VEC4", U8, 3, &[0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = b.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
    let mut inverse = [glam::Mat4::IDENTITY.to_cols_array(); 2];
    inverse[1][12] = -1.0;
    let inverse = b.floats("MAT4", &inverse.concat());
    let attributes = &mut primitive(&mut b)["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    b.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    b.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 100, 100], "children": [1]},
        {"translation": [-100, -100, -90], "children": [2]},
        {"translation": [1, 0, 5]},
    ]);
    let loaded = b.loaded();
    // Joint 0 moves by (0, 0, 10); joint 1, at rest at x = 1, by (0, 0, 15). The node's own transform is ignored.
    let expected = [Vec3::new(0.0, 0.0, 10.0), Vec3::new(1.0, 0.0, 15.0), Vec3::new(0.0, 1.0, 12.5)];
    for (p, e) in loaded.scene.meshes[0].positions.iter().zip(expected) {
        assert!((*p - e).length() < 1e-4, "{p} is not {e}");
    }
    assert_eq!(loaded.scene.instances[0].transform, glam::Affine3A::IDENTITY);
}
