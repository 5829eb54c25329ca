//! What a person at a terminal sees while waiting: what is being done, then a bar with the time left. In a pipe,
//! nothing.

use super::interrupt;
use super::message;
use super::pipeline::RenderControl;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// The waiting person's view, and the way to stop.
pub(super) struct Progress {
    bar: ProgressBar,
    is_watched: bool,
    done: AtomicU64,
}

impl Progress {
    /// Visible only on a terminal, and not when quiet.
    pub fn new(quiet: bool) -> Self {
        // A terminal that cannot move its cursor would show every step of the bar.
        let is_dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let is_watched = !quiet && std::io::stderr().is_terminal() && !is_dumb;
        let bar = if is_watched { ProgressBar::no_length() } else { ProgressBar::hidden() };
        Self { bar, is_watched, done: AtomicU64::new(0) }
    }

    /// Whether anybody sees it.
    pub fn is_watched(&self) -> bool {
        self.is_watched
    }

    /// Names a piece of work of unknown length.
    pub fn phase(&self, name: &str) {
        self.bar.set_style(style("{spinner} {msg}"));
        self.bar.set_message(message::printable(name).into_owned());
        // The bar needs a thread to turn, and is not worth failing for want of one.
        if self.is_watched && std::thread::Builder::new().spawn(|| {}).is_ok() {
            self.bar.enable_steady_tick(Duration::from_millis(120));
        }
    }

    /// Begins the bar.
    pub fn rendering(&self) {
        self.bar.set_length(1);
        self.bar.reset();
        self.bar.set_message("rendering");
        self.bar.set_style(style("{msg} {wide_bar} {percent:>3} %  {elapsed} elapsed, {eta} left"));
    }

    /// Says how good the picture is that can be looked at.
    pub fn shown(&self, spp: u32) {
        self.bar.set_message(format!(
            "rendering (written: {} a pixel)",
            message::count(spp.into(), "sample", "samples")
        ));
    }

    /// Names the part of the bar that follows `before` of `total` samples.
    pub fn part(&self, name: &str, before: u64, total: u64) -> Part<'_> {
        self.bar.set_message(message::printable(name).into_owned());
        Part { progress: self, before, total }
    }

    /// Prints a line to standard output, above the bar if there is one.
    pub fn print(&self, line: &str) {
        self.bar.suspend(|| message::print(line));
    }

    /// Removes whatever is shown.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl RenderControl for Progress {
    fn advance(&self, samples_done: u64, samples_total: u64) {
        // Threads report out of order.
        let furthest = self.done.fetch_max(samples_done, Ordering::Relaxed).max(samples_done);
        self.bar.set_length(samples_total);
        self.bar.set_position(furthest);
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

/// One of several renders that share a bar.
pub(super) struct Part<'a> {
    progress: &'a Progress,
    before: u64,
    total: u64,
}

impl RenderControl for Part<'_> {
    fn advance(&self, samples_done: u64, _: u64) {
        self.progress.advance(self.before + samples_done, self.total);
    }

    fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
