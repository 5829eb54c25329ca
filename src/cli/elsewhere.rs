//! What other programs call our options and commands.

/// Our options, each with what it is called elsewhere. The first of ours that a command has is meant, so that `--samples` is
/// `--spp` of `render` and `--paths` of `profile`.
const OPTIONS: &[(&str, &[&str])] = &[
    (
        "spp",
        &[
            "samples",
            "sample-count",
            "samples-per-pixel",
            "num-samples",
            "nsamples",
            "sample",
            "passes",
            "iterations",
        ],
    ),
    ("paths", &["samples", "spp", "photons", "sample-count", "num-paths"]),
    ("reference-spp", &["reference-samples", "ref-spp", "ref-samples"]),
    (
        "size",
        &[
            "resolution",
            "res",
            "width",
            "height",
            "resolution-x",
            "resolution-y",
            "dimensions",
            "image-size",
            "film-size",
            "geometry",
            "w",
            "h",
        ],
    ),
    (
        "output",
        &[
            "out",
            "out-file",
            "outfile",
            "output-file",
            "output-path",
            "render-output",
            "outputs",
            "save",
            "dest",
            "destination",
            "image",
            "write",
        ],
    ),
    (
        "env",
        &[
            "hdri",
            "hdr",
            "hdri-file",
            "envmap",
            "env-map",
            "environment",
            "environment-map",
            "sky",
            "skybox",
            "skydome",
            "ibl",
            "background",
            "world",
            "dome-light",
        ],
    ),
    (
        "env-rotation",
        &["env-rotate", "hdri-rotation", "environment-rotation", "sky-rotation", "ibl-rotation"],
    ),
    (
        "env-intensity",
        &[
            "env-strength",
            "env-scale",
            "hdri-strength",
            "hdri-intensity",
            "environment-intensity",
            "sky-intensity",
            "ibl-intensity",
            "world-strength",
        ],
    ),
    (
        "max-depth",
        &[
            "bounces",
            "max-bounces",
            "depth",
            "maxdepth",
            "path-depth",
            "ray-depth",
            "max-path-length",
            "path-length",
        ],
    ),
    ("subsurface", &["integrator", "model", "sss", "bssrdf", "subsurface-model", "engine", "method"]),
    ("models", &["model", "methods", "integrators", "subsurface"]),
    (
        "tonemap",
        &[
            "tone-mapping",
            "tone-map",
            "tonemapping",
            "tone-mapper",
            "tonemapper",
            "view-transform",
            "display-transform",
            "filmic",
        ],
    ),
    (
        "exposure",
        &["ev", "exposure-value", "exposure-compensation", "exposure-bias", "gain", "brightness", "stops"],
    ),
    ("at", &["time", "animation-time", "moment", "seconds", "frame"]),
    ("animation", &["anim", "animation-index", "animation-name", "animations", "action", "clip"]),
    ("camera", &["cam", "camera-index", "camera-name", "view", "viewpoint"]),
    ("scene", &["scene-index", "scene-name"]),
    ("variant", &["material-variant", "variants"]),
    ("transparent-background", &["transparent", "film-transparent", "alpha", "no-background"]),
    ("ground", &["floor", "ground-plane", "plane", "shadow-catcher"]),
    ("shutter", &["motion-blur", "shutter-speed", "shutter-time", "exposure-time"]),
    (
        "light-scale",
        &[
            "light-intensity",
            "light-strength",
            "light-multiplier",
            "lights-scale",
            "lamp-scale",
            "light-power",
            "lights",
        ],
    ),
    ("light-units", &["light-unit", "lighting-mode", "lamp-units", "units", "unit"]),
    ("seed", &["random-seed", "rng-seed", "rng"]),
    ("threads", &["nthreads", "num-threads", "thread-count", "jobs", "cores", "cpus", "workers"]),
    ("quiet", &["silent", "no-progress"]),
    ("stats", &["statistics", "timings", "profile"]),
    ("float", &["float32", "f32", "32bit", "full-float"]),
    ("strict", &["pedantic", "werror", "fail-on-warning"]),
    ("limit", &["limits", "memory-limit", "max-memory"]),
    ("json", &["as-json", "format", "output-format"]),
    ("medium", &["preset", "material", "coefficients"]),
    ("preset", &["medium", "presets"]),
    ("material", &["materials", "mat", "material-name"]),
    ("absorption", &["sigma-a", "mu-a", "absorption-coefficient", "absorption-coefficients"]),
    ("scattering", &["sigma-s", "mu-s", "scattering-coefficient", "scattering-coefficients", "scatter"]),
    ("anisotropy", &["g", "hg", "phase", "phase-g", "asymmetry", "scatter-anisotropy"]),
    ("ior", &["eta", "index", "index-of-refraction", "refractive-index"]),
    ("density", &["scale", "density-factor", "density-scale"]),
    ("mean-free-path", &["mfp", "dmfp", "scatter-distance", "subsurface-radius", "radius"]),
    ("color", &["colour", "albedo", "subsurface-color", "base-color", "diffuse"]),
    ("unit", &["units", "length-unit", "length-units"]),
    ("in-place", &["inplace", "overwrite", "force", "replace"]),
    ("copy-resources", &["copy", "copy-files", "copy-textures"]),
    ("remove", &["delete", "clear", "reset"]),
    ("to", &["format", "target", "form"]),
    ("filter", &["only", "case", "cases", "match", "include"]),
    ("report", &["html", "html-report"]),
    ("junit", &["xml"]),
    ("renderer", &["command", "cmd", "exec", "program"]),
    ("spp-scale", &["samples", "spp", "scale"]),
];

