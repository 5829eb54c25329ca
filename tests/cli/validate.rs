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

/// The drafts of OpenPBR: what they exclude and allow is told, `inspect` names them, `edit` keeps them.
#[test]
fn drafts_are_validated_named_and_kept() {
    let sandbox = Sandbox::new();
    let file = |more: &str| {
        let drafts = r#""KHR_materials_coat": { "coatFactor": 2, "coatIor": 0.5, "coatColorFactor": [1, 0.5, 0.25] },
            "KHR_materials_fuzz": { "fuzzFactor": 0.5, "fuzzRoughnessFactor": 0.25 },
            "KHR_materials_diffuse_roughness": { "diffuseRoughnessFactor": 0.75, "extras": { "kept": true } }"#;
        let materials = format!(r#"[ {{ "name": "Dusty", "extensions": {{ {drafts} {more} }} }} ]"#);
        let used = r#"{ "extensionsUsed": [ "KHR_materials_coat", "KHR_materials_fuzz",
            "KHR_materials_diffuse_roughness", "KHR_materials_unlit" ],"#;
        tetrahedra(&materials, r#"[ { "mesh": 0 } ]"#, None).replacen('{', used, 1)
    };
    sandbox.file("a.gltf", file(r#", "KHR_materials_unlit": {}"#));
    let run = sandbox.run(&["validate", "a.gltf", "--json"]).exits(0);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    let at = |name: &str| format!("/materials/0/extensions/{name}");
    let excluded: Vec<String> = find(&report, "must not be on a material that has KHR_materials_unlit")
        .iter()
        .map(|f| f.1.to_owned())
        .collect();
    let names = ["KHR_materials_coat", "KHR_materials_diffuse_roughness", "KHR_materials_fuzz"];
    for name in names {
        assert!(excluded.contains(&at(name)), "{name}: {report}");
    }
    for wrong in ["coatFactor", "coatIor"] {
        let pointer = format!("{}/{wrong}", at(names[0]));
        assert!(report["findings"].as_array().unwrap().iter().any(|f| f["pointer"] == pointer), "{wrong}");
    }
    sandbox.file("b.gltf", file(""));
    sandbox
        .run(&["render", "a.gltf", "-o", "a.png", "--strict"])
        .exits(1)
        .says(&["must not be on a material"]);
    let run = sandbox.run(&["inspect", "b.gltf"]).exits(0);
    run.check(run.stdout.contains("fuzz, coat, diffuse roughness"), "should name the layers");
    let edit = ["edit", "b.gltf", "-o", "c.gltf", "--material", "Dusty", "--preset", "marble"];
    sandbox.run(&edit).exits(0);
    let document = |name: &str| -> Value {
        serde_json::from_slice(&std::fs::read(sandbox.path(name)).unwrap()).unwrap()
    };
    let (before, after) = (document("b.gltf"), document("c.gltf"));
    for name in names {
        assert_eq!(before.pointer(&at(name)), after.pointer(&at(name)), "{name}");
        assert!(after.pointer(&at(name)).is_some() && after["extensionsUsed"].to_string().contains(name));
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

/// Corners and triangles of a box.
type Solid = (Vec<[f32; 3]>, Vec<[u16; 3]>);

fn cuboid(low: [f32; 3], high: [f32; 3]) -> Solid {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), triangles.collect())
}

fn cube(at: [f32; 3]) -> Solid {
    cuboid(at, at.map(|x| x + 1.0))
}

fn flipped((corners, triangles): Solid) -> Solid {
    (corners, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect())
}

fn joined(parts: impl IntoIterator<Item = Solid>) -> Solid {
    parts.into_iter().fold((Vec::new(), Vec::new()), |(mut corners, mut triangles), (more, of_more)| {
        let first = corners.len() as u16;
        corners.extend(more);
        triangles.extend(of_more.into_iter().map(|t: [u16; 3]| t.map(|i| i + first)));
        (corners, triangles)
    })
}

/// What is found in a file of those meshes, each at a node, with one medium.
fn validated(meshes: &[Solid]) -> Value {
    use base64::Engine;
    use serde_json::json;
    let (mut views, mut accessors, mut list) = (Vec::new(), Vec::new(), Vec::new());
    let mut bytes: Vec<u8> = Vec::new();
    for (corners, triangles) in meshes {
        for (data, kind, component, count) in [
            (
                corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>(),
                "VEC3",
                5126,
                corners.len(),
            ),
            (
                triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect(),
                "SCALAR",
                5123,
                3 * triangles.len(),
            ),
        ] {
            views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
            accessors.push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
            bytes.extend(data);
        }
        let primitive = json!({"attributes": {"POSITION": accessors.len() - 2}, "indices": accessors.len() - 1, "material": 0});
        list.push(json!({"primitives": [primitive]}));
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": (0..meshes.len()).collect::<Vec<_>>()}],
        "nodes": (0..meshes.len()).map(|mesh| json!({"mesh": mesh})).collect::<Vec<_>>(),
        "meshes": list, "accessors": accessors, "bufferViews": views,
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {OURS: {"absorptionCoefficient": [1, 1, 1]}}}], "extensionsUsed": [OURS],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}")}],
    });
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", document.to_string());
    serde_json::from_str(&sandbox.run(&["validate", "a.gltf", "--json"]).stdout).unwrap()
}

