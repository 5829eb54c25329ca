//! Rendering, measuring and judging all cases of a suite; and making references.

use super::reference::{Reference, RegionMean};
use super::renderer::{Job, Own, Renderer};
use super::{
    Case, ConformanceError, Diagnosis, Estimate, Expectation, Judgement, Suite, Verdict, diagnose, judge,
    measure,
};
use crate::film::{Film, Picture};
use crate::sampling::rng::{hash3, mix64};
use crate::transport::RenderControl;
use std::time::Instant;

/// Independent renders of a reference.
const REFERENCE_BATCHES: u32 = 16;
/// Tells the seeds of references from those of pictures that are compared with them.
const REFERENCE_SEED: u32 = 0x5eed;

/// How to run a suite.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Who renders.
    pub renderer: Renderer,
    /// Independent renders of each case, which share its samples; 1 if the renderer takes no seed.
    pub batches: u32,
    /// Multiplies the samples of each case.
    pub spp_scale: f64,
    /// Another seed, another noise.
    pub seed: u32,
}

/// What came of an expectation.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Which of the case's expectations.
    pub index: usize,
    /// What was expected, and its standard error.
    pub expected: ([f64; 3], [f64; 3]),
    /// What was seen.
    pub measured: Estimate,
    /// How they compare.
    pub judgement: Judgement,
    /// What is probably wrong, if something is.
    pub diagnoses: Vec<Diagnosis>,
}

/// What came of a case.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// The worst of its findings, or that there are none.
    pub verdict: Verdict,
    /// Why there is no picture.
    pub error: Option<String>,
    /// One for each expectation, in order; empty without a picture.
    pub findings: Vec<Finding>,
    /// The mean of all batches.
    pub picture: Option<Picture>,
    /// Samples a pixel, over all batches.
    pub spp: u32,
    /// Batches that were rendered.
    pub batches: u32,
    /// Wall-clock seconds, loading included.
    pub seconds: f64,
}

impl Outcome {
    /// What must be seen, and what was.
    pub fn results(&self) -> impl Iterator<Item = (&Expectation, &Finding)> {
        self.findings.iter().map(|finding| (&self.case.expectations[finding.index], finding))
    }

    /// The largest |z| of all channels; 0 without a picture.
    pub fn worst_z(&self) -> f64 {
        let all = self.findings.iter().flat_map(|f| f.judgement.z);
        all.fold(0.0, |worst: f64, z| if z.abs() > worst.abs() || z.is_nan() { z } else { worst })
    }
}

/// Who watches a run.
pub trait Watch: Sync {
    /// Case `index` of `count` begins; the result watches its renders, of which there are `batches`.
    fn begin(&self, case: &Case, index: usize, count: usize) -> Box<dyn RenderControl + '_>;
    /// A case is done.
    fn done(&self, outcome: &Outcome);
    /// Whether to stop.
    fn cancelled(&self) -> bool;
}

/// Runs all cases of a suite, one after the other; fewer if the run is cancelled.
pub fn run(suite: &Suite, options: &RunOptions, watch: &dyn Watch) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    for (i, case) in suite.cases.iter().enumerate() {
        let control = watch.begin(case, i, suite.cases.len());
        let outcome = run_case(case, options, &*control);
        if watch.cancelled() {
            break;
        }
        watch.done(&outcome);
        outcomes.push(outcome);
    }
    outcomes
}

fn run_case(case: &Case, options: &RunOptions, control: &dyn RenderControl) -> Outcome {
    let batches = if options.renderer.has_seed() { options.batches.max(1) } else { 1 };
    let spp = (f64::from(case.spp) * options.spp_scale / f64::from(batches)).ceil().max(1.0) as u32;
    let started = Instant::now();
    let films = render_batches(case, &options.renderer, batches, spp, options.seed, control);
    let seconds = started.elapsed().as_secs_f64();
    let mut outcome = Outcome {
        case: case.clone(),
        verdict: Verdict::Error,
        error: None,
        findings: Vec::new(),
        picture: None,
        spp: spp.saturating_mul(batches),
        batches,
        seconds,
    };
    match films {
        Err(message) => outcome.error = Some(message),
        Ok(films) => {
            for (index, expectation) in case.expectations.iter().enumerate() {
                match find(case, index, expectation, &films) {
                    Some(finding) => outcome.findings.push(finding),
                    None => outcome.error = Some(missing(expectation)),
                }
            }
            outcome.picture = Some(mean(&films));
            if outcome.error.is_none() {
                let verdicts = outcome.findings.iter().map(|finding| finding.judgement.verdict);
                outcome.verdict = verdicts.max().unwrap_or(Verdict::Error);
            }
        }
    }
    outcome
}

