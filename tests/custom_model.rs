//! The example of a model from another crate builds (with the tests, as cargo builds examples) and renders.

use std::path::Path;
use std::process::Command;

#[test]
fn a_model_from_another_crate_renders() {
    // target/PROFILE/deps/this-test → target/PROFILE/examples/custom_model
    let here = std::env::current_exe().expect("a test has a path");
    let built = here.parent().and_then(Path::parent).expect("in deps").join("examples/custom_model");
    assert!(
        built.with_extension(std::env::consts::EXE_EXTENSION).exists(),
        "`cargo build --release --example custom_model` first, or run all tests"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("gaussian.png");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/jade-knot/jade-knot.glb");
    let run = Command::new(built).arg(sample).arg(&picture).output().expect("runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let image = image::open(&picture).expect("a picture").into_rgb8();
    assert_eq!(image.dimensions(), (160, 120));
    let greens = image.pixels().map(|p| p.0[1]);
    let (darkest, brightest) = (greens.clone().min(), greens.max());
    assert!(darkest < Some(60) && brightest > Some(120), "{darkest:?} to {brightest:?}");
}
