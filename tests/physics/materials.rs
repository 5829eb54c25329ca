//! The white furnace of every kind of material: what absorbs nothing cannot be seen in a uniform environment, from any
//! side, at any angle. Materials are read from glTF, so that the way from an extension to paths is tested as a whole.
//!
//! Where energy is only conserved to a known accuracy (`docs/materials.md`), that is the tolerance.

use crate::lab::*;
use glam::Vec3;
use nephrite::asset::{LoadOptions, load_bytes};
use nephrite::scene::*;
use serde_json::{Value, json};
use std::path::Path;

/// What a material is, what it says, and how far its mean may be from 1.
type Case = (&'static str, Value, f64);

/// Energy is conserved but for the noise.
const EXACT: f64 = 2e-3;

/// Samples a pixel.
const SAMPLES: u32 = 96;
/// Standard error of a channel: wavelengths of dispersive glass are each drawn with less than a third of the samples.
const MOST_NOISE: f64 = 5e-3;

/// The material of a document.
fn material(json: &Value) -> MaterialDescription {
    let document = json!({"asset": {"version": "2.0"}, "materials": [json]});
    let loaded = load_bytes(document.to_string().into_bytes(), Path::new(""), &LoadOptions::default());
    loaded.expect("it loads").scene.materials.swap_remove(0)
}

/// A sphere with smooth normals, and tangents along its parallels.
fn sphere() -> MeshDescription {
    let mut mesh = icosphere(0.02, 4, true);
    mesh.tangents =
        mesh.normals.iter().map(|n| Vec3::Y.cross(*n).normalize_or(Vec3::X).extend(1.0)).collect();
    mesh.uvs = vec![vec![glam::Vec2::ZERO; mesh.positions.len()]];
    mesh
}

fn plain(metallic: f64, roughness: f64, extensions: Value) -> Value {
    json!({
        "pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness}, "extensions": extensions,
    })
}

/// Without a volume below it.
fn surfaces() -> Vec<Case> {
    let coat = json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.4}});
    let thin = |extensions: Value| {
        let mut all = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
        for (name, own) in extensions.as_object().expect("an object") {
            all[name] = own.clone();
        }
        all
    };
    let film =
        json!({"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 400}});
    vec![
        ("plastic", plain(0.0, 0.5, json!({})), EXACT),
        ("metal", plain(1.0, 0.7, json!({})), EXACT),
        ("specular", plain(0.0, 0.4, json!({"KHR_materials_specular": {"specularFactor": 0.5}})), EXACT),
        ("ior", plain(0.0, 0.4, json!({"KHR_materials_ior": {"ior": 2.0}})), EXACT),
        ("coat on plastic", plain(0.0, 0.6, coat.clone()), 5e-3),
        ("coat on metal", plain(1.0, 0.6, coat), 5e-3),
        (
            "sheen",
            plain(
                0.0,
                0.8,
                json!({"KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.5}}),
            ),
            5e-3,
        ),
        (
            "brushed metal",
            plain(1.0, 0.4, json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.7}})),
            8e-3,
        ),
        (
            "brushed plastic",
            plain(0.0, 0.4, json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.7}})),
            8e-3,
        ),
        ("thin wall", plain(0.0, 0.5, thin(json!({}))), EXACT),
        (
            "leaf",
            plain(
                0.0,
                0.5,
                json!({"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.6}}),
            ),
            EXACT,
        ),
        (
            "paper",
            plain(
                0.0,
                0.5,
                thin(json!({"KHR_materials_scatter": {"scatterStrengthFactor": 0.5,
                "multiscatterColorFactor": [1, 1, 1], "scatterAnisotropy": 0.3}})),
            ),
            EXACT,
        ),
        (
            "specular-glossiness",
            json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "specularFactor": [0.3, 0.3, 0.3], "glossinessFactor": 0.5}}}),
            EXACT,
        ),
        ("film on metal", plain(1.0, 0.5, film), 5e-3),
    ]
}

