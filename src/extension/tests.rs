//! Tests of the extensions, through the loader.

use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use super::*;
use crate::asset::tests::{Builder, refused, told};
use crate::asset::{LoadOptions, Loaded, Severity};
use crate::scene::{MediumDescription, PunctualKind};

const OURS: &str = "NEPHRITE_materials_subsurface";

fn material(extensions: Value) -> Builder {
    let mut b = Builder::with_material(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions,
    }));
    let names: Vec<&String> = extensions.as_object().expect("an object").keys().collect();
    b.json["extensionsUsed"] = json!(names);
    b
}

fn medium(loaded: &Loaded) -> &MediumDescription {
    loaded.scene.materials[0].medium.as_ref().expect("a medium")
}

#[test]
fn subsurface_defaults_are_clear_glass() {
    let loaded = material(json!({OURS: {}})).loaded();
    let (m, inside) = (&loaded.scene.materials[0], medium(&loaded));
    assert_eq!((m.transmission, m.ior, inside.ior), (1.0, 1.5, 1.5));
    assert_eq!((inside.sigma_a, inside.sigma_s), (Vec3::ZERO, Vec3::ZERO));
    assert_eq!((inside.anisotropy, inside.priority), (0.0, 0));
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
}

#[test]
fn subsurface_coefficients_are_per_world_metre() {
    let mut b = material(json!({OURS: {
        "absorptionCoefficient": [1, 2, 3], "scatteringCoefficient": [10, 20, 30], "densityFactor": 2,
        "scatterAnisotropy": -0.5, "ior": 1.3, "priority": -7,
    }}));
    b.json["nodes"] = json!([{"mesh": 0, "scale": [100, 100, 100]}]);
    let loaded = b.loaded();
    let inside = medium(&loaded);
    assert_eq!(inside.sigma_a, Vec3::new(2.0, 4.0, 6.0));
    assert_eq!(inside.sigma_s, Vec3::new(20.0, 40.0, 60.0));
    assert_eq!((inside.anisotropy, inside.ior, inside.priority), (-0.5, 1.3, -7));
    let summary = loaded.summary.materials[0].medium.as_ref().expect("a medium");
    assert!((summary.mean_free_path[0].expect("finite") - 1.0 / 22.0).abs() < 1e-9);
}

#[test]
fn subsurface_index_and_transmission_come_from_where_they_should() {
    for (extensions, ior, transmission) in [
        (json!({OURS: {}, "KHR_materials_ior": {"ior": 1.7}}), 1.7, 1.0),
        (json!({OURS: {"ior": 1.2}, "KHR_materials_ior": {"ior": 1.7}}), 1.2, 1.0),
        (json!({OURS: {"ior": 1e300}, "KHR_materials_ior": {"ior": 1.7}}), 1e4, 1.0),
        (json!({OURS: {}, "KHR_materials_transmission": {"transmissionFactor": 0.25}}), 1.5, 0.25),
        (json!({OURS: {}, "KHR_materials_transmission": {}}), 1.5, 0.0),
        (json!({OURS: {}, "KHR_materials_ior": {"ior": 0}}), 1.5, 1.0),
    ] {
        let loaded = material(extensions.clone()).loaded();
        let m = &loaded.scene.materials[0];
        assert_eq!((m.ior, medium(&loaded).ior, m.transmission), (ior, ior, transmission), "{extensions}");
    }
}

#[test]
fn subsurface_refuses_what_cannot_be() {
    let place = format!("/materials/0/extensions/{OURS}");
    for (own, expected) in [
        (json!({"ior": 0.5}), "/ior: 0.5 is below 1"),
        (json!({"ior": "glass"}), "/ior: \"glass\" where a number is expected"),
        (json!({"absorptionCoefficient": [-1, 0, 0]}), "/absorptionCoefficient: -1 is below 0"),
        (json!({"scatteringCoefficient": [1, 2]}), "/scatteringCoefficient: 2 numbers where 3 are expected"),
        (json!({"densityFactor": -0.1}), "/densityFactor: -0.1 is below 0"),
        (json!({"scatterAnisotropy": 1}), "/scatterAnisotropy: 1 is not below 1"),
        (json!({"scatterAnisotropy": -1.5}), "/scatterAnisotropy: -1.5 is not above -1"),
        (json!({"priority": 0.5}), "/priority: 0.5 is not an integer of 32 bits"),
        (json!([]), ": an array where an object is expected"),
    ] {
        assert_eq!(refused(&material(json!({OURS: own}))), format!("{place}{expected}"));
    }
}

