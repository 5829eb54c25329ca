//! What the drafts that bring OpenPBR to glTF have in common: `KHR_materials_coat`, `_diffuse_roughness`, `_fuzz`.

use crate::asset::{AssetError, Json, Loader};

/// Extensions of a material that none of the drafts goes together with.
const EXCLUDED: [&str; 2] = ["KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit"];

/// Tells of extensions beside `name` that it must not be used with. They are honoured all the same.
pub(super) fn exclude(loader: &mut Loader<'_>, name: &str, material: &Json<'_>) -> Result<(), AssetError> {
    for other in EXCLUDED {
        if material.extension(other).is_some() {
            let pointer = format!("{}/extensions/{name}", material.pointer());
            loader.invalid(&pointer, format!("must not be on a material that has {other}"))?;
        }
    }
    Ok(())
}

/// Tells of an older extension beside `name` that is there for those who do not know it.
pub(super) fn replaces(loader: &mut Loader<'_>, name: &str, older: &str, material: &Json<'_>) {
    if material.extension(older).is_some() {
        let pointer = format!("{}/extensions/{older}", material.pointer());
        loader.note(&pointer, format!("{name} takes its place"));
    }
}

/// Tells that a property is left out of which the text of a draft and its schema say different defaults.
pub(super) fn tell_default(loader: &mut Loader<'_>, own: &Json<'_>, key: &str, text: &str, schema: &str) {
    if own.get(key).is_none() {
        let message = format!(
            "{key} is left out: {text}, as the text of the draft has it; its schema says {schema}, so a file should state it"
        );
        loader.note(own.pointer(), message);
    }
}
