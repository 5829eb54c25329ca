//! What is wrong, or looks wrong, with the media of a file.
//!
//! Core glTF is the business of the validator of Khronos. Here is what it cannot know: the rules of our extension, meshes
//! that do not hold a medium, units that were mixed up, bodies that overlap, and what other viewers will show instead. What
//! the loader has to say of the file comes first.

mod contact;
mod material;
mod overlap;
mod shape;
mod triangles;

use super::AuthoredFile;
use super::nephrite::{self, NAME};
use crate::asset::{AssetError, Diagnostic, Loaded, Severity};

/// All findings, most serious first. `loaded` is what the loader made of the same file.
pub fn check(file: &AuthoredFile, loaded: Result<&Loaded, &AssetError>) -> Vec<Diagnostic> {
    let mut found = schema(file);
    match loaded {
        Err(error) => {
            // The loader stops at the first of what the schema was asked for all at once.
            if !found
                .iter()
                .any(|d| d.pointer.starts_with(error.pointer()) || error.pointer().starts_with(&d.pointer))
            {
                found.push(from_error(error));
            }
        }
        Ok(loaded) => {
            found.extend(loaded.diagnostics.iter().cloned());
            material::check(file.document(), &loaded.scene, &mut found);
            let (bodies, shapes) = shape::check(file.document(), &loaded.scene, &mut found);
            overlap::check(&loaded.scene, &bodies, &shapes, &mut found);
        }
    }
    found.sort_by_key(|d| std::cmp::Reverse(d.severity));
    found
}

/// Every violation of the schema of our extension, in all materials.
fn schema(file: &AuthoredFile) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let materials = file.document().get("materials").and_then(|list| list.as_array()).into_iter().flatten();
    for (i, material) in materials.enumerate() {
        let Some(own) = material.get("extensions").and_then(|e| e.get(NAME)) else { continue };
        for (pointer, message) in nephrite::violations(own) {
            found.push(finding(
                Severity::Error,
                format!("/materials/{i}/extensions/{NAME}{pointer}"),
                message,
                None,
            ));
        }
    }
    let required = file.document().get("extensionsRequired").and_then(|list| list.as_array());
    if let Some(at) = required.and_then(|list| list.iter().position(|name| name == NAME)) {
        found.push(finding(
            Severity::Warning,
            format!("/extensionsRequired/{at}"),
            format!("{NAME} should not be required: other viewers refuse the file"),
            Some("list it in extensionsUsed alone"),
        ));
    }
    found
}

fn from_error(error: &AssetError) -> Diagnostic {
    let pointer = error.pointer().to_owned();
    let text = error.to_string();
    let message = text.strip_prefix(&format!("{pointer}: ")).unwrap_or(&text).to_owned();
    Diagnostic { severity: Severity::Error, pointer, message, advice: error.advice() }
}

fn finding(
    severity: Severity,
    pointer: impl Into<String>,
    message: impl Into<String>,
    advice: Option<&str>,
) -> Diagnostic {
    Diagnostic {
        severity,
        pointer: pointer.into(),
        message: message.into(),
        advice: advice.map(str::to_owned),
    }
}
