//! Presets as text: a line each, or a paragraph each.

use crate::optics::presets::{Preset, Source};
use std::fmt::Write as _;

/// A line each, below the source. Writing to a string cannot fail.
pub(super) fn table(presets: &[&Preset]) -> String {
    let mut text = String::new();
    let mut source: Option<Source> = None;
    for preset in presets {
        if source != Some(preset.source) {
            let before = if source.is_some() { "\n" } else { "" };
            let _ = writeln!(text, "{before}{}", preset.source.citation());
            let _ =
                writeln!(text, "  {:<28}{:>27}{:>27}{:>21}{:>6}", "name", "σa / mm⁻¹", "σs / mm⁻¹", "g", "η");
            source = Some(preset.source);
        }
        let _ = writeln!(
            text,
            "  {:<28}{:>27}{:>27}{:>21}{:>6}",
            preset.name,
            triple(preset.sigma_a_per_mm),
            triple(preset.sigma_s_per_mm),
            anisotropy(preset),
            preset.eta
        );
    }
    text
}

/// A paragraph each.
pub(super) fn in_full(presets: &[&Preset]) -> String {
    let mut text = String::new();
    for (i, preset) in presets.iter().enumerate() {
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "  {name:<18}{value}");
        };
        if i > 0 {
            line("", String::new());
        }
        let others: Vec<&str> = preset.other_names().collect();
        line("name", preset.name.to_owned());
        if !others.is_empty() {
            line("also", others.join(", "));
        }
        line("source", preset.source.citation().to_owned());
        if !preset.note.is_empty() {
            line("what it is", preset.note.to_owned());
        }
        let free = [0, 1, 2].map(|i| 1.0 / (preset.sigma_a_per_mm[i] + preset.sigma_s_per_mm[i]));
        line("absorption σa", format!("{} 1/mm", triple(preset.sigma_a_per_mm)));
        line("scattering σs", format!("{} 1/mm", triple(preset.sigma_s_per_mm)));
        line("anisotropy g", anisotropy(preset));
        line("index η", preset.eta.to_string());
        line("mean free path", format!("{} mm", triple(free)));
        line("to use it", format!("nephrite edit IN -o OUT --material NAME --preset {}", preset.name));
    }
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

fn anisotropy(preset: &Preset) -> String {
    if preset.g == [0.0; 3] { "0".to_owned() } else { triple(preset.g) }
}

fn triple(values: [f64; 3]) -> String {
    values.map(short).join(" ")
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
