//! `nephrite convert`: describes the media of a file in another way, and says what the other way cannot say.

use super::Failure;
use super::author_args::{ConvertArgs, TargetArgs};
use super::authored::{Authored, each_target};
use super::edit::fallback_thickness;
use super::message::{Reporter, count};
use crate::author::{
    Form, Reading, bodies, declare, khronos, medium, nephrite, openpbr, remove_member, text::Node,
};

/// Converts as the arguments say.
pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    each_target(&args.target, |target, reporter| convert_file(args.to, target, reporter))
}

fn convert_file(to: Form, target: &TargetArgs, reporter: &Reporter) -> Result<(), Failure> {
    let authored = Authored::open(target, reporter)?;
    let mut tree = authored.file.tree().map_err(Failure::cannot)?;
    let scene = authored.loaded.as_ref().ok().map(|loaded| &loaded.scene);
    let mut changed = Vec::new();
    let materials = tree.root().get("materials").map_or(0, Node::len);
    for index in 0..materials {
        let Some(material) = tree.root_mut().get_mut("materials").and_then(|list| list.item_mut(index))
        else {
            continue;
        };
        let Some(reading) = material.value().as_ref().and_then(medium::read) else { continue };
        if reading.form == to {
            reporter.note(format!("/materials/{index}: is described that way already"));
            continue;
        }
        let body = scene.and_then(|scene| bodies::with_material(scene, index).next());
        let thickness = fallback_thickness(&reading.medium, body.as_ref());
        for loss in convert(material, &reading, to, thickness) {
            reporter.warning(format!("/materials/{index}: {loss}"));
        }
        changed.push(index);
    }
    if changed.is_empty() {
        reporter.warning("no material has a medium that could be converted; the file is written as it is");
    }
    let names: Vec<&str> = std::iter::once(nephrite::NAME)
        .chain(khronos::NAMES)
        .chain(["KHR_materials_volume_scatter"])
        .collect();
    if !changed.is_empty() {
        declare(tree.root_mut(), &names);
    }
    authored.write(&tree.to_string(), &changed, reporter)?;
    let media = count(changed.len() as u64, "medium", "media");
    reporter.note(format!("wrote {} ({media} converted)", target.written().display()));
    Ok(())
}

/// Writes the medium of a material anew; what is lost.
fn convert(material: &mut Node<'_>, reading: &Reading, to: Form, thickness: f64) -> Vec<String> {
    let mut lost = reading.beyond.clone();
    if reading.form == Form::Nephrite {
        remove_member(material, "extensions", nephrite::NAME);
    }
    match to {
        Form::Nephrite => {
            nephrite::write(material, &reading.medium);
            khronos::write(material, &reading.medium, thickness, true);
        }
        Form::KhrScatter => khronos::write(material, &reading.medium, thickness, false),
        Form::OpenPbr => openpbr::write(material, &reading.medium),
    }
    if to != Form::OpenPbr {
        remove_member(material, "extras", openpbr::KEY);
    }
    if let Some(back) = material.value().as_ref().and_then(medium::read) {
        lost.extend(reading.medium.differences(&back.medium, medium::KEPT));
    }
    lost
}
