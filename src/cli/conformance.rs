//! `nephrite conformance`: is what a renderer shows what is known to be there?

use super::Failure;
use super::conformance_args::ConformanceArgs;
use super::interrupt;
use super::job::{Failures, check_distinct, check_output, write_text};
use super::message::{self, Reporter};
use super::progress::{Part, Progress};
use crate::conformance::report::{self, About};
use crate::conformance::{
    Case, CommandTemplate, ConformanceError, Outcome, Own, Renderer, RunOptions, Suite, Verdict, Watch, run,
    update_reference,
};
use crate::transport::RenderControl;
use std::path::Path;
use std::time::{Duration, Instant};

/// Where the suite is, in a checkout.
const DEFAULT_FOLDER: &str = "samples/conformance";
/// Samples of a reference over those of its case: a quarter of the noise.
const REFERENCE_FACTOR: f64 = 16.0;
/// Parts of the bar that stand for one case.
const STEPS: u64 = 1000;
/// Cases that a message names.
const MOST_NAMED: usize = 8;

impl From<ConformanceError> for Failure {
    fn from(error: ConformanceError) -> Self {
        match &error {
            ConformanceError::Template(_) => Self::Usage(error.to_string()),
            _ => Self::cannot(error),
        }
    }
}

/// Runs as the arguments say.
pub(super) fn run_suite(args: ConformanceArgs) -> Result<(), Failure> {
    let renderer = renderer(&args)?;
    let outputs: Vec<&Path> =
        [&args.report, &args.junit, &args.json].into_iter().flatten().map(|path| path.as_path()).collect();
    check_distinct(&outputs)?;
    outputs.into_iter().try_for_each(check_output)?;
    let suite = suite(&args)?;
    interrupt::finish_at_first();
    let progress = Progress::new(args.quiet);
    let screen = Screen { progress: &progress, quiet: args.quiet };
    if args.update_references {
        return update_references(&suite, &screen);
    }
    let options =
        RunOptions { renderer, batches: args.batches, spp_scale: args.spp_scale.into(), seed: args.seed };
    let started = Instant::now();
    progress.rendering();
    let outcomes = run(&suite, &options, &screen);
    progress.clear();
    let name = args.name.clone().or_else(|| args.renderer.clone());
    let about = About {
        renderer: name.unwrap_or_else(|| format!("nephrite {}", env!("CARGO_PKG_VERSION"))),
        suite: suite.folder.display().to_string(),
        spp_scale: options.spp_scale,
        seed: args.seed,
        seconds: started.elapsed().as_secs_f64(),
    };
    write_reports(&args, &about, &outcomes)?;
    if outcomes.len() < suite.cases.len() {
        let (done, all) = (outcomes.len(), suite.cases.len());
        Reporter::new(args.quiet).warning(format!("interrupted after {done} of {all} cases"));
        return Err(Failure::Interrupted);
    }
    conclude(&about, &outcomes)
}

fn renderer(args: &ConformanceArgs) -> Result<Renderer, Failure> {
    let Some(command) = &args.renderer else {
        return Ok(Renderer::Own(Own {
            subsurface: args.subsurface.clone(),
            microfacet: args.microfacet,
            threads: args.threads.unwrap_or(0),
        }));
    };
    // What is typed is a decimal number, and is said again.
    let milliseconds = (f64::from(args.timeout.min(1e9)) * 1e3).round().max(1.0);
    let timeout = Duration::from_millis(milliseconds as u64);
    Ok(Renderer::Command(CommandTemplate::new(command, timeout)?))
}

fn suite(args: &ConformanceArgs) -> Result<Suite, Failure> {
    let folder = args.dir.as_deref().unwrap_or(Path::new(DEFAULT_FOLDER));
    if args.dir.is_none() && !folder.is_dir() {
        return Err(Failure::advise(
            format!("there is no {DEFAULT_FOLDER} here"),
            "run it in a checkout of nephrite, or name the folder of the suite",
        ));
    }
    Ok(Suite::load(folder, &args.filter)?)
}

fn write_reports(args: &ConformanceArgs, about: &About, outcomes: &[Outcome]) -> Result<(), Failure> {
    let mut failures = Failures::default();
    if let Some(path) = &args.report {
        failures.note(write_text(path, &report::html(about, outcomes)));
    }
    if let Some(path) = &args.junit {
        failures.note(write_text(path, &report::junit(about, outcomes)));
    }
    if let Some(path) = &args.json {
        failures.note(write_text(path, &format!("{:#}\n", report::json(about, outcomes))));
    }
    failures.finish()
}

/// The last line, and the exit code.
fn conclude(about: &About, outcomes: &[Outcome]) -> Result<(), Failure> {
    let [passed, inconclusive, failed, errors] = report::counts(outcomes);
    message::print(&format!(
        "{passed} passed, {failed} failed, {inconclusive} inconclusive, {errors} without a picture, {:.1} s",
        about.seconds
    ));
    let wrong: Vec<&str> =
        outcomes.iter().filter(|o| o.verdict != Verdict::Passed).map(|o| o.case.name.as_str()).collect();
    if wrong.is_empty() {
        return Ok(());
    }
    let more = match wrong.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let named = wrong.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
    let message = format!("{} of {} cases did not pass: {named}{more}", wrong.len(), outcomes.len());
    let advice = match failed + errors {
        0 => "they are too noisy to tell: raise --spp-scale",
        _ => "--report FILE.html shows what is probably wrong",
    };
    Err(Failure::advise(message, advice))
}

fn update_references(suite: &Suite, screen: &Screen<'_>) -> Result<(), Failure> {
    let cases: Vec<&Case> = suite.cases.iter().filter(|case| case.has_reference).collect();
    if cases.is_empty() {
        return Err(Failure::cannot("none of these cases has a reference to render"));
    }
    screen.progress.rendering();
    for (i, case) in cases.iter().enumerate() {
        let control = screen.begin(case, i, cases.len());
        let made = update_reference(case, REFERENCE_FACTOR, &*control);
        if interrupt::requested() {
            screen.progress.clear();
            return Err(Failure::Interrupted);
        }
        made?;
        screen.say(&format!("reference     {}", case.name));
    }
    screen.progress.clear();
    Ok(())
}

/// Shows how far a run is.
struct Screen<'a> {
    progress: &'a Progress,
    quiet: bool,
}

impl Screen<'_> {
    fn say(&self, line: &str) {
        if !self.quiet {
            self.progress.print(line);
        }
    }
}

impl Watch for Screen<'_> {
    fn begin(&self, case: &Case, index: usize, count: usize) -> Box<dyn RenderControl + '_> {
        let name = format!("{} ({} of {count})", case.name, index + 1);
        let part = self.progress.part(&name, index as u64 * STEPS, count as u64 * STEPS);
        Box::new(Fraction(part))
    }

    fn done(&self, outcome: &Outcome) {
        let name = &outcome.case.name;
        let mut line = format!("{:<13} {name:<26} {:>6.2} s", outcome.verdict.name(), outcome.seconds);
        if let Some(error) = &outcome.error {
            line += &format!("  {}", error.lines().next().unwrap_or_default());
        } else {
            line += &format!("  z {:+.1}", outcome.worst_z());
        }
        if let Some(guess) = outcome.findings.iter().flat_map(|f| &f.diagnoses).next() {
            line += &format!("  probably: {}", guess.says);
        }
        self.say(&line);
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

/// A case's share of the bar, whatever its number of samples.
struct Fraction<'a>(Part<'a>);

impl RenderControl for Fraction<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.0.advance(done * STEPS / total.max(1), STEPS);
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}
