//! Area lights, measured lights and lenses as the loader reads them.

use serde_json::{Value, json};

use crate::asset::tests::{Builder, refused, told};
use crate::asset::{Asset, LoadOptions, Loaded, Moment, Severity};
use crate::scene::{AreaLight, AreaShape, Lens, PunctualKind};
use base64::Engine;
use glam::{Vec2, Vec3};

/// A triangle, and lights of an extension, each at a node as given.
fn lit(extension: &str, lights: Value, nodes: &[Value]) -> Builder {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!([extension]);
    b.json["extensions"] = json!({ extension: { "lights": lights } });
    b.json["nodes"] = json!([[json!({"mesh": 0})].as_slice(), nodes].concat());
    b.json["scenes"] = json!([{"nodes": (0..=nodes.len()).collect::<Vec<_>>()}]);
    b
}

fn at(extension: &str, own: Value, more: Value) -> Value {
    let mut node = more;
    node["extensions"] = json!({ extension: own });
    node
}

const AREA: &str = "EXT_lights_area";
const IES: &str = "EXT_lights_ies";

fn area(lights: Value, node: Value) -> Loaded {
    lit(AREA, lights, &[at(AREA, json!({"light": 0}), node)]).loaded()
}

fn only(loaded: &Loaded) -> &AreaLight {
    assert_eq!(loaded.scene.area_lights.len(), 1, "{:?}", loaded.diagnostics);
    &loaded.scene.area_lights[0]
}

