//! `nephrite convert`: there and back, and what is lost.

use super::util::{Sandbox, tetrahedra};
use serde_json::{Value, json};

fn media(sandbox: &Sandbox, name: &str) -> Value {
    let run = sandbox.run(&["inspect", name, "--json"]).exits(0);
    serde_json::from_str::<Value>(&run.stdout).unwrap()["media"].clone()
}

#[test]
fn there_and_back_keeps_the_coefficients() {
    let sandbox = Sandbox::new();
    let materials = r#"[
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "NEPHRITE_materials_subsurface": {
            "absorptionCoefficient": [0.3, 4.1, 900], "scatteringCoefficient": [2190, 262, 300], "scatterAnisotropy": 0.8, "ior": 1.37, "densityFactor": 0.5 } } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "NEPHRITE_materials_subsurface": { "absorptionCoefficient": [1, 2, 30] } } },
        { "name": "plain" } ]"#;
    sandbox.file("a.gltf", tetrahedra(materials, r#"[ { "mesh": 0 } ]"#, None));
    let before = media(&sandbox, "a.gltf");
    for form in ["khr-scatter", "openpbr"] {
        let run = sandbox
            .run(&["convert", "a.gltf", "-o", "b.gltf", "--to", form])
            .exits(0)
            .says(&["2 media converted"]);
        run.check(!run.stderr.contains("becomes"), "should lose nothing");
        let text = std::fs::read_to_string(sandbox.path("b.gltf")).unwrap();
        assert!(!text.contains("NEPHRITE_materials_subsurface"), "{text}");
        sandbox
            .run(&["convert", "b.gltf", "-o", "c.gltf", "--to", "nephrite"])
            .exits(0)
            .says(&["2 media converted"]);
        let after = media(&sandbox, "c.gltf");
        for i in 0..2 {
            for key in ["sigma_a", "sigma_s"] {
                for c in 0..3 {
                    let [a, b] = [&before, &after].map(|m| m[i][key][c].as_f64().unwrap());
                    assert!((a - b).abs() <= 1e-4 * a, "{form} {i} {key} {c}: {a} {b}");
                }
            }
            assert_eq!(before[i]["ior"], after[i]["ior"]);
            assert_eq!(before[i]["anisotropy"], after[i]["anisotropy"]);
        }
    }
    // As other readers see the file: within what single precision leaves of colours near white.
    sandbox.run(&["convert", "a.gltf", "-o", "b.gltf", "--to", "khr-scatter"]).exits(0);
    let seen = media(&sandbox, "b.gltf");
    let [a, b] = [&before, &seen].map(|m| m[0]["sigma_s"][0].as_f64().unwrap());
    assert!((a - b).abs() < 1e-4 * a, "{a} {b}");
}

#[test]
fn what_cannot_be_said_is_told() {
    let sandbox = Sandbox::new();
    let materials = r#"[ { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "NEPHRITE_materials_subsurface": {
        "absorptionCoefficient": [1, 1, 1], "scatteringCoefficient": [0, 9, 9], "priority": 2 } } } ]"#;
    sandbox.file("a.gltf", tetrahedra(materials, r#"[ { "mesh": 0 } ]"#, None));
    sandbox
        .run(&["convert", "a.gltf", "-o", "b.gltf", "--to", "khr-scatter"])
        .exits(0)
        .says(&["/materials/0: the priority of 2", "red scattering"]);
    sandbox
        .run(&["convert", "a.gltf", "-o", "c.gltf", "--to", "nephrite"])
        .exits(0)
        .says(&["that way already"]);
    assert_eq!(
        std::fs::read(sandbox.path("c.gltf")).unwrap(),
        std::fs::read(sandbox.path("a.gltf")).unwrap()
    );
    sandbox
        .run(&["convert", "a.gltf", "-o", "d.gltf", "--to", "khr"])
        .exits(2)
        .says(&["did you mean khr-scatter"]);
    assert_eq!(sandbox.files(), ["a.gltf", "b.gltf", "c.gltf"]);
}

#[test]
fn openpbr_parameters_are_read_from_the_extras() {
    let sandbox = Sandbox::new();
    let materials = r#"[ { "pbrMetallicRoughness": { "metallicFactor": 0 },
        "extras": { "openpbr": { "subsurface_weight": 1, "subsurface_color": [0.5, 0.5, 0.5], "subsurface_radius": 0.002 }, "other": 1 } } ]"#;
    sandbox.file("a.gltf", tetrahedra(materials, r#"[ { "mesh": 0 } ]"#, None));
    sandbox.run(&["convert", "a.gltf", "-o", "b.gltf", "--to", "nephrite"]).exits(0);
    let medium = &media(&sandbox, "b.gltf")[0];
    // ρ = 0.5 is σs/σt = 0.9117089; the default radius scale is 1, 0.5, 0.25.
    for (i, sigma_t) in [500.0, 1000.0, 2000.0].into_iter().enumerate() {
        let found = medium["sigma_s"][i].as_f64().unwrap();
        assert!((found / (0.911_708_85 * sigma_t) - 1.0).abs() < 1e-5, "{found}");
    }
    let document: Value = serde_json::from_slice(&std::fs::read(sandbox.path("b.gltf")).unwrap()).unwrap();
    assert_eq!(document["materials"][0]["extras"], json!({ "other": 1 }));
}
