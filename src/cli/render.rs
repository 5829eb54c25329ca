//! `nephrite render`: a glTF file to pictures.

use super::Failure;
use super::args::RenderArgs;
use super::interrupt;
use super::job::{RenderJob, file_name};
use super::message::Reporter;
use super::names;
use super::pipeline::{self, Microfacet, RenderOptions, Rendered};
use super::progress::Progress;
use super::stats::{Stopwatch, cpu_seconds, peak_memory_bytes};
use crate::film::{self, Format, WriteReport, atomic};
use crate::scene::{CameraDescription, Projection, SceneDescription};
use serde_json::{Map, Value, json};

/// Aspect ratios that differ by less than this are the same.
const ASPECT_TOLERANCE: f32 = 0.01;

/// Renders as the arguments say.
pub(super) fn run(args: RenderArgs) -> Result<(), Failure> {
    let job = RenderJob::new(args)?;
    job.check_outputs()?;
    interrupt::install()?;
    let reporter = Reporter::new(job.args.quiet);
    let progress = Progress::new(job.args.quiet);
    let mut measured = Measured::default();
    let mut watch = Stopwatch::start();

    progress.phase(&format!("loading {}", file_name(&job.args.input)));
    let loaded = pipeline::load(&job.args.input, job.args.scene, job.args.strict);
    progress.clear();
    let loaded = loaded?;
    reporter.diagnostics(&loaded.diagnostics);
    let mut description = loaded.scene;
    let (environment, is_studio) =
        pipeline::choose_environment(job.args.env.as_ref(), &description, &reporter)?;
    description.environment = environment;
    pipeline::adjust_environment(&mut description.environment, job.args.env_rotation, job.args.env_intensity);
    let options = render_options(&job, &description, &reporter)?;
    measured.load = watch.lap();
    interrupt::check()?;

    progress.phase("building");
    let scene = pipeline::build(description);
    progress.clear();
    let scene = scene?;
    measured.build = watch.lap();
    interrupt::check()?;

    let cpu_before = cpu_seconds();
    progress.rendering();
    let rendered = pipeline::render(&scene, &options, &progress);
    progress.clear();
    let rendered = rendered?;
    measured.render = watch.lap();
    measured.render_cpu = cpu_before.and_then(|before| Some(cpu_seconds()? - before));
    let interrupted = rendered.spp < options.spp;
    if rendered.spp == 0 {
        reporter.warning("interrupted before every pixel had a sample; nothing is written");
        return Err(Failure::Interrupted);
    }

    report_counters(&rendered, &reporter);
    write_pictures(&job, &rendered, &options, &job.environment_name(is_studio), &reporter)?;
    measured.write = watch.lap();
    if let Some(path) = &job.args.stats {
        let stats = measured.json(&job, &options, &rendered);
        atomic::write_atomically(path, |out| writeln!(out, "{stats:#}"))
            .map_err(|e| Failure::cannot(format!("cannot write {}: {e}", path.display())))?;
    }
    if interrupted {
        reporter.warning(format!(
            "interrupted: the pictures have {} of {} samples a pixel",
            rendered.spp, options.spp
        ));
        return Err(Failure::Interrupted);
    }
    let written: Vec<String> = job.outputs.iter().map(|(path, _)| path.display().to_string()).collect();
    reporter.note(format!(
        "wrote {} ({} × {}, {} samples a pixel, {:.1} s)",
        written.join(", "),
        options.width,
        options.height,
        rendered.spp,
        measured.render
    ));
    Ok(())
}

fn render_options(
    job: &RenderJob,
    scene: &SceneDescription,
    reporter: &Reporter,
) -> Result<RenderOptions, Failure> {
    let chosen = choose_camera(job.args.camera.as_deref(), scene)?;
    let own_aspect = chosen.and_then(|camera| match camera.projection {
        Projection::Perspective { aspect, .. } | Projection::Orthographic { aspect, .. } => aspect,
    });
    let (width, height) = job.size(own_aspect);
    let aspect = width as f32 / height as f32;
    if let Some(own) = own_aspect.filter(|own| (own / aspect - 1.0).abs() > ASPECT_TOLERANCE) {
        reporter.note(format!(
            "the camera's aspect ratio is {own:.3}, the picture's {aspect:.3}: what is seen to the sides changes"
        ));
    }
    let camera = match chosen {
        Some(camera) => camera.clone(),
        None => {
            reporter.note("the file has no camera; the whole scene is framed");
            pipeline::automatic_camera(scene, aspect)
        }
    };
    Ok(RenderOptions {
        width,
        height,
        spp: job.args.spp,
        seed: job.args.seed,
        threads: job.args.threads.unwrap_or(0),
        camera,
        subsurface: job.args.subsurface.clone(),
        max_depth: job.args.max_depth,
        microfacet: job.args.microfacet,
        aim: !job.args.no_aim,
    })
}

/// The camera that was asked for, by name or else by index; the first where none was; `None` if there is none.
fn choose_camera<'a>(
    wanted: Option<&str>,
    scene: &'a SceneDescription,
) -> Result<Option<&'a CameraDescription>, Failure> {
    let Some(wanted) = wanted else { return Ok(scene.cameras.first()) };
    let by_name = scene.cameras.iter().find(|camera| camera.name == wanted);
    let by_index = || wanted.parse().ok().and_then(|index: usize| scene.cameras.get(index));
    if let Some(camera) = by_name.or_else(by_index) {
        return Ok(Some(camera));
    }
    if scene.cameras.is_empty() {
        return Err(Failure::advise(
            format!("there is no camera {wanted:?}: the file has none"),
            "leave --camera out, and the whole scene is framed",
        ));
    }
    let known = scene.cameras.iter().map(|camera| camera.name.as_str());
    Err(Failure::advise(
        names::unknown("camera", wanted, known),
        format!("give a name, or an index from 0 to {}", scene.cameras.len() - 1),
    ))
}

