//! What files and the machine may do to the program: texts that move the cursor, threads and memory that are not there,
//! names that are not UTF-8, programs that hang.

use super::util::{Run, Sandbox, triangle};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A material whose name and extension clear the screen, go back to the beginning of the line, and begin a new one.
fn hostile() -> String {
    let name = r"\u001b[2J\rx\nerror: forged\u009b2J\u202e";
    triangle(&format!(
        r#""extensionsUsed": ["EXT_{name}", "NEPHRITE_materials_subsurface"],
        "materials": [{{ "name": "{name}", "extensions": {{ "EXT_{name}": {{}},
            "NEPHRITE_materials_subsurface": {{ "scatteringCoefficient": [1, 1, 1], "{name}": 1 }} }} }}],
        "animations": [{{ "name": "{name}", "channels": [], "samplers": [] }}],"#
    ))
}

#[test]
fn texts_from_files_neither_move_the_cursor_nor_forge_lines() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", hostile());
    let commands: &[&[&str]] = &[
        &["render", "a.gltf", "-o", "a.png", "--size", "4x4", "--spp", "1"],
        &["render", "a.gltf", "-o", "a.png", "--strict"],
        &["render", "a.gltf", "-o", "a.png", "--size", "4x4", "--spp", "1", "--at", "1"],
        &["inspect", "a.gltf"],
        &["validate", "a.gltf"],
        &["edit", "a.gltf", "-o", "b.gltf", "--material", "nothing", "--preset", "marble"],
        &["edit", "a.gltf", "-o", "b.gltf", "--material", "0", "--preset", "marble"],
        &["convert", "a.gltf", "-o", "c.gltf", "--to", "khr-scatter"],
    ];
    let mut said = String::new();
    for args in commands {
        let run = sandbox.run(args);
        for text in [&run.stdout, &run.stderr] {
            let odd = text.chars().find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}');
            run.check(odd.is_none(), &format!("should not print {odd:?}"));
            run.check(!text.lines().any(|line| line.starts_with("error: forged")), "should keep lines whole");
            said += text;
        }
    }
    assert!(said.contains(r"\u{1b}[2J"), "what is escaped can be read: {said}");
}

#[test]
fn names_that_are_not_utf_8_are_names() {
    let sandbox = Sandbox::new();
    let odd = |end: &str| [b"\xff\xfe", end.as_bytes()].concat();
    let path = |end: &str| sandbox.path("").join(OsStr::from_bytes(&odd(end)));
    std::fs::write(path("a.gltf"), triangle("")).unwrap();
    // A radiance picture of 2 × 1 texels.
    std::fs::write(
        path(".hdr"),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x81",
    )
    .unwrap();
    let mut command = sandbox.command(&["render", "--size", "4x4", "--spp", "1", "--env"]);
    command
        .arg(path(".hdr"))
        .arg(path("a.gltf"))
        .arg("-o")
        .arg(path(".png"))
        .arg("--stats")
        .arg(path(".json"));
    Run::new(&["render"], command.output().unwrap()).exits(0).says(&["wrote"]);
    assert!(path(".png").is_file() && path(".json").is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn threads_are_those_that_were_asked_for() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let args = ["render", "a.gltf", "-o", "a.exr", "--size", "64x64", "--spp", "1000000", "--threads", "5"];
    let mut child = sandbox.command(&args).stderr(Stdio::null()).spawn().unwrap();
    let began = Instant::now();
    let mut most = 0;
    while began.elapsed() < Duration::from_millis(1000) {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", child.id())).map_or(0, Iterator::count);
        most = most.max(tasks);
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The main thread, the one that listens to signals, and five that work.
    assert_eq!(most, 7);
}

#[cfg(target_os = "linux")]
#[test]
fn limits_of_the_machine_are_errors() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    let limited = |limit: &str, more: &str| {
        let nephrite = env!("CARGO_BIN_EXE_nephrite");
        let line = format!("ulimit {limit}; exec '{nephrite}' render a.gltf -o a.png {more}");
        let mut command = Command::new("sh");
        command.args(["-c", &line]).current_dir(sandbox.path(""));
        Run::new(&[&line], command.output().unwrap())
    };
    // Each thread takes address space for its stack. One that has just been started may miss a little more of it, which ends
    // the program before anything of it can act.
    let mut attempts = (0..5).map(|_| limited("-v 1500000", "--threads 4000"));
    let run =
        attempts.find(|run| !run.stderr.contains("alternative stack")).expect("one that ends by itself");
    let run = run.exits(1).says(&["cannot start 4000 threads", "--threads"]);
    run.check(!run.stderr.contains("panicked"), "should not panic");
    // A white image of 15000 × 15000 pixels in some kilobytes.
    let mut encoder =
        png::Encoder::new(std::fs::File::create(sandbox.path("white.png")).unwrap(), 15000, 15000);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![255; 15000 * 1875]).unwrap();
    writer.finish().unwrap();
    let textured = triangle(
        r#""images": [{ "uri": "white.png" }], "textures": [{ "source": 0 }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],"#,
    );
    let textured =
        textured.replace(r#""POSITION": 0 } }"#, r#""POSITION": 0, "TEXCOORD_0": 0 }, "material": 0 }"#);
    sandbox.file("a.gltf", textured);
    let run = limited("-v 600000", "--threads 1 --size 8x8 --spp 1").exits(1);
    let run = run.says(&["/images/0: decoding images", "GB of memory"]);
    run.check(!run.stderr.contains("panicked"), "should not panic");
    sandbox.file("a.gltf", triangle(""));
    let run = limited("-v 1500000", "--threads 1 --size 16000x16000").exits(1).says(&["no memory", "16000"]);
    run.check(!run.stderr.contains("panicked"), "should not panic");
}

#[test]
fn conformance_ends_well_where_nobody_reads() {
    let sandbox = Sandbox::new();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/conformance");
    let args = ["conformance", folder, "--filter", "furnace-diffuse*", "--spp-scale", "0.01"];
    let mut child = sandbox.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let run = Run::new(&args, child.wait_with_output().unwrap());
    run.check(!run.stderr.contains("panicked") && matches!(run.code, Some(0 | 1)), "should not panic");
}

/// A renderer that starts another one and waits for it.
#[test]
fn renderers_that_hang_end_with_all_they_started() {
    let sandbox = Sandbox::new();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/conformance");
    let script = "sh -c '(sleep 2; touch late) & wait' x {input} {output} {width} {height}";
    let one = std::fs::read_dir(folder).unwrap().flatten().find(|e| e.path().join("expect.toml").exists());
    let name = one.unwrap().file_name().into_string().unwrap();
    let args = ["conformance", folder, "--filter", &name, "--timeout", "0.3", "--renderer", script];
    let run = sandbox.run(&args).exits(1);
    run.check(run.stdout.contains("not finished after 0.3 s"), "should say why");
    std::thread::sleep(Duration::from_millis(2500));
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}
