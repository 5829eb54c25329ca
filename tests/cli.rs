//! The program as users have it: what it accepts, what it says, how it ends, and what it leaves behind.

mod util;

use util::{Sandbox, exr_channel, triangle};

#[test]
fn nonsense_on_the_command_line_ends_with_2_and_says_what_is_right() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let cases: &[(&[&str], &[&str])] = &[
        (&[], &["Usage"]),
        (&["rendr"], &["render"]),
        (&["render", "a.gltf"], &["--output"]),
        (&["render", "-o", "a.png"], &["INPUT"]),
        (&["render", "a.gltf", "-o", "a.bmp"], &["a.bmp", ".exr", ".png", ".jpg", ".hdr"]),
        (&["render", "a.gltf", "-o", "a.png", "-o", "a.png"], &["a.png", "twice"]),
        (&["render", "a.gltf", "-o", "a.png", "--stats", "a.png"], &["a.png"]),
        (&["render", "a.gltf", "-o", "a.png", "--size", "640"], &["1280x720"]),
        (&["render", "a.gltf", "-o", "a.png", "--size", "40000x40000"], &["1600.0 million", "268 million"]),
        (&["render", "a.gltf", "-o", "a.jpg", "--size", "70000x10"], &["a.jpg", "65535"]),
        (&["render", "a.gltf", "-o", "a.png", "--spp", "0"], &["--spp"]),
        (&["render", "a.gltf", "-o", "a.png", "--threads", "0"], &["--threads"]),
        (&["render", "a.gltf", "-o", "a.png", "--tonemap", "acess"], &["did you mean aces"]),
        (&["render", "a.gltf", "-o", "a.png", "--subsurface", "randomwalk"], &["did you mean random-walk"]),
        (&["render", "a.gltf", "-o", "a.png", "--microfacet", "double"], &["single", "multiple"]),
        (&["render", "a.gltf", "-o", "a.png", "--env", "studoi"], &["did you mean studio"]),
        (&["render", "a.gltf", "-o", "a.png", "--env", "sky.jpg"], &[".hdr", ".exr"]),
        (&["render", "a.gltf", "-o", "a.png", "--exposure", "bright"], &["--exposure"]),
    ];
    for (args, texts) in cases {
        sandbox.run(args).exits(2).says(texts);
    }
    assert_eq!(sandbox.files(), ["a.gltf"], "a refused command leaves nothing behind");
}

#[test]
fn help_and_version_go_to_standard_output_and_end_with_0() {
    let sandbox = Sandbox::new();
    let run = sandbox.run(&["--version"]).exits(0);
    run.check(
        run.stdout.trim() == concat!("nephrite ", env!("CARGO_PKG_VERSION")),
        "should name its version",
    );
    let run = sandbox.run(&["render", "--help"]).exits(0);
    for option in ["--size", "--spp", "--env", "--stats", "--tonemap", "--quiet"] {
        run.check(run.stdout.contains(option), option);
    }
}

#[test]
fn what_cannot_be_rendered_ends_with_1_before_any_work() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    sandbox.file("broken.gltf", "{");
    sandbox.file("broken.hdr", "no picture");
    sandbox.run(&["render", "nowhere.glb", "-o", "a.png"]).exits(1).says(&["error: nowhere.glb"]);
    sandbox.run(&["render", "broken.gltf", "-o", "a.png"]).exits(1).says(&["broken.gltf", "JSON"]);
    sandbox.run(&["render", "a.gltf", "-o", "no/a.png"]).exits(1).says(&["no/a.png", "create the folder"]);
    sandbox.run(&["render", "a.gltf", "-o", "a.png", "--env", "broken.hdr"]).exits(1).says(&["broken.hdr"]);
    sandbox.run(&["render", "a.gltf", "-o", "a.png", "--env", "no.exr"]).exits(1).says(&["no.exr"]);
    sandbox
        .run(&["render", "a.gltf", "-o", "a.png", "--camera", "Front"])
        .exits(1)
        .says(&["Front", "--camera"]);
    sandbox.run(&["inspect", "nowhere.glb"]).exits(1).says(&["nowhere.glb"]);
    std::fs::create_dir(sandbox.path("folder.png")).unwrap();
    sandbox.run(&["render", "a.gltf", "-o", "folder.png"]).exits(1).says(&["folder.png", "directory"]);
    assert_eq!(sandbox.files(), ["a.gltf", "broken.gltf", "broken.hdr", "folder.png"]);
}

