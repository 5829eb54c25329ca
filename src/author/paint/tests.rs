use super::*;
use crate::author::text::Tree;
use crate::optics::seen_color::{seen_color, shares_of_seen_color};
use glam::Vec3;
use serde_json::{Value, json};

/// Texels from black to white beside each other: coefficients against the inversion, and the colour that comes back.
#[test]
fn every_texel_is_inverted_and_keeps_its_colour_beside_black() {
    let basis = Basis { sigma_t: [1000.0, 2000.0, 500.0], g: 0.3, ior: 1.45 };
    let greys = [0.0f32, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0];
    let texels: Vec<Vec3> = greys.iter().map(|&c| Vec3::new(c, (0.2 + c).min(1.0), 0.5)).collect();
    let painted = basis.paint(&Colors::Picture { width: 4, texels: texels.clone() });
    let (absorption, scattering) =
        (painted.absorption.as_ref().unwrap(), painted.scattering.as_ref().unwrap());
    assert_eq!((absorption.0, absorption.1.len()), (4, greys.len()));
    for (i, texel) in texels.iter().enumerate() {
        for c in 0..2 {
            let a = painted.sigma_a[c] * f64::from(absorption.1[i][c]) / 65535.0;
            let s = painted.sigma_s[c] * f64::from(scattering.1[i][c]) / 65535.0;
            let color = f64::from(texel[c]);
            let seen = seen_color(s / (a + s), basis.g, basis.ior);
            assert!((seen - color).abs() < 4e-4, "{i} [{c}]: {seen} for {color}");
            // The mean free path is kept where absorption is more than a step or two.
            if color < 0.9 {
                let [scattered, absorbed] = shares_of_seen_color(color, basis.g, basis.ior);
                assert!((a / basis.sigma_t[c] - absorbed).abs() < 2e-5, "{i} [{c}]: {a}");
                assert!((s / basis.sigma_t[c] - scattered).abs() < 6e-3, "{i} [{c}]: {s}");
            }
        }
    }
    // A channel that is the same everywhere needs no texture of its own.
    assert!(absorption.1.iter().all(|t| t[2] == u16::MAX) && scattering.1.iter().all(|t| t[2] == u16::MAX));
    let uniform = basis.paint(&Colors::Uniform(Vec3::splat(0.5)));
    assert!(uniform.absorption.is_none() && (uniform.sigma_s[2] / painted.sigma_s[2] - 1.0).abs() < 1e-4);
    let mean = painted.mean(&basis);
    assert!(
        (mean.sigma_t()[2] / 500.0 - 1.0).abs() < 1e-4
            && (mean.sigma_a[2] / painted.sigma_a[2] - 1.0).abs() < 1e-3
    );
}

#[test]
fn vertex_colours_go_everywhere_and_further_sets_stay_data() {
    let text = r#"{"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1,"COLOR_1":2},
        "targets":[{"POSITION":3,"COLOR_0":4},{"POSITION":5}],
        "extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0,"COLOR_0":1,"COLOR_1":2}}}}]}]}"#;
    let mut tree = Tree::parse(text).unwrap();
    assert!(document::clear_vertex_colors(tree.root_mut(), 0, 0));
    let after: Value = serde_json::from_str(&tree.to_string()).unwrap();
    let expected = json!({"meshes":[{"primitives":[{"attributes":{"POSITION":0,"_COLOR_1":2},
        "targets":[{"POSITION":3},{"POSITION":5}],
        "extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0,"_COLOR_1":2}}}}]}]});
    assert_eq!(after, expected);
    assert!(!document::clear_vertex_colors(tree.root_mut(), 0, 0));
    assert!(!document::clear_vertex_colors(tree.root_mut(), 3, 0));
}

#[test]
fn primitives_change_their_material_and_their_variants() {
    let text = r#"{"meshes":[{"primitives":[{"material":1,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[0]},{"material":2,"variants":[1]}]}}}]}]}"#;
    let mut tree = Tree::parse(text).unwrap();
    document::use_material(tree.root_mut(), [0, 0], 1, 7);
    let expected = text.replace("\"material\":1", "\"material\":7");
    assert_eq!(tree.to_string(), expected);
    let animated = json!({ "animations": [{ "channels": [{ "target": {} }, { "target": { "extensions": {
        "KHR_animation_pointer": { "pointer": "/materials/4/pbrMetallicRoughness/baseColorFactor" } } } }] }] });
    assert_eq!(document::animated_base_color(&animated, 4).as_deref(), Some("/animations/0/channels/1"));
    assert_eq!(document::animated_base_color(&animated, 5), None);
}
