//! From what was typed to what it means: a [`RenderJob`] is complete and has been checked as far as that goes without
//! reading the input.

use super::Failure;
use super::args::RenderArgs;
use crate::film::{Format, WriteOptions, atomic};
use std::collections::HashSet;
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
        let mut seen = HashSet::new();
        let mut outputs = Vec::new();
        for path in &args.output {
            let format = Format::from_path(path).map_err(|e| Failure::Usage(e.to_string()))?;
            if !seen.insert(path) {
                return Err(Failure::Usage(format!("{} is asked for twice", path.display())));
            }
            outputs.push((path.clone(), format));
        }
        if let Some(path) = args.stats.as_ref().filter(|path| !seen.insert(path)) {
            return Err(Failure::Usage(format!(
                "{} cannot be both a picture and statistics",
                path.display()
            )));
        }
        let job = Self { args, outputs };
        if let Some((width, height)) = job.args.size {
            job.check_size(width, height).map_err(Failure::Usage)?;
        }
        Ok(job)
    }

    /// Whether every output could be written, before work begins that would be lost.
    pub fn check_outputs(&self) -> Result<(), Failure> {
        let mut paths = self.outputs.iter().map(|(path, _)| path).chain(&self.args.stats);
        paths.try_for_each(|path| check_output(path))
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