#[test]
fn one_render_gives_every_picture_and_the_statistics() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let outputs = ["-o", "a.exr", "-o", "a.png", "-o", "a.jpg", "-o", "a.hdr"];
    let args =
        [&["render", "a.gltf", "--size", "24x16", "--spp", "4", "--stats", "a.json"], &outputs[..]].concat();
    sandbox.run(&args).exits(0).says(&["studio", "framed", "wrote a.exr, a.png, a.jpg, a.hdr"]);
    assert_eq!(sandbox.files(), ["a.exr", "a.gltf", "a.hdr", "a.jpg", "a.json", "a.png"]);
    assert_eq!(exr_channel(&sandbox.path("a.exr"), "R").len(), 24 * 16);

    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(sandbox.path("a.json")).unwrap()).unwrap();
    for key in
        ["load_seconds", "build_seconds", "render_seconds", "write_seconds", "rays", "mean", "counters"]
    {
        assert!(!stats[key].is_null(), "{key} in {stats}");
    }
    assert_eq!(
        (stats["spp"].as_u64(), stats["width"].as_u64(), stats["seed"].as_u64()),
        (Some(4), Some(24), Some(0))
    );
    if cfg!(target_os = "linux") {
        assert!(stats["peak_memory_bytes"].as_u64() > Some(1 << 20), "{stats}");
        assert!(stats["render_cpu_seconds"].is_number(), "{stats}");
    }
    let mean = stats["mean"][1].as_f64().unwrap();
    let green = exr_channel(&sandbox.path("a.exr"), "G");
    let expected = green.iter().map(|&g| f64::from(g)).sum::<f64>() / green.len() as f64;
    assert!((mean - expected).abs() <= 1e-3 * expected, "{mean} {expected}");
}

#[test]
fn quiet_says_nothing_and_a_pipe_gets_neither_bar_nor_colour() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let args = ["render", "a.gltf", "-o", "a.png", "--size", "8x8", "--spp", "1"];
    let run = sandbox.run(&args).exits(0);
    run.check(!run.stderr.contains('\x1b') && !run.stderr.contains('\r'), "should be plain text");
    run.check(run.stdout.is_empty(), "should leave standard output alone");
    let run = sandbox.run(&[&args[..], &["--quiet"]].concat()).exits(0);
    run.check(run.stderr.is_empty(), "should be quiet");
    sandbox.run(&["render", "no.gltf", "-o", "a.png", "--quiet"]).exits(1).says(&["error: no.gltf"]);
}

#[test]
fn equal_runs_give_equal_files() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    for (name, threads) in [("1", "1"), ("2", "2"), ("3", "1")] {
        let (exr, png) = (format!("{name}.exr"), format!("{name}.png"));
        let args = [
            "render",
            "a.gltf",
            "-o",
            &exr,
            "-o",
            &png,
            "--size",
            "20x20",
            "--spp",
            "3",
            "--threads",
            threads,
        ];
        sandbox.run(&args).exits(0);
    }
    for extension in ["exr", "png"] {
        let bytes = |name: &str| std::fs::read(sandbox.path(&format!("{name}.{extension}"))).unwrap();
        assert!(bytes("1") == bytes("2") && bytes("1") == bytes("3"), "{extension}");
    }
}

#[cfg(unix)]
#[test]
fn interrupted_renders_write_what_they_have() {
    use std::process::{Command, Stdio};
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let args =
        ["render", "a.gltf", "-o", "a.exr", "--size", "16x16", "--spp", "10000000", "--stats", "a.json"];
    let child = sandbox.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let run = util::Run::new(&args, child.wait_with_output().unwrap()).exits(130);
    let run = run.says(&["stopping", "interrupted: the pictures have"]);
    run.check(exr_channel(&sandbox.path("a.exr"), "R").len() == 256, "should have written the picture");
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(sandbox.path("a.json")).unwrap()).unwrap();
    assert!(stats["spp"].as_u64() < stats["spp_requested"].as_u64(), "{stats}");
}

#[test]
fn inspect_speaks_to_people_and_programs() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let run = sandbox.run(&["inspect", "a.gltf"]).exits(0);
    run.check(run.stdout.starts_with("a.gltf\n"), "should begin with the file");
    let run = sandbox.run(&["inspect", "a.gltf", "--json"]).exits(0);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(report["file"], "a.gltf");
    assert!(report["media"].is_array() && report["diagnostics"].is_array(), "{report}");
}
