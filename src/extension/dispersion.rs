//! `KHR_materials_dispersion`: the index of refraction depends on the wavelength.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::MaterialDescription;

const NAME: &str = "KHR_materials_dispersion";

/// Twenty times what the most dispersive mineral has.
const MAX_DISPERSION: f64 = 40.0;

/// Tells of dispersion in a medium that scatters, which disperses nothing: after a few events it would show as nothing but
/// coloured noise.
pub(super) fn tell_beside_scattering(loader: &mut Loader<'_>, material: &Json<'_>) -> Result<(), AssetError> {
    let Some(own) = material.extension(NAME) else { return Ok(()) };
    if own.f64("dispersion")?.is_some_and(|d| d > 0.0) {
        let message = "a medium that scatters does not disperse here; one index is used for all colors";
        loader.note(own.pointer(), message);
    }
    Ok(())
}

pub(super) struct Dispersion;

impl Extension for Dispersion {
    fn name(&self) -> &str {
        NAME
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
