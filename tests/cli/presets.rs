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
    assert_eq!(all.as_array().unwrap().len(), 62);
    let marble = all.as_array().unwrap().iter().find(|p| p["name"] == "marble").unwrap();
    assert_eq!(marble["as_written"]["scatteringCoefficient"], serde_json::json!([2190.0, 2620.0, 3000.0]));
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
