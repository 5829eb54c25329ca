//! `nephrite edit`: gives materials a medium, changes it, or takes it away.

mod change;
mod paint;
mod select;
mod textured;

use super::Failure;
use super::author_args::{EditArgs, TargetArgs};
use super::authored::{Authored, each_target};
use super::documents::shown;
use super::message::Reporter;
use crate::author::paint::images::NewImages;
use crate::author::text::{Node, Tree};
use crate::author::{Medium, bodies, declare, khronos, nephrite, remove_member};
use crate::plural::count;
use crate::scene::SceneDescription;
use change::Change;
use serde_json::{Map, Value};

/// Edits as the arguments say.
pub(super) fn run(args: &EditArgs) -> Result<(), Failure> {
    let change = Change::new(args)?;
    each_target(&args.target, |target, reporter| edit_file(&change, target, reporter))
}

fn edit_file(change: &Change<'_>, target: &TargetArgs, reporter: &Reporter) -> Result<(), Failure> {
    let args = change.args;
    let authored = Authored::open(target, reporter)?;
    let mut chosen = select::materials(authored.file.document(), &args.material)?;
    let mut tree = authored.file.tree().map_err(Failure::cannot)?;
    let mut images = NewImages::new(authored.file.document());
    if args.from_base_color {
        chosen = paint::run(&mut tree, &mut images, &authored, change, &chosen, reporter)?;
    } else {
        let scene = authored.loaded.as_ref().ok().map(|loaded| &loaded.scene);
        for &index in &chosen {
            let material = material_of(&mut tree, index)?;
            edit(material, index, change, scene)?;
        }
        if args.fix_surface {
            paint::clear_vertex_colors(&mut tree, authored.file.document(), &chosen, reporter);
        }
    }
    let names: Vec<&str> = std::iter::once(nephrite::NAME).chain(khronos::NAMES).collect();
    if !chosen.is_empty() {
        declare(tree.root_mut(), if args.no_fallback { &names[..1] } else { &names });
    }
    let text = tree.to_string();
    let unchanged = authored.is_unchanged(&text);
    if unchanged && !args.allow_unchanged {
        return Err(nothing_changes(args, target, &chosen));
    }
    authored.write_with_images(tree, &images, &chosen, reporter)?;
    let changed = if unchanged { "nothing".to_owned() } else { count(chosen.len(), "material", "materials") };
    let added = match images.list().len() {
        0 => String::new(),
        n => format!(", {} added", count(n, "image", "images")),
    };
    reporter.note(format!("wrote {} ({changed} changed{added})", target.written().display()));
    Ok(())
}

/// Material `index` of a document.
fn material_of<'n, 'a>(tree: &'n mut Tree<'a>, index: usize) -> Result<&'n mut Node<'a>, Failure> {
    let material = tree.root_mut().get_mut("materials").and_then(|list| list.item_mut(index));
    material.ok_or_else(|| Failure::cannot(format!("/materials/{index} is missing")))
}

/// Whoever asked for a change and gets the same file made a mistake.
fn nothing_changes(args: &EditArgs, target: &TargetArgs, chosen: &[usize]) -> Failure {
    let file = shown(&target.load.input);
    if args.from_base_color {
        let (why, advice) = ("no material has paint", "`nephrite inspect` shows base colours");
        return Failure::advise(format!("{file}: nothing changes, and nothing is written: {why}"), advice);
    }
    let (why, advice) = match (chosen.len(), args.remove) {
        (0, _) => ("it has no materials", "give its meshes a material first"),
        (1, true) => ("the material has no medium that could be removed", "`nephrite inspect` lists media"),
        (_, true) => {
            ("none of the materials has a medium that could be removed", "`nephrite inspect` lists media")
        }
        (1, false) => ("the material is like that already", "`nephrite inspect` says what it has"),
        (_, false) => ("the materials are like that already", "`nephrite inspect` says what they have"),
    };
    Failure::advise(format!("{file}: nothing changes, and nothing is written: {why}"), advice)
}

fn edit(
    material: &mut Node<'_>,
    index: usize,
    change: &Change<'_>,
    scene: Option<&SceneDescription>,
) -> Result<(), Failure> {
    let before = material.value().unwrap_or_default();
    if change.args.remove {
        let reading = nephrite::read(&before);
        remove_member(material, "extensions", nephrite::NAME);
        if let Some(reading) = reading.filter(|_| !change.args.no_fallback) {
            let medium = textured::mean([&before; 2], reading.medium, index, scene);
            khronos::remove(material, &medium, thickness(&medium, index, scene));
        }
        return Ok(());
    }
    let members = change.applied_to(&before, index)?;
    set_members(material, &before, &members);
    if change.args.fix_surface {
        change::fix_surface(material, &before);
    }
    if !change.args.no_fallback {
        let after = material.value().unwrap_or_default();
        if let Some(reading) = nephrite::read(&after) {
            let medium = textured::mean([&before, &after], reading.medium, index, scene);
            khronos::write(material, &medium, thickness(&medium, index, scene), true);
        }
    }
    Ok(())
}

/// Gives a material an extension of ours with these members and no others.
fn set_members(material: &mut Node<'_>, before: &Value, members: &Map<String, Value>) {
    let old = before.pointer(&format!("/extensions/{}", nephrite::NAME)).and_then(|own| own.as_object());
    if let Some(own) = material.get_mut("extensions").and_then(|e| e.get_mut(nephrite::NAME)) {
        let gone = old.into_iter().flat_map(|old| old.keys()).filter(|key| !members.contains_key(*key));
        for key in gone {
            own.remove(key);
        }
    }
    crate::author::set_extension(material, nephrite::NAME, members);
}

fn thickness(medium: &Medium, index: usize, scene: Option<&SceneDescription>) -> f64 {
    let body = scene.and_then(|scene| bodies::with_material(scene, index).next());
    fallback_thickness(medium, body.as_ref())
}

/// The thickness for readers that do not trace rays, in units of the mesh: a quarter of a mean free path where light is
/// scattered, since such readers would show black otherwise, else the body's own.
pub(super) fn fallback_thickness(medium: &Medium, body: Option<&bodies::Body<'_>>) -> f64 {
    let densest = medium.sigma_t().into_iter().fold(0.0, f64::max);
    let (own, scale) = body.map_or((1.0, 1.0), |body| (body.thickness(), body.scale));
    let thickness = if medium.scatters() && scale > 0.0 { 0.25 / densest / scale } else { own };
    if thickness > 0.0 && thickness.is_finite() { thickness } else { 1.0 }
}