#[test]
fn subsurface_tells_of_misspelt_keys() {
    let b = material(json!({OURS: {"scatterCoefficient": [1, 1, 1]}}));
    let loaded = b.loaded();
    let place = format!("/materials/0/extensions/{OURS}/scatterCoefficient");
    let told = loaded.diagnostics.iter().find(|d| d.pointer == place).expect("a warning");
    assert_eq!(told.severity, Severity::Warning);
    assert!(told.message.contains("`scatteringCoefficient`"), "{}", told.message);
    assert!(b.load_with(&LoadOptions { strict: true, ..LoadOptions::default() }).is_err());
}

#[test]
fn subsurface_warns_of_what_hides_it() {
    let mut b = material(json!({OURS: {}}));
    b.json["materials"][0]["alphaMode"] = json!("BLEND");
    b.json["materials"][0]["pbrMetallicRoughness"] = json!({"baseColorFactor": [0.1, 0.2, 0.3, 1]});
    let loaded = b.loaded();
    for place in ["alphaMode", "pbrMetallicRoughness/metallicFactor", "pbrMetallicRoughness/baseColorFactor"]
    {
        assert!(told(&loaded, Severity::Warning, &format!("/materials/0/{place}")), "{place}");
    }
}

#[test]
fn subsurface_wins_over_volume() {
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [0.5, 0.5, 0.5]});
    let both = material(json!({
        OURS: {"scatteringCoefficient": [1, 1, 1]}, "KHR_materials_volume": volume,
        "KHR_materials_transmission": {"transmissionFactor": 1},
    }));
    let loaded = both.loaded();
    assert_eq!((medium(&loaded).sigma_a, medium(&loaded).sigma_s), (Vec3::ZERO, Vec3::ONE));
}

