//! `--animation`, `--at` and `--shutter`.

use serde_json::{Value, json};

use super::util::{Sandbox, exr_channel, triangle};

/// An unlit white triangle that moves from x = 0 to x = 2 in one second, seen by a parallel camera 2 high.
fn moving() -> String {
    // Times 0 1, then translations (0 0 0) (2 0 0), as floats.
    let uri = "data:application/octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAABAAAAAAAAAAAA=";
    let mut json: Value = serde_json::from_str(&triangle("")).expect("JSON");
    let mut add = |list: &str, entry: Value| match json[list].as_array_mut() {
        Some(list) => list.push(entry),
        None => json[list] = json!([entry]),
    };
    add("buffers", json!({"byteLength": 32, "uri": uri}));
    add("bufferViews", json!({"buffer": 1, "byteLength": 32}));
    add(
        "accessors",
        json!({
            "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1],
        }),
    );
    add(
        "accessors",
        json!({
            "bufferView": 1, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3",
        }),
    );
    add(
        "animations",
        json!({
            "name": "slide",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 1, "output": 2}],
        }),
    );
    let lens = json!({"xmag": 1, "ymag": 1, "znear": 0, "zfar": 10});
    add("cameras", json!({"type": "orthographic", "orthographic": lens}));
    add("nodes", json!({"camera": 0, "translation": [0, 0, 5]}));
    add("materials", json!({"extensions": {"KHR_materials_unlit": {}}}));
    add("extensionsUsed", json!("KHR_materials_unlit"));
    json["scenes"][0]["nodes"] = json!([0, 1]);
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    json.to_string()
}

fn mean(sandbox: &Sandbox, args: &[&str]) -> f64 {
    let mut all = vec!["render", "a.gltf", "-o", "a.exr", "--size", "32x32", "--float", "--env", "none"];
    all.extend(args);
    sandbox.run(&all).exits(0);
    let values = exr_channel(&sandbox.path("a.exr"), "R");
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
}

#[test]
fn animations_are_listed_chosen_and_played() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", moving());
    let run = sandbox.run(&["inspect", "a.gltf"]).exits(0);
    run.check(run.stdout.contains("\"slide\": 1 s, 1 channel (translation)"), "should list the animation");
    let json = sandbox.run(&["inspect", "a.gltf", "--json"]).exits(0).stdout;
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["animations"][0]["end"], 1.0);

    // The triangle covers half of the view; at x = 1 what is right of its axis is out of view, at x = 2 all of it.
    for (args, expected) in [
        (&[][..], 0.5),
        (&["--animation", "slide"], 0.5),
        (&["--animation", "0", "--at", "0.5"], 0.25),
        (&["--at", "7"], 0.0),
        (&["--animation", "all", "--at", "-1"], 0.5),
    ] {
        // Edges take up 1/16 of the pixels, sampled 16 times: a standard error below 0.001.
        let found = mean(&sandbox, args);
        assert!((found - expected).abs() < 0.004, "{args:?}: {found} is not {expected}");
    }
    sandbox
        .run(&["render", "a.gltf", "-o", "a.exr", "--size", "4x4", "--spp", "1", "--at", "0.5"])
        .exits(0)
        .says(&["--at plays the first animation, \"slide\""]);
    sandbox
        .run(&["render", "a.gltf", "-o", "a.exr", "--animation", "slid"])
        .exits(1)
        .says(&["did you mean slide", "0 to 0"]);
    sandbox.file("still.gltf", triangle(""));
    sandbox
        .run(&["render", "still.gltf", "-o", "a.exr", "--size", "4x4", "--spp", "1", "--shutter", "0.5"])
        .exits(0)
        .says(&["--shutter does nothing: the file has no animations"]);
    sandbox.run(&["render", "a.gltf", "-o", "a.exr", "--shutter", "2,1"]).exits(2).says(&["-0.01,0.01"]);
    sandbox.run(&["render", "a.gltf", "-o", "a.exr", "--at", "soon"]).exits(2).says(&["seconds"]);
}

#[test]
fn an_open_shutter_blurs_what_moves_and_nothing_else() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", moving());
    // The share of the triangle in view at x = 2t is ½(1 − 2t²) up to t = ½, and (1 − t)² after: the mean of a second is
    // ½(½ − 1/12) + 1/24 = ¼. Moments jittered in 16 strata give a standard error of 2/16 · 1/√(12 · 16) = 0.01 at most.
    for (args, expected) in [
        (&["--shutter", "1"][..], 0.25),
        (&["--shutter", "-1,1"], 0.375),
        (&["--at", "5", "--shutter", "3"], 0.0),
    ] {
        let found = mean(&sandbox, args);
        assert!((found - expected).abs() < 0.04, "{args:?}: {found} is not {expected}");
    }
    let shutter = ["--shutter", "0.5", "--spp", "7", "--shutter-slices", "3"];
    let one = [&shutter[..], &["--threads", "1"]].concat();
    let many = [&shutter[..], &["--threads", "5"]].concat();
    mean(&sandbox, &one);
    let first = std::fs::read(sandbox.path("a.exr")).expect("a picture");
    mean(&sandbox, &many);
    assert!(first == std::fs::read(sandbox.path("a.exr")).expect("a picture"), "threads changed the picture");
    mean(&sandbox, &[&many[..], &["--progressive"]].concat());
    assert!(
        first == std::fs::read(sandbox.path("a.exr")).expect("a picture"),
        "pictures on the way changed the last"
    );

    // Where nothing moves the picture is that without a shutter, up to the rounding of the mean.
    let still = ["--at", "-5", "--spp", "10"];
    mean(&sandbox, &still);
    let plain = exr_channel(&sandbox.path("a.exr"), "R");
    mean(&sandbox, &[&still[..], &["--shutter", "0.1", "--shutter-slices", "4"]].concat());
    for (a, b) in plain.iter().zip(exr_channel(&sandbox.path("a.exr"), "R")) {
        assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    }
}

/// The mean of the reference of a comparison is the integral over time, as the picture of `render` is.
#[test]
fn models_are_compared_with_an_open_shutter() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", moving());
    let compare = |more: &[&str]| {
        let base = ["compare-models", "a.gltf", "-o", "s.png", "--size", "32x32", "--env", "none"];
        let all = [&base[..], &["--models", "random-walk", "--spp", "32"], more].concat();
        sandbox.run(&all).exits(0);
        let json = std::fs::read(sandbox.path("s.json")).expect("numbers");
        serde_json::from_slice::<Value>(&json).expect("JSON")
    };
    let mean = |json: &Value| json["reference"]["mean"][0].as_f64().expect("a mean");
    assert!((mean(&compare(&[])) - 0.5).abs() < 0.004, "at rest");
    // As in the test above, with twice as many moments in the two halves of the reference.
    let blurred = compare(&["--shutter", "1"]);
    assert!((mean(&blurred) - 0.25).abs() < 0.03, "{}", mean(&blurred));
    assert_eq!(blurred["options"]["shutter"], json!([0.0, 1.0]));
    assert_eq!(blurred["options"]["shutter_slices"], 16);
}
