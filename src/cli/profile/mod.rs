//! `nephrite profile`: R(r) of a medium, by every subsurface model and by the random walk.
//!
//! The walk is measured ([`searchlight`]), in bins of the logarithm of the distance. A model with a closed form is
//! averaged over the same bins, any other is measured as the walk is; a model that has no profile is left out, and why is
//! said.

mod figure;
mod job;
mod report;

use super::Failure;
use super::args::ProfileArgs;
use super::interrupt;
use super::job::{Failures, cannot_write, write_text};
use super::message::Reporter;
use super::pipeline::{self, Cosines, Registry};
use super::progress::Progress;
use crate::optics::diffusion::{Coefficients, RadialProfile};
use crate::subsurface::SubsurfaceModel;
use crate::transport::searchlight::{self, Searchlight, SearchlightError, Share};
use job::{Channel, Kind, ProfileJob};
use std::f64::consts::TAU;

/// The model that the others are compared with.
const REFERENCE: &str = "random-walk";
/// First radius, in transport mean free paths, and bins in a factor of ten.
const FIRST: f64 = 0.01;
const BINS_A_DECADE: i32 = 8;
/// The last radius in diffuse mean free paths, of which there are √3 in a transport mean free path at most, and in
/// transport mean free paths at most.
const LAST: f64 = 12.0;
const LARGEST_LAST: f64 = 100.0;

/// Where the numbers of a curve come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    ClosedForm,
    Measured,
}

impl Source {
    fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed form",
            Self::Measured => "measured",
        }
    }
}

/// R(r) of one model. The unit of length is the transport mean free path.
struct Curve {
    name: String,
    source: Source,
    /// R in each bin.
    bins: Vec<Share>,
    /// The reflectance of everything.
    total: Share,
    /// Points (r, R) for a smooth line, of a closed form.
    line: Vec<(f64, f64)>,
}

/// All curves of one channel.
struct Curves {
    channel: Channel,
    /// Radii between the bins, in transport mean free paths.
    edges: Vec<f64>,
    walk: Curve,
    models: Vec<Curve>,
    /// Models without a profile, and why.
    left_out: Vec<(String, String)>,
}

/// Measures as the arguments say.
pub(super) fn run(args: ProfileArgs) -> Result<(), Failure> {
    let models = pipeline::models(Cosines::default());
    let job = ProfileJob::new(args, &models)?;
    interrupt::finish_at_first();
    let reporter = Reporter::new(job.args.quiet);
    let progress = Progress::new(job.args.quiet);
    progress.rendering();
    let found = measure_all(&job, &models, &progress);
    progress.clear();
    let found = found?;
    if found.is_empty() {
        reporter.warning("interrupted before the random walk was finished; nothing is written");
        return Err(Failure::Interrupted);
    }
    for (name, reason) in found.iter().flat_map(|curves| &curves.left_out) {
        reporter.note(format!("{name} is left out: {reason}"));
    }
    let mut failures = Failures::default();
    for (path, kind) in &job.outputs {
        failures.note(match kind {
            Kind::Png => figure::draw(&found).map_err(Failure::cannot).and_then(|picture| {
                picture.write_png(path, &report::attributes(&job)).map_err(|e| cannot_write(path, e))
            }),
            Kind::Csv => write_text(path, &report::csv(&found)),
            Kind::Json => write_text(path, &format!("{:#}\n", report::json(&job, &found))),
        });
    }
    failures.finish()?;
    if interrupt::requested() {
        reporter.warning("interrupted: what was measured so far is written");
        return Err(Failure::Interrupted);
    }
    let written: Vec<String> = job.outputs.iter().map(|(path, _)| path.display().to_string()).collect();
    reporter.note(format!("wrote {} ({} paths)", written.join(", "), job.args.paths));
    Ok(())
}

/// All channels, or those that are finished when somebody interrupts.
fn measure_all(job: &ProfileJob, models: &Registry, progress: &Progress) -> Result<Vec<Curves>, Failure> {
    let measured = |name: &&String| **name != REFERENCE && closed_form_of(models, name, job).is_none();
    let runs = job.channels.len() * (1 + job.models.iter().filter(measured).count());
    let mut bench = Bench { job, models, progress, done: 0, total: runs as u64 * job.args.paths };
    let mut found = Vec::new();
    for channel in &job.channels {
        if let Some(curves) = bench.channel(channel)? {
            found.push(curves);
        }
        if interrupt::requested() {
            break;
        }
    }
    Ok(found)
}

fn closed_form_of(models: &Registry, name: &str, job: &ProfileJob) -> Option<Box<dyn RadialProfile>> {
    models.get(name)?.closed_form(&job.channels.first()?.coefficients)
}

struct Bench<'a> {
    job: &'a ProfileJob,
    models: &'a Registry,
    progress: &'a Progress,
    /// Paths of all runs so far, and of all runs.
    done: u64,
    total: u64,
}

