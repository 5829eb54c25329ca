//! `nephrite edit`: what it writes, what it leaves alone, and how it ends.

use super::util::{Sandbox, glb, tetrahedra, tetrahedron_data, triangle};
use serde_json::{Value, json};

const OURS: &str = "NEPHRITE_materials_subsurface";

/// Odd spellings, an unknown extension and extras, which all have to stay.
const MATERIALS: &str = r#"[
    { "name": "Wax", "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1e-1 }, "extras" : {"id":12345678901234567890, "x": 1.50} },
    { "name" : "1", "extensions": { "VENDOR_unknown": { "weights": [ 1.0,2.00 ] } } }
  ]"#;

fn wax() -> String {
    tetrahedra(MATERIALS, r#"[ { "mesh": 0, "scale": [0.5, 0.5, 0.5] } ]"#, None)
}

fn read(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(sandbox.path(name)).unwrap()).unwrap()
}

fn inspect(sandbox: &Sandbox, name: &str) -> Value {
    let run = sandbox.run(&["inspect", name, "--json"]).exits(0);
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn nonsense_is_refused_and_leaves_nothing_behind() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", wax());
    let edit = |more: &[&'static str]| [&["edit", "a.gltf"], more].concat();
    let usage: &[(&[&str], &[&str])] = &[
        (&["--material", "0", "--preset", "marble"], &["--output"]),
        (&["-o", "b.gltf", "--in-place"], &["--in-place"]),
        (&["-o", "b.gltf", "--preset", "marble"], &["--material"]),
        (&["-o", "b.gltf", "--material", "0"], &["what to change"]),
        (&["-o", "b.gltf", "--material", "0", "--preset", "marbel"], &["did you mean marble"]),
        (&["-o", "b.gltf", "--material", "0", "--anisotropy", "1"], &["--anisotropy"]),
        (&["-o", "b.gltf", "--material", "0", "--absorption", "1,2"], &["--absorption"]),
        (
            &["-o", "b.gltf", "--material", "0", "--color", "1,1,2", "--mean-free-path", "1"],
            &["--color", "between 0 and 1"],
        ),
        (&["-o", "b.gltf", "--material", "0", "--color", "1", "--absorption", "1"], &["--absorption"]),
        (&["-o", "b.gltf", "--material", "0", "--remove", "--ior", "1.4"], &["--remove"]),
    ];
    for (more, texts) in usage {
        sandbox.run(&edit(more)).exits(2).says(texts);
    }
    let cannot: &[(&[&str], &[&str])] = &[
        (&["-o", "a.gltf", "--material", "0", "--preset", "marble"], &["is the input", "--in-place"]),
        (&["-o", "b.glb", "--material", "0", "--preset", "marble"], &["container is kept", ".gltf"]),
        (&["-o", "no/b.gltf", "--material", "0", "--preset", "marble"], &["create the folder"]),
        (&["-o", "b.gltf", "--material", "Wxa", "--preset", "marble"], &["did you mean Wax", "0 to 1"]),
        (
            &["-o", "b.gltf", "--material", "0", "--anisotropy", "0.5"],
            &["/materials/0", "--preset", "convert"],
        ),
        (&["-o", "b.gltf", "--material", "0", "--color", "0.5"], &["--mean-free-path"]),
        (
            &["-o", "b.gltf", "--material", "0", "--preset", "cream", "--absorption-texture", "3"],
            &["/materials/0", "texture"],
        ),
    ];
    for (more, texts) in cannot {
        sandbox.run(&edit(more)).exits(1).says(texts);
    }
    assert_eq!(sandbox.files(), ["a.gltf"]);
}

#[test]
fn what_is_written_is_what_inspect_reads() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", wax());
    let args = [
        "edit",
        "a.gltf",
        "-o",
        "b.gltf",
        "--material",
        "Wax",
        "--unit",
        "mm",
        "--absorption",
        "0.0021,0.0041,0.07",
        "--scattering",
        "2.19,2.62,3",
        "--anisotropy",
        "-0.25",
        "--ior",
        "1.3717135",
        "--priority",
        "-3",
    ];
    sandbox.run(&args).exits(0).says(&["wrote b.gltf (1 material changed)"]);
    let medium = &inspect(&sandbox, "b.gltf")["media"][0];
    let triple = |key: &str| [0, 1, 2].map(|i| medium[key][i].as_f64().unwrap() as f32);
    assert_eq!(triple("sigma_a"), [2.1, 4.1, 70.0]);
    assert_eq!(triple("sigma_s"), [2190.0, 2620.0, 3000.0]);
    assert_eq!(medium["anisotropy"].as_f64().unwrap() as f32, -0.25);
    assert_eq!(medium["ior"].as_f64().unwrap() as f32, 1.3717135);
    assert_eq!(medium["priority"], json!(-3));

    // One thing changes, the others stay.
    sandbox
        .run(&["edit", "b.gltf", "--in-place", "--material", "*", "--density", "0.5", "-q"])
        .exits(1)
        .says(&["/materials/1"]);
    sandbox.run(&["edit", "b.gltf", "--in-place", "--material", "0", "--density", "0.5"]).exits(0);
    let own = read(&sandbox, "b.gltf")["materials"][0]["extensions"][OURS].clone();
    let expected = json!({ "absorptionCoefficient": [2.1, 4.1, 70], "scatteringCoefficient": [2190, 2620, 3000],
        "scatterAnisotropy": -0.25, "ior": 1.3717135, "priority": -3, "densityFactor": 0.5 });
    assert_eq!(own, expected);
}

