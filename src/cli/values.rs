//! How single values on the command line are read, and what is said where they make no sense.

use super::names;
use super::pipeline::{Cosines, Microfacet, subsurface_models};
use crate::asset::Limits;
use crate::film::ToneMap;
use crate::optics::diffusion::Coefficients;
use crate::optics::presets::Preset;
use glam::Vec3;
use std::path::PathBuf;

/// The light that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum EnvArg {
    Studio,
    None,
    Constant(Vec3),
    File(PathBuf),
}

/// The ground that was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GroundArg {
    None,
    /// Only its shadow is seen.
    Shadow,
    /// Matte, of that linear reflectance.
    Color(Vec3),
}

/// The medium that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MediumArg {
    Preset(&'static Preset),
    /// In the unit that is asked for beside it.
    Numbers(Coefficients),
}

/// Which channels of a preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelArg {
    Red,
    Green,
    Blue,
    All,
}

/// The unit whose inverse coefficients have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LengthUnit {
    Metre,
    Centimetre,
    Millimetre,
}

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "write it as width x height, for example 1280x720".to_owned();
    if let Ok(side) = text.trim().parse::<u32>() {
        return Err(format!("{side} is one side of two; {}", wrong()));
    }
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |s: &str| s.trim().parse::<u32>().ok().filter(|&n| n > 0).ok_or_else(wrong);
    Ok((side(width)?, side(height)?))
}

/// More threads than this are a typing error.
const MAX_THREADS: usize = 4096;

pub(super) fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MAX_THREADS).contains(&n) => Ok(n),
        _ => Err(format!("a whole number from 1 to {MAX_THREADS} is expected")),
    }
}

pub(super) fn number(text: &str) -> Result<f32, String> {
    number_of(text, "a number", |_| true)
}

pub(super) fn positive(text: &str) -> Result<f32, String> {
    number_of(text, "a number of at least 0", |x| x >= 0.0)
}

pub(super) fn filter_width(text: &str) -> Result<f32, String> {
    number_of(text, "a width of 0 to 1 pixel", |x| (0.0..=1.0).contains(&x))
}

pub(super) fn above_zero(text: &str) -> Result<f32, String> {
    number_of(text, "a number above 0", |x| x > 0.0)
}

fn number_of(text: &str, what: &str, holds: impl Fn(f32) -> bool) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|&x| x.is_finite() && holds(x));
    number.ok_or_else(|| format!("{what} is expected{}", without_unit(text)))
}

/// “, without mm” where a number is followed by something.
pub(super) fn without_unit(text: &str) -> String {
    let text = text.trim();
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
    let number = &text[..text.len() - unit.len()];
    if unit.is_empty() || number.parse::<f64>().is_err() {
        return String::new();
    }
    format!(", without {:?}", unit.trim())
}

/// A limit of the loader by its name, as in `vertices=200M`.
pub(super) fn limit(text: &str) -> Result<(String, u64), String> {
    let (name, value) = text.split_once('=').ok_or("write it as NAME=N, for example image-bytes=4G")?;
    if !Limits::NAMES.contains(&name) {
        return Err(names::unknown("limit", name, Limits::NAMES));
    }
    let digits = value.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &value[digits.len()..] {
        "" => 1,
        "k" => 1_000,
        "M" => 1_000_000,
        "G" => 1_000_000_000,
        "Ki" => 1 << 10,
        "Mi" => 1 << 20,
        "Gi" => 1 << 30,
        other => return Err(format!("{other} is none of the units k, M, G, Ki, Mi and Gi")),
    };
    let value = digits.parse::<u64>().ok().and_then(|n| n.checked_mul(unit));
    Ok((name.to_owned(), value.ok_or("a whole number is expected, for example 200M")?))
}

