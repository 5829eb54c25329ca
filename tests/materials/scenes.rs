//! A glTF material on a square, lit and seen from given directions.

use crate::lab::{Estimate, measure, options, ortho, single};
use glam::{DVec3, Vec2, Vec3};
use nephrite::asset::{LoadOptions, load_bytes};
use nephrite::optics::Microfacet;
use nephrite::scene::*;
use nephrite::transport::{RenderOptions, render};
use serde_json::{Value, json};
use std::path::Path;

/// The material of a glTF document.
pub fn material(json: &Value) -> MaterialDescription {
    let used: Vec<&String> = json["extensions"].as_object().into_iter().flat_map(|e| e.keys()).collect();
    let document = json!({"asset": {"version": "2.0"}, "extensionsUsed": used, "materials": [json]});
    let loaded = load_bytes(document.to_string().into_bytes(), Path::new(""), &LoadOptions::default());
    let loaded = loaded.expect("it loads");
    let complaints = loaded.diagnostics.iter().filter(|d| d.pointer.starts_with("/materials"));
    assert_eq!(complaints.count(), 0, "{:?}", loaded.diagnostics);
    loaded.scene.materials.into_iter().next().expect("a material")
}

/// A material of that base colour, with extensions.
pub fn pbr(color: [f64; 3], metallic: f64, roughness: f64, extensions: Value) -> Value {
    let [r, g, b] = color;
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": roughness,
        },
        "extensions": extensions,
    })
}

/// A square of side 2 at z = 0 that faces +z, with its tangent along x.
pub fn square() -> MeshDescription {
    let corners = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0)];
    MeshDescription {
        positions: corners.iter().map(|c| c.extend(0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec3::X.extend(1.0); 4],
        uvs: vec![corners.to_vec()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Default::default()
    }
}

/// Options of a picture of the middle of the square from the direction `v`.
pub fn seen_from(v: DVec3, pixels: u32, spp: u32, microfacet: Microfacet) -> RenderOptions {
    options(ortho(-v.as_vec3(), 10.0, 0.05), pixels, spp).with(|o| o.settings.microfacet = microfacet)
}

/// f(v, l) |N·L| of the square: its radiance under a directional light of irradiance 1. There is nothing random in it
/// but where in a pixel a path begins, and rounding.
pub fn reflected(json: &Value, v: DVec3, l: DVec3, microfacet: Microfacet) -> [f64; 3] {
    let mut scene = single(square(), material(json), EnvironmentDescription::default());
    scene.lights.push(PunctualLight {
        name: String::new(),
        intensity: Vec3::ONE,
        position: Vec3::ZERO,
        direction: -l.as_vec3(),
        range: None,
        kind: PunctualKind::Directional,
    });
    picture(scene, &seen_from(v, 2, 1, microfacet))
}

/// The mean of a picture without noise.
pub fn picture(scene: SceneDescription, options: &RenderOptions) -> [f64; 3] {
    let scene = Scene::build(scene).expect("builds");
    let film = render(&scene, options, &()).expect("renders").picture;
    let sum: DVec3 = film.pixels.iter().map(|p| p.as_dvec3()).sum();
    (sum / film.pixels.len() as f64).to_array()
}

/// The square in an environment of radiance 1.
pub fn in_furnace(json: &Value, v: DVec3, spp: u32, microfacet: Microfacet) -> Estimate {
    let scene = single(square(), material(json), EnvironmentDescription::Constant(Vec3::ONE));
    measure(&Scene::build(scene).expect("builds"), &seen_from(v, 16, spp, microfacet))
}

/// Asserts that `found` is `expected` up to the rounding of single precision, `relative` of it.
#[track_caller]
pub fn same(found: [f64; 3], expected: [f64; 3], relative: f64, what: &str) {
    println!("{what}: {found:.6?}, expected {expected:.6?}");
    for (a, b) in found.into_iter().zip(expected) {
        assert!((a - b).abs() <= relative * b.abs() + 1e-6, "{what}: {found:?} is not {expected:?}");
    }
}
