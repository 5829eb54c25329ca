//! An inspection for people.

use super::format::{length, lengths, number, triple};
use super::lamps::{describe_lamp, describe_light};
use super::report::{MediumReport, ObjectReport, Report};
use crate::asset::AnimationSummary;
use crate::cli::message::{also_in, grouped, printable};
use crate::cli::pipeline::{Severity, is_lamp, is_lit};
use crate::plural::count;
use crate::scene::{AreaShape, CameraDescription, Lens, Projection, PunctualKind, SceneDescription};
use std::fmt::Write;

/// The most animations that are listed.
const MOST_ANIMATIONS: usize = 50;

/// The most lights that are listed.
const MOST_LIGHTS: usize = 50;

/// The most names on one line.
const MOST_NAMES: usize = 6;

/// The whole report as text.
pub(super) fn describe(report: &Report<'_>, scene: &SceneDescription) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = overview(&mut out, report, scene);
    for medium in &report.media {
        let _ = describe_medium(&mut out, medium);
    }
    let _ = ignored(&mut out, report);
    let _ = findings(&mut out, report);
    out
}

fn overview(out: &mut String, report: &Report<'_>, scene: &SceneDescription) -> std::fmt::Result {
    let summary = report.summary;
    writeln!(out, "{}", printable(&report.file))?;
    if let Some(generator) = &summary.generator {
        line(out, "written by", generator)?;
    }
    if let Some(copyright) = &summary.copyright {
        line(out, "copyright", copyright)?;
    }
    let scenes = match summary.scenes.len() {
        0 | 1 => String::new(),
        n => format!("; {n} scenes: {}", names(summary.scenes.iter().map(String::as_str))),
    };
    let geometry = format!(
        "{} of {}, {}, {}{scenes}",
        count(report.objects, "object", "objects"),
        count(scene.meshes.len(), "mesh", "meshes"),
        count(summary.instanced_triangles, "triangle", "triangles"),
        count(summary.vertices, "vertex", "vertices")
    );
    line(out, "geometry", &geometry)?;
    let cameras: Vec<String> = scene.cameras.iter().map(camera).collect();
    let cameras = match cameras.len() {
        0 => "none: the whole scene will be framed".to_owned(),
        _ => names(cameras.iter().map(String::as_str)),
    };
    line(out, "cameras", &cameras)?;
    line(out, "lights", &lights(scene))?;
    each_light(out, report)?;
    if !summary.animations.is_empty() {
        animations(out, &summary.animations)?;
    }
    if !summary.variants.is_empty() {
        line(out, "variants", &names(summary.variants.iter().map(String::as_str)))?;
    }
    let layered: Vec<String> = summary
        .materials
        .iter()
        .filter(|m| !m.layers.is_empty())
        .map(|m| format!("{:?} with {}", m.name, m.layers.join(", ")))
        .collect();
    if !layered.is_empty() {
        line(out, "layers", &names(layered.iter().map(String::as_str)))?;
    }
    if report.media.is_empty() {
        line(out, "media", "none: nothing in this file scatters light below its surface")?;
    }
    Ok(())
}

fn animations(out: &mut String, animations: &[AnimationSummary]) -> std::fmt::Result {
    for (i, animation) in animations.iter().take(MOST_ANIMATIONS).enumerate() {
        let AnimationSummary { name, start, end, channels, ignored, properties, .. } = animation;
        let from = if *start > 0.0 { format!("{} to ", number(*start)) } else { String::new() };
        let ignored = if *ignored > 0 { format!(", {ignored} ignored") } else { String::new() };
        let moves = names(properties.iter().map(String::as_str));
        let channels = count(*channels, "channel", "channels");
        let title = if i == 0 { "animations" } else { "" };
        line(out, title, &format!("{name:?}: {from}{} s, {channels}{ignored} ({moves})", number(*end)))?;
    }
    let more = animations.len().saturating_sub(MOST_ANIMATIONS);
    if more > 0 { line(out, "", &format!("and {more} more")) } else { Ok(()) }
}

fn camera(camera: &CameraDescription) -> String {
    match camera.projection {
        Projection::Perspective { yfov, .. } => {
            let lens = camera.lens.map(|l| lens(&l)).unwrap_or_default();
            format!("{:?} (perspective, {}°{lens})", camera.name, number(yfov.to_degrees()))
        }
        Projection::Orthographic { ymag, .. } => {
            format!("{:?} (orthographic, {} high)", camera.name, length(2.0 * ymag))
        }
    }
}

/// “, 35 mm on 36 mm × 24 mm, f/2.8, focused at 5 m”.
fn lens(lens: &Lens) -> String {
    let Lens { focal_length, sensor: [width, height], f_stop, focus_distance } = lens;
    let sensor =
        if *width > 0.0 { format!(" on {} × {}", length(*width), length(*height)) } else { String::new() };
    let f_stop = f_stop.map(|n| format!(", f/{}", number(n))).unwrap_or_default();
    let focus = focus_distance.map(|d| format!(", focused at {}", length(d))).unwrap_or_default();
    format!(", {}{sensor}{f_stop}{focus}", length(*focal_length))
}

