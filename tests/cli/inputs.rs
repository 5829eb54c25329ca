//! Where the document comes from, and how much it may ask for.

use crate::util::{Run, Sandbox, triangle};
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
    sandbox.run(&["inspect", "."]).exits(0);
    sandbox.file("b.gltf", triangle(""));
    sandbox.run(&["inspect", "."]).exits(1).says(&["a.gltf, b.gltf", "name one"]);
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
