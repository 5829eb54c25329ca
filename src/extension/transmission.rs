//! `KHR_materials_transmission`: the fraction of light that goes through the surface instead of to the diffuse base.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) const NAME: &str = "KHR_materials_transmission";

pub(super) struct Transmission;

impl Extension for Transmission {
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
        out.transmission = loader.factor(own, "transmissionFactor", 0.0, 0.0..=1.0)?;
        out.transmission_texture = loader.texture_slot(own, "transmissionTexture", ColorSpace::Linear)?;
        Ok(())
    }
}