fn missing(expectation: &Expectation) -> String {
    format!(
        "there is no reference for {:?}: make it with `nephrite conformance --update-references`",
        expectation.name
    )
}

fn find(case: &Case, index: usize, expectation: &Expectation, films: &[Film]) -> Option<Finding> {
    let (mean, error) = case.truth(expectation)?;
    let measured = measure(films, case.region(expectation));
    let judgement = judge(&measured, mean, error, expectation.tolerance);
    let diagnoses = match judgement.verdict {
        Verdict::Failed => diagnose(&measured, mean, expectation),
        _ => Vec::new(),
    };
    Some(Finding { index, expected: (mean, error), measured, judgement, diagnoses })
}

fn render_batches(
    case: &Case,
    renderer: &Renderer,
    batches: u32,
    spp: u32,
    seed: u32,
    control: &dyn RenderControl,
) -> Result<Vec<Film>, String> {
    (0..batches)
        .map(|batch| {
            let part = Part { control, batch, batches };
            renderer.render(&Job { case, spp, seed: seed_of(&case.name, batch, seed) }, &part)
        })
        .collect()
}

/// One batch of several, for whoever watches all.
struct Part<'a> {
    control: &'a dyn RenderControl,
    batch: u32,
    batches: u32,
}

impl RenderControl for Part<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.control.advance(u64::from(self.batch) * total + done, u64::from(self.batches) * total);
    }

    fn cancelled(&self) -> bool {
        self.control.cancelled()
    }
}

/// A seed for each batch of each case, within the positive numbers of 31 bits that any program takes.
fn seed_of(case: &str, batch: u32, seed: u32) -> u32 {
    let name = case.bytes().fold(0, |hash: u64, byte| mix64(hash ^ u64::from(byte)));
    hash3(name as u32, batch, seed) as u32 >> 1
}

/// The picture of films of one size.
fn mean(films: &[Film]) -> Picture {
    let Some((first, rest)) = films.split_first() else { return Picture::default() };
    let mut sum = first.clone();
    for film in rest {
        // They have one size and no layers.
        let _ = sum.merge(film);
    }
    sum.develop()
}

/// Renders the reference of a case with `factor` times its samples, and writes it into its folder.
pub fn update_reference(
    case: &Case,
    factor: f64,
    control: &dyn RenderControl,
) -> Result<(), ConformanceError> {
    let spp = (f64::from(case.spp) * factor / f64::from(REFERENCE_BATCHES)).ceil().max(1.0) as u32;
    let renderer = Renderer::Own(Own::default());
    let films = render_batches(case, &renderer, REFERENCE_BATCHES, spp, REFERENCE_SEED, control)
        .map_err(|message| ConformanceError::Render { case: case.name.clone(), message })?;
    let region = |expectation: &Expectation| {
        let found = measure(&films, case.region(expectation));
        RegionMean {
            name: expectation.name.clone(),
            mean: found.mean,
            standard_error: found.standard_error.unwrap_or_default(),
        }
    };
    let reference = Reference {
        picture: mean(&films),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        spp: spp * REFERENCE_BATCHES,
        seed: REFERENCE_SEED,
        batches: REFERENCE_BATCHES,
        regions: case.expectations.iter().map(region).collect(),
    };
    reference.save(&case.folder, &case.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_have_seeds_of_their_own() {
        let mut seeds: Vec<u32> =
            ["a", "b"].iter().flat_map(|case| (0..8).map(|batch| seed_of(case, batch, 0))).collect();
        seeds.push(seed_of("a", 0, 1));
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 17);
        assert!(seeds.iter().all(|seed| *seed <= i32::MAX as u32));
    }
}
