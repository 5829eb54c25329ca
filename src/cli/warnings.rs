//! What a render warns of: media without a closed mesh, and what was counted while it ran.

use super::message::{Reporter, count};
use super::pipeline::{RenderStats, Scene};

/// More leaks a sample than this are told of; rounding lets a path in a million slip through an edge of a closed mesh.
const BY_ROUNDING: f64 = 1e-5;
/// Counts that exceed what is expected by fewer standard deviations come by chance.
const CHANCE: f64 = 4.0;

/// Says what went wrong in a render of so many samples; `of` begins the sentences.
pub(super) fn report_counters(stats: &RenderStats, samples: f64, of: &str, reporter: &Reporter) {
    if stats.truncated_paths > 0 {
        reporter.warning(format!(
            "{of}{} cut off at --max-depth; the picture is darker than it should be",
            count(stats.truncated_paths, "path was", "paths were")
        ));
    }
    // Each kind is told of only where it is so: there may be open meshes in a scene out of which nothing leaks.
    let by_rounding = BY_ROUNDING * samples;
    let leaked = stats.leaked_paths.saturating_sub(stats.lost_paths);
    if leaked as f64 > by_rounding {
        reporter.warning(format!(
            "{of}{} leaked out of meshes that are not closed (`nephrite inspect` says where)",
            count(leaked, "path", "paths")
        ));
    }
    let lost = stats.lost_paths;
    if lost as f64 > by_rounding + CHANCE * by_rounding.sqrt() {
        reporter.warning(format!(
            "{of}{} lost at boundaries of media that are closed: where they touch or cross, it can be unclear what is \
             inside (`nephrite validate` finds such places)",
            count(lost, "path was", "paths were")
        ));
    }
    if stats.invalid_samples > 0 {
        let samples = count(
            stats.invalid_samples,
            "sample was not finite and counts",
            "samples were not finite and count",
        );
        reporter.warning(format!("{of}{samples} as black"));
    }
}

/// Media need closed meshes: elsewhere there is no telling what is inside.
pub(super) fn warn_of_open_media(scene: &Scene, reporter: &Reporter) {
    const MOST_NAMED: usize = 5;
    let objects = scene.objects.iter().zip(&scene.description.instances);
    let open: Vec<String> = objects
        .filter(|(object, _)| object.has_medium && !object.closed)
        .map(|(_, instance)| format!("{:?} ({})", instance.name, instance.pointer))
        .collect();
    if !open.is_empty() {
        let more = open.len().saturating_sub(MOST_NAMED);
        let named: Vec<&str> = open.iter().take(MOST_NAMED).map(String::as_str).collect();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        reporter.warning(format!(
            "{}{more}: the mesh is not closed, so light may leak out of its medium (`nephrite inspect` says where)",
            named.join(", ")
        ));
    }
}
