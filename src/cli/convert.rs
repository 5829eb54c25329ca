//! `nephrite convert`: describes the media of a file in another way, and says what the other way cannot say.

use super::Failure;
use super::author_args::ConvertArgs;
use super::authored::Authored;
use super::edit::fallback_thickness;
use super::message::Reporter;
use crate::author::{
    Form, Reading, bodies, declare, khronos, medium, nephrite, openpbr, remove_member, text::Node,
};

/// Converts as the arguments say.
pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let reporter = Reporter::new(args.target.quiet);
    let authored = Authored::open(&args.target, &reporter)?;
    let mut tree = authored.file.tree().map_err(Failure::cannot)?;
    let scene = authored.loaded.as_ref().ok().map(|loaded| &loaded.scene);
    let mut changed = Vec::new();
    let count = tree.root().get("materials").map_or(0, Node::len);
    for index in 0..count {
        let Some(material) = tree.root_mut().get_mut("materials").and_then(|list| list.item_mut(index))
        else {
            continue;
        };
        let Some(reading) = material.value().as_ref().and_then(medium::read) else { continue };
        if reading.form == args.to {
            reporter.note(format!("/materials/{index}: is described that way already"));
            continue;
        }
        let body = scene.and_then(|scene| bodies::with_material(scene, index).next());
        let thickness = fallback_thickness(&reading.medium, body.as_ref());
        for loss in convert(material, &reading, args.to, thickness) {
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
    authored.write(&tree.to_string(), &changed, &reporter)?;
    let output = args.target.output.as_ref().unwrap_or(&args.target.input);
    let media = if changed.len() == 1 { "1 medium".to_owned() } else { format!("{} media", changed.len()) };
    reporter.note(format!("wrote {} ({media} converted)", output.display()));
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
