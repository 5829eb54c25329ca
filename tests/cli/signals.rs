//! How the program ends when it is asked to, and what is left then.

use super::util::{Run, Sandbox, exr_channel, tetrahedra, triangle};
use glam::Vec3;
use nephrite::asset::{LoadOptions, load_bytes};
use nephrite::scene::{Scene, auto_camera};
use nephrite::transport::{RenderControl, RenderOptions, render};
use nix::sys::signal::{SigHandler, Signal, kill, signal};
use nix::unistd::Pid;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A program with its own signals: those that run tests in the background ignore some, and that is inherited.
fn start(command: &mut Command, ignored: &'static [Signal]) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    // SAFETY: setting what a signal does is allowed between fork and exec.
    unsafe {
        command.pre_exec(move || {
            for s in [Signal::SIGINT, Signal::SIGHUP, Signal::SIGTERM] {
                let handler = if ignored.contains(&s) { SigHandler::SigIgn } else { SigHandler::SigDfl };
                signal(s, handler)?;
            }
            Ok(())
        })
    };
    command.spawn().unwrap()
}

fn send(child: &Child, signal: Signal) {
    kill(Pid::from_raw(child.id() as i32), signal).unwrap();
}

/// The end of a program that has to end soon; it is not waited for any longer.
#[track_caller]
fn ends_within(mut child: Child, limit: Duration) -> (Run, Duration) {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() && began.elapsed() < 10 * limit {
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = began.elapsed();
    let _ = child.kill();
    let run = Run::new(&[], child.wait_with_output().unwrap());
    run.check(took < limit, &format!("should have ended within {limit:?}, took {took:?}"));
    (run, took)
}

const LONG: [&str; 8] = ["render", "a.gltf", "-o", "a.exr", "--size", "16x16", "--spp", "10000000"];

fn pause(milliseconds: u64) {
    std::thread::sleep(Duration::from_millis(milliseconds));
}

#[test]
fn a_second_signal_at_once_is_the_same_and_a_later_one_is_not() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    for between in [0, 1, 30, 200] {
        let child = start(&mut sandbox.command(&LONG), &[]);
        pause(1000);
        send(&child, Signal::SIGINT);
        pause(between);
        // Gone already where the second one comes late; then there is nothing to lose.
        let _ = kill(Pid::from_raw(child.id() as i32), Signal::SIGINT);
        let (run, _) = ends_within(child, Duration::from_secs(5));
        run.exits(130).says(&["stopping", "interrupted: the pictures have"]);
        assert_eq!(exr_channel(&sandbox.path("a.exr"), "R").len(), 256);
        std::fs::remove_file(sandbox.path("a.exr")).unwrap();
    }
}

/// The picture goes into a pipe that nobody reads, so that the program is still there for the second one.
#[test]
fn a_later_signal_ends_the_program_also_where_standard_error_is_gone() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    nix::unistd::mkfifo(&sandbox.path("a.exr"), nix::sys::stat::Mode::S_IRWXU).unwrap();
    let mut child = start(&mut sandbox.command(&LONG), &[]);
    drop(child.stderr.take());
    drop(child.stdout.take());
    pause(1000);
    send(&child, Signal::SIGINT);
    pause(800);
    assert!(child.try_wait().unwrap().is_none(), "waits for a reader");
    send(&child, Signal::SIGINT);
    let (run, _) = ends_within(child, Duration::from_millis(500));
    run.exits(130);
}

#[test]
fn what_is_ignored_at_the_start_stays_ignored() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gltf", triangle(""));
    for ignored in [&[Signal::SIGHUP][..], &[Signal::SIGINT]] {
        let mut child = start(&mut sandbox.command(&LONG), ignored);
        pause(800);
        send(&child, ignored[0]);
        pause(300);
        assert!(child.try_wait().unwrap().is_none(), "{ignored:?} should be ignored");
        send(&child, Signal::SIGTERM);
        ends_within(child, Duration::from_secs(5)).0.exits(130).says(&["stopping"]);
    }
}

/// Somebody who wants to stop as soon as the first pass has begun.
struct AtOnce(AtomicBool);

impl RenderControl for AtOnce {
    fn advance(&self, _: u64, _: u64) {}

    fn cancelled(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }
}

/// Without the first pass there is no picture, so it gets 0.3 s more; a later one does not.
#[test]
fn the_first_pass_is_finished_where_that_takes_little() {
    let loaded = load_bytes(triangle("").into_bytes(), "".as_ref(), &LoadOptions::default()).unwrap();
    let camera = auto_camera(Vec3::NEG_ONE, Vec3::ONE, 1.0);
    let scene = Scene::build(loaded.scene).unwrap();
    let options = RenderOptions::new(camera).with(|o| {
        o.view.width = 40;
        o.view.height = 24;
        o.samples.count = 1000;
    });
    let began = Instant::now();
    let rendered = render(&scene, &options, &AtOnce(AtomicBool::new(false))).unwrap();
    assert_eq!(rendered.spp, 1);
    // Nothing is begun where it is asked before.
    assert_eq!(render(&scene, &options, &AtOnce(AtomicBool::new(true))).unwrap().spp, 0);
    assert!(began.elapsed() < Duration::from_secs(5));
}

/// Walks in a medium without absorption, ten thousand mean free paths thick: a tile takes minutes.
#[test]
fn costly_media_stop_within_half_a_second() {
    let sandbox = Sandbox::new();
    let medium =
        r#"{ "absorptionCoefficient": [0, 0, 0], "scatteringCoefficient": [1e4, 1e4, 1e4], "ior": 1.5 }"#;
    let materials = format!(r#"[ {{ "extensions": {{ "NEPHRITE_materials_subsurface": {medium} }} }} ]"#);
    sandbox.file("a.gltf", tetrahedra(&materials, r#"[ { "mesh": 0 } ]"#, None));
    let args = ["render", "a.gltf", "-o", "a.exr", "--size", "32x32", "--spp", "10000"];
    let child = start(&mut sandbox.command(&args), &[]);
    pause(3000);
    send(&child, Signal::SIGINT);
    // Half a second, and as much for a machine that is busy with other tests.
    let (run, took) = ends_within(child, Duration::from_millis(1000));
    println!("{took:?}");
    run.exits(130).says(&["stopping"]);
}

#[test]
fn loading_ends_at_the_first_signal_and_temporary_files_go_with_it() {
    let sandbox = Sandbox::new();
    nix::unistd::mkfifo(&sandbox.path("out.gltf"), nix::sys::stat::Mode::S_IRWXU).unwrap();
    // Standard input that does not end: it is read for as long as it lasts.
    let args = ["render", "-", "-o", "a.exr"];
    let mut child = start(sandbox.command(&args).stdin(Stdio::piped()), &[]);
    let input = child.stdin.take();
    pause(500);
    send(&child, Signal::SIGINT);
    ends_within(child, Duration::from_millis(500)).0.exits(130).says(&["interrupted"]);
    drop(input);
    // `edit` ends while it writes.
    sandbox.file("a.gltf", triangle(r#""materials": [{}],"#));
    let args = ["edit", "a.gltf", "-o", "out.gltf", "--material", "0", "--preset", "marble"];
    let child = start(&mut sandbox.command(&args), &[]);
    pause(500);
    send(&child, Signal::SIGINT);
    ends_within(child, Duration::from_millis(500)).0.exits(130);
    assert_eq!(sandbox.files(), ["a.gltf", "out.gltf"]);
}