/// With a volume that absorbs nothing below it.
fn boundaries() -> Vec<Case> {
    let glass = |extensions: Value| {
        let mut all = json!({
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1},
        });
        for (name, own) in extensions.as_object().expect("an object") {
            all[name] = own.clone();
        }
        all
    };
    let scattering = json!({"NEPHRITE_materials_subsurface": {"scatteringCoefficient": [90, 100, 111]}});
    let mut scattering_coated = scattering.clone();
    scattering_coated["KHR_materials_clearcoat"] = json!({"clearcoatFactor": 1});
    vec![
        ("glass", plain(0.0, 0.4, glass(json!({}))), 5e-3),
        (
            "dispersive glass",
            plain(0.0, 0.0, glass(json!({"KHR_materials_dispersion": {"dispersion": 2}}))),
            5e-3,
        ),
        (
            "brushed glass",
            plain(0.0, 0.4, glass(json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.7}}))),
            1.5e-2,
        ),
        (
            "tinted reflection",
            plain(0.0, 0.0, glass(json!({"KHR_materials_specular": {"specularFactor": 0.3}}))),
            EXACT,
        ),
        (
            "film on smooth glass",
            plain(0.0, 0.0, glass(json!({"KHR_materials_iridescence": {"iridescenceFactor": 1}}))),
            EXACT,
        ),
        (
            "coated glass",
            plain(0.0, 0.0, glass(json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1}}))),
            EXACT,
        ),
        ("wax", plain(0.0, 0.3, scattering), 5e-3),
        ("coated wax", plain(0.0, 0.0, scattering_coated), EXACT),
    ]
}

fn furnaces(cases: Vec<Case>) {
    let mut failed = Vec::new();
    for (what, json, tolerance) in cases {
        let scene = single(sphere(), material(&json), EnvironmentDescription::Constant(Vec3::ONE));
        let scene = Scene::build(scene).expect("builds");
        let estimate = measure(&scene, &options(ortho(Vec3::new(-0.4, -0.3, -0.9), 0.2, 0.022), 24, SAMPLES));
        println!("{what}: {:.4?} ± {:.4?}, within {tolerance}", estimate.mean, estimate.se);
        for c in 0..3 {
            let off = (estimate.mean[c] - 1.0).abs();
            if off > tolerance + 4.0 * estimate.se[c] || estimate.se[c] > MOST_NOISE {
                failed.push(format!("{what} [{c}]: {} ± {}", estimate.mean[c], estimate.se[c]));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn surfaces_of_every_extension_conserve_energy() {
    furnaces(surfaces());
}

#[test]
fn boundaries_of_every_extension_conserve_energy() {
    furnaces(boundaries());
}

/// A film on plastic gives the base what the strongest channel of its reflectance leaves, as its specification has it: a
/// white film keeps less than it takes, by the mean distance of its channels to the strongest one at each angle.
#[test]
fn a_film_on_plastic_darkens_as_its_specification_has_it() {
    let json = plain(
        0.0,
        0.5,
        json!({"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 400}}),
    );
    let scene = single(sphere(), material(&json), EnvironmentDescription::Constant(Vec3::ONE));
    let scene = Scene::build(scene).expect("builds");
    let estimate = measure(&scene, &options(ortho(Vec3::new(-0.4, -0.3, -0.9), 0.2, 0.022), 24, SAMPLES));
    println!("film on plastic: {:.4?} ± {:.4?}", estimate.mean, estimate.se);
    // At 400 nm and index 1.3 channels are up to 0.03 from the strongest, which has all of its light, and none is the
    // strongest at every angle.
    assert!(estimate.mean.iter().all(|m| (0.97..0.999).contains(m)), "{:?}", estimate.mean);
}

/// KHR_materials_clearcoat dims what shines below the coat by its reflectance, 0.04 + 0.96 (1 − cos θ)⁵: a flat emitter
/// seen under θ, by paths that find it and by lights that are sampled.
#[test]
fn a_coat_dims_emission() {
    let radiance = |factor: f64| {
        material(&json!({
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1}, "emissiveFactor": [1, 1, 1],
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": factor}},
        }))
    };
    for (cos, factor) in [(1.0f64, 1.0), (0.4, 1.0), (0.4, 0.5)] {
        let material = radiance(factor);
        let mesh = cuboid(Vec3::new(1.0, 1.0, 0.01));
        let scene = single(mesh, material, EnvironmentDescription::Constant(Vec3::ZERO));
        let scene = Scene::build(scene).expect("builds");
        let sin = (1.0 - cos * cos).sqrt();
        let camera = ortho(Vec3::new(sin as f32, 0.0, -cos as f32), 3.0, 0.02);
        let estimate = measure(&scene, &options(camera, 8, 4));
        let expected = 1.0 - factor * (0.04 + 0.96 * (1.0 - cos).powi(5));
        for mean in estimate.mean {
            assert!((mean - expected).abs() < 1e-4, "cos {cos}, factor {factor}: {mean} for {expected}");
        }
    }
}