fn report_counters(rendered: &Rendered, reporter: &Reporter) {
    let stats = &rendered.stats;
    if stats.truncated_paths > 0 {
        reporter.warning(format!(
            "{} paths were cut off at --max-depth; the picture is darker than it should be",
            stats.truncated_paths
        ));
    }
    // Rounding lets a path in a million slip through an edge of a closed mesh.
    let samples = rendered.film.pixels.len() as f64 * f64::from(rendered.spp);
    if stats.leaked_paths as f64 > 1e-5 * samples {
        reporter.warning(format!(
            "{} paths leaked out of meshes that are not closed (`nephrite inspect` says where)",
            stats.leaked_paths
        ));
    }
    if stats.invalid_samples > 0 {
        reporter.warning(format!("{} samples were not finite and count as black", stats.invalid_samples));
    }
}

fn write_pictures(
    job: &RenderJob,
    rendered: &Rendered,
    options: &RenderOptions,
    environment: &str,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let mut report = WriteReport::default();
    for (path, format) in &job.outputs {
        let mut write_options = job.write_options();
        write_options.attributes = attributes(job, *format, rendered.spp, options, environment);
        let written = film::write(path, &rendered.film, &write_options)
            .map_err(|e| Failure::cannot(format!("cannot write {}: {e}", path.display())))?;
        report = report.max(written);
    }
    if report.non_finite > 0 {
        reporter.warning(format!("{} pixels are not finite and were written as black", report.non_finite));
    }
    if report.clamped_to_half > 0 {
        reporter.warning(format!(
            "{} pixels are brighter than 65504, the most a half float can hold (--float keeps them)",
            report.clamped_to_half
        ));
    }
    Ok(())
}

/// What is recorded in a picture: enough to render it again. Nothing that does not change it (threads, times), so
/// that equal pictures are equal files.
fn attributes(
    job: &RenderJob,
    format: Format,
    spp: u32,
    options: &RenderOptions,
    environment: &str,
) -> Vec<(String, String)> {
    let args = &job.args;
    let mut recorded = json!({
        "size": [options.width, options.height],
        "camera": options.camera.name,
        "env": environment,
        "env_rotation": args.env_rotation,
        "env_intensity": args.env_intensity,
        "subsurface": options.subsurface,
        "max_depth": options.max_depth,
        "microfacet": match options.microfacet {
            Microfacet::Multiple => "multiple",
            Microfacet::Single => "single",
        },
    });
    if let Some(scene) = args.scene {
        recorded["scene"] = json!(scene);
    }
    if !format.is_linear() {
        recorded["tonemap"] = json!(args.tonemap.name());
        recorded["exposure"] = json!(args.exposure);
    }
    let pairs = [
        ("scene", file_name(&args.input)),
        ("options", recorded.to_string()),
        ("spp", spp.to_string()),
        ("seed", options.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    pairs.map(|(name, value)| (format!("nephrite:{name}"), value)).to_vec()
}

/// Seconds spent on each part.
#[derive(Debug, Default)]
struct Measured {
    load: f64,
    build: f64,
    render: f64,
    render_cpu: Option<f64>,
    write: f64,
}

impl Measured {
    fn json(&self, job: &RenderJob, options: &RenderOptions, rendered: &Rendered) -> Value {
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let counters: Map<String, Value> = pipeline::counters(&rendered.stats)
            .into_iter()
            .map(|(name, count)| (name.to_owned(), json!(count)))
            .collect();
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "input": job.args.input.to_string_lossy(),
            "width": options.width,
            "height": options.height,
            "spp": rendered.spp,
            "spp_requested": options.spp,
            "seed": options.seed,
            "threads": threads,
            "load_seconds": self.load,
            "build_seconds": self.build,
            "render_seconds": self.render,
            "render_cpu_seconds": self.render_cpu.map(|seconds| (seconds * 100.0).round() / 100.0),
            "write_seconds": self.write,
            "rays": rendered.stats.rays,
            "counters": counters,
            "mean": rendered.film.mean(),
            "peak_memory_bytes": peak_memory_bytes(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;

    fn scene(names: &[&str]) -> SceneDescription {
        let camera = |name: &&str| CameraDescription {
            name: (*name).to_owned(),
            transform: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov: 1.0, aspect: Some(2.0) },
        };
        SceneDescription { cameras: names.iter().map(camera).collect(), ..Default::default() }
    }

    #[test]
    fn cameras_are_found_by_name_before_index() {
        let scene = scene(&["Front", "0", "Side"]);
        let name = |wanted| choose_camera(wanted, &scene).unwrap().map(|c| c.name.clone());
        assert_eq!(name(None).as_deref(), Some("Front"));
        assert_eq!(name(Some("0")).as_deref(), Some("0"));
        assert_eq!(name(Some("2")).as_deref(), Some("Side"));
        for wrong in ["3", "Sidee", "-1"] {
            let Err(Failure::Cannot { message, advice }) = choose_camera(Some(wrong), &scene) else {
                panic!("{wrong} was found")
            };
            assert!(message.contains("Side") && advice.unwrap().contains("0 to 2"), "{message}");
        }
        assert!(choose_camera(None, &SceneDescription::default()).unwrap().is_none());
    }
}
