//! The numbers of a comparison, for programs.

use super::{Results, input_name};
use crate::cli::args::CompareArgs;
use crate::cli::setup::Prepared;
use crate::film::compare::{Comparison, Measured};
use serde_json::{Value, json};
use std::fmt::Write;

/// What is recorded in the sheet.
pub(super) fn attributes(
    args: &CompareArgs,
    prepared: &Prepared,
    results: &Results,
) -> Vec<(String, String)> {
    let mut options = prepared.record(&args.scene);
    options["reference_spp"] = json!(results.reference_spp);
    options["tonemap"] = json!(args.scene.tonemap.name());
    options["exposure"] = json!(args.scene.exposure);
    let pairs = [
        ("scene", input_name(args)),
        ("options", options.to_string()),
        ("spp", results.spp.to_string()),
        ("seed", args.scene.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    pairs.map(|(name, value)| (format!("nephrite:{name}"), value)).to_vec()
}

/// Everything, with what is needed to do it again.
pub(super) fn json(args: &CompareArgs, prepared: &Prepared, results: &Results, full_scale: f32) -> Value {
    let reference = &results.reference;
    let models: Vec<Value> = results
        .models
        .iter()
        .map(|(entry, found)| {
            json!({
                "name": entry.name,
                "summary": entry.summary,
                "seconds": entry.work.seconds,
                "cpu_seconds": entry.work.cpu_seconds,
                "rel_mse": found.rel_mse,
                "bias": number(found.bias),
                "noise": found.noise,
                "noise_p999": found.noise_p999,
                "reference_noise": found.reference_noise,
                "mean": entry.picture.mean(),
                "mean_ratio": found.mean_ratio.map(number),
            })
        })
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "input": args.scene.load.input.to_string_lossy(),
        "options": prepared.record(&args.scene),
        "seed": args.scene.seed,
        "threads": prepared.options(&args.scene, results.spp, "").thread_count(),
        "spp": results.spp,
        "reference": {
            "name": reference.name,
            "spp": results.reference_spp,
            "seconds": reference.work.seconds,
            "cpu_seconds": reference.work.cpu_seconds,
            "mean": reference.picture.mean(),
        },
        "false_color_full_scale": full_scale,
        "models": models,
    })
}

fn number(measured: Measured) -> Value {
    json!({ "value": measured.value, "standard_error": measured.standard_error })
}

/// One line a model.
pub(super) fn csv(results: &Results) -> String {
    let mut text = String::from(
        "model,spp,seconds,cpu_seconds,rel_mse,bias,bias_se,noise,noise_p999,reference_noise,\
         mean_ratio_r,mean_ratio_g,mean_ratio_b,mean_ratio_r_se,mean_ratio_g_se,mean_ratio_b_se\n",
    );
    for (entry, found) in &results.models {
        let Comparison { rel_mse, bias, noise, noise_p999, reference_noise, mean_ratio } = found;
        let cpu = entry.work.cpu_seconds.map(|s| s.to_string()).unwrap_or_default();
        let fields =
            [*rel_mse, bias.value, bias.standard_error, *noise, *noise_p999, *reference_noise].into_iter();
        let ratios = mean_ratio.iter().map(|m| m.value).chain(mean_ratio.iter().map(|m| m.standard_error));
        let (name, spp, seconds) = (&entry.name, results.spp, entry.work.seconds);
        // Writing to a string cannot fail.
        let _ = write!(text, "{name},{spp},{seconds},{cpu}");
        fields.chain(ratios).for_each(|value| {
            let _ = write!(text, ",{value}");
        });
        text.push('\n');
    }
    text
}
