//! What is written where: nothing is lost to a name, a neighbour, or a file that was there.

use super::util::{Sandbox, exr_channel, tetrahedra, triangle};
use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::process::Stdio;

fn render(outputs: &[&'static str]) -> Vec<&'static str> {
    [&["render", "a.gltf", "--size", "8x8", "--spp", "1"][..], outputs].concat()
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    sandbox
}

#[test]
fn one_output_that_fails_takes_no_other_along() {
    let sandbox = sandbox();
    // What is written there fails, and that cannot be known before.
    symlink("/dev/full", sandbox.path("full.png")).unwrap();
    let args = render(&["-o", "full.png", "-o", "ok.exr", "--stats", "s.json"]);
    sandbox.run(&args).exits(1).says(&["error: cannot write full.png", "wrote ok.exr"]);
    assert_eq!(exr_channel(&sandbox.path("ok.exr"), "R").len(), 64);
    assert!(sandbox.path("s.json").exists());
    symlink("/dev/full", sandbox.path("b.json")).unwrap();
    let args =
        ["compare-models", "a.gltf", "-o", "b.png", "--size", "8x8", "--spp", "2", "--models", "dipole"];
    sandbox.run(&args).exits(1).says(&["error: cannot write b.json"]);
    assert!(sandbox.path("b.png").exists() && sandbox.path("b.csv").exists());
}

#[test]
fn what_cannot_be_replaced_is_found_before_rendering() {
    let sandbox = sandbox();
    std::fs::create_dir(sandbox.path("folder.png")).unwrap();
    symlink("loop.png", sandbox.path("loop.png")).unwrap();
    let long: &'static str = format!("{}.png", "a".repeat(252)).leak();
    for (name, text) in [
        (long, "too long"),
        ("b.png/", "directory"),
        ("folder.png", "directory"),
        ("no/b.png", "create the folder"),
        ("loop.png", "links"),
    ] {
        let run = sandbox.run(&render(&["-o", name, "-o", "other.exr"])).exits(1).says(&["error:", text]);
        run.check(!run.stderr.contains(".tmp"), "should not name temporary files");
    }
    assert_eq!(sandbox.files(), ["a.gltf", "folder.png", "loop.png"]);
}

#[test]
fn outputs_are_neither_inputs_nor_other_outputs() {
    let sandbox = sandbox();
    let image = r#""images": [{ "uri": "skin%20a.png" }], "textures": [{ "source": 0 }],"#;
    sandbox.file("textured.gltf", triangle(image));
    sandbox.file("skin a.png", "an image");
    sandbox.file("sky.hdr", "an environment");
    std::fs::hard_link(sandbox.path("a.gltf"), sandbox.path("a.png")).unwrap();
    symlink("b.png", sandbox.path("link.png")).unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["-o", "b.png", "-o", "./b.png"], "same file"),
        (&["-o", "b.png", "-o", "link.png"], "same file"),
        (&["-o", "b.png", "--stats", "./b.png"], "same file"),
        (&["-o", "b.png", "-o", "b.png"], "twice"),
        (&["-o", "a.png"], "is the input a.gltf"),
        (&["-o", "b.png", "--stats", "a.gltf"], "is an input"),
        (&["-o", "sky.hdr", "--env", "./sky.hdr"], "is the input ./sky.hdr"),
    ];
    for (outputs, text) in cases {
        let args = [&["render", "a.gltf", "--size", "8x8", "--spp", "1"][..], outputs].concat();
        sandbox.run(&args).exits(2).says(&[text]);
    }
    sandbox.run(&["render", "textured.gltf", "-o", "skin a.png"]).exits(2).says(&["skin a.png is an input"]);
    sandbox.run(&["compare-models", "textured.gltf", "-o", "skin a.png"]).exits(2).says(&["is an input"]);
    assert_eq!(std::fs::read(sandbox.path("skin a.png")).unwrap(), b"an image");
    let args = ["profile", "--medium", "cream", "-o", "x.csv", "-o", "./x.csv"];
    sandbox.run(&args).exits(2).says(&["same file"]);
    let args = ["conformance", "--report", "x.html", "--json", "./x.html"];
    sandbox.run(&args).exits(2).says(&["same file"]);
}

