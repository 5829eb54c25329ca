//! Area lights, measured lights and lenses of glTF extensions, as commands show and keep them.

use super::util::{Sandbox, exr_channel, tetrahedra, triangle};
use serde_json::Value;

const PROFILE: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 10\n0 180\n0\n50 50\n";

/// All three, with odd spellings that have to stay.
fn document() -> String {
    let nodes = r#"[
    { "mesh": 0 },
    { "name": "eye", "camera": 0, "translation": [0, 0, 4.0] },
    { "translation": [0, 2, 1e0], "extensions": { "EXT_lights_area": { "light" : 0 } } },
    { "translation": [0, -2, 1], "extensions": { "EXT_lights_ies": { "multiplier": 2.0, "light": 0, "color": [1, 1, 0.50] } } } ]"#;
    let more = r#"{
  "extensionsUsed": ["EXT_lights_area", "EXT_lights_ies", "EXT_camera_physical"],
  "extensions": {
    "EXT_lights_area": { "lights": [ { "type": "disk", "name": "lamp", "size": 2, "intensity": 1e2 } ] },
    "EXT_lights_ies": { "lights": [ { "name": "luminaire", "uri": "a.ies" } ] } },
  "cameras": [ { "name": "c", "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.01, "aspectRatio": 1 },
    "extensions": { "EXT_camera_physical": { "focalLength": 0.050, "sensorSize": [0.02553, 0.02553], "fStop": 2, "focusDistance": 4 } } } ],
"#;
    tetrahedra(r#"[ { "name": "Wax" } ]"#, nodes, None).replacen('{', more, 1)
}

#[test]
fn inspect_tells_of_power_and_lenses() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", document());
    sandbox.file("a.ies", PROFILE);
    let run = sandbox.run(&["inspect", "a.gltf"]).exits(0);
    // π · 100 · π lumens; 4π · 50 · 2.
    for text in [
        "1 measured (IES), 1 round",
        "\"luminaire\": 100  100  50 cd at most, power 1257  1257  628 lm, at (",
        "\"lamp\": 100 cd/m², 2 m across, power 987 lm, at (",
        "50 mm on 25.5 mm × 25.5 mm, f/2, focused at 4 m",
    ] {
        run.check(run.stdout.contains(text), &format!("should say {text:?}"));
    }
    let report: Value =
        serde_json::from_str(&sandbox.run(&["inspect", "a.gltf", "--json"]).exits(0).stdout).unwrap();
    assert_eq!(report["objects"], 1);
    assert_eq!(report["lights"][1]["kind"], "disk");
    let lumens = report["lights"][1]["power"][0].as_f64().unwrap();
    assert!((lumens - 100.0 * std::f64::consts::PI.powi(2)).abs() < 1e-2);
    assert_eq!(report["cameras"][0]["lens"]["f_stop"], 2.0);
    sandbox.run(&["validate", "a.gltf"]).exits(0);
    sandbox.file("a.ies", "nothing of the kind");
    sandbox.run(&["inspect", "a.gltf"]).exits(1).says(&["/extensions/EXT_lights_ies/lights/0/uri", "TILT="]);
    let broken = sandbox.run(&["validate", "a.gltf"]).exits(1);
    broken.check(broken.stdout.contains("/extensions/EXT_lights_ies/lights/0/uri"), "should say where");
}

#[test]
fn edit_keeps_lights_and_lenses_to_the_byte() {
    let sandbox = Sandbox::new();
    let text = document();
    sandbox.file("a.gltf", &text);
    sandbox.file("a.ies", PROFILE);
    let args = ["edit", "a.gltf", "-o", "b.gltf", "--material", "Wax", "--preset", "marble", "--no-fallback"];
    sandbox.run(&args).exits(0);
    let edited = std::fs::read_to_string(sandbox.path("b.gltf")).unwrap();
    let part = |text: &str, from: &str, to: &str| {
        let start = text.find(from).expect("is there");
        text[start..start + text[start..].find(to).expect("is there")].to_owned()
    };
    for (from, to) in [("\"extensions\": {\n", "\"asset\""), ("\"nodes\": [\n", "\"materials\"")] {
        assert_eq!(part(&edited, from, to), part(&text, from, to));
    }
    sandbox.run(&["edit", "b.gltf", "-o", "c.gltf", "--material", "Wax", "--remove"]).exits(0);
    let value = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    let back = value(&std::fs::read_to_string(sandbox.path("c.gltf")).unwrap());
    for key in ["extensions", "nodes", "cameras", "extensionsUsed"] {
        assert_eq!(back[key], value(&text)[key], "{key}");
    }
}

#[test]
fn options_focus_any_perspective_camera() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let mut args = vec!["render", "a.gltf", "-o", "a.exr", "--size", "16x16", "--spp", "4", "--env", "1"];
    let alpha_edges = |args: &[&str]| {
        sandbox.run(args).exits(0);
        let alpha = exr_channel(&sandbox.path("a.exr"), "A");
        alpha.iter().filter(|a| **a > 0.05 && **a < 0.95).count()
    };
    args.push("--transparent-background");
    let sharp = alpha_edges(&args);
    // A lens as wide as the triangle, focused far in front of it.
    args.extend(["--f-stop", "0.05", "--focus-distance", "1"]);
    let blurred = alpha_edges(&args);
    assert!(blurred > 2 * sharp, "{sharp} {blurred}");
    let half = ["render", "a.gltf", "-o", "b.exr", "--size", "8x8", "--spp", "1", "--f-stop", "2"];
    sandbox.run(&half).exits(0).says(&["--f-stop does nothing", "--focus-distance"]);
    let half = ["render", "a.gltf", "-o", "c.exr", "--size", "8x8", "--spp", "1", "--focus-distance", "2"];
    sandbox.run(&half).exits(0).says(&["--focus-distance does nothing", "--f-stop"]);
    sandbox.run(&["render", "a.gltf", "-o", "d.exr", "--f-stop", "0"]).exits(2).says(&["above 0"]);
}

#[test]
fn area_lights_and_profiles_light_a_file_by_themselves() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", document());
    sandbox.file("a.ies", PROFILE);
    let run = sandbox.run(&["render", "a.gltf", "-o", "a.exr", "--size", "8x8", "--spp", "4"]).exits(0);
    run.check(!run.stderr.contains("studio"), "should need no studio");
    assert!(exr_channel(&sandbox.path("a.exr"), "R").iter().sum::<f32>() > 0.0);
}
