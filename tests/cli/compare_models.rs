//! `nephrite compare-models`: the sheet, the numbers beside it, and how it ends.

use super::util::{Run, Sandbox, triangle};
use serde_json::Value;

/// A tetrahedron full of milk.
pub fn tetrahedron() -> String {
    // Positions (0 0 1), (0.943 0 −0.333), (−0.471 ±0.816 −0.333) as floats, then four triangles as 16 bit indices.
    let data =
        "AAAAAAAAAAAAAIA/c2hxPwAAAAD6fqq+6SbxvmDlUD/6fqq+6SbxvmDlUL/6fqq+AAABAAIAAAACAAMAAAADAAEAAQADAAIA";
    format!(
        r#"{{ "asset": {{ "version": "2.0" }},
        "extensionsUsed": ["NEPHRITE_materials_subsurface"],
        "materials": [{{ "pbrMetallicRoughness": {{ "metallicFactor": 0, "roughnessFactor": 0.3 }},
            "extensions": {{ "NEPHRITE_materials_subsurface": {{
                "absorptionCoefficient": [0.1, 0.2, 1], "scatteringCoefficient": [10, 12, 15], "ior": 1.3 }} }} }}],
        "scene": 0, "scenes": [{{ "nodes": [0] }}], "nodes": [{{ "mesh": 0 }}],
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "indices": 1, "material": 0 }}] }}],
        "accessors": [
            {{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
               "min": [-0.471, -0.816, -0.333], "max": [0.943, 0.816, 1] }},
            {{ "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 48 }}, {{ "buffer": 0, "byteOffset": 48, "byteLength": 24 }}],
        "buffers": [{{ "byteLength": 72, "uri": "data:application/octet-stream;base64,{data}" }}] }}"#
    )
}

fn read_json(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(sandbox.path(name)).unwrap()).expect("JSON")
}

fn rows(sandbox: &Sandbox, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(sandbox.path(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn nonsense_is_refused_before_any_work() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedron());
    let compare = |more: &[&'static str]| [&["compare-models", "a.gltf"], more].concat();
    let cases: &[(&[&str], &[&str])] = &[
        (&[], &["--output"]),
        (&["-o", "a.exr"], &["a.exr", ".png"]),
        (&["-o", "a.png", "--models", "dipole,betterdipole"], &["did you mean better-dipole"]),
        (&["-o", "a.png", "--spp", "1"], &["--spp"]),
        (&["-o", "a.png", "--size", "40000x40000"], &["268 million"]),
        (&["-o", "a.png", "--brdf-cosines", "none"], &["refracted"]),
    ];
    for (more, texts) in cases {
        sandbox.run(&compare(more)).exits(2).says(texts);
    }
    sandbox.run(&compare(&["-o", "no/a.png"])).exits(1).says(&["no/a.png", "create the folder"]);
    sandbox
        .run(&compare(&["-o", "a.png", "--size", "5000x5000"]))
        .exits(1)
        .says(&["sheet of 14 pictures", "smaller --size"]);
    assert_eq!(sandbox.files(), ["a.gltf"]);
}

#[test]
fn a_sheet_comes_with_its_numbers() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedron());
    let args = [
        "compare-models",
        "a.gltf",
        "-o",
        "sheet.png",
        "--size",
        "40x30",
        "--spp",
        "15",
        "--models",
        "random-walk,better-dipole,single-scattering",
        "--env",
        "1,1,1",
    ];
    sandbox
        .run(&args)
        .exits(0)
        .says(&["wrote sheet.png, sheet.json, sheet.csv (3 models, 40 × 30, 16 samples"]);
    assert_eq!(sandbox.files(), ["a.gltf", "sheet.csv", "sheet.json", "sheet.png"]);

    let file = std::io::BufReader::new(std::fs::File::open(sandbox.path("sheet.png")).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    assert!(reader.info().width > 160 && reader.info().height > 100, "four cells of a sheet");
    assert!(reader.info().utf8_text.iter().any(|text| text.keyword == "nephrite:options"));

    let json = read_json(&sandbox, "sheet.json");
    assert_eq!((json["spp"].as_u64(), json["reference"]["spp"].as_u64()), (Some(16), Some(60)));
    assert_eq!(json["options"]["brdf_cosines"], "refracted");
    let models = json["models"].as_array().unwrap();
    let number = |model: &Value, key: &str| model[key].as_f64().unwrap_or_else(|| panic!("{key} in {model}"));
    for model in models {
        let parts =
            number(&model["bias"], "value") + number(model, "noise") + number(model, "reference_noise");
        // Apart from the products of both noises.
        let sum = number(model, "rel_mse");
        assert!((parts - sum).abs() < 0.25 * sum, "{model}");
        assert!(number(model, "seconds") > 0.0 && model["mean_ratio"].as_array().unwrap().len() == 3);
    }
    let z = number(&models[0]["bias"], "value") / number(&models[0]["bias"], "standard_error");
    assert!(z.abs() < 4.0, "the random walk has no bias: z {z}");
    let z = number(&models[2]["bias"], "value") / number(&models[2]["bias"], "standard_error");
    assert!(z > 10.0, "single scattering alone has: z {z}");
    let ratio = number(&models[2]["mean_ratio"][0], "value");
    assert!(ratio < 0.99, "and is darker: {ratio}");

    let rows = rows(&sandbox, "sheet.csv");
    assert!(rows.len() == 4 && rows.iter().all(|row| row.len() == rows[0].len()), "{rows:?}");
    let names: Vec<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(names, ["model", "random-walk", "better-dipole", "single-scattering"]);
    let at = rows[0].iter().position(|name| name == "rel_mse").unwrap();
    assert_eq!(rows[2][at].parse::<f64>().unwrap(), number(&models[1], "rel_mse"));
}

#[test]
fn numbers_depend_neither_on_threads_nor_on_other_models() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedron());
    let found = |name: &str, models: &str, threads: &str| {
        let args = [
            "compare-models",
            "a.gltf",
            "-o",
            &format!("{name}.png"),
            "--size",
            "16x12",
            "--spp",
            "4",
            "--models",
            models,
            "--threads",
            threads,
        ];
        sandbox.run(&args).exits(0);
        let json = read_json(&sandbox, &format!("{name}.json"));
        let models = json["models"].as_array().unwrap();
        let dipole = models.iter().find(|model| model["name"] == "dipole-diffuse").unwrap();
        (dipole["rel_mse"].clone(), dipole["mean"].clone())
    };
    let alone = found("a", "dipole-diffuse", "1");
    assert_eq!(alone, found("b", "random-walk,dipole-diffuse", "2"));
}

