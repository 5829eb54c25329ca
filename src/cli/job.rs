//! From what was typed to what it means: a [`RenderJob`] is complete and has been checked as far as that goes without
//! reading the input.

use super::Failure;
use super::args::{EnvArg, RenderArgs};
use crate::film::{Format, WriteOptions, atomic};
use std::collections::HashSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The most pixels a picture may have: 16384 × 16384, 3 GB as floats.
pub(super) const MAX_PIXELS: u64 = 1 << 28;

/// Longest side of a picture whose size was not asked for.
const DEFAULT_LONGEST_SIDE: u32 = 1024;
/// Aspect ratio where neither the command line nor the camera gives one.
const DEFAULT_ASPECT: f32 = 4.0 / 3.0;

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

    /// The size to render: what was asked for, else the longest side 1024 with the camera's aspect ratio.
    pub fn size(&self, camera_aspect: Option<f32>) -> (u32, u32) {
        self.args.size.unwrap_or_else(|| default_size(camera_aspect))
    }

    fn check_size(&self, width: u32, height: u32) -> Result<(), String> {
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(format!(
                "{width}x{height} is {:.1} million pixels; at most {} million are rendered",
                f64::from(width) * f64::from(height) / 1e6,
                MAX_PIXELS / 1_000_000
            ));
        }
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
        let RenderArgs { tonemap, exposure, float, .. } = self.args;
        WriteOptions { tone_map: tonemap, exposure, float, attributes: Vec::new() }
    }

    /// What the environment is called in the files written.
    pub fn environment_name(&self, is_studio: bool) -> String {
        match &self.args.env {
            Some(EnvArg::Studio) => "studio".to_owned(),
            Some(EnvArg::None) => "none".to_owned(),
            Some(EnvArg::Constant(c)) => format!("{},{},{}", c.x, c.y, c.z),
            Some(EnvArg::File(path)) => file_name(path),
            None if is_studio => "studio".to_owned(),
            None => "none".to_owned(),
        }
    }
}

/// The last part of a path, as text.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn default_size(aspect: Option<f32>) -> (u32, u32) {
    let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(DEFAULT_ASPECT);
    let longest = DEFAULT_LONGEST_SIDE;
    let shorter = |ratio: f32| ((longest as f32 * ratio).round() as u32).clamp(1, longest);
    if aspect >= 1.0 { (longest, shorter(1.0 / aspect)) } else { (shorter(aspect), longest) }
}

fn check_output(path: &Path) -> Result<(), Failure> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_sizes_have_a_longest_side_of_1024() {
        assert_eq!(default_size(None), (1024, 768));
        assert_eq!(default_size(Some(16.0 / 9.0)), (1024, 576));
        assert_eq!(default_size(Some(0.5)), (512, 1024));
        assert_eq!(default_size(Some(1.0)), (1024, 1024));
        assert_eq!(default_size(Some(1e9)), (1024, 1));
        assert_eq!(default_size(Some(f32::NAN)), (1024, 768));
    }
}