#[test]
fn everything_else_keeps_every_byte() {
    let sandbox = Sandbox::new();
    let before = wax();
    sandbox.file("a.gltf", &before);
    sandbox
        .run(&["edit", "a.gltf", "-o", "b.gltf", "--material", "1", "--preset", "marble", "--no-fallback"])
        .exits(0);
    let after = std::fs::read_to_string(sandbox.path("b.gltf")).unwrap();
    for kept in [
        r#""roughnessFactor": 1e-1"#,
        r#""extras" : {"id":12345678901234567890, "x": 1.50}"#,
        "[ 1.0,2.00 ]",
        r#""name" : "1""#,
    ] {
        assert!(after.contains(kept), "{kept} in {after}");
    }
    assert_eq!(read(&sandbox, "b.gltf")["extensionsUsed"], json!([OURS]));
    sandbox.run(&["edit", "b.gltf", "-o", "c.gltf", "--material", "*", "--remove"]).exits(0);
    assert_eq!(std::fs::read_to_string(sandbox.path("c.gltf")).unwrap(), before);

    let binary = glb(&before);
    sandbox.file("a.glb", &binary);
    sandbox.run(&["edit", "a.glb", "-o", "b.glb", "--material", "0", "--preset", "marble"]).exits(0);
    let changed = std::fs::read(sandbox.path("b.glb")).unwrap();
    assert!(changed.ends_with(&tetrahedron_data()) && changed.len() > binary.len());
    assert_eq!(inspect(&sandbox, "b.glb")["media"][0]["sigma_s"][1], json!(2620.0));
    sandbox.run(&["edit", "b.glb", "--in-place", "--material", "0", "--remove"]).exits(0);
    assert!(std::fs::read(sandbox.path("b.glb")).unwrap() == binary);
}

/// The values are those of the fallback example of the specification, which was computed elsewhere; its node has a
/// scale of 1/50, this one of 1/2.
#[test]
fn other_viewers_get_the_medium_of_the_specification() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", wax());
    sandbox.run(&["edit", "a.gltf", "-o", "b.gltf", "--material", "0", "--preset", "skim-milk"]).exits(0);
    let document = read(&sandbox, "b.gltf");
    let extensions = &document["materials"][0]["extensions"];
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 2e-5, "{found} {expected}");
    };
    let volume = &extensions["KHR_materials_volume"];
    close(&volume["attenuationDistance"], 0.000522411);
    close(&volume["thicknessFactor"], 0.000522411 / 4.0 / 0.5);
    for (i, (color, rho)) in
        [(0.693212, 0.90223), (0.528006, 0.9011), (0.367879, 0.82027)].into_iter().enumerate()
    {
        close(&volume["attenuationColor"][i], color);
        close(&extensions["KHR_materials_scatter"]["multiscatterColorFactor"][i], rho);
    }
    assert_eq!(extensions["KHR_materials_transmission"]["transmissionFactor"], json!(1));
    assert_eq!(extensions["KHR_materials_ior"]["ior"], json!(1.3));
    assert_eq!(document["extensionsUsed"].as_array().unwrap().len(), 5);
    sandbox.run(&["edit", "b.gltf", "-o", "c.gltf", "--material", "0", "--remove"]).exits(0);
    assert_eq!(read(&sandbox, "c.gltf"), read(&sandbox, "a.gltf"));
}

#[test]
fn a_colour_is_what_an_exact_solution_says() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", wax());
    // Adding–doubling of the specification's table for albedo 0.9, g 0, index 1.5: 0.25991857 of perpendicular light comes
    // back, 0.04 of it from the surface.
    let seen = format!("{}", (0.25991857 - 0.04) / 0.96);
    let args = [
        "edit",
        "a.gltf",
        "-o",
        "b.gltf",
        "--material",
        "0",
        "--color",
        &seen,
        "--mean-free-path",
        "0.5,1,2",
        "--unit",
        "mm",
    ];
    sandbox.run(&args).exits(0);
    let own = read(&sandbox, "b.gltf")["materials"][0]["extensions"][OURS].clone();
    for (i, sigma_t) in [2000.0, 1000.0, 500.0].into_iter().enumerate() {
        let scattering = own["scatteringCoefficient"][i].as_f64().unwrap();
        let absorption = own["absorptionCoefficient"][i].as_f64().unwrap();
        assert!((scattering + absorption - sigma_t).abs() < 1e-4 * sigma_t);
        assert!((scattering / sigma_t - 0.9).abs() < 1e-4, "{scattering}");
    }
}

