//! `KHR_materials_specular`: strength and colour of the dielectric reflection.

use glam::Vec3;

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::{ColorSpace, MaterialDescription};

/// The specification sets no upper bound on the colour; beyond this it only makes the reflection saturate.
const MAX_COLOR: f64 = 1e4;

pub(super) struct Specular;

impl Extension for Specular {
    fn name(&self) -> &str {
        "KHR_materials_specular"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        out.specular = loader.factor(own, "specularFactor", 1.0, 0.0..=1.0)?;
        out.specular_texture = loader.texture_slot(own, "specularTexture", ColorSpace::Linear)?;
        let color = loader.factors(own, "specularColorFactor", [1.0; 3], 0.0..=MAX_COLOR)?;
        out.specular_color = Vec3::from(color);
        out.specular_color_texture = loader.texture_slot(own, "specularColorTexture", ColorSpace::Srgb)?;
        Ok(())
    }
}
