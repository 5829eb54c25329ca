//! The written specification holds together: examples, assets, schema, property table and test vectors agree.
//!
//! Every fenced JSON block of the specification is preceded by a comment that names a complete asset; the block is the
//! beginning of that asset's materials. Every asset is rendered, with the extension and without it.

use nephrite::asset::{self, LoadOptions};
use nephrite::film::Picture;
use nephrite::scene::Scene;
use nephrite::transport::{self, RenderOptions};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

const EXTENSION: &str = "NEPHRITE_materials_subsurface";

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("extensions").join(EXTENSION)
}

fn text(path: &str) -> String {
    let path = folder().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn document(path: &str) -> Value {
    serde_json::from_str(&text(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The complete assets of the specification, relative to its folder, in alphabetical order.
fn example_assets() -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder().join("examples"))
        .expect("the folder of examples")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("an UTF-8 name"))
        .filter(|name| name.ends_with(".gltf"))
        .map(|name| format!("examples/{name}"))
        .collect();
    names.sort();
    names
}

/// The fenced JSON blocks of the specification with the asset that the line above each names.
fn fenced_examples() -> Vec<(String, Value)> {
    let readme = text("README.md");
    let lines: Vec<&str> = readme.lines().collect();
    let mut found = Vec::new();
    for (at, _) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("```json")) {
        let asset = lines[at - 1]
            .strip_prefix("<!-- ")
            .and_then(|line| line.strip_suffix(" -->"))
            .unwrap_or_else(|| panic!("README.md line {}: no asset is named above this example", at + 1));
        let body: Vec<&str> =
            lines[at + 1..].iter().take_while(|line| !line.starts_with("```")).copied().collect();
        let value = serde_json::from_str(&body.join("\n"))
            .unwrap_or_else(|error| panic!("README.md, example from line {}: {error}", at + 1));
        found.push((asset.to_string(), value));
    }
    found
}

/// Runs `check` with a validator for the extension object.
fn with_validator(check: impl FnOnce(&dyn Fn(&Value) -> Result<(), String>)) {
    let base = "https://example.org/schema/";
    let named = |file: &str| {
        let mut schema = document(&format!("schema/{file}"));
        assert_eq!(schema["$id"], file, "$id of schema/{file}");
        schema["$id"] = json!(format!("{base}{file}"));
        schema
    };
    let registry = jsonschema::Registry::new()
        .add(format!("{base}glTFProperty.schema.json"), named("glTFProperty.schema.json"))
        .and_then(|registry| {
            registry.add(format!("{base}textureInfo.schema.json"), named("textureInfo.schema.json"))
        })
        .and_then(|registry| registry.prepare())
        .expect("the referenced schemas");
    let schema = named("material.NEPHRITE_materials_subsurface.schema.json");
    let validator =
        jsonschema::draft202012::options().with_registry(&registry).build(&schema).expect("the schema");
    check(&|instance| {
        let errors: Vec<String> = validator
            .iter_errors(instance)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        if errors.is_empty() { Ok(()) } else { Err(errors.join("; ")) }
    });
}

/// The extension objects of a document's materials, with their JSON pointers.
fn extension_objects(document: &Value) -> Vec<(String, &Value)> {
    let materials = document["materials"].as_array().expect("materials");
    let objects = materials.iter().enumerate();
    objects
        .filter_map(|(i, m)| {
            Some((format!("/materials/{i}/extensions/{EXTENSION}"), m["extensions"].get(EXTENSION)?))
        })
        .collect()
}

#[test]
fn schemas_are_schemas() {
    for file in ["material.NEPHRITE_materials_subsurface", "glTFProperty", "textureInfo"] {
        let schema = document(&format!("schema/{file}.schema.json"));
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{file}");
        assert!(jsonschema::draft202012::meta::is_valid(&schema), "{file} is not a valid schema");
    }
}

#[test]
fn every_example_satisfies_the_schema() {
    with_validator(|validate| {
        let fenced = fenced_examples();
        assert!(fenced.len() >= 8, "only {} examples found", fenced.len());
        let complete = example_assets().into_iter().map(|asset| (asset.clone(), document(&asset)));
        for (source, value) in fenced.into_iter().chain(complete) {
            let objects = extension_objects(&value);
            assert!(!objects.is_empty(), "{source}: no extension object");
            for (pointer, object) in objects {
                assert_eq!(validate(object), Ok(()), "{source} {pointer}");
            }
        }
    });
}

