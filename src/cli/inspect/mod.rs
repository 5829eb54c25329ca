//! `nephrite inspect`: what is in a file, what its media do to light, and what will be ignored.
//!
//! [`report`] gathers the facts; they are printed as JSON, or for people by [`text`].

mod format;
mod report;
mod text;

use super::Failure;
use super::args::InspectArgs;
use super::message::Reporter;
use super::pipeline;
use crate::asset::LoadOptions;
use report::Report;
use std::io::{ErrorKind, Write};

/// Inspects as the arguments say.
pub(super) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let mut asset = pipeline::open_with(&args.load, LoadOptions { scene: args.scene, ..Default::default() })?;
    let moment = args.play.moment(&asset, false, &Reporter::new(false))?;
    let loaded = pipeline::load(&args.load.input, &mut asset, &moment)?;
    let report = Report::new(&args.load.input, &loaded);
    let output = if args.json {
        let mut json = serde_json::to_string_pretty(&report).map_err(Failure::cannot)?;
        json.push('\n');
        json
    } else {
        text::describe(&report, &loaded.scene)
    };
    match std::io::stdout().lock().write_all(output.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::cannot(error)),
        _ => Ok(()),
    }
}