#[test]
fn what_a_file_was_it_stays() {
    let sandbox = sandbox();
    let file = |name: &str, mode: u32| {
        std::fs::set_permissions(sandbox.file(name, "old"), Permissions::from_mode(mode)).unwrap();
    };
    let mode = |name: &str| sandbox.path(name).metadata().unwrap().mode() & 0o7777;
    file("private.exr", 0o600);
    file("shared.exr", 0o664);
    file("one.exr", 0o640);
    std::fs::hard_link(sandbox.path("one.exr"), sandbox.path("two.exr")).unwrap();
    std::fs::create_dir(sandbox.path("later")).unwrap();
    symlink("later/not-yet.exr", sandbox.path("dangling.exr")).unwrap();
    for name in ["private.exr", "shared.exr", "one.exr", "dangling.exr"] {
        sandbox.run(&render(&["-o", name.to_owned().leak()])).exits(0);
        assert_eq!(exr_channel(&sandbox.path(name), "R").len(), 64, "{name}");
    }
    assert_eq!((mode("private.exr"), mode("shared.exr"), mode("one.exr")), (0o600, 0o664, 0o640));
    assert_eq!(exr_channel(&sandbox.path("two.exr"), "R").len(), 64, "the other name shows the new picture");
    assert!(sandbox.path("dangling.exr").symlink_metadata().unwrap().is_symlink());
    assert!(sandbox.path("later/not-yet.exr").is_file());

    let materials = r#"[{}]"#;
    let path = sandbox.file("edited.gltf", tetrahedra(materials, r#"[{ "mesh": 0 }]"#, None));
    std::fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
    let edit = |preset| ["edit", "edited.gltf", "--in-place", "--material", "0", "--preset", preset];
    sandbox.run(&edit("marble")).exits(0);
    assert_eq!(mode("edited.gltf"), 0o600);
    // Root may give files away, and then keeps the owner.
    if std::os::unix::fs::chown(&path, Some(12345), Some(12345)).is_ok() {
        sandbox.run(&edit("cream")).exits(0);
        let found = path.metadata().unwrap();
        assert_eq!((found.uid(), found.gid(), mode("edited.gltf")), (12345, 12345, 0o600));
    }
    assert!(!sandbox.files().iter().any(|name| name.ends_with(".tmp")));
}

#[test]
fn pipes_get_their_picture() {
    let sandbox = sandbox();
    nix::unistd::mkfifo(&sandbox.path("pipe.exr"), nix::sys::stat::Mode::S_IRWXU).unwrap();
    // A reader that ends when the pipe is closed for the first time, as all do.
    let reader =
        std::process::Command::new("cat").arg(sandbox.path("pipe.exr")).stdout(Stdio::piped()).spawn();
    let run = sandbox.command(&render(&["-o", "pipe.exr"])).stderr(Stdio::piped()).spawn().unwrap();
    let read = reader.unwrap().wait_with_output().unwrap().stdout;
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    sandbox.file("read.exr", read);
    assert_eq!(exr_channel(&sandbox.path("read.exr"), "R").len(), 64);

    // What goes to standard output is added to what is there.
    let path = sandbox.file("log", "before\n");
    let log = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    let args = render(&["-o", "b.exr", "--stats", "/dev/stdout"]);
    assert!(sandbox.command(&args).stdout(log).stderr(Stdio::null()).status().unwrap().success());
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("before\n{") && text.contains("\"rays\""), "{text}");
    let run = sandbox.run(&args).exits(0);
    run.check(run.stdout.contains("\"rays\""), "should have written to a pipe");
}
