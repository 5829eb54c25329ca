//! Where the document comes from, and how much it may ask for.

use crate::util::{Run, Sandbox, glb, tetrahedra, triangle};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

/// Runs `nephrite` with a document at its standard input.
fn piped(sandbox: &Sandbox, args: &[&str], document: &[u8]) -> Run {
    let mut command = sandbox.command(args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    child.stdin.take().expect("a pipe").write_all(document).expect("the program reads");
    Run::new(args, child.wait_with_output().expect("the program ends"))
}

#[test]
fn a_document_may_come_from_standard_input_but_cannot_name_files() {
    let sandbox = Sandbox::new();
    let run = piped(&sandbox, &["inspect", "-", "--json"], triangle("").as_bytes()).exits(0);
    run.check(run.stdout.contains("\"triangles\": 1"), "should have counted one triangle");
    let args = ["render", "-", "-o", "a.png", "--size", "8x8", "--spp", "1"];
    piped(&sandbox, &args, triangle("").as_bytes()).exits(0);
    assert_eq!(sandbox.files(), ["a.png"]);
    let relative = triangle("").replace("data:application/octet-stream;base64,", "triangle.bin?");
    piped(&sandbox, &["inspect", "-"], relative.as_bytes()).exits(1).says(&[
        "standard input",
        "/buffers/0/uri",
        "stream",
        ".glb",
    ]);
    piped(&sandbox, &["inspect", "-"], b"").exits(1).says(&["standard input", "empty"]);
}

#[test]
fn a_folder_stands_for_its_only_document() {
    let sandbox = Sandbox::new();
    sandbox.run(&["inspect", "."]).exits(1).says(&["no .gltf or .glb"]);
    sandbox.file("a.gltf", triangle(""));
    let render = ["render", ".", "-o", "a.png", "--size", "4x4", "--spp", "1"];
    sandbox.run(&render).exits(0);
    sandbox.file("b.gltf", triangle(""));
    sandbox.run(&render).exits(1).says(&["a.gltf, b.gltf", "name one"]);
}

/// What looks at files or changes them takes all that a folder holds; one that fails takes no other along.
#[test]
fn a_folder_stands_for_all_documents_in_it() {
    let sandbox = Sandbox::new();
    let folder = |name: &str| std::fs::create_dir(sandbox.path(name)).expect("a folder");
    ["in", "out", "in/below"].into_iter().for_each(folder);
    let body = tetrahedra(r#"[{ "name": "M" }]"#, r#"[{ "mesh": 0 }]"#, None);
    sandbox.file("in/a.gltf", &body);
    sandbox.file("in/b.glb", glb(&body));
    sandbox.file("in/notes.txt", "no document");
    sandbox.file("in/below/c.gltf", "never read");

    let run = sandbox.run(&["inspect", "in"]).exits(0);
    run.check(run.stdout.contains("in/a.gltf\n") && run.stdout.contains("\nin/b.glb\n"), "should name both");
    let json = |args: &[&str]| -> Value { serde_json::from_str(&sandbox.run(args).stdout).expect("JSON") };
    for command in ["inspect", "validate"] {
        let found = json(&[command, "in", "--json"]);
        let files: Vec<&str> =
            found.as_array().expect("a list").iter().filter_map(|r| r["file"].as_str()).collect();
        assert_eq!(files, ["in/a.gltf", "in/b.glb"], "{command}");
    }

    let change = ["--material", "M", "--preset", "marble"];
    let edit = |output: &[&'static str]| sandbox.run(&[&["edit", "in"], output, &change].concat());
    edit(&["-o", "x.gltf"]).exits(2).says(&["several files", "folder", "--in-place"]);
    edit(&["-o", "out"]).exits(0).says(&["wrote out/a.gltf", "wrote out/b.glb"]);
    for name in ["out/a.gltf", "out/b.glb"] {
        assert_eq!(json(&["inspect", name, "--json"])["media"][0]["sigma_s"][1], serde_json::json!(2620.0));
    }
    sandbox.run(&["convert", "out", "--in-place", "--to", "khr-scatter"]).exits(0);
    sandbox.file("out/bad.gltf", "{ no JSON");
    let run = sandbox.run(&["edit", "out", "--in-place", "--material", "M", "--preset", "cream"]).exits(1);
    run.says(&["out/bad.gltf", "wrote out/a.gltf", "wrote out/b.glb"]);
    let run = sandbox.run(&["validate", "out"]).exits(1).says(&["out/bad.gltf"]);
    run.check(run.stdout.contains("out/b.glb: 0 errors"), "should have gone on");

    std::fs::remove_file(sandbox.path("out/bad.gltf")).expect("a file");
    let compare = ["--size", "8x8", "--spp", "2", "--reference-spp", "2", "--models", "dipole"];
    sandbox
        .run(&[&["compare-models", "out", "-o", "x.png"], &compare[..]].concat())
        .exits(2)
        .says(&["folder"]);
    sandbox.run(&[&["compare-models", "out", "-o", "in"], &compare[..]].concat()).exits(0);
    assert!(["a.png", "a.csv", "b.png", "b.json"].iter().all(|name| sandbox.path("in").join(name).exists()));
}

#[test]
fn every_command_that_reads_files_reads_standard_input_and_keeps_limits() {
    let sandbox = Sandbox::new();
    let body = tetrahedra(r#"[{ "name": "M" }]"#, r#"[{ "mesh": 0 }]"#, None);
    let edit = ["edit", "-", "-o", "e.gltf", "--material", "0", "--preset", "marble"];
    piped(&sandbox, &edit, body.as_bytes()).exits(0).says(&["wrote e.gltf"]);
    let edited = std::fs::read(sandbox.path("e.gltf")).expect("written");
    piped(&sandbox, &["convert", "-", "-o", "c.gltf", "--to", "khr-scatter"], &edited).exits(0);
    let run = piped(&sandbox, &["validate", "-"], &edited).exits(0);
    run.check(run.stdout.contains("standard input: 0 errors"), "should name it");
    let compare = ["compare-models", "-", "-o", "m.png", "--size", "8x8", "--spp", "2", "--models", "dipole"];
    piped(&sandbox, &compare, &edited).exits(0);
    let in_place = ["edit", "-", "--in-place", "--material", "0", "--preset", "marble"];
    piped(&sandbox, &in_place, body.as_bytes()).exits(2).says(&["standard input", "-o FILE"]);
    let relative = tetrahedra("[{}]", r#"[{ "mesh": 0 }]"#, Some("c.gltf"));
    let run = piped(&sandbox, &["validate", "-"], relative.as_bytes()).exits(1);
    run.check(run.stdout.contains("stream"), "should not look for files of standard input");

    sandbox.file("a.gltf", &body);
    for args in [
        &["validate", "a.gltf"][..],
        &["edit", "a.gltf", "-o", "x.gltf", "--material", "0", "--preset", "marble"],
        &["convert", "a.gltf", "-o", "x.gltf", "--to", "khr-scatter"],
        &["inspect", "a.gltf"],
        &["render", "a.gltf", "-o", "x.png"],
        &["compare-models", "a.gltf", "-o", "x.png"],
    ] {
        let run = sandbox.run(&[args, &["--limit", "json-values=10"]].concat()).exits(1);
        run.says(&["--limit json-values="]);
    }
    assert!(!sandbox.path("x.gltf").exists());
}

#[test]
fn an_exceeded_limit_names_the_option_that_raises_it() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    for (limit, enough) in [
        ("vertices=2", "vertices=3"),
        ("triangles=0", "triangles=1"),
        ("nodes=0", "nodes=1"),
        ("instances=0", "instances=1"),
        ("json-values=10", "json-values=1k"),
        ("file-bytes=99", "file-bytes=1Mi"),
    ] {
        let name = limit.split('=').next().expect("a name");
        sandbox
            .run(&["inspect", "a.gltf", "--limit", limit])
            .exits(1)
            .says(&[&format!("--limit {name}="), "the limit is"]);
        sandbox.run(&["inspect", "a.gltf", "--limit", limit, "--limit", enough]).exits(0);
    }
    sandbox.run(&["inspect", "a.gltf", "--limit", "vertexes=2"]).exits(2).says(&["did you mean vertices"]);
}

#[test]
fn files_outside_the_folder_are_read_only_if_that_is_allowed() {
    let sandbox = Sandbox::new();
    let inner = sandbox.path("inner");
    std::fs::create_dir(&inner).expect("a folder");
    sandbox.file("triangle.bin", [0_u8; 36]);
    let document = triangle("");
    let start = document.find("data:").expect("a data URI");
    let end = start + document[start..].find('"').expect("its end");
    let document = format!("{}../triangle.bin{}", &document[..start], &document[end..]);
    sandbox.file("inner/a.gltf", document);
    sandbox.run(&["inspect", "inner/a.gltf"]).exits(1).says(&["/buffers/0/uri", "--allow-outside"]);
    sandbox.run(&["inspect", "inner/a.gltf", "--allow-outside"]).exits(0);
}