/// A light, whose file may have any name.
pub(super) fn environment_parser() -> impl clap::builder::TypedValueParser<Value = EnvArg> {
    use clap::builder::TypedValueParser;
    clap::builder::OsStringValueParser::new().try_map(|text| match text.into_string() {
        Ok(text) => environment(&text),
        Err(name) => Ok(EnvArg::File(name.into())),
    })
}

pub(super) fn environment(text: &str) -> Result<EnvArg, String> {
    match text {
        "studio" => return Ok(EnvArg::Studio),
        "none" => return Ok(EnvArg::None),
        _ => {}
    }
    if let Some(digits) = text.strip_prefix('#').filter(|_| !text.contains('.')) {
        return hexadecimal(digits).map(EnvArg::Constant);
    }
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    if let Ok(radiance) = parts.iter().map(|part| positive(part)).collect::<Result<Vec<f32>, _>>() {
        return match radiance[..] {
            [grey] => Ok(EnvArg::Constant(Vec3::splat(grey))),
            [r, g, b] => Ok(EnvArg::Constant(Vec3::new(r, g, b))),
            _ => {
                Err("a radiance has three parts, red,green,blue, or is one number, which is grey".to_owned())
            }
        };
    }
    let path = PathBuf::from(text);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("hdr" | "exr") => Ok(EnvArg::File(path)),
        Some(other) => Err(format!("a .{other} file is no environment; .hdr and .exr are")),
        None => Err(format!(
            "{}; besides those, a .hdr or .exr file or a radiance, R,G,B or one number, of at least 0",
            names::unknown("environment", text, ["studio", "none"])
        )),
    }
}

/// A colour of a paint program, linear.
fn hexadecimal(digits: &str) -> Result<Vec3, String> {
    super::author_values::hexadecimal(digits).map(|color| Vec3::from_array(color.map(|c| c as f32)))
}

/// Reflectance of a ground whose colour was not chosen.
const GREY: f32 = 0.5;

pub(super) fn ground(text: &str) -> Result<GroundArg, String> {
    match text {
        "none" => return Ok(GroundArg::None),
        "shadow" => return Ok(GroundArg::Shadow),
        "color" => return Ok(GroundArg::Color(Vec3::splat(GREY))),
        _ => {}
    }
    if let Some(digits) = text.strip_prefix('#') {
        return hexadecimal(digits).map(GroundArg::Color);
    }
    let parts: Result<Vec<f32>, _> = text.split(',').map(|part| number(part.trim())).collect();
    match parts.as_deref() {
        Ok(&[r, g, b]) if [r, g, b].iter().all(|c| (0.0..=1.0).contains(c)) => {
            Ok(GroundArg::Color(Vec3::new(r, g, b)))
        }
        Ok(&[grey]) if (0.0..=1.0).contains(&grey) => Ok(GroundArg::Color(Vec3::splat(grey))),
        Ok(_) => Err("a colour has three parts from 0 to 1, red,green,blue, or is one number, which is grey"
            .to_owned()),
        Err(_) => Err(format!(
            "{}; besides those, a linear reflectance R,G,B from 0 to 1",
            names::unknown("ground", text, ["none", "shadow", "color"])
        )),
    }
}

pub(super) fn subsurface(text: &str) -> Result<String, String> {
    let models = subsurface_models();
    if models.iter().any(|name| name == text) {
        return Ok(text.to_owned());
    }
    Err(names::unknown("subsurface model", text, models.iter().map(String::as_str)))
}

/// The name of the model of a walk.
pub(super) fn walk(text: &str) -> Result<String, String> {
    match text {
        "exact" => Ok("random-walk".to_owned()),
        "accelerated" => Ok("accelerated-walk".to_owned()),
        _ => Err(names::unknown("walk", text, ["exact", "accelerated"])),
    }
}

/// When unfinished pictures are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progressive {
    /// Where somebody watches and nothing is lost.
    Auto,
    Always,
    Never,
}

