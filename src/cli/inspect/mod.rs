//! `nephrite inspect`: what is in a file, what its media do to light, and what will be ignored.
//!
//! [`report`] gathers the facts; they are printed as JSON, or for people by [`text`].

mod format;
mod lamps;
mod report;
mod text;

use super::Failure;
use super::args::{InspectArgs, LoadArgs};
use super::documents::Documents;
use super::message::{Reporter, write_out};
use super::pipeline;
use crate::asset::LoadOptions;
use report::Report;
use serde_json::Value;

/// Inspects as the arguments say.
pub(super) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let all = Documents::all(&args.load.input)?;
    let mut reports = Vec::new();
    let mut is_first = true;
    let result = all.each(|document| {
        let load = LoadArgs { input: document.to_owned(), ..args.load.clone() };
        let mut asset = pipeline::open_with(&load, LoadOptions { scene: args.scene, ..Default::default() })?;
        let reporter = Reporter::of(false, all.named(document));
        let moment = args.play.moment(&asset, false, &reporter)?;
        let loaded = pipeline::load(document, &mut asset, &moment)?;
        let report = Report::new(document, &loaded);
        match (args.json, all.are_several()) {
            (true, false) => {
                write_out(&format!("{}\n", serde_json::to_string_pretty(&report).map_err(Failure::cannot)?))
            }
            (true, true) => {
                reports.push(serde_json::to_value(&report).map_err(Failure::cannot)?);
                Ok(())
            }
            (false, _) => {
                let between = if std::mem::take(&mut is_first) { "" } else { "\n" };
                write_out(&format!("{between}{}", text::describe(&report, &loaded.scene)))
            }
        }
    });
    if args.json && all.are_several() {
        write_out(&format!("{:#}\n", Value::Array(reports)))?;
    }
    result
}
