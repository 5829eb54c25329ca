//! `KHR_materials_dispersion`: the index of refraction depends on the wavelength.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::MaterialDescription;

/// Twenty times what the most dispersive mineral has.
const MAX_DISPERSION: f64 = 40.0;

pub(super) struct Dispersion;

impl Extension for Dispersion {
    fn name(&self) -> &str {
        "KHR_materials_dispersion"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let dispersion = loader.factor(own, "dispersion", 0.0, 0.0..=MAX_DISPERSION)?;
        if dispersion > 0.0 {
            out.layers_mut().dispersion = dispersion;
        }
        Ok(())
    }
}