pub(super) fn progressive(text: &str) -> Result<Progressive, String> {
    match text {
        "auto" => Ok(Progressive::Auto),
        "always" => Ok(Progressive::Always),
        "never" => Ok(Progressive::Never),
        _ => Err(names::unknown("way to show progress", text, ["auto", "always", "never"])),
    }
}

pub(super) fn microfacet(text: &str) -> Result<Microfacet, String> {
    match text {
        "multiple" => Ok(Microfacet::Multiple),
        "single" => Ok(Microfacet::Single),
        _ => Err(names::unknown("microfacet model", text, ["multiple", "single"])),
    }
}

pub(super) fn cosines(text: &str) -> Result<Cosines, String> {
    match text {
        "refracted" => Ok(Cosines::Refracted),
        "unrefracted" => Ok(Cosines::Unrefracted),
        _ => Err(names::unknown("choice of cosines", text, ["refracted", "unrefracted"])),
    }
}

pub(super) fn tone_map(text: &str) -> Result<ToneMap, String> {
    let found = ToneMap::ALL.into_iter().find(|map| map.name() == text);
    found.ok_or_else(|| names::unknown("tone map", text, ToneMap::ALL.map(ToneMap::name)))
}

pub(super) fn medium(text: &str) -> Result<MediumArg, String> {
    if !text.contains(',') {
        return Preset::named(text).map(MediumArg::Preset).ok_or_else(|| {
            let unknown = names::unknown("preset", text, Preset::all_names());
            format!("{unknown}; or give four numbers σa,σs,g,η")
        });
    }
    let parts = text.split(',').map(|part| part.trim().parse::<f64>().map_err(|_| part.trim()));
    let wrong =
        |why: &str| Err(format!("{why}a medium is four numbers: σa,σs,g,η, for example 20,1500,0.4,1.4"));
    let numbers: Vec<f64> = match parts.collect() {
        Ok(numbers) => numbers,
        Err("") => return wrong("a number is missing; "),
        Err(part) => return wrong(&format!("{part:?} is no number; ")),
    };
    let [sigma_a, sigma_s, g, eta] = numbers[..] else { return wrong("") };
    let coefficient = |v: f64| v == 0.0 || (MIN_COEFFICIENT..=MAX_COEFFICIENT).contains(&v);
    if !(coefficient(sigma_a) && coefficient(sigma_s)) {
        return Err(format!("σa and σs are 0, or between {MIN_COEFFICIENT:e} and {MAX_COEFFICIENT:e}"));
    }
    if sigma_s == 0.0 {
        return Err("a medium that does not scatter (σs = 0) has no profile".to_owned());
    }
    if !(-MAX_ANISOTROPY..=MAX_ANISOTROPY).contains(&g) {
        return Err(format!("g is between −{MAX_ANISOTROPY} and {MAX_ANISOTROPY}"));
    }
    if !(1.0..=MAX_INDEX).contains(&eta) {
        return Err(format!("η is between 1 and {MAX_INDEX}"));
    }
    Ok(MediumArg::Numbers(Coefficients { sigma_a, sigma_s, g, eta }))
}

/// Coefficients above this are a typing error; so is a mean cosine nearer to 1, whose walks would not end.
const MAX_COEFFICIENT: f64 = 1e12;
/// Below this nothing would be scattered within the earth's orbit.
const MIN_COEFFICIENT: f64 = 1e-12;
const MAX_ANISOTROPY: f64 = 0.99;
/// Diamond has 2.4.
const MAX_INDEX: f64 = 4.0;

pub(super) fn channel(text: &str) -> Result<ChannelArg, String> {
    match text {
        "r" => Ok(ChannelArg::Red),
        "g" => Ok(ChannelArg::Green),
        "b" => Ok(ChannelArg::Blue),
        "all" => Ok(ChannelArg::All),
        _ => Err(names::unknown("channel", text, ["r", "g", "b", "all"])),
    }
}

