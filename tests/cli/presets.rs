//! `nephrite presets`: the table, the JSON, and the sheet.

use super::util::Sandbox;
use serde_json::Value;

#[test]
fn presets_are_listed_with_their_sources() {
    let sandbox = Sandbox::new();
    let run = sandbox.run(&["presets"]).exits(0);
    for text in ["Jensen", "Narasimhan", "OpenPBR", "skim-milk", "espresso", "openpbr-skin-iv"] {
        run.check(run.stdout.contains(text), text);
    }
    let run = sandbox.run(&["presets", "--json"]).exits(0);
    let all: Value = serde_json::from_str(&run.stdout).unwrap();
    let (estimates, published): (Vec<&Value>, Vec<&Value>) =
        all.as_array().unwrap().iter().partition(|p| p["source"].as_str().unwrap().contains("estimate"));
    assert_eq!(published.len(), 62);
    // What artists type first; nothing that was estimated is without its sentence.
    for name in ["jade", "wax", "soap", "amber", "leaf", "gummy", "skin-i", "skin-vi", "marble-carrara"] {
        assert!(
            estimates.iter().any(|p| p["name"] == name && !p["note"].as_str().unwrap().is_empty()),
            "{name}"
        );
    }
    let marble = all.as_array().unwrap().iter().find(|p| p["name"] == "marble").unwrap();
    assert_eq!(marble["as_written"]["scatteringCoefficient"], serde_json::json!([2190.0, 2620.0, 3000.0]));
}

/// Coefficients are per millimetre, with their mean free path; words find names and other names.
#[test]
fn a_few_presets_are_told_in_full() {
    let sandbox = Sandbox::new();
    let run = sandbox.run(&["presets", "jade"]).exits(0);
    for text in [
        "jade-lavender",
        "also",
        "nephrite",
        "estimates of ours",
        "0.062 0.02 0.046 1/mm",
        "1.466 1.429 1.458 mm",
        "--preset jade",
    ] {
        run.check(run.stdout.contains(text), text);
    }
    run.check(!run.stdout.contains("marble"), "no others");
    let run = sandbox.run(&["presets", "candle", "--json"]).exits(0);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((found[0]["name"].as_str(), found.as_array().unwrap().len()), (Some("wax"), 1));
    let run = sandbox.run(&["presets", "skin"]).exits(0);
    run.check(
        run.stdout.contains("skin1") && run.stdout.contains("skin-vi") && run.stdout.contains("Jensen"),
        "all skins",
    );
    sandbox.run(&["presets", "jaed"]).exits(2).says(&["did you mean jade"]);
    let help = sandbox.run(&["edit", "--help"]).exits(0);
    help.check(help.stdout.contains("nephrite presets") && help.stdout.contains("--from-base-color"), "help");
}

#[test]
fn nonsense_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.run(&["presets", "-o", "a.exr"]).exits(2).says(&["a.exr", ".png"]);
    sandbox.run(&["presets", "-o", "no/a.png"]).exits(1).says(&["create the folder"]);
    sandbox.run(&["presets", "-o", "a.png", "--radius", "0"]).exits(2).says(&["--radius"]);
    sandbox.run(&["presets", "--spp", "3"]).exits(2).says(&["--output"]);
    assert!(sandbox.files().is_empty());
}