#[test]
fn volume_is_an_absorbing_medium_behind_transmission() {
    let with = |volume: Value, transmission: f64| {
        let b = material(json!({
            "KHR_materials_volume": volume, "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_transmission": {"transmissionFactor": transmission},
        }));
        b.loaded()
    };
    let loaded = with(
        json!({"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.25, 1, 0]}),
        1.0,
    );
    let inside = medium(&loaded);
    assert!((inside.sigma_a.x - 4.0_f32.ln() / 0.5).abs() < 1e-6, "{}", inside.sigma_a);
    assert_eq!((inside.sigma_a.y, inside.sigma_s, inside.ior), (0.0, Vec3::ZERO, 1.33));
    assert!(inside.sigma_a.z.is_finite() && inside.sigma_a.z > 100.0);
    let clear = with(json!({"thicknessFactor": 1, "attenuationColor": [0.25, 1, 0]}), 1.0);
    assert_eq!(medium(&clear).sigma_a, Vec3::ZERO, "an infinite distance is clear");
    assert!(with(json!({"attenuationDistance": 0.5}), 1.0).scene.materials[0].medium.is_none(), "thin wall");
    assert!(with(json!({"thicknessFactor": 1}), 0.0).scene.materials[0].medium.is_none(), "nothing gets in");
}

#[test]
fn scattering_drafts_split_the_extinction_of_the_volume() {
    let with = |drafts: Value| {
        let mut extensions = json!({
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.1, "attenuationColor": [0.5, 0.5, 0.5]},
            "KHR_materials_transmission": {"transmissionFactor": 1},
        });
        let all = extensions.as_object_mut().expect("an object");
        all.extend(drafts.as_object().expect("an object").clone());
        material(extensions).loaded()
    };
    let sigma_t = std::f32::consts::LN_2 / 0.1;
    // s(0.5) = 0.297138: ρss = (1 − s²)/(1 − g s²) = 0.911709 for g = 0 and 0.953816 for g = 0.5
    for (drafts, albedo, g) in [
        (
            json!({"KHR_materials_volume_scatter": {"multiscatterColor": [0.5, 1, 0], "scatterAnisotropy": 0.5}}),
            0.911_709,
            0.5,
        ),
        (
            json!({"KHR_materials_scatter": {"multiscatterColorFactor": [1, 1, 0], "scatterStrengthFactor": 0.5, "scatterAnisotropy": 0.5}}),
            0.953_816,
            0.5,
        ),
        (
            json!({
                "KHR_materials_scatter": {"multiscatterColorFactor": [0.5, 1, 0], "scatterStrengthFactor": 1},
                "KHR_materials_volume_scatter": {"multiscatterColorFactor": [0.9, 0.9, 0.9], "scatterAnisotropy": 0.5},
            }),
            0.911_709,
            0.0,
        ),
    ] {
        let loaded = with(drafts.clone());
        let inside = medium(&loaded);
        assert!(
            (inside.sigma_s.x / sigma_t - albedo).abs() < 2e-6,
            "{drafts}: {}",
            inside.sigma_s.x / sigma_t
        );
        assert_eq!(inside.anisotropy, g);
        let sum = inside.sigma_a + inside.sigma_s;
        assert!((sum - Vec3::splat(sigma_t)).abs().max_element() < 1e-5 * sigma_t, "{sum}");
        assert!(inside.sigma_s.z < 1e-4 * sigma_t);
    }
    let off = with(json!({"KHR_materials_scatter": {"multiscatterColorFactor": [1, 1, 1]}}));
    assert_eq!(medium(&off).sigma_s, Vec3::ZERO, "the default strength is 0");
    let wild = with(json!({"KHR_materials_scatter": {"scatterStrengthFactor": 1, "scatterAnisotropy": 1}}));
    assert!(medium(&wild).anisotropy < 1.0);
    assert!(told(
        &wild,
        Severity::Warning,
        "/materials/0/extensions/KHR_materials_scatter/scatterAnisotropy"
    ));
    let thin = material(json!({"KHR_materials_scatter": {"scatterStrengthFactor": 1}})).loaded();
    assert!(told(&thin, Severity::Warning, "/materials/0/extensions/KHR_materials_scatter"));
}

#[test]
fn surface_extensions() {
    let mut b = material(json!({
        "KHR_materials_emissive_strength": {"emissiveStrength": 5}, "KHR_materials_unlit": {},
        "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 0.5, 2]},
        "KHR_materials_ior": {"ior": 0},
    }));
    b.json["materials"][0]["emissiveFactor"] = json!([1, 0.5, 0.25]);
    let loaded = b.loaded();
    let m = &loaded.scene.materials[0];
    assert_eq!(m.emission, Vec3::new(5.0, 2.5, 1.25));
    assert_eq!((m.specular, m.specular_color, m.unlit), (0.5, Vec3::new(1.0, 0.5, 2.0), true));
    assert!(((m.ior - 1.0) / (m.ior + 1.0)).powi(2) > 0.999);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
}

#[test]
fn texture_transform_as_the_specifications_example() {
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
    let half_pi = std::f64::consts::FRAC_PI_2;
    let mut b = Builder::with_material(json!({"emissiveTexture": {"index": 0, "texCoord": 1, "extensions": {
        "KHR_texture_transform": {"offset": [0, 1], "rotation": half_pi, "scale": [0.5, 0.5], "texCoord": 0}}}}));
    b.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    b.push("images", json!({"uri": png}));
    b.push("textures", json!({"source": 0}));
    let loaded = b.loaded();
    let slot = loaded.scene.materials[0].emission_texture.expect("a texture");
    assert_eq!(slot.uv_set, 0);
    // "only the lower left quadrant of the source image, rotated clockwise 90°"
    for (uv, expected) in [
        (Vec2::new(0.0, 0.0), Vec2::new(0.0, 1.0)),
        (Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.5)),
        (Vec2::new(0.0, 1.0), Vec2::new(0.5, 1.0)),
        (Vec2::new(1.0, 1.0), Vec2::new(0.5, 0.5)),
    ] {
        let found = slot.transform.transform_point2(uv);
        assert!((found - expected).length() < 1e-6, "{uv} became {found} instead of {expected}");
    }
}