pub(super) fn length_unit(text: &str) -> Result<LengthUnit, String> {
    match text {
        "m" => Ok(LengthUnit::Metre),
        "cm" => Ok(LengthUnit::Centimetre),
        "mm" => Ok(LengthUnit::Millimetre),
        _ => Err(names::unknown("unit", text, ["m", "cm", "mm"])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_environments_are_read_and_nonsense_is_not() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for wrong in ["640", "0x3", "x", "-3x4", "1e3x10", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(environment("studio"), Ok(EnvArg::Studio));
        assert_eq!(environment("1, .5,0"), Ok(EnvArg::Constant(Vec3::new(1.0, 0.5, 0.0))));
        assert_eq!(environment("1"), Ok(EnvArg::Constant(Vec3::ONE)));
        assert_eq!(environment(" .25"), Ok(EnvArg::Constant(Vec3::splat(0.25))));
        assert_eq!(environment("a,b.hdr"), Ok(EnvArg::File("a,b.hdr".into())));
        for (wrong, advice) in [
            ("1,2", "three"),
            ("1,-2,3", "at least 0"),
            ("-1", "at least 0"),
            ("studoi", "studio"),
            ("sky.jpg", ".hdr"),
            ("nan,1,1", "R,G,B"),
        ] {
            let error = environment(wrong).unwrap_err();
            assert!(error.contains(advice), "{wrong}: {error}");
        }
        assert_eq!(limit("vertices=200M"), Ok(("vertices".to_owned(), 200_000_000)));
        assert_eq!(limit("image-bytes=3Gi"), Ok(("image-bytes".to_owned(), 3 << 30)));
        assert_eq!(limit("nodes=0"), Ok(("nodes".to_owned(), 0)));
        for (wrong, advice) in [
            ("vertices", "NAME=N"),
            ("vertexes=1", "vertices"),
            ("nodes=1T", "units"),
            ("nodes=-1", "whole number"),
            ("nodes=99999999999999999999", "whole number"),
            ("nodes=18446744073709551615k", "whole number"),
        ] {
            assert!(limit(wrong).unwrap_err().contains(advice), "{wrong}");
        }
        let numbers = Coefficients { sigma_a: 20.0, sigma_s: 1500.0, g: 0.4, eta: 1.4 };
        assert_eq!(medium("20, 1500,0.4,1.4"), Ok(MediumArg::Numbers(numbers)));
        for (wrong, advice) in [
            ("skimmilk", "did you mean skim-milk"),
            ("1,2,3", "four numbers"),
            ("1,x,0,1.3", "\"x\" is no number; a medium is four numbers"),
            ("1,x,2,0,1.3", "\"x\" is no number"),
            ("1,2,0,1.3,", "a number is missing"),
            ("20 1500 0.4 1.4,", "is no number"),
            ("-1,2,0,1.3", "σa"),
            ("1,0,0,1.3", "scatter"),
            ("1,2,1,1.3", "g is"),
            ("1,2,0,nan", "η is"),
        ] {
            let error = medium(wrong).unwrap_err();
            assert!(error.contains(advice), "{wrong}: {error}");
        }
        for (wrong, advice) in [
            ("10mm", "without \"mm\""),
            ("90°", "without"),
            ("-1", "at least 0"),
            ("mm", "at least 0 is expected"),
        ] {
            assert!(positive(wrong).unwrap_err().contains(advice), "{wrong}");
        }
        assert!(!positive("mm").unwrap_err().contains("without"));
        assert_eq!(ground("#ff0000"), Ok(GroundArg::Color(Vec3::X)));
        assert_eq!(ground("0.25"), Ok(GroundArg::Color(Vec3::splat(0.25))));
        assert_eq!(environment("#00f"), Ok(EnvArg::Constant(Vec3::Z)));
        assert!(environment("#12").unwrap_err().contains("#rrggbb"));
        assert!(tone_map("acess").unwrap_err().contains("did you mean aces"));
    }
}
