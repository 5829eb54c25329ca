//! Tests of the scattering drafts: textures in volumes, spellings, and what cannot be.

use glam::Vec3;
use serde_json::{Value, json};

use crate::asset::tests::{Builder, told};
use crate::asset::{Loaded, Severity};
use crate::optics::albedo::single_from_multiple;
use crate::scene::Scene;
use crate::subsurface::TexturedMedium;
use crate::transport::Enclosure;

const SCATTER: &str = "/materials/0/extensions/KHR_materials_scatter";

/// A triangle whose material has a volume that attenuates to `color` over 0.1 m and the given extensions, with an image of one
/// texel.
fn volume(color: [f32; 3], texel: [u8; 4], extensions: Value) -> Loaded {
    let mut all = json!({
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.1, "attenuationColor": color},
    });
    all.as_object_mut().expect("an object").extend(extensions.as_object().expect("an object").clone());
    let mut b =
        Builder::with_material(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": all}));
    let names: Vec<&String> = all.as_object().expect("an object").keys().collect();
    b.json["extensionsUsed"] = json!(names);
    let uv = b.floats("VEC2", &[0.0; 6]);
    b.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    let mut png = Vec::new();
    let encoder = ::image::codecs::png::PngEncoder::new(&mut png);
    ::image::ImageEncoder::write_image(encoder, &texel, 1, 1, ::image::ColorType::Rgba8.into())
        .expect("a PNG");
    let view = b.view(&png);
    b.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    b.push("textures", json!({"source": 0}));
    b.loaded()
}

/// σa and σs at a point near the triangle.
fn coefficients(loaded: Loaded) -> (Vec3, Vec3) {
    let scene = Scene::build(loaded.scene).expect("a scene");
    let enclosure = Enclosure { instance: 0, material: 0, rank: 1 };
    TexturedMedium::new(&scene, enclosure).coefficients(Vec3::new(0.2, 0.2, -0.1))
}

#[test]
fn textures_multiply_the_multi_scatter_albedo_and_leave_the_extinction() {
    // 188 in sRGB is 0.5029 in linear light; the colour of the strength texture and the alpha of the other do not count.
    let srgb = |byte: u8| ((f32::from(byte) / 255.0 + 0.055) / 1.055).powf(2.4);
    let texel = [188, 255, 128, 51];
    let (color, alpha) = (Vec3::new(srgb(188), 1.0, srgb(128)), 51.0 / 255.0);
    let factor = Vec3::new(1.0, 0.5, 0.25);
    let sigma_t = std::f32::consts::LN_2 / 0.1;
    let index = json!({"index": 0});
    for (mut own, rho, g) in [
        (json!({"multiscatterColorTexture": index}), factor * 0.5 * color, 0.0),
        (json!({"scatterStrengthTexture": index}), factor * 0.5 * alpha, 0.0),
        (json!({"scatterTexture": index}), factor * 0.5 * alpha, 0.0),
        (
            json!({"scatterStrengthTexture": index, "multiscatterColorTexture": index, "scatterAnisotropy": 0.5}),
            factor * 0.5 * color * alpha,
            0.5,
        ),
    ] {
        own["scatterStrengthFactor"] = json!(0.5);
        own["multiscatterColorFactor"] = json!([1, 0.5, 0.25]);
        let loaded = volume([0.5; 3], texel, json!({"KHR_materials_scatter": own}));
        assert!(
            !loaded.diagnostics.iter().any(|d| d.message.contains("ignored")),
            "{:?}",
            loaded.diagnostics
        );
        let (sigma_a, sigma_s) = coefficients(loaded);
        let expected = sigma_t * rho.map(|r| single_from_multiple(r, g));
        assert!((sigma_s - expected).abs().max_element() < 2e-3 * sigma_t, "{own}: {sigma_s} {expected}");
        assert!((sigma_a + sigma_s - sigma_t).abs().max_element() < 1e-5 * sigma_t);
    }
    let older = json!({"multiscatterColorFactor": [1, 1, 1], "multiscatterColorTexture": index, "scatterAnisotropy": 0.5});
    let (_, sigma_s) = coefficients(volume([0.5; 3], texel, json!({"KHR_materials_volume_scatter": older})));
    let expected = sigma_t * color.map(|r| single_from_multiple(r, 0.0));
    assert!((sigma_s - expected).abs().max_element() < 2e-3 * sigma_t, "{sigma_s} {expected}");
}

#[test]
fn older_spellings_are_told() {
    let own = json!({"scatterFactor": 1, "scatterTexture": {"index": 0}});
    let loaded = volume([0.5; 3], [255; 4], json!({"KHR_materials_scatter": own}));
    for key in ["scatterFactor", "scatterTexture"] {
        assert!(told(&loaded, Severity::Warning, &format!("{SCATTER}/{key}")), "{:?}", loaded.diagnostics);
    }
}

#[test]
fn channels_that_cannot_scatter_are_told() {
    let own = json!({"scatterStrengthFactor": 1, "multiscatterColorFactor": [1, 1, 0]});
    let loaded = volume([1.0, 0.5, 1.0], [255; 4], json!({"KHR_materials_scatter": own}));
    let told: Vec<_> = loaded.diagnostics.iter().filter(|d| d.pointer == SCATTER).collect();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].message.starts_with("red cannot scatter"), "{}", told[0]);
    let fine = volume([0.5; 3], [255; 4], json!({"KHR_materials_scatter": own}));
    assert!(!fine.diagnostics.iter().any(|d| d.pointer == SCATTER), "{:?}", fine.diagnostics);
}

#[test]
fn what_the_draft_excludes_and_dispersion_are_told() {
    for name in ["KHR_materials_volume_scatter", "KHR_materials_diffuse_transmission", "KHR_materials_unlit"]
    {
        let loaded = volume([0.5; 3], [255; 4], json!({"KHR_materials_scatter": {}, name: {}}));
        let is_told = loaded.diagnostics.iter().any(|d| d.pointer == SCATTER && d.message.contains(name));
        assert!(is_told, "{name}: {:?}", loaded.diagnostics);
    }
    let pointer = "/materials/0/extensions/KHR_materials_dispersion";
    for (strength, is_told) in [(1, true), (0, false)] {
        let extensions = json!({
            "KHR_materials_scatter": {"scatterStrengthFactor": strength}, "KHR_materials_dispersion": {"dispersion": 1},
        });
        let loaded = volume([0.5; 3], [255; 4], extensions);
        assert_eq!(told(&loaded, Severity::Note, pointer), is_told, "{:?}", loaded.diagnostics);
    }
}
