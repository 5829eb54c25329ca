//! What can be typed. Values are checked one by one in [`super::values`]; what they mean together is decided in
//! [`super::job`].

use super::animation::{PlayArgs, ShutterArgs};
use super::author_args::{ConvertArgs, EditArgs, PresetsArgs, ValidateArgs};
use super::conformance_args::ConformanceArgs;
use super::lights::LightArgs;
use super::pipeline::{Cosines, Microfacet, subsurface_models};
use super::values::*;
use crate::film::ToneMap;
use crate::scene::Footprint;
use clap::{Parser, Subcommand};
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
    /// Render a glTF file with every subsurface model, and measure how far each is from the random walk
    CompareModels(Box<CompareArgs>),
    /// Measure how far light travels below the surface of a medium: R(r) by every subsurface model
    Profile(ProfileArgs),
    /// Give materials of a glTF file a medium, change it, or remove it
    Edit(Box<EditArgs>),
    /// Describe the media of a glTF file in another way
    Convert(ConvertArgs),
    /// List published media, or render a sphere of each
    Presets(PresetsArgs),
    /// Check the media of a glTF file
    Validate(ValidateArgs),
    /// Check that nephrite, or another renderer, shows what is known to be right
    Conformance(Box<ConformanceArgs>),
}

/// What every command that reads a glTF file has to know of it.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct LoadArgs {
    /// The .gltf or .glb file, a folder that holds only one, or - for standard input
    pub input: PathBuf,

    /// Let the file ask for more (or less) than usual, such as image-bytes=4G; may be repeated. Names: file-bytes,
    /// json-values, nodes, instances, vertices, triangles, image-bytes, pose-elements, and of what is made of the file
    /// pyramid-bytes, environment-bytes, hierarchy-bytes, light-bytes
    #[arg(long = "limit", value_name = "NAME=N", value_parser = limit, hide_short_help = true)]
    pub limits: Vec<(String, u64)>,

    /// Let the file name files outside of its folder
    #[arg(long, hide_short_help = true)]
    pub allow_outside: bool,

    /// How far apart the edges of a seam may be, in metres, to be closed where a mesh holds a medium; 0 closes none
    /// [default: 1e-5 of the largest coordinate of the mesh]
    #[arg(long, value_name = "LENGTH", value_parser = positive, hide_short_help = true)]
    pub weld_tolerance: Option<f32>,
}

/// What every command that renders has to know of the scene.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct SceneArgs {
    #[command(flatten)]
    pub load: LoadArgs,

    /// Another seed gives another noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,

    /// Threads; the picture does not depend on them [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,

    /// Camera of the file; by default its first, or automatic framing if it has none
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,

    /// Blur what is not in focus: f-number of the lens [default: that of the camera (EXT_camera_physical), or all is sharp]
    #[arg(long, value_name = "N", value_parser = above_zero)]
    pub f_stop: Option<f32>,

    /// Distance in metres at which the picture is sharp [default: that of the camera]
    #[arg(long, value_name = "METRES", value_parser = above_zero)]
    pub focus_distance: Option<f32>,

    /// Scene of the file [default: the file's own choice]
    #[arg(long, value_name = "N")]
    pub scene: Option<usize>,

    /// Materials of a variant of the file (KHR_materials_variants) [default: what the file shows by itself]
    #[arg(long, value_name = "NAME|INDEX")]
    pub variant: Option<String>,
    #[command(flatten)]
    pub play: PlayArgs,

    /// Light from all around: an equirectangular .hdr or .exr, the built-in studio, none, or one radiance; by default
    /// the studio if the file has no lights, else none
    #[arg(long, value_name = "FILE|studio|none|R,G,B|GREY", value_parser = environment_parser())]
    pub env: Option<EnvArg>,

    /// Turn the environment about the vertical axis, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = number)]
    pub env_rotation: f32,

    /// Multiply the radiance of the environment
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = positive)]
    pub env_intensity: f32,

    #[command(flatten)]
    pub lights: LightArgs,

    /// A ground below the scene: one that is seen only by its shadow, a matte one (color is grey; or give its linear
    /// reflectance), or none
    #[arg(long, value_name = "none|shadow|color|R,G,B", default_value = "none", value_parser = ground)]
    pub ground: GroundArg,

    /// Most reflections, refractions and scatterings of a path; paths cut off here lose light
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_depth: u32,

    /// Whether light bounces more than once among the facets of rough surfaces: multiple or single
    #[arg(long, value_name = "MODEL", default_value = "multiple", value_parser = microfacet)]
    pub microfacet: Microfacet,

    /// Which cosines divide single scattering in brdf-approximation and light-biased: refracted, as the formula means
    /// them, or unrefracted, as it is often read
    #[arg(long, value_name = "WHICH", default_value = "refracted", value_parser = cosines, hide_short_help = true)]
    pub brdf_cosines: Cosines,

    /// Do not aim paths below a surface at lights (the same picture, noisier; for comparisons)
    #[arg(long, hide_short_help = true)]
    pub no_aim: bool,

    /// How wide a part of a pixel colour textures are averaged over, in pixels; 0 looks them up at points (noisier where
    /// textures are small in the picture)
    #[arg(long, value_name = "PIXELS", default_value_t = Footprint::DEFAULT_FILTER, value_parser = filter_width, hide_short_help = true)]
    pub texture_filter: f32,

    /// The same as --texture-filter 0
    #[arg(long, hide_short_help = true, conflicts_with = "texture_filter")]
    pub no_texture_filter: bool,

    /// Tone map of .png and .jpg: pbr-neutral, aces, agx or linear
    #[arg(long, value_name = "NAME", default_value = "pbr-neutral", value_parser = tone_map)]
    pub tonemap: ToneMap,

    /// Exposure of .png and .jpg in stops
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = number)]
    pub exposure: f32,

    /// Treat what is wrong with the file as an error even where it could be rendered
    #[arg(long)]
    pub strict: bool,

    /// Neither notes nor progress; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite render jade.glb -o jade.png\n  \
    nephrite render jade.glb -o jade.exr -o jade.png --size 1920x1080 --spp 512 --env sky.hdr")]
