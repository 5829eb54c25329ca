//! The pages of `docs/`, the front page, those of the samples and of the conformance suite: commands work, links lead somewhere.
//!
//! A block of the language `sh` holds commands, and commands are found nowhere else. Those of a page run one after the
//! other in a scratch copy of what they need of the repository, and each must end with 0:
//!
//! - Options that cost time are set to little ([`REDUCED`]), whatever the page says.
//! - `conformance` finds only the cheapest cases in its folder ([`CASES`]); `--update-references` finds one that has a
//!   reference, with one sample. The renderer of `--renderer` is nephrite: others need not be there, but the page's own
//!   command must have the places that it has to have.
//! - Files of the reader's own are small ones of ours ([`own_files`]).
//! - A command that ran for another page does not run again.
//! - Commands of other programs do not run. They are listed ([`OTHERS`]), so that nobody adds one unseen.

use super::util::{Sandbox, glb, tetrahedra, triangle};
use nephrite::conformance::CommandTemplate;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// How commands say `nephrite`.
const PROGRAM: [&str; 2] = ["nephrite ", "cargo run --release -- "];

/// A command, a word that it must have for this to count, and the options that are set.
const REDUCED: [(&str, &str, &[&str]); 4] = [
    ("render", "", &["--size", "16x12", "--spp", "1"]),
    ("compare-models", "", &["--size", "16x12", "--spp", "2", "--reference-spp", "2"]),
    ("profile", "", &["--paths", "1000"]),
    ("presets", "-o", &["--spp", "1", "--radius", "0.001", "--side", "16"]),
];

/// Cases that take less than a second with the samples that they ask for.
const CASES: [&str; 3] = ["absorption", "camera-inside", "khr-volume"];
/// A case that has a reference.
const REFERENCE: &str = "rough-06";

/// Commands of other programs.
const OTHERS: [&str; 14] = [
    "blender -b scene.blend --python samples/from-blender/to_nephrite.py -- scene.glb",
    "cargo install --path .",
    "cargo test --release",
    "cargo test --release --test physics -- --ignored --nocapture colours_that_were_asked_for",
    "for name in samples/*/*.glb; do nephrite render \"$name\" -o \"${name%.glb}.png\" --size 480x360 --spp 64; done",
    "mdbook build docs",
    "node -e \"require('gltf-validator').validateBytes(new Uint8Array(require('fs').readFileSync('milk.glb'))).then(r => console.log(JSON.stringify(r.issues, null, 2)))\"",
    "npm install gltf-validator",
    "pip install bpy==4.5.15",
    "pip install bpy==5.0.1 numpy        # Python 3.11",
    "pip install mitsuba numpy",
    "python3 samples/make/build.py --meshes MESHES [NAME ...]",
    "python3 samples/conformance/make/build.py                  # Python 3.10 or newer, numpy",
    "python3 samples/from-blender/to_nephrite.py scene.blend scene.glb",
];

