//! Core materials, textures and images.

use glam::{Vec3, Vec4};

use super::*;
use crate::scene::{AlphaMode, ColorSpace, ImagePixels, Wrap};

/// One pixel: red, half transparent.
fn png(color: ::image::ColorType, data: &[u8]) -> Vec<u8> {
    use ::image::ImageEncoder;
    let mut bytes = Vec::new();
    let encoder = ::image::codecs::png::PngEncoder::new(&mut bytes);
    encoder.write_image(data, 1, 1, color.into()).expect("encodes");
    bytes
}

fn textured(bytes: &[u8]) -> Builder {
    let mut b = Builder::with_material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let view = b.view(bytes);
    b.push("images", json!({"bufferView": view, "mimeType": "image/png", "name": "skin"}));
    b.push("textures", json!({"source": 0}));
    b
}

#[test]
fn every_core_property() {
    let mut b = textured(&png(::image::ColorType::Rgba8, &[255, 0, 0, 128]));
    b.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}]);
    b.json["textures"] = json!([{"source": 0}, {"source": 0, "sampler": 0}]);
    b.json["materials"] = json!([{
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.25,
            "baseColorTexture": {"index": 0, "texCoord": 1}, "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 1, "scale": 0.5},
        "occlusionTexture": {"index": 1},
        "emissiveFactor": [1, 0.5, 0], "emissiveTexture": {"index": 0},
        "alphaMode": "MASK", "alphaCutoff": 0.75, "doubleSided": true,
    }]);
    let scene = b.loaded().scene;
    let m = &scene.materials[0];
    assert_eq!((&*m.name, &*m.pointer), ("all", "/materials/0"));
    assert_eq!(m.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((m.metallic, m.roughness, m.normal_scale), (0.5, 0.25, 0.5));
    assert_eq!(m.emission, Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(m.alpha_mode, AlphaMode::Mask(0.75));
    assert!(m.double_sided && !m.unlit && m.medium.is_none());
    let base = m.base_color_texture.expect("a texture");
    assert_eq!((base.uv_set, base.color_space), (1, ColorSpace::Srgb));
    let roughness = m.metallic_roughness_texture.expect("a texture");
    assert_eq!(roughness.color_space, ColorSpace::Linear);
    let texture = scene.textures[roughness.texture];
    assert_eq!((texture.wrap_u, texture.wrap_v), (Wrap::ClampToEdge, Wrap::MirroredRepeat));
    assert!(!texture.linear_filter && scene.textures[base.texture].linear_filter);
    assert_eq!(scene.images.len(), 1, "images are shared");
    assert!(matches!(&scene.images[0].pixels, ImagePixels::Rgba8(p) if p[..] == [255, 0, 0, 128]));
    assert_eq!(scene.images[0].name, "skin");
}

#[test]
fn grey_and_deep_images() {
    let grey = textured(&png(::image::ColorType::L8, &[7])).loaded();
    assert!(matches!(&grey.scene.images[0].pixels, ImagePixels::Rgba8(p) if p[..] == [7, 7, 7, 255]));
    let deep = textured(&png(::image::ColorType::Rgb16, &[1, 2, 3, 4, 5, 6])).loaded();
    let expected =
        [u16::from_ne_bytes([1, 2]), u16::from_ne_bytes([3, 4]), u16::from_ne_bytes([5, 6]), 65535];
    assert!(matches!(&deep.scene.images[0].pixels, ImagePixels::Rgba16(p) if p[..] == expected));
}

#[test]
fn an_image_that_cannot_be_decoded_leaves_the_factor() {
    let whole = png(::image::ColorType::Rgba8, &[255, 0, 0, 128]);
    for bytes in [&whole[..whole.len() / 2], b"GIF89a and so on", b"hello", b"\xFF\xD8\xFF\xFF\xFF"] {
        let loaded = textured(bytes).loaded();
        assert!(loaded.scene.materials[0].base_color_texture.is_none());
        assert!(told(&loaded, Severity::Warning, "/images/0"), "{:?}", loaded.diagnostics);
    }
    let mut missing = textured(&whole);
    missing.json["images"] = json!([{"uri": "not-there.png"}]);
    let loaded = missing.loaded();
    assert!(loaded.scene.materials[0].base_color_texture.is_none());
    assert!(told(&loaded, Severity::Warning, "/images/0/uri"));
    missing.json["textures"] = json!([{}]);
    assert!(told(&missing.loaded(), Severity::Warning, "/textures/0"));
}

#[test]
fn a_wrong_media_type_is_told_and_the_bytes_are_believed() {
    let mut b = textured(&png(::image::ColorType::Rgba8, &[255, 0, 0, 128]));
    b.json["images"][0]["mimeType"] = json!("image/jpeg");
    let loaded = b.loaded();
    assert!(loaded.scene.materials[0].base_color_texture.is_some());
    assert!(told(&loaded, Severity::Warning, "/images/0/mimeType"));
}

#[test]
fn image_bombs_are_measured_before_they_are_decoded() {
    let mut bomb = png(::image::ColorType::Rgba8, &[255, 0, 0, 128]);
    bomb[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 0, 0x80, 0]);
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    match textured(&bomb).load() {
        Err(AssetError::Limit { field, needed, .. }) => {
            assert_eq!((field, needed), ("image_bytes", 4 << 30));
        }
        other => panic!("{other:?}"),
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn values_out_of_range_are_clamped_with_a_warning() {
    let b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1e30, -1, 0.5], "metallicFactor": 2, "roughnessFactor": -1},
        "alphaMode": "MASK", "alphaCutoff": -1,
    }));
    let loaded = b.loaded();
    let m = &loaded.scene.materials[0];
    assert_eq!((m.base_color, m.metallic, m.roughness), (Vec4::new(1.0, 0.0, 0.5, 1.0), 1.0, 0.0));
    assert!(told(&loaded, Severity::Warning, "/materials/0/pbrMetallicRoughness/metallicFactor"));
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    assert!(b.load_with(&strict).is_err());
    let bright = Builder::with_material(json!({"emissiveFactor": [5, 0, 0]})).loaded();
    assert_eq!(bright.scene.materials[0].emission, Vec3::new(5.0, 0.0, 0.0), "as viewers show it");
    assert!(told(&bright, Severity::Warning, "/materials/0/emissiveFactor"));
    for (material, pointer) in [
        (json!({"alphaMode": "FOO"}), "/materials/0/alphaMode: "),
        (
            json!({"pbrMetallicRoughness": {"roughnessFactor": "rough"}}),
            "/materials/0/pbrMetallicRoughness/roughnessFactor: ",
        ),
        (json!({"normalTexture": {"index": 9}}), "/materials/0/normalTexture/index: "),
        (json!({"normalTexture": {}}), "/materials/0/normalTexture/index: "),
        (json!([]), "/materials/0: "),
    ] {
        let message = refused(&Builder::with_material(material));
        assert!(message.starts_with(pointer), "{message}");
    }
}

#[test]
fn a_texture_coordinate_set_that_is_not_there_is_told() {
    let b = textured(&png(::image::ColorType::Rgba8, &[255, 0, 0, 128]));
    assert!(told(&b.loaded(), Severity::Warning, "/meshes/0/primitives/0/attributes"));
}
