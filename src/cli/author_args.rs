//! What can be typed after the authoring commands.

use super::args::LoadArgs;
use super::author_values::*;
use super::values::{LengthUnit, length_unit, threads};
use crate::author::Form;
use crate::optics::presets::Preset;
use std::path::PathBuf;

/// A file, and where it goes when it is changed.
#[derive(Clone, Debug, clap::Args)]
#[command(mut_arg("input", |input| input.help("The .gltf or .glb file, a folder of them, or - for standard input")))]
pub(super) struct TargetArgs {
    #[command(flatten)]
    pub load: LoadArgs,

    /// File to write; a .glb stays a .glb, a .gltf a .gltf. Or a folder that is there, for files of the same names
    #[arg(
        short,
        long,
        value_name = "FILE|FOLDER",
        required_unless_present = "in_place",
        conflicts_with = "in_place"
    )]
    pub output: Option<PathBuf>,

    /// Replace the input, in one step
    #[arg(long)]
    pub in_place: bool,

    /// Copy the files that a .gltf refers to where the output is in another folder
    #[arg(long)]
    pub copy_resources: bool,

    /// Neither notes nor progress; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite edit cow.glb -o jade-cow.glb --material Cow --preset jade\n  \
    nephrite edit milk.gltf --in-place --material 0 --absorption 0.0014,0.0025,0.0142 --scattering 0.7,1.22,1.9 --unit mm\n  \
    nephrite edit soap.glb -o soap2.glb --material '*' --color 0.8,0.3,0.2 --mean-free-path 1,0.5,0.3 --unit mm\n  \
    nephrite edit painted.glb -o candy.glb --material '*' --from-base-color --mean-free-path 0.5 --unit mm --fix-surface\n\n\
    Presets are listed by `nephrite presets`, with their sources.\n\n\
    --color is what one sees straight on in uniform light, without the reflection of the surface: of the light that \
    enters, the share that comes out again. The index and the anisotropy are accounted for.\n\n\
    Only what is asked for changes; everything else keeps every byte. The same medium is also written as \
    KHR_materials_ior, _transmission, _volume and _scatter for other viewers, unless --no-fallback is given.")]
pub(super) struct EditArgs {
    #[command(flatten)]
    pub target: TargetArgs,

    /// Material to change, by name or else by index, or * for all; may be repeated
    #[arg(short, long, value_name = "NAME|INDEX|*")]
    pub material: Vec<String>,

    /// A medium by its name, such as marble, jade, wax, soap, amber, leaf, gummy or skin-iv; `nephrite presets` lists
    /// them all. Options beside it change it
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<&'static Preset>,

    /// Absorption coefficient, in 1/m unless --unit says otherwise
    #[arg(long, value_name = "R,G,B", value_parser = channels)]
    pub absorption: Option<[f64; 3]>,

    /// Scattering coefficient (not the reduced one)
    #[arg(long, value_name = "R,G,B", value_parser = channels)]
    pub scattering: Option<[f64; 3]>,

    /// Mean cosine of the scattering angle
    #[arg(long, value_name = "G", value_parser = anisotropy)]
    pub anisotropy: Option<f64>,

    /// Index of refraction
    #[arg(long, value_name = "N", value_parser = ior)]
    pub ior: Option<f64>,

    /// Factor on both coefficients
    #[arg(long, value_name = "X", value_parser = density)]
    pub density: Option<f64>,

    /// Where closed meshes overlap, the medium of the highest priority fills the overlap
    #[arg(long, value_name = "N")]
    pub priority: Option<i32>,

    /// Texture that multiplies the absorption coefficient
    #[arg(long, value_name = "INDEX|none", value_parser = texture)]
    pub absorption_texture: Option<TextureArg>,

    /// Texture that multiplies the scattering coefficient
    #[arg(long, value_name = "INDEX|none", value_parser = texture)]
    pub scattering_texture: Option<TextureArg>,

    /// The colour to be seen, linear, or #rrggbb as paint programs have it; with the mean free path it stands for both coefficients
    #[arg(long, value_name = "R,G,B", value_parser = color, conflicts_with_all = ["absorption", "scattering"])]
    pub color: Option<[f64; 3]>,