/// Severity, pointer and beginning of all findings but those of other viewers.
fn findings(meshes: &[Solid]) -> Vec<[String; 3]> {
    let report = validated(meshes);
    let findings = report["findings"].as_array().unwrap().iter();
    let text = |f: &Value, key: &str| f[key].as_str().unwrap().to_owned();
    let all = findings.map(|f| [text(f, "severity"), text(f, "pointer"), text(f, "message")]);
    all.filter(|[_, _, message]| !message.starts_with("there is nothing that other viewers")).collect()
}

#[track_caller]
fn finds(meshes: &[Solid], expected: &[[&str; 3]]) {
    let found = findings(meshes);
    let as_expected = |(found, expected): (&[String; 3], &[&str; 3])| {
        found[..2] == expected[..2] && found[2].starts_with(expected[2])
    };
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(as_expected), "{found:#?}");
}

#[test]
fn bodies_that_share_faces_are_counted_as_bodies() {
    let row = |n: u8| (0..n).map(|i| cube([f32::from(i), 0.0, 0.0])).collect::<Vec<_>>();
    finds(
        &row(2),
        &[["note", "/nodes/0", "2 bodies touch: \"node 0\" (/nodes/0) and \"node 1\" (/nodes/1)"]],
    );
    finds(&row(4), &[["note", "/nodes/0", "4 bodies touch: such as"]]);
    // Only a part of a face, and one that is inside out.
    let aside = flipped(cube([1.0, 0.5, 0.25]));
    finds(
        &[cube([0.0; 3]), aside],
        &[
            ["warning", "/meshes/1", "1 of 1 part is inside out; it is turned here"],
            ["note", "/nodes/0", "2 bodies touch:"],
        ],
    );
    // Only an edge, a corner, or nothing.
    for apart in [[1.0, 1.0, 0.0], [1.0; 3], [2.0, 0.0, 0.0]] {
        finds(&[cube([0.0; 3]), cube(apart)], &[]);
    }
    // Parts of one mesh.
    finds(&[joined(row(3))], &[["note", "/meshes/0", "3 of 3 parts share faces with each other"]]);
    finds(&[joined([cube([0.0; 3]), cube([1.0, 1.0, 0.0])])], &[]);
}

#[test]
fn bodies_that_cross_are_found_where_no_vertex_is_inside() {
    let rods = [cuboid([-3.0, 0.0, 0.0], [3.0, 1.0, 1.0]), cuboid([0.0, -3.0, 0.2], [1.0, 3.0, 0.8])];
    finds(
        &rods,
        &[["warning", "/nodes/0", "\"node 0\" overlaps \"node 1\" (/nodes/1) and has the same priority"]],
    );
    finds(&[joined(rods)], &[["warning", "/meshes/0", "2 of 2 parts cross each other"]]);
    // Moved along an axis, all faces but two are in common planes.
    let slid = [cube([0.0; 3]), cube([0.5, 0.0, 0.0])];
    finds(&slid, &[["warning", "/nodes/0", "\"node 0\" overlaps \"node 1\""]]);
    let with_one_apart = joined(slid.into_iter().chain([cube([3.0; 3])]));
    finds(&[with_one_apart], &[["warning", "/meshes/0", "2 of 3 parts cross each other"]]);
    // What faces inwards and only crosses is no cavity.
    let crossing = joined([cube([0.0; 3]), flipped(cube([0.5; 3]))]);
    finds(
        &[crossing],
        &[
            ["warning", "/meshes/0", "1 of 2 parts is inside out; it is turned here"],
            ["warning", "/meshes/0", "2 of 2 parts cross each other"],
        ],
    );
}