/// Our commands, each with what it is called elsewhere.
const COMMANDS: &[(&str, &[&str])] = &[
    ("render", &["trace", "image", "draw", "view", "show", "picture", "snapshot"]),
    ("inspect", &["info", "stat", "stats", "dump", "describe", "print", "ls"]),
    ("validate", &["check", "lint", "verify"]),
    ("compare-models", &["compare", "diff", "models"]),
    ("presets", &["list", "media", "materials", "preset"]),
    ("convert", &["export", "translate"]),
    ("edit", &["set", "modify", "change", "author"]),
    ("profile", &["measure", "plot"]),
    ("conformance", &["test", "suite", "bench", "selftest"]),
];

/// A name without what people spell differently.
fn plain(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '-' | '_')).flat_map(char::to_lowercase).collect()
}

/// Our name of an option of a command that has the options of `has`; also of one that is spelt with underscores or capitals.
pub(super) fn option<'a>(theirs: &str, has: impl Iterator<Item = &'a str>) -> Option<String> {
    let (wanted, has) = (plain(theirs), has.collect::<Vec<_>>());
    let same = has.iter().find(|ours| plain(ours) == wanted).copied();
    let known = OPTIONS.iter().filter(|(_, names)| names.iter().any(|name| plain(name) == wanted));
    same.or_else(|| known.map(|(ours, _)| *ours).find(|ours| has.contains(ours))).map(str::to_owned)
}

/// Our name of a command.
pub(super) fn command(theirs: &str) -> Option<&'static str> {
    let wanted = plain(theirs);
    COMMANDS.iter().find(|(_, names)| names.iter().any(|name| plain(name) == wanted)).map(|(ours, _)| *ours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::Args;
    use clap::CommandFactory;

    #[test]
    fn what_is_proposed_is_there_and_nothing_is_called_otherwise_that_is_ours() {
        let all = Args::command();
        let longs = |c: &clap::Command| -> Vec<String> {
            c.get_arguments().filter_map(|a| a.get_long().map(str::to_owned)).collect()
        };
        let every: Vec<String> = all.get_subcommands().flat_map(longs).collect();
        for (ours, _) in OPTIONS {
            assert!(every.iter().any(|own| own == ours), "there is no --{ours}");
        }
        for (ours, theirs) in COMMANDS {
            assert!(all.find_subcommand(ours).is_some(), "there is no {ours}");
            assert!(theirs.iter().all(|name| all.find_subcommand(name).is_none()));
        }
    }

    #[test]
    fn the_option_of_the_command_is_meant() {
        let render = ["spp", "size", "max-depth"];
        assert_eq!(option("samples", render.into_iter()).as_deref(), Some("spp"));
        assert_eq!(option("samples", ["paths", "medium"].into_iter()).as_deref(), Some("paths"));
        assert_eq!(option("maxDepth", render.into_iter()).as_deref(), Some("max-depth"));
        assert_eq!(option("max_depth", render.into_iter()).as_deref(), Some("max-depth"));
        assert_eq!(option("samples", ["json"].into_iter()), None);
        assert_eq!(command("info"), Some("inspect"));
    }
}