pub(super) struct RenderArgs {
    /// Picture to write: .exr .png .jpg .hdr; may be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Size in pixels; by default the longest side is 1024, with the camera's own aspect ratio or 4:3
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,

    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,

    // The models are listed as the registry has them.
    #[arg(long, value_name = "MODEL", default_value = "random-walk", value_parser = subsurface,
        help = format!("How light travels below surfaces: {}", subsurface_models().join(", ")))]
    pub subsurface: String,

    /// The random walk: exact, or accelerated by jumps where it is deep inside (off by less than 0.5 %); short for
    /// --subsurface accelerated-walk
    #[arg(long, value_name = "exact|accelerated", value_parser = walk, conflicts_with = "subsurface")]
    pub walk: Option<String>,

    #[command(flatten)]
    pub blur: ShutterArgs,

    #[command(flatten)]
    pub scene: SceneArgs,

    /// Leave the background out: .exr and .png get alpha, and the shadow of --ground shadow goes into it
    #[arg(long)]
    pub transparent_background: bool,

    /// Write .exr with 32 bit floats instead of 16 bit ones
    #[arg(long)]
    pub float: bool,

    /// Write the pictures after the first sample of every pixel, and again as they get better: always, never, or auto: on a
    /// terminal, where no file is there yet
    #[arg(long, value_name = "auto|always|never", value_parser = progressive, num_args = 0..=1, require_equals = true,
        default_value = "auto", default_missing_value = "always")]
    pub progressive: Progressive,

    /// Write times, counts and the mean colour as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
}

#[derive(Clone, Debug, clap::Args)]
#[command(mut_arg("input", |input| input.help("The .gltf or .glb file, a folder of them, or - for standard input")))]
#[command(after_help = "Examples:\n  \
    nephrite compare-models jade.glb -o jade-models.png\n  \
    nephrite compare-models jade.glb -o jade.png --models dipole,better-dipole --spp 256\n\n\
    The sheet shows each model's picture, below it the difference to the reference in false colour (red is brighter, \
    blue is darker), its time, and its relative mean squared error. The numbers are also written beside the sheet, as \
    .json and .csv: with -o sheet.png, sheet.json and sheet.csv.")]
pub(super) struct CompareArgs {
    /// Contact sheet to write, a .png; the same name with .json and .csv gets the numbers. For a folder of several files a
    /// folder, which gets a sheet of each
    #[arg(short, long, value_name = "FILE.png|FOLDER")]
    pub output: PathBuf,