#[test]
fn references_are_not_broken() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedra(MATERIALS, r#"[ { "mesh": 0 } ]"#, Some("data/a%20b.bin")));
    std::fs::create_dir_all(sandbox.path("data")).unwrap();
    std::fs::write(sandbox.path("data/a b.bin"), tetrahedron_data()).unwrap();
    std::fs::create_dir(sandbox.path("out")).unwrap();
    let args = ["edit", "a.gltf", "-o", "out/b.gltf", "--material", "0", "--preset", "marble"];
    sandbox.run(&args).exits(1).says(&["/buffers/0/uri", "--copy-resources"]);
    assert_eq!(std::fs::read_dir(sandbox.path("out")).unwrap().count(), 0);
    sandbox.run(&[&args[..], &["--copy-resources"]].concat()).exits(0);
    assert_eq!(std::fs::read(sandbox.path("out/data/a b.bin")).unwrap(), tetrahedron_data());
    assert_eq!(inspect(&sandbox, "out/b.gltf")["media"][0]["objects"][0]["closed"], json!(true));
    std::fs::write(sandbox.path("out/data/a b.bin"), "another file").unwrap();
    sandbox.run(&[&args[..], &["--copy-resources"]].concat()).exits(1).says(&["exists and is another file"]);
    assert_eq!(std::fs::read(sandbox.path("out/data/a b.bin")).unwrap(), b"another file");
}

#[test]
fn the_surface_is_fixed_on_request_and_warned_about_otherwise() {
    let sandbox = Sandbox::new();
    let materials = r#"[ { "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.1, 0.1, 1], "roughnessFactor": 0.25 }, "alphaMode": "BLEND" } ]"#;
    sandbox.file("a.gltf", tetrahedra(materials, r#"[ { "mesh": 0 } ]"#, None));
    let args = ["edit", "a.gltf", "-o", "b.gltf", "--material", "0", "--preset", "marble"];
    sandbox.run(&args).exits(0).says(&["metallicFactor", "baseColorFactor", "alphaMode"]);
    let run = sandbox.run(&[&args[..], &["--fix-surface"]].concat()).exits(0);
    run.check(!run.stderr.contains("warning"), "should have nothing to warn about");
    let material = read(&sandbox, "b.gltf")["materials"][0].clone();
    assert_eq!(material["pbrMetallicRoughness"], json!({ "roughnessFactor": 0.25, "metallicFactor": 0 }));
    assert!(material.get("alphaMode").is_none());
}

#[test]
fn an_edit_that_changes_nothing_says_so_and_fails() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", wax());
    sandbox.file("none.gltf", triangle(""));
    sandbox.run(&["edit", "a.gltf", "-o", "b.gltf"]).exits(2).says(&["nothing would change", "--material"]);
    sandbox.run(&["edit", "a.gltf", "--in-place"]).exits(2).says(&["nothing would change"]);
    sandbox.run(&["edit", "a.gltf", "-o", "m.gltf", "--material", "0", "--preset", "marble"]).exits(0);
    let written = || std::fs::metadata(sandbox.path("m.gltf")).unwrap().modified().unwrap();
    let before = written();
    let same = ["edit", "m.gltf", "--in-place", "--material", "0"];
    for more in [&["--preset", "marble"][..], &["--ior", "1.5"]] {
        let run = sandbox.run(&[&same[..], more].concat()).exits(1);
        run.says(&["m.gltf: nothing changes", "like that already", "inspect"]);
    }
    assert_eq!(written(), before);
    let remove = ["edit", "a.gltf", "-o", "b.gltf", "--remove", "--material"];
    for (which, why) in [("0", "the material has no medium"), ("*", "none of the materials has a medium")] {
        sandbox.run(&[&remove[..], &[which]].concat()).exits(1).says(&["nothing changes", why]);
    }
    let args = ["edit", "none.gltf", "-o", "b.gltf", "--material", "*", "--preset", "marble"];
    sandbox.run(&args).exits(1).says(&["nothing changes", "no materials"]);
    assert_eq!(sandbox.files(), ["a.gltf", "m.gltf", "none.gltf"]);
    assert!(std::fs::read_to_string(sandbox.path("a.gltf")).unwrap() == wax());
    sandbox.run(&[&args[..], &["--allow-unchanged"]].concat()).exits(0).says(&["nothing changed"]);
    let copy = ["edit", "a.gltf", "-o", "c.gltf", "--allow-unchanged"];
    sandbox.run(&copy).exits(0).says(&["wrote c.gltf (nothing changed)"]);
    assert!(std::fs::read_to_string(sandbox.path("c.gltf")).unwrap() == wax());
}
