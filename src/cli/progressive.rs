//! Pictures on disk while they are rendered: the first after one sample a pixel, then better ones.
//!
//! Writing takes at most a small part of the time, the first picture apart, however large the picture and slow the disk.
//! What cannot be written is not tried again: the finished picture will say why. `auto` leaves alone what is there: a
//! finished picture is worth more than an unfinished one, and whoever gives up on a render still has it.

use super::message::Reporter;
use super::pipeline::{RenderControl, Rendered};
use super::progress::Progress;
use super::values::Progressive;
use crate::film::Format;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Most of the time that goes into writing unfinished pictures.
const SHARE: f64 = 0.02;

/// A picture to write.
pub(super) type Output = (PathBuf, Format);

/// Those of the outputs that may hold an unfinished picture. What is no file (a pipe, a device) never may.
pub(super) fn unfinished(
    wanted: Progressive,
    outputs: &[Output],
    is_watched: bool,
    reporter: &Reporter,
) -> Vec<Output> {
    let may = |path: &Path| match (wanted, path.metadata()) {
        (Progressive::Never, _) => false,
        (Progressive::Always, found) => found.map_or(true, |found| found.is_file()),
        (Progressive::Auto, Ok(_)) if is_watched => {
            reporter.note(format!(
                "{} stays as it is until the new picture is finished (--progressive shows it on the way)",
                path.display()
            ));
            false
        }
        (Progressive::Auto, found) => is_watched && found.is_err(),
    };
    outputs.iter().filter(|(path, _)| may(path)).cloned().collect()
}

/// Shows progress, and writes pictures between passes.
pub(super) struct Showing<'a, W> {
    progress: &'a Progress,
    /// Writes a picture; false if that failed.
    write: W,
    began: Instant,
    writing: Mutex<Writing>,
}

/// What writing has cost.
#[derive(Default)]
struct Writing {
    all: Duration,
    last: Duration,
    /// Nobody wants more, or it failed.
    over: bool,
}

impl Writing {
    /// Whether another picture may be written.
    fn is_due(&self, elapsed: Duration) -> bool {
        !self.over && (self.all + self.last).as_secs_f64() <= SHARE * elapsed.as_secs_f64()
    }

    fn note(&mut self, took: Duration, written: bool) {
        self.all += took;
        self.last = took;
        self.over |= !written;
    }
}

impl<'a, W: Fn(&Rendered) -> bool + Sync> Showing<'a, W> {
    /// `write` gets every picture that is worth writing, if any is wanted.
    pub fn new(progress: &'a Progress, is_wanted: bool, write: W) -> Self {
        let writing = Writing { over: !is_wanted, ..Writing::default() };
        Self { progress, write, began: Instant::now(), writing: Mutex::new(writing) }
    }
}

impl<W: Fn(&Rendered) -> bool + Sync> RenderControl for Showing<'_, W> {
    fn advance(&self, samples_done: u64, samples_total: u64) {
        self.progress.advance(samples_done, samples_total);
    }

    fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }

    fn between_passes(&self, picture: &dyn Fn() -> Rendered) {
        let Ok(mut writing) = self.writing.lock() else { return };
        if writing.is_due(self.began.elapsed()) {
            let before = Instant::now();
            let picture = picture();
            let written = (self.write)(&picture);
            writing.note(before.elapsed(), written);
            if written {
                self.progress.shown(picture.spp);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_picture_is_due_at_once_and_later_ones_when_they_cost_little() {
        let mut writing = Writing::default();
        let seconds = Duration::from_secs_f64;
        assert!(writing.is_due(Duration::ZERO));
        writing.note(seconds(0.1), true);
        // The one that was written and the next are a fiftieth of ten seconds.
        assert!(!writing.is_due(seconds(9.0)) && writing.is_due(seconds(11.0)));
        writing.note(seconds(0.1), true);
        assert!(!writing.is_due(seconds(11.0)) && writing.is_due(seconds(16.0)));
        writing.note(seconds(0.1), false);
        assert!(!writing.is_due(seconds(1e6)));
    }

    #[test]
    fn what_is_there_is_only_replaced_by_unfinished_pictures_on_demand() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old.png"), folder.path().join("new.png"));
        std::fs::write(&old, "good").unwrap();
        let outputs = [(old.clone(), Format::Png), (new.clone(), Format::Png)];
        let found = |wanted, is_watched| -> Vec<PathBuf> {
            let chosen = unfinished(wanted, &outputs, is_watched, &Reporter::new(true));
            chosen.into_iter().map(|(path, _)| path).collect()
        };
        assert_eq!(found(Progressive::Always, false), [old, new.clone()]);
        assert_eq!(found(Progressive::Auto, true), [new]);
        assert!(found(Progressive::Auto, false).is_empty());
        assert!(found(Progressive::Never, true).is_empty());
        let device = [(PathBuf::from("/dev/null"), Format::Png)];
        assert!(
            cfg!(not(unix))
                || unfinished(Progressive::Always, &device, true, &Reporter::new(true)).is_empty()
        );
    }
}
