//! `nephrite validate`: what it finds, and how it ends.

use super::util::{Run, Sandbox, tetrahedra};
use serde_json::Value;

const OURS: &str = "NEPHRITE_materials_subsurface";

fn material(medium: &str) -> String {
    format!(
        r#"[ {{ "pbrMetallicRoughness": {{ "metallicFactor": 0 }}, "extensions": {{ "{OURS}": {medium} }} }} ]"#
    )
}

fn validate(sandbox: &Sandbox, medium: &str, nodes: &str) -> (Run, Value) {
    let used = format!(r#"{{ "extensionsUsed": ["{OURS}"],"#);
    let text = tetrahedra(&material(medium), nodes, None).replacen('{', &used, 1);
    sandbox.file("a.gltf", text);
    let run = sandbox.run(&["validate", "a.gltf", "--json"]);
    let report = serde_json::from_str(&run.stdout).unwrap();
    (run, report)
}

/// Severity and pointer of the findings that hold a text.
fn find<'a>(report: &'a Value, text: &str) -> Vec<(&'a str, &'a str)> {
    let findings = report["findings"].as_array().unwrap().iter();
    let holds = findings.filter(|f| f["message"].as_str().unwrap().contains(text));
    holds.map(|f| (f["severity"].as_str().unwrap(), f["pointer"].as_str().unwrap())).collect()
}

const MARBLE: &str =
    r#"{ "absorptionCoefficient": [2.1, 4.1, 7.1], "scatteringCoefficient": [2190, 2620, 3000] }"#;

#[test]
fn a_good_file_has_no_errors_and_no_warnings() {
    let sandbox = Sandbox::new();
    let (run, report) = validate(&sandbox, MARBLE, r#"[ { "mesh": 0 } ]"#);
    let run = run.exits(0);
    run.check(report["errors"] == 0 && report["warnings"] == 0 && report["valid"] == true, "should be clean");
    assert_eq!(find(&report, "other viewers"), [("note", "/materials/0/extensions")]);
    let run = sandbox.run(&["validate", "a.gltf"]).exits(0);
    run.check(run.stdout.contains("0 errors, 0 warnings"), "should count");
    sandbox.run(&["validate", "nowhere.gltf"]).exits(1).says(&["nowhere.gltf"]);
    assert_eq!(sandbox.files(), ["a.gltf"]);
}

#[test]
fn all_violations_of_the_schema_are_found_at_once() {
    let sandbox = Sandbox::new();
    let medium = r#"{ "absorptionCoefficient": [-1, 0, 0], "scatterAnisotropy": 1, "priority": 0.5, "scaterAnisotropy": 0 }"#;
    let (run, report) = validate(&sandbox, medium, r#"[ { "mesh": 0 } ]"#);
    run.exits(1).says(&["a.gltf has 3 errors"]);
    let pointer = |rest: &str| format!("/materials/0/extensions/{OURS}{rest}");
    for rest in ["/absorptionCoefficient/0", "/scatterAnisotropy", "/priority"] {
        assert!(
            report["findings"].as_array().unwrap().iter().any(|f| f["pointer"] == pointer(rest)),
            "{rest}: {report}"
        );
    }
}

#[test]
fn units_that_were_mixed_up_are_suspected() {
    let sandbox = Sandbox::new();
    for (medium, expected) in [
        (r#"{ "absorptionCoefficient": [1e-5, 1e-5, 1e-5] }"#, 1),
        (r#"{ "scatteringCoefficient": [1e6, 2e6, 3e6] }"#, 1),
        (r#"{ "scatteringCoefficient": [1, 2, 3] }"#, 0),
        ("{}", 0),
    ] {
        let (run, report) = validate(&sandbox, medium, r#"[ { "mesh": 0 } ]"#);
        run.exits(0);
        assert_eq!(find(&report, "mean free path is").len(), expected, "{medium}: {report}");
    }
    // The scale of a node does not change the medium, but the size of the body.
    let (_, report) = validate(&sandbox, MARBLE, r#"[ { "mesh": 0, "scale": [100, 100, 100] } ]"#);
    assert_eq!(find(&report, "it looks opaque"), [("warning", "/materials/0")]);
}

#[test]
fn open_meshes_and_overlaps_are_found() {
    let sandbox = Sandbox::new();
    let (run, report) = validate(&sandbox, MARBLE, r#"[ { "mesh": 1 } ]"#);
    run.exits(1);
    assert_eq!(find(&report, "3 edges of one triangle"), [("error", "/meshes/1")]);
    let two = |by: f32, scale: f32| {
        format!(
            r#"[ {{ "mesh": 0 }}, {{ "mesh": 0, "translation": [{by}, {by}, {by}], "scale": [{scale}, {scale}, {scale}] }} ]"#
        )
    };
    // The corner at (0.5, 0.5, 0.5) is moved to (0.1, 0.1, 0.1), inside the first one.
    let (_, report) = validate(&sandbox, MARBLE, &two(-0.4, 1.0));
    assert_eq!(find(&report, "overlaps").len(), 1, "{report}");
    let (_, report) = validate(&sandbox, MARBLE, &two(0.0, 0.2));
    assert_eq!(find(&report, "is inside"), [("note", "/nodes/1")]);
    let (_, report) = validate(&sandbox, MARBLE, &two(3.0, 1.0));
    assert!(find(&report, "overlaps").is_empty() && find(&report, "is inside").is_empty());
}

#[test]
fn fallbacks_that_say_something_else_are_found() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedra(&material(MARBLE), r#"[ { "mesh": 0 } ]"#, None));
    sandbox.run(&["edit", "a.gltf", "-o", "b.gltf", "--material", "0", "--density", "1"]).exits(0);
    let report = |name: &str| -> Value {
        serde_json::from_str(&sandbox.run(&["validate", name, "--json"]).exits(0).stdout).unwrap()
    };
    assert_eq!(report("b.gltf")["warnings"], 0, "{}", report("b.gltf"));
    sandbox
        .run(&["edit", "b.gltf", "--in-place", "--material", "0", "--density", "2", "--no-fallback"])
        .exits(0);
    assert_eq!(find(&report("b.gltf"), "other viewers see another medium").len(), 1);
}
