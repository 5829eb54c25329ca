//! `nephrite profile`: the figure, the numbers, and how it ends.

use super::util::{Run, Sandbox};
use serde_json::Value;

#[test]
fn nonsense_is_refused_before_any_work() {
    let sandbox = Sandbox::new();
    let profile = |more: &[&'static str]| [&["profile"], more].concat();
    let cases: &[(&[&str], &[&str])] = &[
        (&["-o", "a.png"], &["--medium"]),
        (&["--medium", "marble"], &["--output"]),
        (&["--medium", "marbel", "-o", "a.png"], &["did you mean marble", "σa,σs,g,η"]),
        (&["--medium", "1,2,3", "-o", "a.png"], &["four numbers"]),
        (&["--medium", "marble", "-o", "a.exr"], &["a.exr", "png", "csv", "json"]),
        (&["--medium", "marble", "-o", "a.csv", "-o", "a.csv"], &["twice"]),
        (&["--medium", "marble", "-o", "a.csv", "--channel", "green"], &["did you mean g?"]),
        (&["--medium", "1,2,0,1.3", "-o", "a.csv", "--channel", "g"], &["--channel"]),
        (&["--medium", "marble", "-o", "a.csv", "--unit", "mm"], &["--unit"]),
        (&["--medium", "marble", "-o", "a.csv", "--models", "bettr-dipole"], &["did you mean better-dipole"]),
        (&["--medium", "marble", "-o", "a.csv", "--paths", "1"], &["--paths"]),
    ];
    for (more, texts) in cases {
        sandbox.run(&profile(more)).exits(2).says(texts);
    }
    let nowhere = profile(&["--medium", "marble", "-o", "no/a.csv"]);
    sandbox.run(&nowhere).exits(1).says(&["no/a.csv", "create the folder"]);
    assert!(sandbox.files().is_empty());
}

#[test]
fn one_run_gives_the_figure_and_the_numbers() {
    let sandbox = Sandbox::new();
    let args = ["profile", "--medium", "skin1", "--channel", "all", "--paths", "2000"];
    let outputs = ["-o", "a.png", "-o", "a.csv", "-o", "a.json"];
    sandbox.run(&[&args[..], &outputs].concat()).exits(0).says(&[
        "brdf-approximation is left out: light leaves where it came in",
        "light-biased is left out",
        "wrote a.png, a.csv, a.json (2000 paths)",
    ]);
    assert_eq!(sandbox.files(), ["a.csv", "a.json", "a.png"]);
    let file = std::io::BufReader::new(std::fs::File::open(sandbox.path("a.png")).unwrap());
    assert!(png::Decoder::new(file).read_info().unwrap().info().height > 1500, "three rows of plots");

    let json: Value = serde_json::from_slice(&std::fs::read(sandbox.path("a.json")).unwrap()).expect("JSON");
    assert_eq!((json["medium"]["preset"].as_str(), json["paths"].as_u64()), (Some("skin1"), Some(2000)));
    let channels = json["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 3);
    let mut values = 0;
    for channel in channels {
        let radii = channel["radii"].as_array().unwrap();
        let curves = || std::iter::once(&channel["random_walk"]).chain(channel["models"].as_array().unwrap());
        for curve in curves() {
            for list in ["reflectance", "standard_error"] {
                assert_eq!(curve[list].as_array().unwrap().len(), radii.len() - 1, "{list}");
            }
            values += radii.len() - 1;
        }
        let source = |name: &str| curves().find(|curve| curve["name"] == name).unwrap()["source"].clone();
        assert_eq!((source("better-dipole"), source("dipole")), ("closed form".into(), "measured".into()));
        assert_eq!(channel["left_out"].as_array().unwrap().len(), 2);
    }
    let total = |i: usize| channels[i]["random_walk"]["total"].as_f64().unwrap();
    assert!(total(0) > total(1) && total(1) > total(2), "skin reflects red best");

    let csv = std::fs::read_to_string(sandbox.path("a.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    assert_eq!(csv.lines().count(), values + 1);
}

#[test]
fn numbers_depend_neither_on_threads_nor_on_the_unit() {
    let sandbox = Sandbox::new();
    let csv = |name: &str, more: &[&str]| {
        let args = ["profile", "-o", name, "--paths", "1000", "--models", "random-walk,better-dipole", "-q"];
        sandbox.run(&[&args[..], more].concat()).exits(0);
        std::fs::read_to_string(sandbox.path(name)).unwrap()
    };
    let one = csv("a.csv", &["--medium", "125,2000,0.5,1.3", "--threads", "1"]);
    assert_eq!(one, csv("b.csv", &["--medium", "125,2000,0.5,1.3", "--threads", "2"]));
    assert_eq!(one, csv("c.csv", &["--medium", "0.125,2,0.5,1.3", "--unit", "mm"]));
    assert!(one.contains(",better-dipole,closed form,") && !one.contains("photon"));
}

#[cfg(unix)]
#[test]
fn interrupted_before_the_walk_is_finished_it_writes_nothing() {
    use std::process::{Command, Stdio};
    let sandbox = Sandbox::new();
    let args = ["profile", "--medium", "cream", "-o", "a.csv", "--paths", "1000000000"];
    let child = sandbox.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let run = Run::new(&args, child.wait_with_output().unwrap()).exits(130);
    run.says(&["stopping", "nothing is written"]);
    assert!(sandbox.files().is_empty());
}

#[test]
fn help_lists_the_presets_and_the_unit() {
    let run = Sandbox::new().run(&["profile", "--help"]).exits(0);
    for text in ["1/m", "skim-milk", "spectralon", "--channel", "--unit", "Jensen"] {
        run.check(run.stdout.contains(text), text);
    }
}