    /// Mean free path, in metres unless --unit says otherwise
    #[arg(long, value_name = "R,G,B", value_parser = lengths, conflicts_with_all = ["absorption", "scattering"])]
    pub mean_free_path: Option<[f64; 3]>,

    /// Take the colours to be seen from the base colour, its texture and vertex colours, as coefficient textures, and make
    /// the base colour white; with the mean free path that is given or that of the medium
    #[arg(long, conflicts_with_all = ["absorption", "scattering", "color", "absorption_texture", "scattering_texture"])]
    pub from_base_color: bool,

    /// Unit of length of coefficients, which are its inverse, and of mean free paths: m, cm or mm
    #[arg(long, value_name = "UNIT", default_value = "m", value_parser = length_unit)]
    pub unit: LengthUnit,

    /// Also set what would hide or tint the medium: metallic 0, base colour white, no vertex colours, alpha mode opaque
    #[arg(long)]
    pub fix_surface: bool,

    /// Remove the medium, and the fallback for other viewers where it is as this command writes it
    #[arg(long, conflicts_with_all = ["preset", "absorption", "scattering", "anisotropy", "ior", "density", "priority",
        "absorption_texture", "scattering_texture", "color", "mean_free_path", "from_base_color", "fix_surface"])]
    pub remove: bool,

    /// Leave the extensions for other viewers as they are
    #[arg(long)]
    pub no_fallback: bool,

    /// Where nothing changes, write the same file instead of failing, as scripts may want that repeat an edit
    #[arg(long)]
    pub allow_unchanged: bool,
}

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite convert milk.glb -o milk-khr.glb --to khr-scatter\n  \
    nephrite convert draft.gltf -o draft-nephrite.gltf --to nephrite\n\n\
    nephrite: NEPHRITE_materials_subsurface, with the others for other viewers beside it\n  \
    khr-scatter: KHR_materials_ior, _transmission, _volume and _scatter\n  \
    openpbr: OpenPBR parameters as an object `openpbr` in the extras of the material\n\n\
    What the other description cannot say is told.")]
pub(super) struct ConvertArgs {
    #[command(flatten)]
    pub target: TargetArgs,

    /// How media are to be described: khr-scatter, nephrite or openpbr
    #[arg(long, value_name = "FORM", value_parser = form)]
    pub to: Form,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite presets\n  \
    nephrite presets jade\n  \
    nephrite presets skin marble -o stones-and-skins.png --spp 64\n\n\
    Coefficients are per millimetre. What nobody measured is an estimate of ours, and says so.")]
pub(super) struct PresetsArgs {
    /// Only presets with these words in one of their names; a few of them are told in full
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Render a sphere of each to a sheet, a .png
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,

    /// Radius of the spheres on the sheet in millimetres
    #[arg(long, value_name = "MM", default_value_t = 10.0, requires = "output", value_parser = super::values::positive)]
    pub radius: f32,

    /// Pixels of a side of each picture on the sheet
    #[arg(long, value_name = "PIXELS", default_value_t = 140, requires = "output", value_parser = clap::value_parser!(u32).range(16..=1024))]
    pub side: u32,

    /// Samples a pixel on the sheet
    #[arg(long, value_name = "N", default_value_t = 8, requires = "output", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub spp: u32,

    /// Threads; the picture does not depend on them [default: all]
    #[arg(long, value_name = "N", requires = "output", value_parser = threads)]
    pub threads: Option<usize>,

    /// Neither notes nor progress; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, clap::Args)]
#[command(mut_arg("input", |input| input.help("The .gltf or .glb file, a folder of them, or - for standard input")))]
#[command(
    after_help = "What is checked is what this program knows about: media, their units and meshes, and what will be \
    ignored. Whether a file is valid glTF, the validator of Khronos says (docs/authoring.md).\n\n\
    Ends with 1 if there are errors, else with 0."
)]
pub(super) struct ValidateArgs {
    #[command(flatten)]
    pub load: LoadArgs,

    /// Scene of the file [default: the file's own choice]
    #[arg(long, value_name = "N")]
    pub scene: Option<usize>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
