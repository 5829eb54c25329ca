//! `nephrite compare-models`: one scene, every subsurface model, side by side with the random walk.
//!
//! Each model is rendered as two independent halves, so that its bias is told from its noise ([`Halves`]); the
//! reference is a random walk of its own, with more samples. The random walk is compared with it as any other model
//! is: what it shows is the noise that is to be expected, and a bias of zero.

mod report;
mod sheet;

use super::Failure;
use super::args::CompareArgs;
use super::documents::{self, Documents};
use super::hint::say_how_to_expose;
use super::interrupt;
use super::job::{
    Failures, cannot_write, check_not_inputs, check_output, check_pixels, file_name, write_text,
};
use super::message::Reporter;
use super::pipeline::{self, Registry};
use super::progress::Progress;
use super::setup::Prepared;
use super::stats::Work;
use super::view::Size;
use super::warnings::report_counters;
use crate::film::compare::{Comparison, Halves};
use crate::film::figure;
use crate::film::{Format, Picture};
use crate::plural::count;
use crate::sampling::rng::{hash3, mix64};
use std::path::{Path, PathBuf};

/// The model that the others are compared with.
const REFERENCE: &str = "random-walk";
/// Samples of the reference over those of a model, if nothing else is asked for.
const REFERENCE_FACTOR: u32 = 4;
/// Longest side of a picture whose size was not asked for.
const LONGEST_SIDE: u32 = 480;
/// Room in a sheet for texts and margins, over that for pictures.
const ROOM: u64 = 2;

/// Where the results go.
struct Outputs {
    sheet: PathBuf,
    json: PathBuf,
    csv: PathBuf,
}

/// A picture, what it took, and what it is of.
struct Entry {
    name: String,
    summary: String,
    picture: Picture,
    work: Work,
}

/// All that was found out.
struct Results {
    spp: u32,
    reference_spp: u32,
    reference: Entry,
    /// In the order in which they were asked for.
    models: Vec<(Entry, Comparison)>,
}

/// Compares as the arguments say.
pub(super) fn run(args: CompareArgs) -> Result<(), Failure> {
    let all = Documents::models(&args.scene.load.input)?;
    if !all.are_several() {
        return compare(args, None);
    }
    let folder = args.output.clone();
    documents::check_folder(&args.scene.load.input, &folder, "")?;
    all.each(|document| {
        let mut args = args.clone();
        args.scene.load.input = document.to_owned();
        let name = document.file_stem().unwrap_or(document.as_os_str());
        let mut name = name.to_owned();
        name.push(".png");
        args.output = folder.join(name);
        compare(args, Some(document))
    })
}

