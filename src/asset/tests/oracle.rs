//! The `gltf` crate as an independent reader of the same documents.

use glam::{Mat4, Quat, Vec3};

use super::*;

/// Numbers in \[-1, 1) from a fixed sequence (splitmix64).
fn numbers() -> impl FnMut() -> f32 {
    let mut state = 7_u64;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// A tree of 40 nodes, some with matrices, and as many materials.
fn forest() -> Value {
    let mut next = numbers();
    let mut b = Builder::with_material(json!({}));
    let mut nodes: Vec<Value> = Vec::new();
    let mut materials: Vec<Value> = Vec::new();
    for i in 0..40_usize {
        let children: Vec<usize> = [2 * i + 1, 2 * i + 2].into_iter().filter(|&c| c < 40).collect();
        let translation = Vec3::new(next(), next(), next());
        let rotation = Quat::from_xyzw(next(), next(), next(), next()).normalize();
        let scale = Vec3::new(next() + 2.0, next() + 2.0, -next() - 2.0);
        let mut node = if i % 3 == 0 {
            let m = Mat4::from_scale_rotation_translation(scale, rotation, translation);
            json!({"matrix": m.to_cols_array()})
        } else {
            json!({
                "translation": translation.to_array(), "rotation": rotation.to_array(), "scale": scale.to_array(),
            })
        };
        node["mesh"] = json!(0);
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        nodes.push(node);
        let mut unit = || next().abs();
        materials.push(json!({
            "name": format!("m{i}"), "emissiveFactor": [unit(), unit(), unit()],
            "alphaMode": (["OPAQUE", "MASK", "BLEND"][i % 3]), "doubleSided": (i % 2 == 0),
            "pbrMetallicRoughness": {
                "baseColorFactor": [unit(), unit(), unit(), unit()],
                "metallicFactor": unit(), "roughnessFactor": unit(),
            },
            "extensions": {
                "KHR_materials_ior": {"ior": 1.0 + unit()},
                "KHR_materials_transmission": {"transmissionFactor": unit()},
                "KHR_materials_emissive_strength": {"emissiveStrength": 10.0 * unit()},
            },
        }));
    }
    b.json["nodes"] = json!(nodes);
    b.json["materials"] = json!(materials);
    b.json["extensionsUsed"] =
        json!(["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_emissive_strength"]);
    b.document()
}

#[test]
fn nodes_and_materials_as_the_gltf_crate_reads_them() {
    let document = forest();
    let loaded = load_json(&document, &LoadOptions::default()).expect("it loads");
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let other = gltf::Gltf::from_slice(document.to_string().as_bytes()).expect("it is valid");

    let mut stack: Vec<(gltf::Node<'_>, Mat4)> =
        other.scenes().flat_map(|s| s.nodes().map(|n| (n, Mat4::IDENTITY))).collect();
    let mut seen = 0;
    while let Some((node, parent)) = stack.pop() {
        let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        let pointer = format!("/nodes/{}", node.index());
        let ours = loaded.scene.instances.iter().find(|i| i.pointer == pointer).expect("an instance");
        let difference = (Mat4::from(ours.transform) - world).to_cols_array();
        let largest = difference.iter().fold(0.0_f32, |m, d| m.max(d.abs()));
        assert!(
            largest < 1e-4 * world.to_cols_array().iter().fold(1.0, |m: f32, x| m.max(x.abs())),
            "{pointer}"
        );
        stack.extend(node.children().map(|c| (c, world)));
        seen += 1;
    }
    assert_eq!((seen, loaded.scene.instances.len()), (40, 40));

    for (ours, theirs) in loaded.scene.materials.iter().zip(other.materials()) {
        let pbr = theirs.pbr_metallic_roughness();
        assert_eq!(Some(&*ours.name), theirs.name());
        assert_eq!(ours.base_color.to_array(), pbr.base_color_factor());
        assert_eq!((ours.metallic, ours.roughness), (pbr.metallic_factor(), pbr.roughness_factor()));
        assert_eq!(Some(ours.ior), theirs.ior());
        assert_eq!(Some(ours.transmission), theirs.transmission().map(|t| t.transmission_factor()));
        assert_eq!(ours.double_sided, theirs.double_sided());
        let strength = theirs.emissive_strength().unwrap_or(1.0);
        assert_eq!(ours.emission, Vec3::from(theirs.emissive_factor()) * strength);
    }
}
