//! From what was typed to what it means: a [`RenderJob`] is complete and has been checked as far as that goes without
//! reading the input.

use super::Failure;
use super::args::RenderArgs;
use crate::film::atomic::{self, Identity, Target};
use crate::film::{Format, WriteOptions};
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The most pixels a picture may have: 16384 × 16384, 3 GB as floats.
const MAX_PIXELS: u64 = 1 << 28;

/// A render that makes sense.
#[derive(Debug)]
pub(super) struct RenderJob {
    pub args: RenderArgs,
    pub outputs: Vec<(PathBuf, Format)>,
}

impl RenderJob {
    /// Checks what was typed as a whole.
    pub fn new(args: RenderArgs) -> Result<Self, Failure> {
        let mut outputs = Vec::new();
        for path in &args.output {
            let format = Format::from_path(path).map_err(|e| Failure::Usage(e.to_string()))?;
            outputs.push((path.clone(), format));
        }
        let job = Self { args, outputs };
        check_distinct(&job.paths())?;
        if let Some((width, height)) = job.args.size {
            job.check_size(width, height).map_err(Failure::Usage)?;
        }
        Ok(job)
    }

    /// Whether every output could be written, before work begins that would be lost.
    pub fn check_outputs(&self) -> Result<(), Failure> {
        let paths = self.paths();
        check_not_inputs(&paths, &self.args.scene.inputs())?;
        paths.into_iter().try_for_each(check_output)
    }

    /// Every file that is written.
    pub fn paths(&self) -> Vec<&Path> {
        self.outputs.iter().map(|(path, _)| path).chain(&self.args.stats).map(PathBuf::as_path).collect()
    }

    fn check_size(&self, width: u32, height: u32) -> Result<(), String> {
        check_pixels(width, height)?;
        for (path, format) in &self.outputs {
            let limit = format.max_side();
            if width.max(height) > limit {
                return Err(format!(
                    "{width}x{height} is too large for {}: at most {limit} a side",
                    path.display()
                ));
            }
        }
        Ok(())
    }

    /// How to write the outputs, all but the recorded attributes.
    pub fn write_options(&self) -> WriteOptions {
        let RenderArgs { scene, float, .. } = &self.args;
        WriteOptions {
            tone_map: scene.tonemap,
            exposure: scene.exposure,
            float: *float,
            attributes: Vec::new(),
        }
    }
}

/// The last part of a path, as text.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Whether a picture of that size may be rendered.
pub(super) fn check_pixels(width: u32, height: u32) -> Result<(), String> {
    if u64::from(width) * u64::from(height) <= MAX_PIXELS {
        return Ok(());
    }
    Err(format!(
        "{width}x{height} is {:.1} million pixels; at most {} million are rendered",
        f64::from(width) * f64::from(height) / 1e6,
        MAX_PIXELS / 1_000_000
    ))
}

/// What a path leads to, if that is a file that only one can write.
fn identity(path: &Path) -> Option<Identity> {
    // What is wrong with a path is said when it is checked or read.
    Target::of(path).ok()?.identity()
}

/// No two outputs may be the same file, whatever they are called.
pub(super) fn check_distinct(outputs: &[&Path]) -> Result<(), Failure> {
    let mut seen: HashMap<Identity, &Path> = HashMap::new();
    for &path in outputs {
        let before = identity(path).and_then(|identity| seen.insert(identity, path));
        if let Some(before) = before {
            return Err(Failure::Usage(if before == path {
                format!("{} is asked for twice", path.display())
            } else {
                format!("{} and {} are the same file, asked for twice", before.display(), path.display())
            }));
        }
    }
    Ok(())
}

/// No output may be what it is made from.
pub(super) fn check_not_inputs(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), Failure> {
    let inputs: HashMap<Identity, &PathBuf> =
        inputs.iter().filter_map(|input| Some((identity(input)?, input))).collect();
    for output in outputs {
        if let Some(input) = identity(output).and_then(|identity| inputs.get(&identity)) {
            return Err(Failure::Usage(if input.as_path() == *output {
                format!("{} is an input, which would be replaced", output.display())
            } else {
                format!("{} is the input {}, which would be replaced", output.display(), input.display())
            }));
        }
    }
    Ok(())
}

/// What went wrong with several outputs, each of which is tried: one that fails takes no other along.
#[derive(Debug, Default)]
pub(super) struct Failures(Option<Failure>);

impl Failures {
    /// Whether it went right; if not, that is said at the latest at the end.
    pub fn note(&mut self, result: Result<(), Failure>) -> bool {
        match result {
            Ok(()) => true,
            Err(failure) => {
                if let Some(before) = self.0.replace(failure) {
                    before.tell();
                }
                false
            }
        }
    }

    /// The failure that has not been said yet.
    pub fn finish(self) -> Result<(), Failure> {
        self.0.map_or(Ok(()), Err)
    }
}

/// Whether a file could be written.
pub(super) fn check_output(path: &Path) -> Result<(), Failure> {
    let Err(error) = atomic::check_writable(path) else { return Ok(()) };
    let message = format!("cannot write {}: {error}", path.display());
    Err(match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => {
            let folder = atomic::directory_of(path);
            Failure::advise(message, format!("create the folder {} first", folder.display()))
        }
        _ => Failure::cannot(message),
    })
}

/// Writes a text file, complete or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    atomic::write_atomically(path, |out| out.write_all(text.as_bytes())).map_err(|e| cannot_write(path, e))
}

/// The failure of writing a file.
pub(super) fn cannot_write(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::cannot(format!("cannot write {}: {error}", path.display()))
}