/// Compares the models in one file, which is told in messages where there are several.
fn compare(args: CompareArgs, of: Option<&Path>) -> Result<(), Failure> {
    let outputs = Outputs::new(&args)?;
    let reporter = Reporter::of(args.scene.quiet, of);
    let progress = Progress::new(args.scene.quiet);
    let size = Size { asked: args.size, longest_side: LONGEST_SIDE };
    let mut prepared = Prepared::new(&args.scene, size, &args.blur, &outputs.paths(), &reporter, &progress)?;
    let models = pipeline::models(args.scene.brdf_cosines);
    let names = chosen(&args.models, &models);
    check_sheet(names.len() + 1, &prepared)?;
    if prepared.scene.objects.iter().all(|object| !object.has_medium) {
        reporter.warning("nothing in the scene has a medium below its surface: all models are the same");
    }

    let mut bench = Bench::new(&args, &mut prepared, &models, &reporter, &progress, names.len());
    interrupt::finish_at_first();
    progress.rendering();
    let found = bench.run(&names);
    progress.clear();
    let Some(results) = found?.filter(|results| !results.models.is_empty()) else {
        reporter.warning("interrupted before any model was finished; nothing is written");
        return Err(Failure::Interrupted);
    };
    let scene = &prepared.scene.description;
    say_how_to_expose(&results.reference.picture, scene, prepared.of_blender, &args.scene, &reporter);
    let drawn = sheet::draw(&args, &prepared, &results)?;
    let attributes = report::attributes(&args, &prepared, &results);
    let mut failures = Failures::default();
    let written = drawn.picture.write_png(&outputs.sheet, &attributes);
    failures.note(written.map_err(|e| cannot_write(&outputs.sheet, e)));
    let json = report::json(&args, &prepared, &results, drawn.full_scale);
    failures.note(write_text(&outputs.json, &format!("{json:#}\n")));
    failures.note(write_text(&outputs.csv, &report::csv(&results)));
    failures.finish()?;
    if results.models.len() < names.len() {
        reporter.warning(format!(
            "interrupted: the sheet has {} of {} models",
            results.models.len(),
            names.len()
        ));
        return Err(Failure::Interrupted);
    }
    let seconds: f64 = results.models.iter().map(|(entry, _)| entry.work.seconds).sum();
    reporter.note(format!(
        "wrote {}, {}, {} ({}, {} × {}, {} samples a pixel, {:.1} s)",
        outputs.sheet.display(),
        outputs.json.display(),
        outputs.csv.display(),
        count(results.models.len(), "model", "models"),
        prepared.width,
        prepared.height,
        results.spp,
        results.reference.work.seconds + seconds,
    ));
    Ok(())
}

impl Outputs {
    fn new(args: &CompareArgs) -> Result<Self, Failure> {
        let sheet = args.output.clone();
        if Format::from_path(&sheet).ok() != Some(Format::Png) {
            let text = format!("{}: a contact sheet is written as .png", sheet.display());
            return Err(Failure::Usage(text));
        }
        if let Some((width, height)) = args.size {
            check_pixels(width, height).map_err(Failure::Usage)?;
        }
        let outputs = Self { json: sheet.with_extension("json"), csv: sheet.with_extension("csv"), sheet };
        check_not_inputs(&outputs.paths(), &args.scene.inputs())?;
        outputs.paths().into_iter().try_for_each(check_output)?;
        Ok(outputs)
    }

    fn paths(&self) -> [&Path; 3] {
        [&self.sheet, &self.json, &self.csv]
    }
}

/// The models that were asked for, each once; all if none was.
fn chosen(wanted: &[String], models: &Registry) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let all = || models.iter().map(|model| model.name().to_owned()).collect();
    for name in if wanted.is_empty() { all() } else { wanted.to_vec() } {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Whether a sheet of so many cells can be drawn, before the work for it is done.
fn check_sheet(cells: usize, prepared: &Prepared) -> Result<(), Failure> {
    let pixels = u64::from(prepared.width) * u64::from(prepared.height);
    if pixels.saturating_mul(2 * ROOM * cells as u64) > figure::MAX_PIXELS {
        return Err(Failure::advise(
            format!(
                "a sheet of {cells} pictures of {}x{} pixels is too large",
                prepared.width, prepared.height
            ),
            "ask for a smaller --size or fewer --models",
        ));
    }
    Ok(())
}

/// Renders models, one after the other.
struct Bench<'a> {
    args: &'a CompareArgs,
    prepared: &'a mut Prepared,
    models: &'a Registry,
    reporter: &'a Reporter,
    progress: &'a Progress,
    /// Samples of a half: of a model, and of the reference.
    halves: [u32; 2],
    /// Samples of everything.
    total: u64,
}

impl<'a> Bench<'a> {
    fn new(
        args: &'a CompareArgs,
        prepared: &'a mut Prepared,
        models: &'a Registry,
        reporter: &'a Reporter,
        progress: &'a Progress,
        count: usize,
    ) -> Self {
        let reference = args.reference_spp.unwrap_or(args.spp.saturating_mul(REFERENCE_FACTOR));
        let halves = [args.spp.div_ceil(2), reference.div_ceil(2)];
        let pixels = u64::from(prepared.width) * u64::from(prepared.height);
        let total = 2 * pixels * (u64::from(halves[0]) * count as u64 + u64::from(halves[1]));
        Self { args, prepared, models, reporter, progress, halves, total }
    }

