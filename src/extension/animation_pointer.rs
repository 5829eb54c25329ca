//! `KHR_animation_pointer`: a channel of an animation names any property that may change by a JSON pointer.
//!
//! Which properties those are is in the Asset Object Model of glTF 2.0 and in
//! [`mutable_properties`](super::Extension::mutable_properties) of extensions; the rest is as with any animation.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};

pub(super) struct AnimationPointer;

impl Extension for AnimationPointer {
    fn name(&self) -> &str {
        "KHR_animation_pointer"
    }

    fn animation_target(&self, _: &mut Loader<'_>, own: &Json<'_>) -> Result<Option<String>, AssetError> {
        let pointer = own.str("pointer")?.ok_or_else(|| own.error_at("pointer", "is missing"))?;
        Ok(Some(pointer.to_owned()))
    }
}