#[test]
fn lights_shine_along_minus_z_whatever_the_scale() {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    b.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 4, "name": "sun"},
        {"type": "spot", "spot": {"outerConeAngle": 0.5}},
        {"type": "point", "range": 3},
        {"type": "spot", "spot": {"innerConeAngle": 2, "outerConeAngle": 0}},
        {"type": "laser"},
    ]}});
    let light = |i: usize| json!({"KHR_lights_punctual": {"light": i}});
    let turn = glam::Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    b.json["nodes"] = json!([
        {"extensions": light(0), "rotation": turn.to_array(), "scale": [5, 5, 5]},
        {"extensions": light(1), "translation": [1, 2, 3]},
        {"extensions": light(2)},
        {"extensions": light(3)},
        {"extensions": light(4)},
    ]);
    b.json["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4]}]);
    let loaded = b.loaded();
    let lights = &loaded.scene.lights;
    assert_eq!(lights.len(), 4);
    assert_eq!((&*lights[0].name, lights[0].intensity), ("sun", Vec3::new(4.0, 2.0, 0.0)));
    assert!((lights[0].direction - Vec3::NEG_Y).length() < 1e-6);
    assert_eq!(lights[1].kind, PunctualKind::Spot { inner: 0.0, outer: 0.5 });
    assert_eq!((lights[1].position, lights[1].direction), (Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Z));
    assert_eq!((&lights[2].kind, lights[2].range), (&PunctualKind::Point, Some(3.0)));
    assert!(told(&loaded, Severity::Warning, "/extensions/KHR_lights_punctual/lights/3/spot"));
    assert!(told(&loaded, Severity::Warning, "/extensions/KHR_lights_punctual/lights/4/type"));
    b.json["nodes"][0]["extensions"] = light(9);
    assert!(refused(&b).starts_with("/nodes/0/extensions/KHR_lights_punctual/light: "));
}

#[test]
fn instancing_and_visibility() {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_node_visibility"]);
    let moved = b.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    b.json["nodes"] = json!([
        {"mesh": 0, "scale": [2, 2, 2], "children": [1],
         "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moved}}}},
        {"children": [2], "extensions": {"KHR_node_visibility": {"visible": false}}},
        {"mesh": 0, "camera": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
    ]);
    b.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    let scene = b.loaded().scene;
    assert_eq!(scene.cameras.len(), 1, "cameras are not hidden");
    let places: Vec<Vec3> = scene.instances.iter().map(|i| i.transform.translation.into()).collect();
    assert_eq!(places, [Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)]);
}

/// A plug-in of somebody else's, which claims media more weakly than the standard ones.
struct Fog;

impl Extension for Fog {
    fn name(&self) -> &str {
        "USER_fog"
    }
    fn order(&self) -> i32 {
        order::VOLUME - 1
    }
    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let sigma = loader.factor(own, "sigma", 1.0, 0.0..=10.0)?;
        out.transmission = 1.0;
        out.medium = Some(MediumDescription {
            sigma_a: Vec3::ZERO,
            sigma_s: Vec3::splat(sigma),
            anisotropy: 0.0,
            ior: 1.0,
            priority: 0,
            absorption_texture: None,
            scattering_texture: None,
            multi_scatter: None,
        });
        Ok(())
    }
}

#[test]
fn users_register_their_own_and_order_decides() {
    let mut options = LoadOptions::default();
    options.registry.register(Box::new(Fog));
    let alone = material(json!({"USER_fog": {"sigma": 3}}));
    let loaded = alone.load_with(&options).expect("loads");
    assert_eq!(medium(&loaded).sigma_s, Vec3::splat(3.0));
    assert!(loaded.summary.extensions[0].supported);
    assert!(alone.loaded().scene.materials[0].medium.is_none(), "unknown without the plug-in");
    let both = material(json!({"USER_fog": {"sigma": 3}, OURS: {}}));
    assert_eq!(medium(&both.load_with(&options).expect("loads")).sigma_s, Vec3::ZERO);
    let names: Vec<&str> = options.registry.iter().map(Extension::name).collect();
    assert_eq!(names.last(), Some(&OURS));
    let before = names.len();
    options.registry.register(Box::new(Fog));
    assert_eq!(options.registry.iter().count(), before, "the same name replaces");
}