    /// What is finished when all is done or somebody interrupts; `None` without a reference.
    fn run(&mut self, names: &[String]) -> Result<Option<Results>, Failure> {
        let mut done = 0;
        let Some((reference, exact)) =
            self.render(REFERENCE, "reference", self.halves[1], "reference", &mut done)?
        else {
            return Ok(None);
        };
        let mut models = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let label = format!("{name} ({} of {})", i + 1, names.len());
            let Some((entry, halves)) = self.render(name, name, self.halves[0], &label, &mut done)? else {
                break;
            };
            let comparison = halves.compare(&exact).map_err(Failure::cannot)?;
            models.push((entry, comparison));
        }
        let [spp, reference_spp] = self.halves.map(|half| 2 * half);
        Ok(Some(Results { spp, reference_spp, reference, models }))
    }

    /// Renders both halves of one model, `as_seed` telling it from other renders of the same; `None` if that was
    /// interrupted.
    fn render(
        &mut self,
        name: &str,
        as_seed: &str,
        spp: u32,
        label: &str,
        done: &mut u64,
    ) -> Result<Option<(Entry, Halves)>, Failure> {
        let Self { args, prepared, models, progress, .. } = self;
        let pixels = u64::from(prepared.width) * u64::from(prepared.height);
        let mut options = prepared.options(&args.scene, spp, name);
        let mut films = Vec::new();
        let (rendered, work) = Work::of(|| {
            for half in 0..2 {
                options.settings.seed = seed_of(as_seed, half, args.scene.seed);
                let part = progress.part(label, *done, self.total);
                let rendered = prepared.render(&args.scene, &options, models, &part)?;
                if rendered.spp < spp {
                    return Ok::<bool, Failure>(false);
                }
                *done += pixels * u64::from(spp);
                let samples = pixels as f64 * f64::from(spp);
                report_counters(&rendered.stats, samples, &format!("{name}: "), self.reporter);
                films.push(rendered.film);
            }
            Ok(true)
        });
        if !rendered? {
            return Ok(None);
        }
        let (Some(b), Some(a)) = (films.pop(), films.pop()) else { return Ok(None) };
        let halves = Halves::new(a, b).map_err(Failure::cannot)?;
        let summary = models.get(name).map_or(String::new(), |model| model.summary().to_owned());
        let entry = Entry { name: name.to_owned(), summary, picture: halves.mean(), work };
        Ok(Some((entry, halves)))
    }
}

/// A seed for each half of each model, whatever other models are compared.
fn seed_of(name: &str, half: u32, seed: u32) -> u32 {
    let name = name.bytes().fold(0, |hash: u64, byte| mix64(hash ^ u64::from(byte)));
    hash3(name as u32, half, seed) as u32
}

/// The last part of the name of the input.
fn input_name(args: &CompareArgs) -> String {
    file_name(&args.scene.load.input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_of_every_model_has_a_seed_of_its_own() {
        let models = pipeline::models(pipeline::Cosines::Refracted);
        let mut names = chosen(&[], &models);
        assert_eq!(names[0], REFERENCE);
        names.push("reference".into());
        let mut seeds: Vec<u32> = names
            .iter()
            .flat_map(|name| [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(half, seed)| seed_of(name, half, seed)))
            .collect();
        let n = seeds.len();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), n);
    }

    #[test]
    fn models_are_chosen_in_the_order_asked_for_and_once() {
        let models = pipeline::models(pipeline::Cosines::Refracted);
        let asked = ["dipole", "random-walk", "dipole"].map(str::to_owned);
        assert_eq!(chosen(&asked, &models), ["dipole", "random-walk"]);
        assert_eq!(chosen(&[], &models).len(), models.iter().count());
    }
}