/// Pages with their text, paths relative to the repository.
fn pages() -> Vec<(PathBuf, String)> {
    let docs = std::fs::read_dir(Path::new(ROOT).join("docs")).expect("docs/");
    let names = docs.map(|entry| Path::new("docs").join(entry.expect("an entry").file_name()));
    let mut paths: Vec<PathBuf> = names.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    paths.extend(["README.md", "samples/README.md", "samples/conformance/README.md"].map(PathBuf::from));
    let samples = std::fs::read_dir(Path::new(ROOT).join("samples")).expect("samples/");
    let of_sample = samples
        .map(|entry| Path::new("samples").join(entry.expect("an entry").file_name()).join("README.md"));
    paths.extend(
        of_sample
            .filter(|page| !page.starts_with("samples/conformance") && Path::new(ROOT).join(page).exists()),
    );
    paths.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(Path::new(ROOT).join(&path)).expect("a page");
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// The lines of a page, each with the language of the block that it is in; `None` outside of fences.
fn lines(text: &str) -> Vec<(Option<&str>, &str)> {
    let mut language = None;
    let mut all = Vec::new();
    for line in text.lines() {
        match line.trim_start().strip_prefix("```") {
            Some(name) if language.is_none() => language = Some(name),
            Some(_) => language = None,
            None => all.push((language, line)),
        }
    }
    all
}

/// The commands of a page; a line that ends with a backslash goes on in the next.
fn commands(text: &str) -> Vec<String> {
    let shell: Vec<&str> = lines(text)
        .into_iter()
        .filter(|(language, _)| *language == Some("sh"))
        .map(|(_, line)| line)
        .collect();
    let joined = shell.join("\n").replace("\\\n", " ");
    joined.lines().filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

/// Sets an option, or adds it.
fn set(words: &mut Vec<String>, option: &str, value: &str) {
    match words.iter().position(|word| word == option) {
        Some(at) => words[at + 1] = value.to_owned(),
        None => words.extend([option.to_owned(), value.to_owned()]),
    }
}

/// Files that pages take for the reader's own.
fn own_files(sandbox: &Sandbox) {
    let body = |material| tetrahedra(material, r#"[{ "mesh": 0 }]"#, None);
    let scattering = r#"[{ "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 0.1, "attenuationColor": [0.9, 0.8, 0.7] },
        "KHR_materials_scatter": { "multiscatterColorFactor": [0.9, 0.8, 0.7], "scatterStrengthFactor": 1 } } }]"#;
    let plain = body(r#"[{ "name": "Cow" }]"#);
    sandbox.file("cow.glb", glb(&plain));
    sandbox.file("soap.glb", glb(&plain));
    sandbox.file("milk.gltf", plain);
    sandbox.file("milk.glb", glb(&body(scattering)));
    sandbox.file("draft.gltf", body(scattering));
    // Times 0 1, translations (0 0 0) (2 0 0).
    let keys = "data:application/octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAABAAAAAAAAAAAA=";
    let mut figure: serde_json::Value = serde_json::from_str(&triangle("")).expect("JSON");
    let accessors = [
        json!({"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}),
        json!({"bufferView": 1, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3"}),
    ];
    figure["accessors"].as_array_mut().expect("a list").extend(accessors);
    figure["buffers"].as_array_mut().expect("a list").push(json!({"byteLength": 32, "uri": keys}));
    figure["bufferViews"].as_array_mut().expect("a list").push(json!({"buffer": 1, "byteLength": 32}));
    figure["animations"] = json!([{
        "name": "walk",
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 1, "output": 2}],
    }]);
    sandbox.file("figure.glb", figure.to_string());
}

/// Copies a folder of the repository, without the folders in it.
fn copy(sandbox: &Sandbox, folder: &str) {
    std::fs::create_dir_all(sandbox.path(folder)).expect("a folder");
    for entry in std::fs::read_dir(Path::new(ROOT).join(folder)).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            let to = sandbox.path(folder).join(path.file_name().expect("a name"));
            std::fs::copy(&path, to).expect("copied");
        }
    }
}

/// The suite as a command needs it.
fn suite(sandbox: &Sandbox, references: bool) {
    // It is not there before the first command.
    let _ = std::fs::remove_dir_all(sandbox.path("samples/conformance"));
    if !references {
        CASES.iter().for_each(|case| copy(sandbox, &format!("samples/conformance/{case}")));
        return;
    }
    copy(sandbox, &format!("samples/conformance/{REFERENCE}"));
    let path = format!("samples/conformance/{REFERENCE}/expect.toml");
    let text = std::fs::read_to_string(sandbox.path(&path)).expect("a description");
    let fewer = |line: &str| if line.starts_with("spp = ") { "spp = 1".to_owned() } else { line.to_owned() };
    sandbox.file(&path, text.lines().map(fewer).collect::<Vec<_>>().join("\n"));
}

/// The words of a command of nephrite, as they are run.
fn reduced(sandbox: &Sandbox, command: &str) -> Vec<String> {
    let mut words = shlex::split(command).unwrap_or_else(|| panic!("an open quote: {command}"));
    for (name, needs, options) in REDUCED {
        if words[0] == name && (needs.is_empty() || words.iter().any(|word| word == needs)) {
            options.chunks(2).for_each(|pair| set(&mut words, pair[0], pair[1]));
        }
    }
    if words[0] == "conformance" {
        suite(sandbox, words.iter().any(|word| word == "--update-references"));
        if let Some(at) = words.iter().position(|word| word == "--renderer") {
            CommandTemplate::new(&words[at + 1], Duration::from_secs(1)).expect("a template");
            words[at + 1] = format!(
                "'{}' render -q {{input}} -o {{output}} --size {{width}}x{{height}} --spp {{spp}} --seed {{seed}}",
                env!("CARGO_BIN_EXE_nephrite")
            );
        }
    }
    words
}

#[test]
fn every_command_works() {
    let sandbox = Sandbox::new();
    for entry in std::fs::read_dir(Path::new(ROOT).join("samples")).expect("samples/") {
        let name = entry.expect("an entry").file_name().into_string().expect("UTF-8");
        if !name.contains('.') && !["conformance", "make"].contains(&name.as_str()) {
            copy(&sandbox, &format!("samples/{name}"));
        }
    }
    copy(&sandbox, "extensions/NEPHRITE_materials_subsurface/examples");
    std::fs::create_dir_all(sandbox.path("docs/models")).expect("a folder");
    let mut listed = BTreeSet::from(OTHERS);
    let mut run = BTreeSet::new();
    for (page, text) in pages() {
        own_files(&sandbox);
        for command in commands(&text) {
            let own = PROGRAM.iter().find_map(|program| command.strip_prefix(program));
            let Some(own) = own else {
                let known = OTHERS.iter().find(|other| **other == command);
                listed.remove(known.unwrap_or_else(|| panic!("{}: not listed: {command}", page.display())));
                continue;
            };
            if run.insert(own.to_owned()) {
                let words = reduced(&sandbox, own);
                sandbox.run(&words.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
            }
        }
    }
    assert!(listed.is_empty(), "no page has these any more: {listed:?}");
    assert!(
        run.len() > 40,
        "only {} commands were found: pages have lost theirs, or they are no longer recognized",
        run.len()
    );
}

#[test]
fn commands_are_found_in_blocks_of_the_language_sh_only() {
    for (page, text) in pages() {
        for (language, line) in lines(&text) {
            let command = ["nephrite ", "cargo ", "python3 ", "pip ", "mdbook "]
                .iter()
                .any(|program| line.strip_prefix("    ").unwrap_or(line).starts_with(program));
            let code = language.is_some() || line.starts_with("    ");
            assert!(!(command && code && language != Some("sh")), "{}: {line}", page.display());
        }
    }
}

/// What a heading is called in links, on code hosts and in the book.
fn anchor(heading: &str) -> String {
    let kept = heading
        .trim()
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .collect::<String>();
    kept.replace(' ', "-")
}

#[test]
fn links_lead_somewhere_and_the_book_has_every_page() {
    let contents = std::fs::read_to_string(Path::new(ROOT).join("docs/SUMMARY.md")).expect("the contents");
    for (page, text) in pages() {
        let folder = Path::new(ROOT).join(page.parent().expect("a folder"));
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, place) = target.split_once('#').unwrap_or((target, ""));
            if target.contains(' ') || file.contains(':') {
                continue;
            }
            let path = if file.is_empty() { Path::new(ROOT).join(&page) } else { folder.join(file) };
            assert!(path.exists(), "{}: {target} is not there", page.display());
            if !place.is_empty() {
                let there = std::fs::read_to_string(&path).expect("a page");
                let found = there.lines().any(|line| {
                    let heading = line.trim_start_matches('#');
                    heading.len() < line.len() && anchor(heading) == place
                });
                assert!(found, "{}: no heading for {target}", page.display());
            }
        }
        if let Some(name) = page.strip_prefix("docs").ok().filter(|name| *name != Path::new("SUMMARY.md")) {
            let name = name.display();
            assert!(contents.contains(&format!("({name})")), "docs/SUMMARY.md does not have {name}");
        }
    }
}
