//! Media, their textures, their fallbacks for other viewers, and their units.

use super::finding;
use crate::asset::{Diagnostic, Severity};
use crate::author::nephrite::NAME;
use crate::author::{bodies, khronos, nephrite};
use crate::scene::{MaterialDescription, MediumDescription, SceneDescription, TextureRef};
use glam::Vec3;
use serde_json::Value;

/// Mean free paths that many times the size of a body, or shorter than that part of it, are most likely in other units.
const LONGEST: f64 = 1e3;
const SHORTEST: f64 = 1e-5;
/// Coefficients of a fallback that are that much off, relatively, might be seen; less comes from rounded numbers.
const VISIBLE: f64 = 0.01;

pub(super) fn check(document: &Value, scene: &SceneDescription, found: &mut Vec<Diagnostic>) {
    for (index, material) in scene.materials.iter().enumerate() {
        let Some(medium) = &material.medium else { continue };
        let json = document.pointer(&format!("/materials/{index}"));
        let own = json.filter(|json| json.pointer(&format!("/extensions/{NAME}")).is_some());
        if let Some(json) = own {
            fallback(json, material, found);
            textures(material, medium, found);
        }
        units(scene, index, material, medium, found);
    }
}

fn fallback(json: &Value, material: &MaterialDescription, found: &mut Vec<Diagnostic>) {
    let pointer = format!("{}/extensions", material.pointer);
    if json.pointer("/extensions/KHR_materials_volume").is_none() {
        found.push(finding(
            Severity::Note,
            pointer,
            "there is nothing that other viewers could show instead of the medium",
            Some("`nephrite edit` and `nephrite convert --to nephrite` write KHR_materials_transmission, _volume and _scatter"),
        ));
        return;
    }
    let textured = material.medium.as_ref().is_some_and(MediumDescription::is_textured);
    let (Some(ours), Some(theirs)) = (nephrite::read(json), khronos::read(json)) else { return };
    let differences = ours.medium.differences(&theirs.medium, VISIBLE);
    if let Some(first) = differences.first().filter(|_| !textured) {
        found.push(finding(
            Severity::Warning,
            format!("{pointer}/KHR_materials_volume"),
            format!("other viewers see another medium: {first}"),
            Some("`nephrite convert --to nephrite` writes their description anew"),
        ));
    }
}

fn textures(material: &MaterialDescription, medium: &MediumDescription, found: &mut Vec<Diagnostic>) {
    let slots: [(&str, &str, &Option<TextureRef>, Vec3); 2] = [
        ("absorptionTexture", "absorptionCoefficient", &medium.absorption_texture, medium.sigma_a),
        ("scatteringTexture", "scatteringCoefficient", &medium.scattering_texture, medium.sigma_s),
    ];
    for (key, coefficient, texture, sigma) in slots {
        let pointer = format!("{}/extensions/{NAME}/{key}", material.pointer);
        if texture.is_some() && sigma == Vec3::ZERO {
            found.push(finding(
                Severity::Warning,
                pointer,
                format!("the texture does nothing: the {coefficient} that it multiplies is 0"),
                Some("give the coefficient the value that white texels should have"),
            ));
        }
    }
}

fn units(
    scene: &SceneDescription,
    index: usize,
    material: &MaterialDescription,
    medium: &MediumDescription,
    found: &mut Vec<Diagnostic>,
) {
    let densest = f64::from((medium.sigma_a + medium.sigma_s).max_element());
    let mut used = false;
    for body in bodies::with_material(scene, index) {
        used = true;
        let (path, extent) = (1.0 / densest, body.extent());
        if densest <= 0.0 || extent <= 0.0 {
            continue;
        }
        let (what, advice) = if path > LONGEST * extent {
            (
                "light crosses it and meets nothing",
                "coefficients are per metre: those of a table per millimetre are multiplied by 1000 (`nephrite edit --unit mm`)",
            )
        } else if path < SHORTEST * extent {
            ("it looks opaque", "coefficients are per metre, and the scale of a node does not change them")
        } else {
            continue;
        };
        found.push(finding(
            Severity::Warning,
            &*material.pointer,
            format!(
                "the mean free path is {path:.1e} m and {:?} ({}) is {extent:.1e} m large, so {what}",
                body.instance.name, body.instance.pointer
            ),
            Some(advice),
        ));
        break;
    }
    if !used {
        found.push(finding(
            Severity::Note,
            &*material.pointer,
            "nothing in the scene uses this medium",
            None,
        ));
    }
}
