//! `nephrite presets`: the published media that come with the program, as a table, as JSON, and as pictures.

mod sheet;

use super::Failure;
use super::author_args::PresetsArgs;
use crate::optics::presets::{Preset, Source};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};

/// Lists or renders as the arguments say.
pub(super) fn run(args: PresetsArgs) -> Result<(), Failure> {
    if args.output.is_some() {
        return sheet::run(&args);
    }
    let text = if args.json { format!("{:#}\n", json()) } else { table() };
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::cannot(error)),
        _ => Ok(()),
    }
}

/// Coefficients in 1/m.
fn json() -> Value {
    let preset = |preset: &Preset| {
        let one = preset.with_one_anisotropy();
        json!({
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
        })
    };
    Preset::all().map(preset).collect()
}

fn table() -> String {
    let mut text = String::new();
    let mut source: Option<Source> = None;
    for preset in Preset::all() {
        // Writing to a string cannot fail.
        if source != Some(preset.source) {
            let before = if source.is_some() { "\n" } else { "" };
            let _ = writeln!(text, "{before}{}", preset.source.citation());
            let _ =
                writeln!(text, "  {:<28}{:>27}{:>27}{:>21}{:>6}", "name", "σa / mm⁻¹", "σs / mm⁻¹", "g", "η");
            source = Some(preset.source);
        }
        let triple = |v: [f64; 3]| v.map(short).join(" ");
        let g = if preset.g == [0.0; 3] { "0".to_owned() } else { triple(preset.g) };
        let _ = writeln!(
            text,
            "  {:<28}{:>27}{:>27}{g:>21}{:>6}",
            preset.name,
            triple(preset.sigma_a_per_mm),
            triple(preset.sigma_s_per_mm),
            preset.eta
        );
    }
    text
}

/// At most four digits.
fn short(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    let decimals = (3 - v.abs().log10().floor() as i32).clamp(0, 7) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
