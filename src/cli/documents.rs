//! Which documents a path means: a file, standard input, or all that are in a folder.
//!
//! Commands that make one thing of a file (`render`) take a folder only where it holds one model. Those that look at files, or
//! change them, take all of them, in the order of their names; one that fails takes no other along.

use super::Failure;
use super::authored::cannot_read;
use super::interrupt;
use super::job::Failures;
use crate::asset;
use std::path::{Path, PathBuf};

/// The path that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Whether a path stands for standard input.
pub(super) fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == STANDARD_INPUT
}

/// What a path is called in messages.
pub(super) fn shown(path: &Path) -> String {
    if is_standard_input(path) { "standard input".to_owned() } else { path.display().to_string() }
}

/// The documents that a path means, at least one.
pub(super) struct Documents(Vec<PathBuf>);

impl Documents {
    /// Every one.
    pub fn all(path: &Path) -> Result<Self, Failure> {
        let found =
            if is_standard_input(path) { Ok(vec![path.to_owned()]) } else { asset::documents_in(path) };
        found.map(Self).map_err(|error| cannot_read(path, &error))
    }

    /// Every model: where one is there as `.glb` and as `.gltf`, the `.glb`.
    pub fn models(path: &Path) -> Result<Self, Failure> {
        let Self(mut all) = Self::all(path)?;
        all.dedup_by(|later, first| later.file_stem() == first.file_stem());
        Ok(Self(all))
    }

    /// Whether there is more than one.
    pub fn are_several(&self) -> bool {
        self.0.len() > 1
    }

    /// The file that messages name, which is only told where there are several.
    pub fn named<'a>(&self, document: &'a Path) -> Option<&'a Path> {
        self.are_several().then_some(document)
    }

    /// Does something with each.
    pub fn each(&self, mut with: impl FnMut(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        let mut failures = Failures::default();
        for document in &self.0 {
            let result = with(document);
            failures.note(if self.are_several() { result.map_err(|e| e.of(document)) } else { result });
            if interrupt::requested() {
                break;
            }
        }
        failures.finish()
    }
}

/// What is made of several files goes into a folder.
pub(super) fn check_folder(input: &Path, output: &Path, besides: &str) -> Result<(), Failure> {
    if output.is_dir() {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{} holds several files, so the output is a folder that is there, which {} is not{besides}",
        input.display(),
        output.display()
    )))
}
