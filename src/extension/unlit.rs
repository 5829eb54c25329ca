//! `KHR_materials_unlit`: the base colour is what the camera sees.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::MaterialDescription;

pub(super) struct Unlit;

impl Extension for Unlit {
    fn name(&self) -> &str {
        "KHR_materials_unlit"
    }

    fn material(
        &self,
        _: &mut Loader<'_>,
        _: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        out.unlit = true;
        Ok(())
    }
}
