//! What can be typed. Values are checked here one by one; what they mean together is decided in [`super::job`].

use super::names;
use super::pipeline::{Microfacet, subsurface_models};
use crate::film::ToneMap;
use clap::{Parser, Subcommand};
use glam::Vec3;
use std::path::PathBuf;

/// A path tracer for glTF 2.0, made for light that travels below surfaces.
#[derive(Debug, Parser)]
#[command(name = "nephrite", version, propagate_version = true, arg_required_else_help = true)]
pub(super) struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a glTF file to pictures
    Render(Box<RenderArgs>),
    /// Say what is in a glTF file, and what will be ignored
    Inspect(InspectArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite render jade.glb -o jade.png\n  \
    nephrite render jade.glb -o jade.exr -o jade.png --size 1920x1080 --spp 512 --env sky.hdr")]
pub(super) struct RenderArgs {
    /// The .gltf or .glb file
    pub input: PathBuf,

    /// Picture to write: .exr .png .jpg .hdr; may be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Size in pixels; by default the longest side is 1024, with the camera's own aspect ratio or 4:3
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,

    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,

    /// Another seed gives another noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,

    /// Threads; the picture does not depend on them [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,

    /// Camera of the file; by default its first, or automatic framing if it has none
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,

    /// Scene of the file [default: the file's own choice]
    #[arg(long, value_name = "N")]
    pub scene: Option<usize>,

    /// Light from all around: an equirectangular .hdr or .exr, the built-in studio, none, or one radiance; by default
    /// the studio if the file has no lights, else none
    #[arg(long, value_name = "FILE|studio|none|R,G,B", value_parser = environment)]
    pub env: Option<EnvArg>,

    /// Turn the environment about the vertical axis, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    pub env_rotation: f32,

    /// Multiply the radiance of the environment
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = positive)]
    pub env_intensity: f32,

    /// How light travels below surfaces
    #[arg(long, value_name = "MODEL", default_value = "random-walk", value_parser = subsurface)]
    pub subsurface: String,

    /// Most events of a path, scatterings included; paths cut off here lose light
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_depth: u32,

    /// Whether light bounces more than once among the facets of rough surfaces: multiple or single
    #[arg(long, value_name = "MODEL", default_value = "multiple", value_parser = microfacet)]
    pub microfacet: Microfacet,
    /// Do not aim paths below a surface at lights (the same picture, noisier; for comparisons)
    #[arg(long, hide_short_help = true)]
    pub no_aim: bool,

    /// Tone map of .png and .jpg: pbr-neutral, aces, agx or linear
    #[arg(long, value_name = "NAME", default_value = "pbr-neutral", value_parser = tone_map)]
    pub tonemap: ToneMap,

    /// Exposure of .png and .jpg in stops
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    pub exposure: f32,

    /// Write .exr with 32 bit floats instead of 16 bit ones
    #[arg(long)]
    pub float: bool,

    /// Write times, counts and the mean colour as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

    /// Treat what is wrong with the file as an error even where it could be rendered
    #[arg(long)]
    pub strict: bool,

    /// Neither notes nor progress; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct InspectArgs {
    /// The .gltf or .glb file
    pub input: PathBuf,

    /// Scene of the file [default: the file's own choice]
    #[arg(long, value_name = "N")]
    pub scene: Option<usize>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The light that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum EnvArg {
    Studio,
    None,
    Constant(Vec3),
    File(PathBuf),
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "write it as width x height, for example 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |s: &str| s.trim().parse::<u32>().ok().filter(|&n| n > 0).ok_or_else(wrong);
    Ok((side(width)?, side(height)?))
}

/// More threads than this are a typing error.
const MAX_THREADS: usize = 4096;

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MAX_THREADS).contains(&n) => Ok(n),
        _ => Err(format!("a whole number from 1 to {MAX_THREADS} is expected")),
    }
}

fn number(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|x| x.is_finite()).ok_or_else(|| "a number is expected".to_owned())
}

fn positive(text: &str) -> Result<f32, String> {
    number(text).ok().filter(|&x| x >= 0.0).ok_or_else(|| "a number of at least 0 is expected".to_owned())
}

fn environment(text: &str) -> Result<EnvArg, String> {
    match text {
        "studio" => return Ok(EnvArg::Studio),
        "none" => return Ok(EnvArg::None),
        _ => {}
    }
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    if let Ok(radiance) = parts.iter().map(|part| positive(part)).collect::<Result<Vec<f32>, _>>() {
        return match radiance[..] {
            [r, g, b] => Ok(EnvArg::Constant(Vec3::new(r, g, b))),
            _ => Err("a radiance has three parts: red,green,blue".to_owned()),
        };
    }
    let path = PathBuf::from(text);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("hdr" | "exr") => Ok(EnvArg::File(path)),
        Some(other) => Err(format!("a .{other} file is no environment; .hdr and .exr are")),
        None => Err(format!(
            "{}; besides those, a .hdr or .exr file or a radiance R,G,B of at least 0",
            names::unknown("environment", text, ["studio", "none"])
        )),
    }
}

fn subsurface(text: &str) -> Result<String, String> {
    let models = subsurface_models();
    if models.iter().any(|name| name == text) {
        return Ok(text.to_owned());
    }
    Err(names::unknown("subsurface model", text, models.iter().map(String::as_str)))
}

fn microfacet(text: &str) -> Result<Microfacet, String> {
    match text {
        "multiple" => Ok(Microfacet::Multiple),
        "single" => Ok(Microfacet::Single),
        _ => Err(names::unknown("microfacet model", text, ["multiple", "single"])),
    }
}

fn tone_map(text: &str) -> Result<ToneMap, String> {
    let found = ToneMap::ALL.into_iter().find(|map| map.name() == text);
    found.ok_or_else(|| names::unknown("tone map", text, ToneMap::ALL.map(ToneMap::name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn sizes_and_environments_are_read_and_nonsense_is_not() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for wrong in ["640", "0x3", "x", "-3x4", "1e3x10", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(environment("studio"), Ok(EnvArg::Studio));
        assert_eq!(environment("1, .5,0"), Ok(EnvArg::Constant(Vec3::new(1.0, 0.5, 0.0))));
        assert_eq!(environment("a,b.hdr"), Ok(EnvArg::File("a,b.hdr".into())));
        for (wrong, advice) in [
            ("1,2", "three"),
            ("1,-2,3", "at least 0"),
            ("studoi", "studio"),
            ("sky.jpg", ".hdr"),
            ("nan,1,1", "R,G,B"),
        ] {
            let error = environment(wrong).unwrap_err();
            assert!(error.contains(advice), "{wrong}: {error}");
        }
        assert!(tone_map("acess").unwrap_err().contains("did you mean aces"));
    }
}