#[test]
fn scenes_without_media_are_pointed_out() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let args = [
        "compare-models",
        "a.gltf",
        "-o",
        "a.png",
        "--size",
        "8x8",
        "--spp",
        "2",
        "--models",
        "dipole",
        "-q",
    ];
    sandbox.run(&args).exits(0).says(&["warning: nothing in the scene has a medium"]);
}

#[cfg(unix)]
#[test]
fn interrupted_comparisons_write_the_models_that_are_finished() {
    use std::process::{Command, Stdio};
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", tetrahedron());
    let interrupt = |args: &[&str]| {
        let child = sandbox.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(2500));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        Run::new(args, child.wait_with_output().unwrap()).exits(130)
    };
    let args = ["compare-models", "a.gltf", "-o", "a.png", "--size", "8x8", "--env", "1,1,1"];
    let endless = [&args[..], &["--spp", "100000000"]].concat();
    interrupt(&endless).says(&["stopping", "interrupted before any model", "nothing is written"]);
    assert_eq!(sandbox.files(), ["a.gltf"]);

    // Single scattering is done within a second, and so are two samples of the reference; thousands of walks through a hundred
    // thousand mean free paths are not.
    let dense =
        tetrahedron().replace("[0.1, 0.2, 1]", "[0, 0, 0]").replace("[10, 12, 15]", "[1e5, 1e5, 1e5]");
    sandbox.file("a.gltf", dense);
    let models = ["--models", "single-scattering,random-walk", "--spp", "16000", "--reference-spp", "2"];
    interrupt(&[&args[..], &models].concat()).says(&["interrupted: the sheet has 1 of 2 models"]);
    assert_eq!(sandbox.files(), ["a.csv", "a.gltf", "a.json", "a.png"]);
    let json = read_json(&sandbox, "a.json");
    assert_eq!(json["models"].as_array().unwrap().len(), 1);
    assert_eq!(json["models"][0]["name"], "single-scattering");
}

#[test]
fn help_says_where_the_numbers_go() {
    let run = Sandbox::new().run(&["compare-models", "--help"]).exits(0);
    for text in ["sheet.json", "sheet.csv", "--reference-spp", "--models", "--env", "480"] {
        run.check(run.stdout.contains(text), text);
    }
}
