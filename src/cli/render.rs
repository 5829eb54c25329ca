//! `nephrite render`: a glTF file to pictures.

use super::Failure;
use super::args::RenderArgs;
use super::hint::say_how_to_expose;
use super::interrupt;
use super::job::{Failures, RenderJob, cannot_write, file_name, write_text};
use super::message::Reporter;
use super::pipeline::{self, RenderOptions, Rendered};
use super::progress::Progress;
use super::progressive::{self, Output, Showing};
use super::setup::Prepared;
use super::stats::{Work, peak_memory_bytes};
use super::view::Size;
use super::warnings::report_counters;
use crate::film::{self, Format, WriteReport};
use crate::plural::count;
use serde_json::{Map, Value, json};
use std::time::Instant;

/// Longest side of a picture whose size was not asked for.
const LONGEST_SIDE: u32 = 1024;

/// Renders as the arguments say.
pub(super) fn run(args: RenderArgs) -> Result<(), Failure> {
    let job = RenderJob::new(args)?;
    job.check_outputs()?;
    let args = &job.args.scene;
    let reporter = Reporter::new(args.quiet);
    let progress = Progress::new(args.quiet);
    let size = Size { asked: job.args.size, longest_side: LONGEST_SIDE };
    let mut prepared = Prepared::new(args, size, &job.args.blur, &job.paths(), &reporter, &progress)?;
    let mut options = prepared.options(args, job.args.spp, job.args.model());
    options.view.transparent = job.args.transparent_background;
    say_what_cannot_be_seen(&job, &prepared, &options, &reporter);
    let models = pipeline::models(args.brdf_cosines);
    let recorded = prepared.record(args);
    let is_watched = progress.is_watched();
    let unfinished = progressive::unfinished(job.args.progressive, &job.outputs, is_watched, &reporter);

    interrupt::finish_at_first();
    progress.rendering();
    let showing = Showing::new(&progress, !unfinished.is_empty(), |rendered| {
        let write = |output| write_picture(&job, output, rendered, &recorded, &options);
        unfinished.iter().filter(|output| write(output).is_ok()).count() > 0
    });
    let (rendered, work) = Work::of(|| prepared.render(args, &options, &models, &showing));
    progress.clear();
    let rendered = rendered?;
    let interrupted = rendered.spp < options.samples.count;
    if rendered.spp == 0 {
        reporter.warning("interrupted before every pixel had a sample; nothing is written");
        return Err(Failure::Interrupted);
    }

    let samples = rendered.picture.pixels.len() as f64 * f64::from(rendered.spp);
    report_counters(&rendered.stats, samples, "", &reporter);
    if job.outputs.iter().any(|(_, format)| !format.is_linear()) {
        let scene = &prepared.scene.description;
        say_how_to_expose(&rendered.picture, scene, prepared.of_blender, args, &reporter);
    }
    let writing = Instant::now();
    let (mut report, mut failures, mut written) = (WriteReport::default(), Failures::default(), Vec::new());
    for output in &job.outputs {
        let done = write_picture(&job, output, &rendered, &recorded, &options);
        if failures.note(done.map(|found| report = report.max(found))) {
            written.push(output.0.display().to_string());
        }
    }
    say_what_was_lost(report, &reporter);
    let measured = Measured { work, write_seconds: writing.elapsed().as_secs_f64() };
    if let Some(path) = &job.args.stats {
        let stats = measured.json(&job, &prepared, &options, &rendered);
        failures.note(write_text(path, &format!("{stats:#}\n")));
    }
    if interrupted && !written.is_empty() {
        reporter.warning(format!(
            "interrupted: the pictures have {} of {} samples a pixel",
            rendered.spp, options.samples.count
        ));
    } else if !written.is_empty() {
        reporter.note(format!(
            "wrote {} ({} × {}, {} a pixel, {:.1} s)",
            written.join(", "),
            options.view.width,
            options.view.height,
            count(rendered.spp, "sample", "samples"),
            measured.work.seconds
        ));
    }
    failures.finish()?;
    if interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Shadows on a black background, and alpha in formats without.
fn say_what_cannot_be_seen(
    job: &RenderJob,
    prepared: &Prepared,
    options: &RenderOptions,
    reporter: &Reporter,
) {
    if options.view.ground.is_some()
        && !options.view.transparent
        && prepared.scene.lights.environment().is_none()
    {
        reporter.note(
            "the shadow of --ground shadow cannot be seen: there is no environment behind it \
             (choose one with --env, or --transparent-background)",
        );
    }
    let without_alpha = job.outputs.iter().find(|(_, f)| !matches!(f, Format::Exr | Format::Png));
    if options.view.transparent
        && let Some((path, _)) = without_alpha
    {
        reporter.note(format!("{}: the format has no alpha; the background is black", path.display()));
    }
}

/// Writes a picture to one of the outputs.
fn write_picture(
    job: &RenderJob,
    (path, format): &Output,
    rendered: &Rendered,
    recorded: &Value,
    options: &RenderOptions,
) -> Result<WriteReport, Failure> {
    let mut write_options = job.write_options();
    write_options.attributes = attributes(job, *format, rendered.spp, recorded, options);
    film::write(path, &rendered.picture, &write_options).map_err(|e| cannot_write(path, e))
}

fn say_what_was_lost(report: WriteReport, reporter: &Reporter) {
    if report.non_finite > 0 {
        let pixels =
            count(report.non_finite, "pixel is not finite and was", "pixels are not finite and were");
        reporter.warning(format!("{pixels} written as black"));
    }
    if report.clamped_to_half > 0 {
        reporter.warning(format!(
            "{} brighter than 65504, the most a half float can hold (--float keeps them)",
            count(report.clamped_to_half, "pixel is", "pixels are")
        ));
    }
}

/// What is recorded in a picture: enough to render it again. Nothing that does not change it (threads, times), so
/// that equal pictures are equal files.
fn attributes(
    job: &RenderJob,
    format: Format,
    spp: u32,
    recorded: &Value,
    options: &RenderOptions,
) -> Vec<(String, String)> {
    let args = &job.args.scene;
    let mut recorded = recorded.clone();
    recorded["subsurface"] = json!(options.settings.subsurface);
    if options.view.transparent {
        recorded["transparent_background"] = json!(true);
    }
    if !format.is_linear() {
        recorded["tonemap"] = json!(args.tonemap.name());
        recorded["exposure"] = json!(args.exposure);
    }
    let pairs = [
        ("scene", file_name(&args.load.input)),
        ("options", recorded.to_string()),
        ("spp", spp.to_string()),
        ("seed", options.settings.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    pairs.map(|(name, value)| (format!("nephrite:{name}"), value)).to_vec()
}

/// What the render and the writing took.
#[derive(Debug)]
struct Measured {
    work: Work,
    write_seconds: f64,
}

impl Measured {
    fn json(
        &self,
        job: &RenderJob,
        prepared: &Prepared,
        options: &RenderOptions,
        rendered: &Rendered,
    ) -> Value {
        let counters: Map<String, Value> = pipeline::counters(&rendered.stats)
            .into_iter()
            .map(|(name, count)| (name.to_owned(), json!(count)))
            .collect();
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "input": job.args.scene.load.input.to_string_lossy(),
            "width": options.view.width,
            "height": options.view.height,
            "spp": rendered.spp,
            "spp_requested": options.samples.count,
            "seed": options.settings.seed,
            "threads": options.thread_count(),
            "load_seconds": prepared.load_seconds,
            "build_seconds": prepared.build_seconds,
            "render_seconds": self.work.seconds,
            "render_cpu_seconds": self.work.cpu_seconds,
            "write_seconds": self.write_seconds,
            "rays": rendered.stats.rays,
            "counters": counters,
            "mean": rendered.picture.mean(),
            "peak_memory_bytes": peak_memory_bytes(),
        })
    }
}
