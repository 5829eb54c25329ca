//! The conformance suite: small assets whose pictures are known, rendered by nephrite or by any other program, measured
//! and judged.
//!
//! A [`Case`] is a folder: a glTF file, what must be seen of it (`expect.toml`), and a README. Most of what must be
//! seen are means of regions whose values are closed forms or tabulated; where there is none, they are those of a
//! converged random walk, kept beside the case ([`Reference`]). [`run()`] renders each case a few times with different
//! seeds through a [`Renderer`]; [`measure`](measure()) estimates means with standard errors from these, [`judge()`]
//! compares, and where a case fails, [`diagnose`](diagnose()) names the mistake that would show just that. [`report`]
//! tells all of it.
//!
//! | word | meaning |
//! | --- | --- |
//! | expectation | mean of a region, three channels, with its standard error and tolerance |
//! | batch | one render of a case with a seed of its own |
//! | symptom | mean that a known mistake would show |

mod case;
mod command;
mod diagnose;
mod judge;
mod measure;
mod reference;
mod renderer;
pub mod report;
mod run;
mod suite;

pub use case::{Case, Expectation, Region, Sweep, Symptom};
pub use command::{CommandTemplate, end_renderers};
pub use diagnose::{Diagnosis, diagnose};
pub use judge::{CONFIDENCE, Judgement, POWER, Verdict, judge, samples_needed};
pub use measure::{Estimate, measure};
pub use reference::{Reference, RegionMean};
pub use renderer::{Job, Own, Renderer};
pub use run::{Finding, Outcome, RunOptions, Watch, run, update_reference};
pub use suite::Suite;

use std::path::PathBuf;

/// More pixels than this are no picture of a case.
const MAX_PIXELS: usize = 1 << 22;

/// Why a suite cannot be run at all, or a reference cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ConformanceError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A description that makes no sense.
    #[error("{}: {message}", path.display())]
    Invalid {
        /// `expect.toml` or `reference.toml` of a case.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// There is nothing to run.
    #[error("{}: {message}", path.display())]
    Empty {
        /// The folder of the suite.
        path: PathBuf,
        /// What is missing.
        message: String,
    },
    /// A command template that cannot be run.
    #[error("--renderer: {0}")]
    Template(String),
    /// A case could not be rendered, where its picture was needed.
    #[error("{case}: {message}")]
    Render {
        /// Name of the case.
        case: String,
        /// What went wrong.
        message: String,
    },
}