#[test]
fn every_example_is_the_beginning_of_its_asset() {
    let fenced = fenced_examples();
    for (asset, example) in &fenced {
        let whole = document(asset);
        let quoted = example["materials"].as_array().expect("materials");
        assert_eq!(quoted[..], whole["materials"].as_array().expect("materials")[..quoted.len()], "{asset}");
    }
    let quoted: BTreeSet<&String> = fenced.iter().map(|(asset, _)| asset).collect();
    let assets = example_assets();
    assert_eq!(quoted, assets.iter().collect(), "assets quoted on the page and assets in the folder");
}

#[test]
fn assets_are_self_contained_and_list_the_extension_as_optional() {
    for asset in example_assets() {
        let whole = document(&asset);
        let listed: Vec<&str> =
            whole["extensionsUsed"].as_array().expect("used").iter().filter_map(Value::as_str).collect();
        assert!(listed.contains(&EXTENSION), "{asset}");
        assert!(whole.get("extensionsRequired").is_none(), "{asset}");
        for list in ["buffers", "images"] {
            for entry in whole[list].as_array().into_iter().flatten() {
                assert!(
                    entry["uri"].as_str().is_some_and(|uri| uri.starts_with("data:")),
                    "{asset}: /{list}"
                );
            }
        }
    }
}

#[test]
fn values_out_of_range_are_refused() {
    let wrong = [
        json!({ "absorptionCoefficient": [-1, 0, 0] }),
        json!({ "absorptionCoefficient": [1, 2] }),
        json!({ "absorptionCoefficient": [1, 2, 3, 4] }),
        json!({ "absorptionCoefficient": 5 }),
        json!({ "absorptionCoefficient": ["1", "2", "3"] }),
        json!({ "scatteringCoefficient": [0, 0, -1e-9] }),
        json!({ "scatteringCoefficient": null }),
        json!({ "scatterAnisotropy": 1 }),
        json!({ "scatterAnisotropy": -1 }),
        json!({ "scatterAnisotropy": [0.9, 0.9, 0.9] }),
        json!({ "ior": 0.999 }),
        json!({ "ior": 0 }),
        json!({ "densityFactor": -0.5 }),
        json!({ "priority": 0.5 }),
        json!({ "priority": 2147483648_i64 }),
        json!({ "absorptionTexture": {} }),
        json!({ "absorptionTexture": 0 }),
        json!({ "scatteringTexture": { "index": -1 } }),
        json!({ "scatteringTexture": { "index": 0, "texCoord": -1 } }),
        json!({ "extensions": [] }),
        json!([]),
    ];
    let right = [
        json!({}),
        json!({ "absorptionCoefficient": [0, 0, 0], "scatteringCoefficient": [1e7, 0, 0.5] }),
        json!({ "scatterAnisotropy": -0.999, "ior": 1, "densityFactor": 0, "priority": -3 }),
        json!({ "absorptionTexture": { "index": 3, "texCoord": 1, "extensions": { "KHR_texture_transform": {} } } }),
        json!({ "extras": 7, "extensions": { "ANY_thing": {} } }),
    ];
    with_validator(|validate| {
        for value in &wrong {
            assert!(validate(value).is_err(), "accepted: {value}");
        }
        for value in &right {
            assert_eq!(validate(value), Ok(()), "refused: {value}");
        }
    });
}

#[test]
fn the_property_table_and_the_schema_name_the_same_properties() {
    let readme = text("README.md");
    let table: BTreeSet<String> = readme
        .lines()
        .filter_map(|line| line.strip_prefix("| **")?.split("**").next().map(str::to_string))
        .collect();
    let schema = document("schema/material.NEPHRITE_materials_subsurface.schema.json");
    let properties = schema["properties"].as_object().expect("properties").keys().cloned();
    let expected: BTreeSet<String> =
        properties.filter(|name| name != "extensions" && name != "extras").collect();
    assert_eq!(table, expected);
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn assert_close(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() <= 1e-8 * expected.abs(), "{what}: {actual} is not {expected}");
}