#[test]
fn area_lights_have_the_values_and_defaults_of_the_draft() {
    let turn = glam::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let loaded = area(
        json!([{"type": "rect", "color": [1, 0.5, 0], "intensity": 300, "size": 0.5, "rect": {"aspect": 3}, "name": "panel"}]),
        json!({"translation": [1, 2, 3], "rotation": turn.to_array(), "scale": [1, -4, 2]}),
    );
    let light = only(&loaded);
    assert_eq!((light.shape, &*light.name), (AreaShape::Rectangle, "panel"));
    assert_eq!((light.radiance, light.size), (Vec3::new(300.0, 150.0, 0.0), Vec2::new(6.0, 2.0)));
    // A quarter turn about Y takes −Z to −X.
    assert!((light.transform.transform_vector3(Vec3::NEG_Z) - Vec3::NEG_X).length() < 1e-6);
    assert!((Vec3::from(light.transform.translation) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
    assert!((light.transform.matrix3.determinant() - 1.0).abs() < 1e-5, "never mirrored");
    let summary = &loaded.summary.lights[0];
    assert_eq!((summary.kind, summary.size), ("rect", Some([6.0, 2.0])));
    let lumens = summary.power.expect("known");
    assert!((lumens[0] - 300.0 * 12.0 * std::f32::consts::PI).abs() < 0.1);
    assert!(loaded.scene.instances.len() == 1 && loaded.summary.materials.is_empty(), "it is no object");

    let loaded = area(json!([{"type": "disk"}]), json!({"name": "spot"}));
    let light = only(&loaded);
    assert_eq!((light.radiance, light.size, light.shape), (Vec3::splat(1000.0), Vec2::ONE, AreaShape::Disk));
    assert_eq!(light.name, "spot");
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    // Scales that leave a direction leave a light.
    assert_eq!(only(&area(json!([{"type": "disk"}]), json!({"scale": [2, 3, 0]}))).size, Vec2::splat(3.0));
    assert_eq!(only(&area(json!([{"type": "disk"}]), json!({"scale": [0, 0, 3]}))).size, Vec2::splat(3.0));
}

#[test]
fn area_lights_in_earlier_spellings() {
    let loaded = area(
        json!([{"shape": "rect", "luminance": 20, "width": 3, "height": 2}]),
        json!({"scale": [2, 2, 2]}),
    );
    let light = only(&loaded);
    assert_eq!((light.radiance, light.size), (Vec3::splat(20.0), Vec2::new(6.0, 4.0)));
    assert!(told(&loaded, Severity::Note, "/extensions/EXT_lights_area/lights/0"));
    assert_eq!(only(&area(json!([{"shape": "disk", "radius": 0.25}]), json!({}))).size, Vec2::splat(0.5));
    assert_eq!(only(&area(json!([{"shape": "disk"}]), json!({}))).size, Vec2::splat(2.0), "a radius of 1");
    assert_eq!(only(&area(json!([{"shape": "disk", "size": 3}]), json!({}))).size, Vec2::splat(3.0));
}

#[test]
fn area_lights_that_make_no_sense_are_told_of() {
    let cases = [
        (json!({"type": "sphere"}), "/type", 0),
        (json!({"type": "disk", "size": 0}), "/size", 0),
        (json!({"type": "disk", "size": -1}), "/size", 0),
        (json!({"type": "rect", "rect": {"aspect": 0}}), "/rect/aspect", 0),
        (json!({}), "", 1),
        (json!({"type": "disk", "color": [2, 1, 1]}), "/color", 1),
        (json!({"type": "disk", "intensity": -3}), "/intensity", 0),
    ];
    for (light, pointer, count) in cases {
        let b = lit(AREA, json!([light]), &[at(AREA, json!({"light": 0}), json!({}))]);
        let loaded = b.loaded();
        let pointer = format!("/extensions/EXT_lights_area/lights/0{pointer}");
        assert!(told(&loaded, Severity::Warning, &pointer), "{pointer}: {:?}", loaded.diagnostics);
        assert_eq!(loaded.scene.area_lights.len(), count, "{pointer}");
        assert!(b.load_with(&LoadOptions { strict: true, ..LoadOptions::default() }).is_err());
    }
    for (scale, translation) in [([0.0; 3], [0.0; 3]), ([1e12; 3], [0.0; 3]), ([1.0; 3], [0.0, 1e12, 0.0])] {
        let loaded = area(json!([{"type": "disk"}]), json!({"scale": scale, "translation": translation}));
        assert!(told(&loaded, Severity::Warning, "/nodes/1") && loaded.scene.area_lights.is_empty());
    }
    let off = area(json!([{"type": "disk", "intensity": 0}]), json!({}));
    assert!(off.scene.area_lights.is_empty() && off.diagnostics.is_empty());
    let missing = lit(AREA, json!([]), &[at(AREA, json!({"light": 0}), json!({}))]);
    assert!(refused(&missing).starts_with("/nodes/1/extensions/EXT_lights_area/light: "));
    let wrong =
        lit(AREA, json!([{"type": "disk", "size": "1"}]), &[at(AREA, json!({"light": 0}), json!({}))]);
    assert!(refused(&wrong).starts_with("/extensions/EXT_lights_area/lights/0/size: "));
    // Many are counted, as objects are.
    let nodes = vec![at(AREA, json!({"light": 0}), json!({})); 9];
    let many = lit(AREA, json!([{"type": "disk"}]), &nodes);
    let mut options = LoadOptions::default();
    options.limits.instances = 5;
    assert!(many.load_with(&options).expect_err("too many").to_string().contains("the limit is 5"));
    options = LoadOptions::default();
    options.limits.triangles = 64 * 8;
    assert!(many.load_with(&options).is_err());
}

/// Twice as bright ahead as at 60°, nothing beyond 90°; 40 cd after the multiplier.
const PROFILE: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 2 3 1 1 2 0 0 0 1 1 10\n0 60 90\n0\n20 10 0\n";

fn data(text: &str) -> String {
    let text = base64::engine::general_purpose::STANDARD.encode(text);
    format!("data:application/x-ies-lm-63;base64,{text}")
}

#[test]
fn measured_lights_are_read_from_uris_and_buffer_views() {
    let own = json!({"light": 0, "multiplier": 3, "color": [1, 0.5, 0]});
    let mut b = lit(
        IES,
        json!([{"uri": data(PROFILE)}]),
        &[
            at(IES, own, json!({"translation": [0, 5, 0], "scale": [9, 9, 9]})),
            at(IES, json!({"light": 1}), json!({"name": "b"})),
        ],
    );
    let view = b.view(PROFILE.as_bytes());
    let lights = b.json["extensions"][IES]["lights"].as_array_mut().expect("an array");
    lights.push(json!({"bufferView": view, "mimeType": "application/x-ies-lm-63"}));
    let loaded = b.loaded();
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let [a, plain] = &loaded.scene.lights[..] else { panic!("two lights") };
    assert_eq!((a.intensity, a.position), (Vec3::new(120.0, 60.0, 0.0), Vec3::new(0.0, 5.0, 0.0)));
    assert_eq!((plain.intensity, &*plain.name), (Vec3::splat(40.0), "b"));
    let PunctualKind::Web(web) = &a.kind else { panic!("a web") };
    let (sin, cos) = 60f32.to_radians().sin_cos();
    assert!((web.relative(Vec3::NEG_Z) - 1.0).abs() < 1e-6);
    assert!((web.relative(Vec3::new(0.0, sin, -cos)) - 0.5).abs() < 1e-5);
    assert!((web.relative(Vec3::new(sin, 0.0, -cos)) - 0.5).abs() < 1e-5);
    // ∫ over the cap: from 1 to 1/2 in 60°, then to 0 in 30°, times 2π sin.
    let piece = |a: f64, b: f64, from: f64, to: f64| {
        let (v0, v1) = (from.to_radians(), to.to_radians());
        a * v0.cos() - b * v1.cos() + (b - a) / (v1 - v0) * (v1.sin() - v0.sin())
    };
    let lumens = 40.0 * std::f64::consts::TAU * (piece(1.0, 0.5, 0.0, 60.0) + piece(0.5, 0.0, 60.0, 90.0));
    let told = loaded.summary.lights[1].power.expect("known")[0];
    assert!((f64::from(told) / lumens - 1.0).abs() < 1e-5, "{told} {lumens}");
    assert_eq!(loaded.summary.lights[0].kind, "ies");
}

#[test]
fn broken_light_profiles_are_errors_that_say_where() {
    let with = |light: Value| lit(IES, json!([light]), &[at(IES, json!({"light": 0}), json!({}))]);
    let text = refused(&with(json!({"uri": data("no profile")})));
    assert!(
        text.starts_with("/extensions/EXT_lights_ies/lights/0/uri: ") && text.contains("TILT="),
        "{text}"
    );
    let text = refused(&with(json!({"uri": data(&PROFILE.replace("20 10 0", "20 x 0"))})));
    assert!(text.contains("line 6: `x`"), "{text}");
    assert!(
        refused(&with(json!({"uri": "missing.ies"}))).starts_with("/extensions/EXT_lights_ies/lights/0/uri")
    );
    assert!(
        refused(&with(json!({"bufferView": 77}))).starts_with("/extensions/EXT_lights_ies/lights/0/buffer")
    );
    let invalid = |light: Value, pointer: &str, lights: usize| {
        let loaded = with(light).loaded();
        let pointer = format!("/extensions/EXT_lights_ies/lights/0{pointer}");
        assert!(told(&loaded, Severity::Warning, &pointer), "{:?}", loaded.diagnostics);
        assert_eq!(loaded.scene.lights.len(), lights);
    };
    invalid(json!({}), "", 0);
    invalid(json!({"uri": data(PROFILE), "mimeType": "text/plain"}), "/mimeType", 1);
    invalid(json!({"uri": data(&PROFILE.replace("20 10 0", "20 -10 0"))}), "/uri", 1);
    invalid(json!({"uri": data(&PROFILE.replace("20 10 0", "0 0 0"))}), "/uri", 1);
    let mut b = with(json!({"uri": data(PROFILE)}));
    let view = b.view(PROFILE.as_bytes());
    b.json["extensions"][IES]["lights"][0]["bufferView"] = json!(view);
    let loaded = b.loaded();
    assert!(told(&loaded, Severity::Warning, "/extensions/EXT_lights_ies/lights/0"));
    assert!(told(&loaded, Severity::Warning, "/extensions/EXT_lights_ies/lights/0/mimeType"));
    let tilted = PROFILE.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n0 90\n1 0.8");
    let loaded = with(json!({"uri": data(&tilted)})).loaded();
    assert!(told(&loaded, Severity::Note, "/extensions/EXT_lights_ies/lights/0/uri"));
    assert_eq!(loaded.scene.lights[0].intensity.x, 40.0);
    for (own, key) in [(json!({"multiplier": -1}), "multiplier"), (json!({"color": [2, 0, 0]}), "color/0")] {
        let mut own = own;
        own["light"] = json!(0);
        let loaded = lit(IES, json!([{"uri": data(PROFILE)}]), &[at(IES, own, json!({}))]).loaded();
        assert!(told(&loaded, Severity::Warning, &format!("/nodes/1/extensions/EXT_lights_ies/{key}")));
    }
}

#[test]
fn lights_are_animated_by_pointers() {
    let mut b = lit(
        AREA,
        json!([{"type": "rect", "rect": {"aspect": 1}}]),
        &[at(AREA, json!({"light": 0}), json!({}))],
    );
    b.json["extensionsUsed"] = json!([AREA, IES, "KHR_animation_pointer"]);
    b.json["extensions"][IES] = json!({"lights": [{"uri": data(PROFILE)}]});
    b.json["nodes"][0]["extensions"] = json!({IES: {"light": 0}});
    let times = b.floats("SCALAR", &[0.0, 1.0]);
    b.json["accessors"][times]["min"] = json!([0]);
    b.json["accessors"][times]["max"] = json!([1]);
    let mut channels = Vec::new();
    let mut samplers = Vec::new();
    for (pointer, kind, end) in [
        ("/extensions/EXT_lights_area/lights/0/color", "VEC3", vec![1.0, 0.0, 0.5]),
        ("/extensions/EXT_lights_area/lights/0/intensity", "SCALAR", vec![200.0]),
        ("/extensions/EXT_lights_area/lights/0/size", "SCALAR", vec![4.0]),
        ("/extensions/EXT_lights_area/lights/0/rect/aspect", "SCALAR", vec![2.0]),
        ("/nodes/0/extensions/EXT_lights_ies/multiplier", "SCALAR", vec![6.0]),
        ("/nodes/0/extensions/EXT_lights_ies/color", "VEC3", vec![1.0, 0.0, 1.0]),
    ] {
        let values = [vec![1.0; end.len()], end].concat();
        let output = b.floats(kind, &values);
        channels.push(json!({"sampler": samplers.len(), "target": {"path": "pointer",
            "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}}));
        samplers.push(json!({"input": times, "output": output}));
    }
    b.json["animations"] = json!([{"channels": channels, "samplers": samplers}]);
    let bytes = b.document().to_string().into_bytes();
    let mut asset = Asset::from_bytes(bytes, "/nowhere".as_ref(), &LoadOptions::default()).expect("opens");
    let moment = Moment { animations: vec![0], time: 1.0 };
    let loaded = asset.load(&moment).expect("loads");
    let light = only(&loaded);
    assert_eq!((light.radiance, light.size), (Vec3::new(200.0, 0.0, 100.0), Vec2::new(8.0, 4.0)));
    assert_eq!(loaded.scene.lights[0].intensity, Vec3::new(240.0, 0.0, 240.0));
}

fn camera(kind: &str, own: Value) -> Builder {
    let mut b = Builder::triangle();
    b.json["extensionsUsed"] = json!(["EXT_camera_physical"]);
    let lens = match kind {
        "perspective" => json!({"yfov": 0.66059, "aspectRatio": 1.5, "znear": 0.01}),
        _ => json!({"xmag": 1, "ymag": 1, "znear": 0.01, "zfar": 10}),
    };
    b.push("cameras", json!({"type": kind, kind: lens, "extensions": {"EXT_camera_physical": own}}));
    b.json["nodes"][0]["camera"] = json!(0);
    b
}

#[test]
fn cameras_have_the_lens_of_the_proposal() {
    let own = json!({"focalLength": 0.035, "sensorSize": [0.036, 0.024], "fStop": 2.8, "focusDistance": 5});
    let loaded = camera("perspective", own.clone()).loaded();
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let lens = loaded.scene.cameras[0].lens.expect("a lens");
    let expected =
        Lens { focal_length: 0.035, sensor: [0.036, 0.024], f_stop: Some(2.8), focus_distance: Some(5.0) };
    assert_eq!(lens, expected);
    let (radius, focus) = lens.aperture().expect("open");
    assert!((radius - 0.00625).abs() < 1e-8 && focus == 5.0);
    assert_eq!(loaded.summary.cameras[0].lens.as_ref().expect("told").f_stop, Some(2.8));

    let pointer = "/cameras/0/extensions/EXT_camera_physical";
    let with = |key: &str, value: Value| {
        let mut own = own.clone();
        match value {
            Value::Null => drop(own.as_object_mut().expect("an object").remove(key)),
            value => own[key] = value,
        }
        camera("perspective", own)
    };
    for (key, value, has_lens, severity) in [
        ("focalLength", json!(null), false, Severity::Warning),
        ("focalLength", json!(0), false, Severity::Warning),
        ("sensorSize", json!(null), true, Severity::Warning),
        ("sensorSize", json!([0.036, 0]), true, Severity::Warning),
        ("fStop", json!(0), true, Severity::Warning),
        ("focusDistance", json!(-1), true, Severity::Warning),
    ] {
        let loaded = with(key, value).loaded();
        assert!(told(&loaded, severity, &format!("{pointer}/{key}")), "{key}: {:?}", loaded.diagnostics);
        assert_eq!(loaded.scene.cameras[0].lens.is_some(), has_lens, "{key}");
    }
    // What is sharp after all, or fits to another sensor, is told.
    for (key, value) in
        [("focusDistance", json!(null)), ("focusDistance", json!(0)), ("sensorSize", json!([0.01, 0.01]))]
    {
        let loaded = with(key, value).loaded();
        assert!(told(&loaded, Severity::Note, pointer), "{key}");
    }
    // Fitted across: 36 mm over 1.5 are 24 mm.
    assert!(!told(&with("sensorSize", json!([0.036, 0.03])).loaded(), Severity::Note, pointer));
    let mut required = camera("perspective", own.clone());
    required.json["extensionsRequired"] = json!(["EXT_camera_physical"]);
    assert!(told(&required.loaded(), Severity::Warning, pointer));
    let parallel = camera("orthographic", own).loaded();
    assert!(told(&parallel, Severity::Warning, pointer) && parallel.scene.cameras[0].lens.is_none());
}

#[test]
fn area_lights_far_away_keep_their_place() {
    let place = [4_161_012.5, 853_447.25, -4_743_990.0];
    let mut b =
        lit(AREA, json!([{"type": "disk"}]), &[at(AREA, json!({"light": 0}), json!({"translation": place}))]);
    b.json["nodes"][0]["translation"] = json!(place);
    let loaded = b.loaded();
    let found = loaded.scene.origin + glam::Vec3::from(only(&loaded).transform.translation).as_dvec3();
    assert!((found - glam::DVec3::from(place)).length() < 1e-6, "{found}");
}
