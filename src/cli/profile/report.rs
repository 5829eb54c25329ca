//! The numbers of the profiles, for programs.

use super::job::ProfileJob;
use super::{Curve, Curves};
use crate::cli::values::MediumArg;
use serde_json::{Value, json};
use std::fmt::Write;

/// What is recorded in the figure.
pub(super) fn attributes(job: &ProfileJob) -> Vec<(String, String)> {
    let pairs = [
        ("medium", medium(job).to_string()),
        ("paths", job.args.paths.to_string()),
        ("seed", job.args.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    pairs.map(|(name, value)| (format!("nephrite:{name}"), value)).to_vec()
}

fn medium(job: &ProfileJob) -> Value {
    let channels: Vec<Value> = job
        .channels
        .iter()
        .map(|channel| {
            let c = &channel.coefficients;
            json!({ "channel": channel.color, "sigma_a": c.sigma_a, "sigma_s": c.sigma_s, "g": c.g, "eta": c.eta })
        })
        .collect();
    let preset = match &job.args.medium {
        MediumArg::Preset(preset) => Some(preset),
        MediumArg::Numbers(_) => None,
    };
    json!({
        "preset": preset.map(|preset| preset.name),
        "source": preset.map(|preset| preset.source.citation()),
        "channels": channels,
    })
}

/// Everything, with what is needed to do it again. Lengths in metres.
pub(super) fn json(job: &ProfileJob, found: &[Curves]) -> Value {
    let channels: Vec<Value> = found
        .iter()
        .map(|curves| {
            let unit = curves.channel.coefficients.transport_mean_free_path();
            let curve = |curve: &Curve| {
                let per_area = |v: f64| v / (unit * unit);
                json!({
                    "name": curve.name,
                    "source": curve.source.name(),
                    "total": curve.total.value,
                    "total_standard_error": curve.total.standard_error,
                    "reflectance": curve.bins.iter().map(|bin| per_area(bin.value)).collect::<Vec<_>>(),
                    "standard_error": curve.bins.iter().map(|bin| per_area(bin.standard_error)).collect::<Vec<_>>(),
                })
            };
            json!({
                "channel": curves.channel.color,
                "transport_mean_free_path": unit,
                "radii": curves.edges.iter().map(|r| unit * r).collect::<Vec<_>>(),
                "random_walk": curve(&curves.walk),
                "models": curves.models.iter().map(curve).collect::<Vec<_>>(),
                "left_out": curves.left_out.iter().map(|(name, reason)| json!({ "name": name, "reason": reason })).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "medium": medium(job),
        "paths": job.args.paths,
        "seed": job.args.seed,
        "channels": channels,
    })
}

/// One line for each channel, model and bin.
pub(super) fn csv(found: &[Curves]) -> String {
    let mut text =
        String::from("channel,model,source,r_min_mm,r_max_mm,r_min_mfp,r_max_mfp,R_per_mm2,R_per_mm2_se\n");
    for curves in found {
        let unit = 1e3 * curves.channel.coefficients.transport_mean_free_path();
        let color = curves.channel.color.unwrap_or_default();
        for curve in std::iter::once(&curves.walk).chain(&curves.models) {
            for (pair, bin) in curves.edges.windows(2).zip(&curve.bins) {
                let [a, b] = [pair[0], pair[1]];
                let [value, error] = [bin.value, bin.standard_error].map(|v| v / (unit * unit));
                let (name, source) = (&curve.name, curve.source.name());
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "{color},{name},{source},{},{},{a},{b},{value},{error}",
                    a * unit,
                    b * unit
                );
            }
        }
    }
    text
}