#[test]
fn derived_test_vectors_follow_from_the_formulas() {
    let readme = text("README.md");
    for medium in document("test-vectors.json")["derived"].as_array().expect("derived") {
        let (given, expected) = (&medium["extension"], &medium["expected"]);
        let density = given["densityFactor"].as_f64().expect("density");
        let g = given["scatterAnisotropy"].as_f64().expect("g");
        let sigma_a: Vec<f64> =
            numbers(&given["absorptionCoefficient"]).iter().map(|v| v * density).collect();
        let sigma_s: Vec<f64> =
            numbers(&given["scatteringCoefficient"]).iter().map(|v| v * density).collect();
        let extinction: Vec<f64> = sigma_a.iter().zip(&sigma_s).map(|(a, s)| a + s).collect();
        let distance = 1.0 / extinction.iter().copied().fold(0.0, f64::max);
        assert_close(distance, expected["attenuationDistance"].as_f64().expect("d"), "attenuationDistance");
        for i in 0..3 {
            let (a, s, t) = (sigma_a[i], sigma_s[i], extinction[i]);
            let albedo = s / t;
            let similar = ((1.0 - albedo) / (1.0 - g * albedo)).sqrt();
            let multiple = (1.0 - similar) * (1.0 - 0.139 * similar) / (1.0 + 1.17 * similar);
            let reduced = s * (1.0 - g);
            for (name, value) in [
                ("sigma_a", a),
                ("sigma_s", s),
                ("sigma_t", t),
                ("meanFreePath", 1.0 / t),
                ("singleScatteringAlbedo", albedo),
                ("reducedScattering", reduced),
                ("reducedAlbedo", reduced / (reduced + a)),
                ("attenuationColor", (-t * distance).exp()),
                ("multiscatterAlbedo", multiple),
            ] {
                assert_close(value, numbers(&expected[name])[i], name);
            }
            let s = 4.09712 + 4.20863 * multiple
                - (9.59217 + 41.6808 * multiple + 17.7126 * multiple * multiple).sqrt();
            let back = (1.0 - s * s) / (1.0 - g * s * s);
            assert!((back - albedo).abs() < 1e-5, "the draft's mapping gives {back} for {albedo}");
        }
        for name in ["sigma_t", "meanFreePath", "singleScatteringAlbedo", "multiscatterAlbedo"] {
            let row: Vec<String> = numbers(&expected[name]).iter().map(f64::to_string).collect();
            assert!(
                readme.contains(&row.join(", ")),
                "README.md lacks {name} of {}: {row:?}",
                medium["name"]
            );
        }
    }
}

#[test]
fn phase_function_vectors_follow_from_the_formula() {
    for case in document("test-vectors.json")["henyeyGreenstein"]["cases"].as_array().expect("cases") {
        let [g, cos, p] = ["g", "cos", "p"].map(|name| case[name].as_f64().expect("a number"));
        let denominator = (1.0 + g * g - 2.0 * g * cos).powf(1.5);
        assert_close((1.0 - g * g) / (4.0 * std::f64::consts::PI * denominator), p, "p");
    }
}

#[test]
fn half_space_table_is_that_of_the_file() {
    let readme = text("README.md");
    for case in document("test-vectors.json")["halfSpace"]["cases"].as_array().expect("cases") {
        let pair = format!("{}, {}", case["perpendicular"], case["diffuse"]);
        assert!(readme.contains(&pair), "README.md lacks {pair}");
    }
}

/// A small picture of an asset.
fn picture(document: &Value, source: &str) -> Picture {
    let bytes = serde_json::to_vec(document).expect("JSON");
    let loaded = asset::load_bytes(bytes, &folder().join("examples"), &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{source}: {error}"));
    let camera = loaded.scene.cameras.first().unwrap_or_else(|| panic!("{source} has no camera")).clone();
    let scene = Scene::build(loaded.scene).unwrap_or_else(|error| panic!("{source}: {error}"));
    let options = RenderOptions::new(camera).with(|o| {
        o.view.width = 32;
        o.view.height = 24;
        o.samples.count = 16;
        o.settings.seed = 1;
    });
    transport::render(&scene, &options, &()).unwrap_or_else(|error| panic!("{source}: {error}")).picture
}

#[test]
fn every_example_renders_and_the_extension_does_something() {
    for source in example_assets() {
        let with = document(&source);
        let mut without = with.clone();
        for material in without["materials"].as_array_mut().expect("materials") {
            if let Some(extensions) = material.get_mut("extensions").and_then(Value::as_object_mut) {
                extensions.retain(|name, _| name == "KHR_materials_emissive_strength");
            }
        }
        let [with, without] = [with, without].map(|document| picture(&document, &source).mean());
        assert!(with.iter().all(|mean| mean.is_finite() && *mean > 0.01), "{source}: mean radiance {with:?}");
        let apart = with.iter().zip(&without).any(|(a, b)| (a - b).abs() > 0.01 * b);
        assert!(apart, "{source}: {with:?} with the extension, {without:?} without it");
    }
}