#[test]
fn nested_bodies_and_cavities_are_no_mistakes() {
    let (outer, inner) = (cuboid([-1.0; 3], [2.0; 3]), cube([0.0; 3]));
    finds(&[joined([outer.clone(), flipped(inner.clone())])], &[]);
    finds(&[outer.clone(), inner], &[["note", "/nodes/1", "\"node 1\" is inside \"node 0\" (/nodes/0)"]]);
    // A body that fills a cavity shares all of its faces with it.
    let hollow = joined([outer, flipped(cube([0.0; 3]))]);
    finds(&[hollow, cube([0.0; 3])], &[["note", "/nodes/0", "2 bodies touch:"]]);
}

#[test]
fn a_body_that_crosses_itself_is_told_of() {
    // A prism over a figure of eight, of one turn each way, and one whose ends do not cross.
    let prism = |base: [[f32; 2]; 4]| {
        let corners = [0.0, 1.0].into_iter().flat_map(|z| base.map(|[x, y]| [x, y, z])).collect();
        let walls = (0..4u16).flat_map(|i| {
            let j = (i + 1) % 4;
            [[i, j, j + 4], [i, j + 4, i + 4]]
        });
        (corners, walls.chain([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]).collect())
    };
    let eight = prism([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.5]]);
    let square = prism([[3.0, 0.0], [4.0, 0.0], [4.0, 1.0], [3.0, 1.0]]);
    let crosses = |found: &[[String; 3]]| {
        found
            .iter()
            .filter(|f| f[0] == "warning" && f[2].contains("crosses itself"))
            .map(|f| f[2][..12].to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(crosses(&findings(std::slice::from_ref(&eight))), ["1 of 1 part "]);
    assert_eq!(crosses(&findings(&[joined([eight, square.clone()])])), ["1 of 2 parts"]);
    finds(&[square], &[]);
}

#[test]
fn what_is_there_twice_is_told_of() {
    let twice = [cube([0.0; 3]), cube([0.0; 3])];
    finds(&twice, &[["warning", "/nodes/0", "2 bodies are in the very place of equal ones:"]]);
    finds(&[joined(twice)], &[["warning", "/meshes/0", "1 of 1 part is in the very place of an equal one"]]);
}

#[test]
fn seams_are_closed_within_the_tolerance_that_is_asked_for() {
    let sandbox = Sandbox::new();
    let text = tetrahedra(&material(MARBLE), r#"[ { "mesh": 0, "scale": [2, 2, 2] } ]"#, None);
    // Every triangle gets its own corners, moved by a hundredth of a millimetre at most.
    let mut document: Value =
        serde_json::from_str(&text.replacen('{', &format!(r#"{{ "extensionsUsed": ["{OURS}"],"#), 1))
            .unwrap();
    let corners = [[0.5f32, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];
    let faces = [[0usize, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    let moved = faces
        .iter()
        .flatten()
        .enumerate()
        .flat_map(|(i, &k)| corners[k].map(|x| x + 1e-5 * ((i * 7 % 5) as f32 / 4.0 - 0.5)));
    let bytes: Vec<u8> = moved.flat_map(f32::to_le_bytes).collect();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    document["buffers"] = serde_json::json!([{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}")}]);
    document["bufferViews"] = serde_json::json!([{"buffer": 0, "byteLength": bytes.len()}]);
    document["accessors"] =
        serde_json::json!([{"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3"}]);
    document["meshes"] =
        serde_json::json!([{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]);
    sandbox.file("a.gltf", document.to_string());
    for (tolerance, code) in [(None, 1), (Some("1e-4"), 0), (Some("1e-6"), 1), (Some("0"), 1)] {
        let mut args = vec!["validate", "a.gltf"];
        args.extend(tolerance.iter().flat_map(|t| ["--weld-tolerance", t]));
        sandbox.run(&args).exits(code);
        args[0] = "inspect";
        let run = sandbox.run(&args).exits(0);
        let text = if code == 0 { "closed; seams are welded, which moves" } else { "NOT CLOSED" };
        run.check(run.stdout.contains(text), text);
    }
}
