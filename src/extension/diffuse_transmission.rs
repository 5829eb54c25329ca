//! `KHR_materials_diffuse_transmission`: light that comes out on the other side in all directions, as through a leaf.
//!
//! Where the material is transmissive too, only what is not transmitted is divided. With a volume the light is diffuse
//! inside; it is not refracted, so the medium has the index of what is around it (unless the material is transmissive).

use glam::Vec3;

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::DiffuseTransmission as Through;
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) struct DiffuseTransmission;

impl Extension for DiffuseTransmission {
    fn name(&self) -> &str {
        "KHR_materials_diffuse_transmission"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let color = loader.factors(own, "diffuseTransmissionColorFactor", [1.0; 3], 0.0..=1.0)?;
        let through = Through {
            factor: loader.factor(own, "diffuseTransmissionFactor", 0.0, 0.0..=1.0)?,
            texture: loader.texture_slot(own, "diffuseTransmissionTexture", ColorSpace::Linear)?,
            color: Vec3::from(color),
            color_texture: loader.texture_slot(own, "diffuseTransmissionColorTexture", ColorSpace::Srgb)?,
        };
        if through.factor > 0.0 {
            out.layers_mut().diffuse_transmission = Some(through);
        }
        Ok(())
    }
}