    #[arg(long, value_name = "A,B,…", value_delimiter = ',', value_parser = subsurface,
        help = format!("Models to compare, separated by commas: {} [default: all]", subsurface_models().join(", ")))]
    pub models: Vec<String>,

    /// Samples a pixel for each model; rounded up to an even number
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=MAX_SPP))]
    pub spp: u32,

    /// Samples a pixel for the reference, which is a random walk of its own [default: 4 times --spp]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=MAX_SPP))]
    pub reference_spp: Option<u32>,

    /// Size of each picture in pixels; by default the longest side is 480, with the camera's own aspect ratio or 4:3
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,

    #[command(flatten)]
    pub blur: ShutterArgs,

    #[command(flatten)]
    pub scene: SceneArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite profile --medium skim-milk -o milk.png\n  \
    nephrite profile --medium marble --channel all -o marble.png -o marble.csv\n  \
    nephrite profile --medium 20,1500,0.4,1.4 -o medium.json --models dipole,better-dipole\n\n\
    Presets are listed by `nephrite presets`, among them the media that Jensen et al. measured in 2001:\n  \
    apple, chicken1, chicken2, cream, ketchup, marble, potato, skim-milk, skin1, skin2, spectralon, whole-milk\n\n\
    The figure shows R(r), the radiant exitance at distance r from a pencil beam at normal incidence on a half space, for \
    unit power that has crossed the surface: the random walk as points with standard errors, closed forms as lines.")]
pub(super) struct ProfileArgs {
    /// A preset, or absorption and scattering coefficients in 1/m, mean cosine of scattering, and index of refraction
    #[arg(long, value_name = "PRESET|σa,σs,g,η", value_parser = medium)]
    pub medium: MediumArg,

    /// File to write: .png for the figure, .csv or .json for the numbers; may be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Channel of a preset: r, g, b or all [default: g]
    #[arg(long, value_name = "CHANNEL", value_parser = channel)]
    pub channel: Option<ChannelArg>,

    /// Unit of length of coefficients given by numbers, which are its inverse: m, cm or mm
    #[arg(long, value_name = "UNIT", default_value = "m", value_parser = length_unit)]
    pub unit: LengthUnit,

    #[arg(long, value_name = "A,B,…", value_delimiter = ',', value_parser = subsurface,
        help = format!("Models to show beside the random walk, separated by commas: {} [default: all]", subsurface_models().join(", ")))]
    pub models: Vec<String>,

    /// Paths of the random walk, and of every model that has no closed form
    #[arg(long, value_name = "N", default_value_t = 500_000, value_parser = clap::value_parser!(u64).range(1000..=1 << 36))]
    pub paths: u64,

    /// Another seed gives another noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,

    /// Threads; the numbers do not depend on them [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,

    /// Neither notes nor progress; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

/// More samples a pixel than this cannot be doubled and quadrupled.
const MAX_SPP: i64 = 1 << 28;

#[derive(Debug, clap::Args)]
#[command(mut_arg("input", |input| input.help("The .gltf or .glb file, a folder of them, or - for standard input")))]
pub(super) struct InspectArgs {
    #[command(flatten)]
    pub load: LoadArgs,

    /// Scene of the file [default: the file's own choice]
    #[arg(long, value_name = "N")]
    pub scene: Option<usize>,

    #[command(flatten)]
    pub play: PlayArgs,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl Command {
    /// The threads that were asked for.
    pub fn threads(&self) -> Option<usize> {
        match self {
            Self::Render(args) => args.scene.threads,
            Self::CompareModels(args) => args.scene.threads,
            Self::Profile(args) => args.threads,
            Self::Presets(args) => args.threads,
            Self::Conformance(args) => args.threads,
            Self::Inspect(_) | Self::Edit(_) | Self::Convert(_) | Self::Validate(_) => None,
        }
    }

    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Render(_) => "render",
            Self::Inspect(_) => "inspect",
            Self::CompareModels(_) => "compare-models",
            Self::Profile(_) => "profile",
            Self::Edit(_) => "edit",
            Self::Convert(_) => "convert",
            Self::Presets(_) => "presets",
            Self::Validate(_) => "validate",
            Self::Conformance(_) => "conformance",
        }
    }
}

impl SceneArgs {
    /// The files that are named as inputs.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let environment = match &self.env {
            Some(EnvArg::File(path)) => Some(path.clone()),
            _ => None,
        };
        std::iter::once(self.load.input.clone()).chain(environment).collect()
    }
}

impl RenderArgs {
    /// The subsurface model that was asked for.
    pub fn model(&self) -> &str {
        self.walk.as_deref().unwrap_or(&self.subsurface)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }
}
