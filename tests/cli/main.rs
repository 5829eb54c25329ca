//! The program as users have it: what it accepts, what it says, how it ends, and what it leaves behind.

mod animation;
mod book;
mod compare_models;
mod conformance;
mod convert;
mod edit;
mod inputs;
mod lamps;
mod lights;
#[cfg(unix)]
mod machine;
#[cfg(unix)]
mod outputs;
mod paint;
mod painted_files;
mod presets;
mod profile;
#[cfg(unix)]
mod signals;
mod usage;
#[path = "../util/mod.rs"]
mod util;
mod validate;

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
        (&["render", "a.gltf", "-o", "a.png", "--brdf-cosines", "unrefractd"], &["did you mean unrefracted"]),
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

/// The picture that is there on the way is complete and has fewer samples; the finished one is the same as without.
#[test]
fn progressive_renders_write_pictures_on_the_way() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let render = |output: &'static str, spp: &'static str, more: &[&'static str]| {
        [&["render", "a.gltf", "-o", output, "--size", "16x16", "--spp", spp][..], more].concat()
    };
    for (output, more) in
        [("a.exr", &["--progressive"][..]), ("b.exr", &[]), ("c.exr", &["--progressive=never"])]
    {
        sandbox.run(&render(output, "40", more)).exits(0);
    }
    let bytes = |name: &str| std::fs::read(sandbox.path(name)).unwrap();
    assert!(bytes("a.exr") == bytes("b.exr") && bytes("b.exr") == bytes("c.exr"));
    sandbox.run(&render("a.exr", "1", &["--progressive=often"])).exits(2).says(&["always", "never"]);

    // Without a terminal nothing is written before the end unless it is asked for.
    let args = render("late.exr", "10000000", &[]);
    let mut late = sandbox.command(&args).stderr(std::process::Stdio::null()).spawn().unwrap();
    let args = render("early.exr", "10000000", &["--progressive"]);
    let mut early = sandbox.command(&args).stderr(std::process::Stdio::null()).spawn().unwrap();
    let began = std::time::Instant::now();
    while !sandbox.path("early.exr").exists() && began.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let channel = exr_channel(&sandbox.path("early.exr"), "R");
    for child in [&mut early, &mut late] {
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert_eq!(channel.len(), 256);
    assert!(!sandbox.files().contains(&"late.exr".to_owned()));
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

#[test]
fn errors_name_the_place_in_the_asset_and_what_to_do() {
    let sandbox = Sandbox::new();
    let material = |properties: &str| {
        format!(
            r#""extensionsUsed": ["NEPHRITE_materials_subsurface"],
            "materials": [{{ "extensions": {{ "NEPHRITE_materials_subsurface": {{ {properties} }} }} }}],"#
        )
    };
    sandbox.file("ior.gltf", triangle(&material(r#""ior": 0.5"#)));
    sandbox.file("typo.gltf", triangle(&material(r#""scatteringCoeficient": [1, 1, 1]"#)));
    sandbox.file(
        "needs.gltf",
        triangle(r#""extensionsUsed": ["EXT_magic"], "extensionsRequired": ["EXT_magic"],"#),
    );
    let render = ["-o", "a.png", "--size", "8x8", "--spp", "1"];
    let with = |file, more: &[&'static str]| [&["render", file], &render[..], more].concat();
    let pointer = "/materials/0/extensions/NEPHRITE_materials_subsurface";
    sandbox.run(&with("ior.gltf", &[])).exits(1).says(&["ior.gltf", &format!("{pointer}/ior"), "0.5"]);
    sandbox.run(&with("needs.gltf", &[])).exits(1).says(&["/extensionsRequired", "EXT_magic", "help:"]);
    sandbox
        .run(&with("typo.gltf", &["--strict"]))
        .exits(1)
        .says(&["error:", &format!("{pointer}/scatteringCoeficient")]);
    sandbox.run(&with("ior.gltf", &["--scene", "3"])).exits(1).says(&["scene 3"]);
    assert!(!sandbox.files().contains(&"a.png".to_owned()), "nothing was rendered");
    sandbox.run(&with("typo.gltf", &["--quiet"])).exits(0).says(&["warning:", "scatteringCoeficient"]);
}

/// Cameras named Front and Side before the triangle, the second one orthographic, seen from +Z.
const CAMERAS: &str = r#""cameras": [
    { "type": "perspective", "name": "Front", "perspective": { "yfov": 1.0, "znear": 0.1, "aspectRatio": 2.0 } },
    { "type": "orthographic", "name": "Side", "orthographic": { "xmag": 3, "ymag": 3, "znear": 0, "zfar": 9 } }],"#;

fn with_cameras() -> String {
    triangle(CAMERAS).replace(r#""nodes": [0] "#, r#""nodes": [0, 1, 2] "#).replace(
        r#""name": "Triangle" }"#,
        r#""name": "Triangle" },
            { "camera": 0, "translation": [0, 0, 4] }, { "camera": 1, "translation": [0, 0, 4] }"#,
    )
}

#[test]
fn cameras_are_chosen_by_name_or_index_and_set_the_default_aspect() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", with_cameras());
    let pixels = |camera: &str| {
        let args = ["render", "a.gltf", "-o", "a.exr", "--size", "24x24", "--spp", "1", "--camera", camera];
        sandbox.run(&args).exits(0);
        exr_channel(&sandbox.path("a.exr"), "R")
    };
    let (front, side) = (pixels("Front"), pixels("Side"));
    assert_ne!(front, side);
    assert_eq!((pixels("0"), pixels("1")), (front, side));
    let args = ["render", "a.gltf", "-o", "b.png", "--spp", "1", "--camera", "Frnt"];
    sandbox.run(&args).exits(1).says(&["did you mean Front? known: Front, Side", "0 to 1"]);
    sandbox.run(&["render", "a.gltf", "-o", "b.png", "--spp", "1"]).exits(0).says(&["1024 × 512"]);
}

#[test]
fn an_environment_is_seen_where_the_convention_says() {
    let sandbox = Sandbox::new();
    // Nothing in the way: the picture is the environment, seen along −Z.
    sandbox.file("a.gltf", with_cameras().replace(r#""nodes": [0, 1, 2] "#, r#""nodes": [1] "#));
    // Sixteen columns; the direction −Z has u = ¼, +X has u = ½. Rows brighten towards the top.
    let texel = |column: usize, row: usize| (1 + column) as f32 * if row == 0 { 100.0 } else { 1.0 };
    let values: Vec<f32> = (0..8).flat_map(|row| (0..16).map(move |column| texel(column, row))).collect();
    let channels = ["B", "G", "R"]
        .map(|name| exr::prelude::AnyChannel::new(name, exr::prelude::FlatSamples::F32(values.clone())));
    let image = exr::prelude::Image::from_channels(
        (16, 8),
        exr::prelude::AnyChannels::sort(channels.into_iter().collect()),
    );
    exr::prelude::WritableImage::write(&image).to_file(sandbox.path("sky.exr")).unwrap();
    let center = |more: &[&str]| {
        let args = [
            "render", "a.gltf", "-o", "a.exr", "--size", "9x9", "--spp", "16", "--float", "--env", "sky.exr",
        ];
        sandbox.run(&[&args, more].concat()).exits(0);
        exr_channel(&sandbox.path("a.exr"), "R")[40]
    };
    // Between the fourth and the fifth column; turning the map by 90° brings what was at +X, between the eighth and
    // the ninth, to −Z.
    let (plain, turned, twice) =
        (center(&[]), center(&["--env-rotation", "90"]), center(&["--env-intensity", "2"]));
    assert!((4.0..=5.0).contains(&plain), "{plain}");
    assert!((8.0..=9.0).contains(&turned), "{turned}");
    assert!((twice - 2.0 * plain).abs() < 1e-5 * plain, "{twice} {plain}");
    // The top of the picture is nearer to the top of the map.
    let picture = exr_channel(&sandbox.path("a.exr"), "R");
    assert!(picture.iter().all(|v| v.is_finite()));
    sandbox
        .run(&[
            "render",
            "a.gltf",
            "-o",
            "c.exr",
            "--size",
            "4x4",
            "--spp",
            "1",
            "--float",
            "--env",
            "0.25,0.5,1",
        ])
        .exits(0);
    for (name, value) in [("R", 0.25), ("G", 0.5), ("B", 1.0)] {
        assert_eq!(exr_channel(&sandbox.path("c.exr"), name), [value; 16]);
    }
    sandbox
        .run(&["render", "a.gltf", "-o", "d.exr", "--size", "4x4", "--spp", "1", "--env", "none"])
        .exits(0);
    assert_eq!(exr_channel(&sandbox.path("d.exr"), "G"), [0.0; 16]);
}

#[test]
fn pictures_say_how_they_were_made() {
    let sandbox = Sandbox::new();
    sandbox.file("Schüssel.gltf", triangle(""));
    let args = [
        "render",
        "Schüssel.gltf",
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "--size",
        "8x6",
        "--spp",
        "2",
        "--seed",
        "7",
    ];
    sandbox.run(&args).exits(0);
    let image = exr::prelude::read_first_flat_layer_from_file(sandbox.path("a.exr")).unwrap();
    let attribute = |name: &str| match &image.layer_data.attributes.other[&exr::prelude::Text::from(name)] {
        exr::prelude::AttributeValue::Text(text) => String::from_utf8(text.as_slice().to_vec()).unwrap(),
        other => panic!("{other:?}"),
    };
    assert_eq!(attribute("nephrite:scene"), "Schüssel.gltf");
    assert_eq!((attribute("nephrite:spp").as_str(), attribute("nephrite:seed").as_str()), ("2", "7"));
    assert_eq!(attribute("nephrite:version"), env!("CARGO_PKG_VERSION"));
    let options: serde_json::Value = serde_json::from_str(&attribute("nephrite:options")).unwrap();
    assert_eq!(options["size"], serde_json::json!([8, 6]));
    assert_eq!((&options["env"], &options["subsurface"]), (&"studio".into(), &"random-walk".into()));
    assert!(options.get("tonemap").is_none());

    let file = std::io::BufReader::new(std::fs::File::open(sandbox.path("a.png")).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    let keywords: Vec<&str> = reader.info().utf8_text.iter().map(|text| text.keyword.as_str()).collect();
    assert_eq!(
        keywords,
        ["scene", "options", "spp", "seed", "version"].map(|name| format!("nephrite:{name}"))
    );
}

#[test]
fn a_file_with_nothing_to_see_renders_its_surroundings() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", r#"{ "asset": { "version": "2.0" } }"#);
    sandbox
        .run(&["render", "a.gltf", "-o", "a.png", "--size", "8x8", "--spp", "1"])
        .exits(0)
        .says(&["warning:"]);
    assert_eq!(sandbox.files(), ["a.gltf", "a.png"]);
}
