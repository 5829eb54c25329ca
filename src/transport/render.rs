//! A picture in one go: passes of growing size over a [`Session`], so that there is soon something to look at.

use super::control::{RenderControl, RenderError, RenderStats};
use super::options::{RenderOptions, View};
use super::session::{Plan, Session};
use crate::film::{Film, Picture};
use crate::scene::Scene;
use crate::subsurface::Registry;
use std::ops::Deref;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Most samples a pixel in one pass.
const LARGEST_PASS: u32 = 16;
/// How much longer the first pass may go on once somebody asked to stop: without it there is no picture at all.
const GRACE: Duration = Duration::from_millis(300);

/// A finished picture.
#[derive(Debug)]
pub struct Rendered {
    /// Mean radiance of every pixel.
    pub picture: Picture,
    /// What the picture was developed from.
    pub film: Film,
    /// Samples that every pixel has (fewer than asked for after cancellation).
    pub spp: u32,
    /// What happened on the way.
    pub stats: RenderStats,
}

impl Rendered {
    /// The picture of a session so far.
    pub(super) fn of<S: Deref<Target = Scene> + Sync>(session: &Session<S>) -> Self {
        let film = session.film().clone();
        Self { picture: film.develop(), spp: film.least_count(), stats: session.stats(), film }
    }

    /// The picture that a session has made.
    pub(super) fn from_session<S: Deref<Target = Scene> + Sync>(session: Session<S>) -> Self {
        let stats = session.stats();
        let film = session.into_film();
        Self { picture: film.develop(), spp: film.least_count(), stats, film }
    }
}

/// Renders a picture with the models of this crate.
///
/// # Errors
/// Unknown models, empty images, no threads.
pub fn render(
    scene: &Scene,
    options: &RenderOptions,
    control: &dyn RenderControl,
) -> Result<Rendered, RenderError> {
    render_with(scene, options, control, &Registry::standard())
}

/// Renders a picture with models from a registry. Once `control` asks to stop, the first pass gets 0.3 s more.
///
/// # Errors
/// Unknown models, empty images, no threads.
pub fn render_with(
    scene: &Scene,
    options: &RenderOptions,
    control: &dyn RenderControl,
    models: &Registry,
) -> Result<Rendered, RenderError> {
    let mut session = begin(scene, options, models)?;
    let pixels = u64::from(options.view.width) * u64::from(options.view.height);
    let goal = Goal { control, before: 0, total: pixels * u64::from(options.samples.count), is_first: true };
    expose(&mut session, options.samples.count, &goal);
    Ok(Rendered::from_session(session))
}

/// A session for a picture that is not empty.
pub(super) fn begin<S: Deref<Target = Scene> + Sync>(
    scene: S,
    options: &RenderOptions,
    models: &Registry,
) -> Result<Session<S>, RenderError> {
    let (view, samples) = (options.view.clone(), options.samples);
    let View { width, height, .. } = view;
    if samples.count == 0 {
        return Err(RenderError::Empty { width, height, spp: samples.count });
    }
    let session = Session::new(scene, view, options.settings.clone(), options.threads, models)?;
    Ok(session.starting_at(samples.first))
}

/// Who waits for a number of samples, of which these are a part.
pub(super) struct Goal<'a> {
    pub control: &'a dyn RenderControl,
    /// Samples of all pixels that were done before.
    pub before: u64,
    /// Those of the whole.
    pub total: u64,
    /// Whether there is nothing yet that could be shown.
    pub is_first: bool,
}

/// Adds `count` samples to every pixel of a session whose pixels all have the same number; false if it was cancelled.
pub(super) fn expose<S: Deref<Target = Scene> + Sync>(
    session: &mut Session<S>,
    count: u32,
    goal: &Goal<'_>,
) -> bool {
    let pixels = session.film().counts().len() as u64;
    let asked = OnceLock::new();
    let mut done = 0;
    while done < count && !goal.control.cancelled() {
        let pass = done.clamp(1, LARGEST_PASS).min(count - done);
        let before = goal.before + pixels * u64::from(done);
        let watch = Pass { goal, before, asked: (goal.is_first && done == 0).then_some(&asked) };
        if !session.pass(&Plan::Everywhere(pass), &watch) {
            return false;
        }
        done += pass;
        if done < count && goal.is_first && !goal.control.cancelled() {
            goal.control.between_passes(&|| Rendered::of(session));
        }
    }
    done == count
}

/// One pass of several, for whoever waits for all of them.
struct Pass<'a> {
    goal: &'a Goal<'a>,
    before: u64,
    /// When it was first seen that somebody wants to stop; only where there is a grace.
    asked: Option<&'a OnceLock<Instant>>,
}

impl RenderControl for Pass<'_> {
    fn advance(&self, samples_done: u64, _: u64) {
        self.goal.control.advance(self.before + samples_done, self.goal.total);
    }

    fn cancelled(&self) -> bool {
        let is_over = |asked: &OnceLock<Instant>| asked.get_or_init(Instant::now).elapsed() >= GRACE;
        self.goal.control.cancelled() && self.asked.is_none_or(is_over)
    }
}
