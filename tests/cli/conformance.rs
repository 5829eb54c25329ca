//! `nephrite conformance`: verdicts, reports, and other renderers, right and wrong ones.

use super::util::{Run, Sandbox};
use serde_json::Value;

/// The suite of the checkout.
const SUITE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/conformance");

fn run(sandbox: &Sandbox, more: &[&str]) -> Run {
    sandbox.run(&[&["conformance", SUITE], more].concat())
}

fn json(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(sandbox.path(name)).expect("a file")).expect("JSON")
}

/// This program as another renderer; `more` goes to `render`.
fn as_other(more: &str) -> String {
    let program = env!("CARGO_BIN_EXE_nephrite");
    format!(
        "'{program}' render --quiet {{input}} -o {{output}} --size {{width}}x{{height}} --spp {{spp}} --seed {{seed}} {more}"
    )
}

#[test]
fn nonsense_is_refused_before_any_work() {
    let sandbox = Sandbox::new();
    for (args, texts) in [
        (&["--renderer", "a {input}"] as &[&str], &["{output}"] as &[&str]),
        (&["--renderer", "a 'b {input}"], &["quote"]),
        (&["--spp-scale", "0"], &["--spp-scale"]),
        (&["--batches", "0"], &["--batches"]),
        (&["--update-references", "--report", "a.html"], &["--update-references"]),
    ] {
        run(&sandbox, args).exits(2).says(texts);
    }
    run(&sandbox, &["--filter", "no-such-case"]).exits(1).says(&["no-such-case"]);
    run(&sandbox, &["--report", "no/a.html"]).exits(1).says(&["create the folder"]);
    sandbox.run(&["conformance"]).exits(1).says(&["samples/conformance", "name the folder"]);
    sandbox.run(&["conformance", "."]).exits(1).says(&["no cases"]);
    assert!(sandbox.files().is_empty());
}

#[test]
fn cases_pass_and_reports_are_self_contained() {
    let sandbox = Sandbox::new();
    let reports = ["--report", "a.html", "--junit", "a.xml", "--json", "a.json"];
    let filters = ["--filter", "tint", "--filter", "camera-insid?"];
    let found = run(&sandbox, &[&filters[..], &reports].concat()).exits(0);
    assert!(found.stdout.contains("2 passed, 0 failed"), "{}", found.stdout);
    let numbers = json(&sandbox, "a.json");
    assert_eq!(numbers["passed"], 2);
    let case = &numbers["cases"][1];
    assert_eq!(case["name"], "tint");
    let expectation = &case["expectations"][0];
    for c in 0..3 {
        let [measured, expected, allowed] =
            ["measured", "expected", "allowed"].map(|key| expectation[key][c].as_f64().expect("a number"));
        assert!((measured - expected).abs() <= allowed && allowed < 0.02 * expected, "{expectation}");
    }
    let junit = std::fs::read_to_string(sandbox.path("a.xml")).expect("a file");
    assert!(
        junit.contains("tests=\"2\" failures=\"0\" errors=\"0\"") && junit.contains("name=\"tint\""),
        "{junit}"
    );
    let page = std::fs::read_to_string(sandbox.path("a.html")).expect("a file");
    assert!(page.contains("2 of 2 cases passed") && page.contains("id=\"camera-inside\""));
    assert_eq!(
        page.matches("<img src=\"").count(),
        page.matches("<img src=\"data:image/png;base64,").count()
    );
    for word in ["http:", "https:", "<script", "url("] {
        assert!(!page.contains(word), "asks for something: {word}");
    }
}

#[test]
fn this_program_passes_as_another_one() {
    let sandbox = Sandbox::new();
    let renderer = as_other("");
    let found = run(&sandbox, &["--filter", "absorption-oblique", "--batches", "2", "--renderer", &renderer]);
    assert!(found.exits(0).stdout.contains("1 passed"));
}

#[test]
fn what_is_wrong_with_a_renderer_is_said() {
    let sandbox = Sandbox::new();
    for (case, wrong, says) in [
        ("furnace-rough-07", "--microfacet single", "single-scattering microfacets"),
        ("absorption-oblique", "--env 2,2,2", "same factor, 2"),
    ] {
        let renderer = as_other(wrong);
        // A quarter of the samples tells mistakes of this size.
        let args = ["--filter", case, "--spp-scale", "0.25", "--renderer", &renderer, "--json", "a.json"];
        let report = ["--report", "a.html", "--junit", "a.xml"];
        run(&sandbox, &[&args[..], &report].concat()).exits(1).says(&["did not pass", case]);
        let numbers = json(&sandbox, "a.json");
        let found = &numbers["cases"][0];
        assert_eq!(found["verdict"], "failed", "{wrong}");
        let diagnoses = found["expectations"][0]["diagnoses"].to_string();
        assert!(diagnoses.contains(says), "{wrong}: {diagnoses}");
        let page = std::fs::read_to_string(sandbox.path("a.html")).expect("a file");
        assert!(page.contains("What is probably wrong") && page.contains(says), "{wrong}");
        let junit = std::fs::read_to_string(sandbox.path("a.xml")).expect("a file");
        assert!(junit.contains("<failure") && junit.contains(says), "{junit}");
    }
}

#[test]
fn renderers_that_fail_are_errors_with_what_they_said() {
    let sandbox = Sandbox::new();
    let all = "{input} {output} {width} {height}";
    for (renderer, says) in [
        (format!("sh -c 'echo no licence >&2; exit 3' x {all}"), "no licence"),
        (format!("sh -c 'echo broken > \"$2\"' x {all}"), "cannot be read"),
        (as_other("--size 3x3").replace("--size {width}x{height}", "{width}{height}"), "ended with"),
    ] {
        let args = ["--filter", "tint", "--renderer", &renderer, "--json", "a.json", "--junit", "a.xml"];
        run(&sandbox, &args).exits(1).says(&["did not pass"]);
        let numbers = json(&sandbox, "a.json");
        assert_eq!(numbers["errors"], 1);
        let error = numbers["cases"][0]["error"].as_str().expect("an error");
        assert!(error.contains(says), "{error}");
        assert!(std::fs::read_to_string(sandbox.path("a.xml")).expect("a file").contains("<error"));
    }
}
