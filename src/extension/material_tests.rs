//! Tests of the extensions of materials, through the loader.

use glam::Vec3;
use serde_json::{Value, json};

use crate::asset::tests::{Builder, refused, told};
use crate::asset::{LoadOptions, Loaded, Severity};
use crate::scene::MaterialDescription;

const PNG: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";

fn loaded(extensions: Value) -> Loaded {
    let mut b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions,
    }));
    let names: Vec<&String> = extensions.as_object().expect("an object").keys().collect();
    b.json["extensionsUsed"] = json!(names);
    b.push("images", json!({"uri": PNG}));
    b.push("textures", json!({"source": 0}));
    b.loaded()
}

fn first(loaded: &Loaded) -> &MaterialDescription {
    &loaded.scene.materials[0]
}

#[test]
fn layers_are_read() {
    let texture = json!({"index": 0});
    let all = loaded(json!({
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25,
            "clearcoatTexture": texture, "clearcoatNormalTexture": {"index": 0, "scale": 2}},
        "KHR_materials_sheen": {"sheenColorFactor": [1, 0.5, 0], "sheenRoughnessFactor": 0.3, "sheenColorTexture": texture},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.5, "anisotropyTexture": texture},
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 900},
        "KHR_materials_dispersion": {"dispersion": 0.36},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 0.9, 0.8]},
    }));
    assert!(
        all.diagnostics.iter().all(|d| d.severity != Severity::Warning || d.message.contains("TEXCOORD"))
    );
    let m = first(&all);
    assert_eq!(m.textures().count(), 4);
    let layers = m.layers.as_ref().expect("layers");
    let coat = layers.coat.as_ref().expect("a coat");
    assert_eq!((coat.factor, coat.roughness, coat.normal_scale), (0.5, 0.25, 2.0));
    let sheen = layers.sheen.as_ref().expect("a sheen");
    assert_eq!((sheen.color, sheen.roughness), (Vec3::new(1.0, 0.5, 0.0), 0.3));
    let brushed = layers.anisotropy.as_ref().expect("an anisotropy");
    assert_eq!((brushed.strength, brushed.rotation), (0.6, 1.5));
    let film = layers.iridescence.as_ref().expect("a film");
    assert_eq!((film.factor, film.ior, film.thickness), (1.0, 1.8, [100.0, 900.0]));
    let through = layers.diffuse_transmission.as_ref().expect("a leaf");
    assert_eq!((through.factor, through.color), (0.25, Vec3::new(1.0, 0.9, 0.8)));
    assert_eq!(m.dispersion(), 0.36);
    assert!(m.is_see_through());
    assert_eq!(all.summary.materials[0].layers.len(), 6);
    assert!(!all.scene.meshes[0].tangents.is_empty(), "brushed metal needs tangents");
    let none =
        loaded(json!({"KHR_materials_clearcoat": {}, "KHR_materials_sheen": {"sheenRoughnessFactor": 1}}));
    assert!(first(&none).layers.is_none(), "factors of 0 are nothing");
}

#[test]
fn specular_glossiness_replaces_metallic_roughness() {
    let all = loaded(json!({"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 0.125, 1], "specularFactor": [0.2, 0.1, 0.05], "glossinessFactor": 0.75,
        "specularGlossinessTexture": {"index": 0},
    }}));
    let m = first(&all);
    assert_eq!((m.base_color.truncate(), m.metallic, m.roughness), (Vec3::new(0.5, 0.25, 0.125), 0.0, 0.25));
    let f0 = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2) * m.specular_color;
    assert!((f0 - Vec3::new(0.2, 0.1, 0.05)).abs().max_element() < 1e-3, "{f0}");
    assert!(m.glossiness_texture.is_some() && m.specular_color_texture.is_some());
}

#[test]
fn a_leaf_with_a_volume_does_not_refract_and_thin_walls_scatter_at_the_surface() {
    let leaf = loaded(json!({
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.25, 1, 1]},
    }));
    let medium = first(&leaf).medium.as_ref().expect("a medium");
    assert_eq!(medium.ior, 1.0);
    assert!((medium.sigma_a.x - 4.0_f32.ln() / 0.5).abs() < 1e-6);
    let paper = loaded(json!({
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_scatter": {"scatterStrengthFactor": 0.5, "multiscatterColorFactor": [1, 0.5, 0.25], "scatterAnisotropy": -1},
    }));
    let m = first(&paper);
    let thin = m.layers.as_ref().and_then(|l| l.thin_scatter.as_ref()).expect("scattering");
    assert!(m.medium.is_none());
    assert_eq!((thin.strength, thin.color, thin.anisotropy), (0.5, Vec3::new(1.0, 0.5, 0.25), -1.0));
}

/// KHR_materials_ior: an index of zero is infinite, and does not disperse.
#[test]
fn an_infinite_index_does_not_disperse() {
    let glass = |ior: f64| {
        let all =
            loaded(json!({"KHR_materials_ior": {"ior": ior}, "KHR_materials_dispersion": {"dispersion": 1}}));
        first(&all).dispersion()
    };
    assert_eq!([1.5, 0.0].map(glass), [1.0, 0.0]);
}

#[test]
fn variants_replace_materials() {
    let mut b = Builder::with_material(json!({"name": "own"}));
    b.push("materials", json!({"name": "other"}));
    b.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    b.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}});
    b.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}});
    let shown = |variant: Option<&str>| {
        let options = LoadOptions { variant: variant.map(str::to_owned), ..LoadOptions::default() };
        b.load_with(&options).map(|l| l.scene.meshes[0].triangle_materials[0])
    };
    assert_eq!(shown(None).expect("loads"), 0);
    assert_eq!(shown(Some("day")).expect("loads"), 0);
    assert_eq!(shown(Some("night")).expect("loads"), 1);
    assert_eq!(shown(Some("1")).expect("loads"), 1);
    let error = shown(Some("dusk")).expect_err("there is none").to_string();
    assert!(error.contains("\"day\", \"night\""), "{error}");
    assert_eq!(b.loaded().summary.variants, ["day", "night"]);
    b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
        json!(7);
    let options = LoadOptions { variant: Some("night".to_owned()), ..LoadOptions::default() };
    assert!(b.load_with(&options).is_err(), "a material that is not there");
    assert!(
        refused(&Builder::with_material(json!({"extensions": {"KHR_materials_sheen": 3}}))).contains("sheen")
    );
    let bright = loaded(json!({"KHR_materials_clearcoat": {"clearcoatFactor": 2}}));
    let place = "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor";
    assert!(told(&bright, Severity::Warning, place));
}
