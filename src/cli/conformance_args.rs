//! What can be typed after `nephrite conformance`.

use super::pipeline::subsurface_models;
use super::values::{above_zero, microfacet, subsurface, threads};
use crate::optics::Microfacet;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    nephrite conformance --report report.html\n  \
    nephrite conformance --filter 'ior-*' --filter furnace\n  \
    nephrite conformance --report other.html --renderer \
    'python3 samples/conformance/adapters/mitsuba.py {input} {output} {width} {height} --spp {spp} --seed {seed}'\n\n\
    The renderer's command is split into words like a shell would, without running one. {input} is the .gltf file, \
    {output} the .exr to write (linear radiance in R, G, B), {width} and {height} its size; {spp}, {seed} and \
    {environment} (uniform radiance as R,G,B, 0,0,0 if there is none) may be used, too. With {seed} each case is \
    rendered several times, so that its noise is known.\n\n\
    Exit code 1 says that cases did not pass.")]
pub(super) struct ConformanceArgs {
    /// Folder with the cases [default: samples/conformance]
    pub dir: Option<PathBuf>,

    /// Only cases whose name contains this or, with * or ?, is like this; may be repeated
    #[arg(long, value_name = "NAME|GLOB")]
    pub filter: Vec<String>,

    /// Write a page with pictures, numbers and what is probably wrong
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,

    /// Write the results as JUnit XML
    #[arg(long, value_name = "FILE.xml")]
    pub junit: Option<PathBuf>,

    /// Write the numbers as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,

    /// Another program to render with, instead of nephrite
    #[arg(long, value_name = "COMMAND")]
    pub renderer: Option<String>,

    /// Name of the renderer in the report [default: nephrite, or the renderer's command]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,

    /// Seconds after which a run of the other program is ended
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, value_parser = above_zero)]
    pub timeout: f32,

    /// Independent renders of each case, which share its samples; from their scatter noise is known
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub batches: u32,

    /// Multiply the samples of each case
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = above_zero)]
    pub spp_scale: f32,

    /// Another seed gives another noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,

    /// Threads of nephrite; pictures do not depend on them [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,

    #[arg(long, value_name = "MODEL", default_value = "random-walk", value_parser = subsurface,
        help = format!("How light travels below surfaces, in nephrite: {}", subsurface_models().join(", ")))]
    pub subsurface: String,

    /// Whether light bounces more than once among the facets of rough surfaces, in nephrite: multiple or single
    #[arg(long, value_name = "MODEL", default_value = "multiple", value_parser = microfacet)]
    pub microfacet: Microfacet,

    /// Instead of running the cases, render the references of those that have one, with 16 times their samples
    #[arg(long, conflicts_with_all = ["renderer", "report", "junit", "json"])]
    pub update_references: bool,

    /// No progress and no line for each case
    #[arg(short, long)]
    pub quiet: bool,
}
