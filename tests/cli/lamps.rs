//! Lamps: what their numbers mean, what is told of them, and pictures that they make white or leave black.

use super::util::{Run, Sandbox, exr_channel, triangle};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A matte wall of reflectance 0.8 in the plane z = 0, a light that shines on it from five metres, and a camera that sees its
/// middle. At the wall the light has the irradiance I/25, or its own where it is parallel, and the wall the radiance 0.8/π
/// times that.
fn wall(light: Option<Value>, generator: &str) -> String {
    let mut document: Value = serde_json::from_str(&triangle("")).expect("JSON");
    document["asset"]["generator"] = json!(generator);
    document["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    document["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 1 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
    }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document["cameras"] = json!([{ "type": "orthographic", "orthographic": { "xmag": 0.05, "ymag": 0.05, "znear": 0.01, "zfar": 9 } }]);
    document["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let mut node = json!({ "translation": [0, 0, 5] });
    if let Some(light) = light {
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    }
    document["nodes"]
        .as_array_mut()
        .expect("a list")
        .extend([node, json!({ "camera": 0, "translation": [0, 0, 4] })]);
    document.to_string()
}

/// Renders the wall, and its mean radiance.
fn radiance(sandbox: &Sandbox, document: &str, more: &[&str]) -> (f64, Run) {
    sandbox.file("a.gltf", document);
    let args = ["render", "a.gltf", "-o", "a.exr", "-o", "a.png", "--float", "--size", "8x8", "--spp", "16"];
    let run = sandbox.run(&[&args[..], more].concat()).exits(0);
    let channel = exr_channel(&sandbox.path("a.exr"), "G");
    (channel.iter().map(|&v| f64::from(v)).sum::<f64>() / channel.len() as f64, run)
}

/// The numbers are those of Blender's exporter for a point of 1000 W, a spot of 300 W, and a sun of 3 W/m².
#[test]
fn a_lamp_in_each_of_blenders_lighting_modes_makes_the_same_picture() {
    let sandbox = Sandbox::new();
    let spot = json!({ "innerConeAngle": 0.3, "outerConeAngle": 0.4 });
    let point = 1000.0 / (4.0 * PI) / 25.0;
    for (kind, written, irradiance) in [
        ("point", [54_351.41, 79.577_47, 1000.0], point),
        ("spot", [16_305.424, 23.873_24, 300.0], 0.3 * point),
        ("directional", [2049.0, 3.0, 3.0], 3.0),
    ] {
        let expected = 0.8 / PI * irradiance;
        let light = |intensity: f64| Some(json!({ "type": kind, "intensity": intensity, "spot": spot }));
        for (intensity, units) in written.into_iter().zip(["blender", "unitless", "watts"]) {
            let (found, run) = radiance(&sandbox, &wall(light(intensity), ""), &["--light-units", units]);
            // Half a per cent: the roughest surface is not quite Lambert's.
            assert!((found / expected - 1.0).abs() < 5e-3, "{kind} {units}: {found} {expected}");
            run.check(!run.stderr.contains("nearly all"), "is well exposed");
        }
        // As the specification has it, with and without the option; and scaled.
        for more in
            [&[][..], &["--light-units", "candela"], &["--light-units", "candela", "--light-scale", "0.5"]]
        {
            let scale = if more.len() > 2 { 0.5 } else { 1.0 };
            let (found, _) = radiance(&sandbox, &wall(light(written[0]), ""), more);
            let expected = 683.0 * scale * expected;
            assert!((found / expected - 1.0).abs() < 5e-3, "{kind} {more:?}: {found} {expected}");
        }
    }
    sandbox.file("a.gltf", triangle(""));
    let args = ["render", "a.gltf", "-o", "a.png", "--size", "4x4", "--spp", "1"];
    sandbox
        .run(&[&args[..], &["--light-scale", "2"]].concat())
        .exits(0)
        .says(&["--light-scale does nothing"]);
    sandbox.run(&[&args[..], &["--light-units", "watt"]].concat()).exits(2).says(&["did you mean watts"]);
    sandbox.run(&[&args[..], &["--light-scale", "-1"]].concat()).exits(2).says(&["at least 0"]);
}

/// The exposure that a message proposes.
fn proposed(run: &Run) -> String {
    let text = run.stderr.split("--exposure ").nth(1).unwrap_or_else(|| panic!("no hint: {}", run.stderr));
    text.split(' ').next().expect("a number").to_owned()
}

#[test]
fn white_and_black_pictures_come_with_the_exposure_that_helps() {
    let sandbox = Sandbox::new();
    let lamp = |intensity: f64| Some(json!({ "type": "point", "intensity": intensity }));
    for (intensity, what, stops) in [(54_351.41, "white", -11.6), (0.02, "black", 9.8)] {
        let document = wall(lamp(intensity), "Khronos glTF Blender I/O v4.5");
        let (_, run) = radiance(&sandbox, &document, &[]);
        run.check(run.stderr.contains(&format!("is {what}:")), "should say what is wrong");
        // 0.18 over 0.8/π I/25, in stops.
        let exposure = proposed(&run);
        assert_eq!(exposure.parse::<f64>().expect("a number"), stops);
        let (_, run) = radiance(&sandbox, &document, &["--exposure", &exposure]);
        run.check(!run.stderr.contains("nearly all"), "should have helped");
        let (_, run) = radiance(&sandbox, &document, &["--exposure", &exposure, "--tonemap", "agx"]);
        run.check(!run.stderr.contains("nearly all"), "should have helped");
    }
    let (_, run) = radiance(&sandbox, &wall(lamp(54_351.41), "Khronos glTF Blender I/O v4.5"), &[]);
    run.says(&["--light-units blender"]);
    // What is meant to be dark has no light, and what has light may not be seen.
    let (_, run) = radiance(&sandbox, &wall(None, ""), &["--env", "none"]);
    run.check(run.stderr.contains("there is no light") && !run.stderr.contains("--exposure"), "has no light");
    let (_, run) = radiance(&sandbox, &wall(lamp(0.0), ""), &["--env", "none"]);
    run.check(run.stderr.contains("there is no light"), "has no light that shines");
    let behind = wall(lamp(5.0), "").replace("[0,0,5]", "[0,0,-5]");
    let (_, run) = radiance(&sandbox, &behind, &["--env", "none"]);
    run.check(run.stderr.contains("none of the light"), "is lit from behind");
    let (_, run) = radiance(&sandbox, &wall(lamp(79.6), ""), &[]);
    run.check(!run.stderr.contains("--exposure"), "is well exposed");
}

#[test]
fn inspect_tells_of_every_lamp() {
    let sandbox = Sandbox::new();
    let spot = json!({ "type": "spot", "name": "Key", "intensity": 16_305.424, "color": [1, 0.5, 0.25],
        "spot": { "innerConeAngle": 0, "outerConeAngle": 0.5 } });
    let text = wall(Some(spot), "Khronos glTF Blender I/O v4.5");
    let mut document: Value = serde_json::from_str(&text).expect("JSON");
    document["materials"][0]["name"] = json!("Glow");
    document["materials"][0]["emissiveFactor"] = json!([0.5, 0.5, 0.5]);
    sandbox.file("a.gltf", document.to_string());
    let run = sandbox.run(&["inspect", "a.gltf"]).exits(0);
    for text in [
        r#""Key": 16305  8153  4076 cd, power"#,
        "(300 W in Blender), at (0, 0, 5) m, along (0, 0, -1), cone 0° to 28.6° from its axis",
        "1 spot, 1 emissive material",
        // The triangle has an area of 2 m²; π · 0.5 · 2.
        r#"material 0 "Glow" (/materials/0): 0.5 cd/m², 2 m², power 3.14 lm, around (0, -0.333, 0) m"#,
    ] {
        run.check(run.stdout.contains(text), text);
    }
    let run = sandbox.run(&["inspect", "a.gltf", "--json"]).exits(0);
    let report: Value = serde_json::from_str(&run.stdout).expect("JSON");
    let light = &report["lights"][0];
    assert_eq!(
        (&light["unit"], &light["kind"], &light["position"]),
        (&json!("cd"), &json!("spot"), &json!([0.0, 0.0, 5.0]))
    );
    // 2π (1 − cos 0.5)/3 sr.
    let power = light["power"][0].as_f64().expect("a number");
    let expected = 16_305.424 * 2.0 * PI * (1.0 - 0.5_f64.cos()) / 3.0;
    assert!((power / expected - 1.0).abs() < 1e-5, "{power} {expected}");
    let lamp = &report["lamps"][0];
    assert!((lamp["area"].as_f64().expect("a number") - 2.0).abs() < 1e-6, "{lamp}");
    assert_eq!(lamp["name"], "Glow");
}