impl Bench<'_> {
    /// The curves of one channel; `None` if the walk was interrupted too early.
    fn channel(&mut self, channel: &Channel) -> Result<Option<Curves>, Failure> {
        let c = &channel.coefficients;
        let edges = edges(c);
        let get =
            |name: &str| self.models.get(name).ok_or_else(|| Failure::cannot(format!("no model {name}")));
        let walk = match self.measure(&*get(REFERENCE)?, c, &edges) {
            Err(SearchlightError::Interrupted) => return Ok(None),
            other => other.map_err(Failure::cannot)?,
        };
        let (mut curves, mut left_out) = (Vec::new(), Vec::new());
        for name in self.job.models.iter().filter(|name| *name != REFERENCE) {
            let model = self.models.get(name).ok_or_else(|| Failure::cannot(format!("no model {name}")))?;
            if let Some(profile) = model.closed_form(c) {
                curves.push(Curve::of_profile(name, &*profile, c, &edges));
            } else if !interrupt::requested() {
                match self.measure(&*model, c, &edges) {
                    Ok(curve) => curves.push(curve),
                    Err(SearchlightError::Interrupted) => {}
                    Err(error) => left_out.push((name.clone(), error.to_string())),
                }
            }
        }
        Ok(Some(Curves { channel: channel.clone(), edges, walk, models: curves, left_out }))
    }

    fn measure(
        &mut self,
        model: &dyn SubsurfaceModel,
        c: &Coefficients,
        edges: &[f64],
    ) -> Result<Curve, SearchlightError> {
        let args = &self.job.args;
        let light = Searchlight {
            coefficients: *c,
            edges: edges.to_vec(),
            paths: args.paths,
            seed: args.seed,
            threads: args.threads.unwrap_or(0),
        };
        let part = self.progress.part(model.name(), self.done, self.total);
        let found = searchlight::measure(model, &light, &part)?;
        self.done += args.paths;
        let bins = (0..edges.len() - 1).map(|i| found.reflectance(i)).collect();
        let name = model.name().to_owned();
        Ok(Curve { name, source: Source::Measured, bins, total: found.total, line: Vec::new() })
    }
}

impl Curve {
    fn of_profile(name: &str, profile: &dyn RadialProfile, c: &Coefficients, edges: &[f64]) -> Self {
        /// Points of the line in each bin, and of the sum that averages over it.
        const POINTS: u32 = 16;
        let unit = c.transport_mean_free_path();
        let value = |r: f64| profile.eval(unit * r) * unit * unit;
        let exact = |value: f64| Share { value, standard_error: 0.0 };
        let mut line = Vec::new();
        let mut bins = Vec::new();
        for pair in edges.windows(2) {
            let step = (pair[1] / pair[0]).ln() / f64::from(POINTS);
            let points = (0..POINTS).map(|k| pair[0] * (step * (f64::from(k) + 0.5)).exp());
            let mut light = 0.0;
            for r in points {
                light += TAU * r * r * value(r) * step;
                line.push((r, value(r)));
            }
            bins.push(exact(2.0 * light / (TAU * (pair[1].powi(2) - pair[0].powi(2)))));
        }
        Self { name: name.to_owned(), source: Source::ClosedForm, bins, total: exact(profile.total()), line }
    }
}

/// Radii from well inside of a transport mean free path to where next to no light is left.
fn edges(c: &Coefficients) -> Vec<f64> {
    let last = LAST * c.diffuse_mean_free_path() / c.transport_mean_free_path();
    let last = last.min(LARGEST_LAST);
    let count = ((last / FIRST).log10() * f64::from(BINS_A_DECADE)).round() as i32;
    (0..=count).map(|i| FIRST * 10f64.powf(f64::from(i) / f64::from(BINS_A_DECADE))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::diffusion::BetterDipole;

    #[test]
    fn bins_of_a_closed_form_are_its_averages() {
        let c = Coefficients::isotropic(20.0, 1000.0, 1.3);
        let profile = BetterDipole::new(&c);
        let edges: Vec<f64> = (0..=120).map(|i| 1e-3 * 10f64.powf(f64::from(i) / 20.0)).collect();
        let curve = Curve::of_profile("better-dipole", &profile, &c, &edges);
        let area = |pair: &[f64]| std::f64::consts::PI * (pair[1] * pair[1] - pair[0] * pair[0]);
        let sum: f64 = edges.windows(2).zip(&curve.bins).map(|(pair, bin)| area(pair) * bin.value).sum();
        assert!((sum - profile.total()).abs() < 1e-4 * profile.total(), "{sum} {}", profile.total());
        assert!(curve.line.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn bins_end_where_the_light_does() {
        let last =
            |sigma_a: f64| edges(&Coefficients::isotropic(sigma_a, 1000.0, 1.3)).last().copied().unwrap();
        assert!((last(0.0) / LARGEST_LAST - 1.0).abs() < 0.2 && (last(1e5) / 6.93 - 1.0).abs() < 0.2);
        assert!(last(1.0) > last(100.0));
    }
}
