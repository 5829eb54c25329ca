//! `nephrite presets`: the media that come with the program, as a table, in full, as JSON, and as pictures.

mod sheet;
mod table;

use super::Failure;
use super::author_args::PresetsArgs;
use super::author_values::unknown_preset;
use crate::optics::presets::Preset;
use serde_json::{Value, json};
use std::io::{ErrorKind, Write as _};

/// As many presets are told in full.
const FEW: usize = 12;

/// Lists or renders as the arguments say.
pub(super) fn run(args: PresetsArgs) -> Result<(), Failure> {
    let presets = chosen(&args.names)?;
    if args.output.is_some() {
        return sheet::run(&args, &presets);
    }
    let text = if args.json {
        format!("{:#}\n", json(&presets))
    } else if args.names.is_empty() || presets.len() > FEW {
        table::table(&presets)
    } else {
        table::in_full(&presets)
    };
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::cannot(error)),
        _ => Ok(()),
    }
}

/// The presets with the words of any of these texts in one of their names, in the order of all; all without texts.
fn chosen(names: &[String]) -> Result<Vec<&'static Preset>, Failure> {
    for name in names {
        if Preset::named(name).is_none() && !Preset::all().any(|preset| preset.matches(name)) {
            return Err(Failure::Usage(unknown_preset(name)));
        }
    }
    let wanted = |preset: &&'static Preset| {
        names.is_empty()
            || names.iter().any(|name| preset.matches(name) || Preset::named(name) == Some(*preset))
    };
    Ok(Preset::all().filter(wanted).collect())
}

/// Coefficients in 1/m.
fn json(presets: &[&Preset]) -> Value {
    let preset = |preset: &&Preset| {
        let one = preset.with_one_anisotropy();
        let mut value = json!({
            "name": preset.name,
            "source": preset.source.citation(),
            "sigma_a": preset.sigma_a_per_mm.map(|v| 1000.0 * v),
            "sigma_s": preset.sigma_s_per_mm.map(|v| 1000.0 * v),
            "anisotropy": preset.g,
            "ior": preset.eta,
            "as_written": {
                "absorptionCoefficient": one.sigma_a,
                "scatteringCoefficient": one.sigma_s,
                "scatterAnisotropy": one.g,
                "ior": one.eta,
            },
            "other_names": preset.other_names().collect::<Vec<_>>(),
        });
        if !preset.note.is_empty() {
            value["note"] = json!(preset.note);
        }
        value
    };
    presets.iter().map(preset).collect()
}