fn lights(scene: &SceneDescription) -> String {
    let is_kind = |wanted: fn(&PunctualKind) -> bool| scene.lights.iter().filter(|l| wanted(&l.kind)).count();
    let is_shape = |wanted: AreaShape| scene.area_lights.iter().filter(|l| l.shape == wanted).count();
    let kinds = [
        (is_kind(|k| matches!(k, PunctualKind::Point)), "point"),
        (is_kind(|k| matches!(k, PunctualKind::Spot { .. })), "spot"),
        (is_kind(|k| matches!(k, PunctualKind::Directional)), "directional"),
        (is_kind(|k| matches!(k, PunctualKind::Web(_))), "measured (IES)"),
        (is_shape(AreaShape::Rectangle), "rectangular"),
        (is_shape(AreaShape::Disk), "round"),
    ];
    let mut found: Vec<String> =
        kinds.iter().filter(|(n, _)| *n > 0).map(|(n, kind)| format!("{n} {kind}")).collect();
    match scene.materials.iter().filter(|m| is_lamp(m)).count() {
        0 => {}
        n => found.push(count(n, "emissive material", "emissive materials")),
    }
    match (found.is_empty(), is_lit(scene)) {
        (true, false) => "none: the built-in studio will light it".to_owned(),
        (true, true) => "an environment".to_owned(),
        (false, true) => found.join(", "),
        (false, false) => {
            format!("{}, none of them visible: the built-in studio will light it", found.join(", "))
        }
    }
}

/// Every light, with its power and its place.
fn each_light(out: &mut String, report: &Report<'_>) -> std::fmt::Result {
    let summary = report.summary;
    let of_blender = summary.generator.as_ref().is_some_and(|generator| generator.contains("Blender"));
    let punctual = summary.lights.iter().map(|light| (light.kind, describe_light(light, of_blender)));
    let lamps = report.lamps.iter().map(|lamp| ("emissive", describe_lamp(lamp)));
    for (kind, text) in punctual.chain(lamps).take(MOST_LIGHTS) {
        line(out, &format!("  {kind}"), &text)?;
    }
    let more = (summary.lights.len() + report.lamps.len()).saturating_sub(MOST_LIGHTS);
    if more > 0 { line(out, "", &format!("and {more} more")) } else { Ok(()) }
}

fn describe_medium(out: &mut String, medium: &MediumReport) -> std::fmt::Result {
    let MediumReport { material, name, pointer, .. } = medium;
    writeln!(out, "\nmedium of material {material} {name:?} ({pointer})")?;
    let textured = if medium.textured { ", times textures" } else { "" };
    line(out, "absorption σa", &format!("{} 1/m{textured}", triple(medium.sigma_a.map(Some))))?;
    line(out, "scattering σs", &format!("{} 1/m{textured}", triple(medium.sigma_s.map(Some))))?;
    line(out, "anisotropy g", &number(medium.anisotropy))?;
    line(out, "index η", &number(medium.ior))?;
    if medium.priority != 0 {
        line(out, "priority", &medium.priority.to_string())?;
    }
    line(out, "mean free path", &lengths(medium.mean_free_path))?;
    line(out, "effective albedo", &triple(medium.effective_albedo))?;
    if medium.objects.is_empty() {
        line(out, "objects", "none: no object of the scene uses it")?;
    }
    for object in &medium.objects {
        line(out, "object", &format!("{:?} ({}): {}", object.name, object.pointer, closedness(object)))?;
    }
    Ok(())
}

fn closedness(object: &ObjectReport) -> String {
    let welded = match object.welded_vertices {
        0 => String::new(),
        n => format!("; seams are welded, which moves {}", count(n, "vertex", "vertices")),
    };
    if object.closed {
        return match object.inside_out_parts {
            0 => format!("closed{welded}"),
            n => format!("closed; {} inside out and turned{welded}", count(n, "part is", "parts are")),
        };
    }
    let mut why = Vec::new();
    if object.open_edges > 0 {
        why.push(count(object.open_edges, "open edge", "open edges"));
    }
    if object.non_manifold_edges > 0 {
        why.push(count(
            object.non_manifold_edges,
            "edge of three or more triangles",
            "edges of three or more triangles",
        ));
    }
    if why.is_empty() {
        why.push("triangles that face different ways".to_owned());
    }
    let around = match object.leaks.first() {
        Some(place) => {
            let [x, y, z] = place.map(number);
            format!(", such as at ({x}, {y}, {z})")
        }
        None => String::new(),
    };
    let why = why.join(" and ");
    let parts = count(object.parts, "part", "parts");
    format!("NOT CLOSED, light leaks out: {why} in {} of {parts}{around}", object.open_parts)
}

fn ignored(out: &mut String, report: &Report<'_>) -> std::fmt::Result {
    let mut ignored =
        report.summary.extensions.iter().filter_map(|e| Some((&e.name, e.ignored.as_ref()?))).peekable();
    if ignored.peek().is_some() {
        writeln!(out, "\nignored")?;
    }
    for (name, why) in ignored {
        writeln!(out, "  {}: {}", printable(name), printable(why))?;
    }
    Ok(())
}

fn findings(out: &mut String, report: &Report<'_>) -> std::fmt::Result {
    for (severity, title) in
        [(Severity::Error, "errors"), (Severity::Warning, "warnings"), (Severity::Note, "notes")]
    {
        let mut found =
            grouped(report.diagnostics).into_iter().filter(|(d, _)| d.severity == severity).peekable();
        if found.peek().is_some() {
            writeln!(out, "\n{title}")?;
        }
        for (diagnostic, more) in found {
            let more = if more > 0 { also_in(more) } else { String::new() };
            writeln!(out, "  {}{more}", printable(&diagnostic.to_string()))?;
        }
    }
    Ok(())
}

fn line(out: &mut String, name: &str, value: &str) -> std::fmt::Result {
    writeln!(out, "  {name:<17} {}", printable(value))
}

fn names<'a>(all: impl ExactSizeIterator<Item = &'a str>) -> String {
    let n = all.len();
    let shown: Vec<&str> = all.take(MOST_NAMES).collect();
    let more = if n > MOST_NAMES { format!(" and {} more", n - MOST_NAMES) } else { String::new() };
    shown.join(", ") + &more
}
