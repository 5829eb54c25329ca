//! `KHR_materials_sheen`: fibres that stand on the surface, as on velvet.

use glam::Vec3;

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::Sheen as Fibres;
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) const NAME: &str = "KHR_materials_sheen";

pub(super) struct Sheen;

impl Extension for Sheen {
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
        let sheen = Fibres {
            color: Vec3::from(loader.factors(own, "sheenColorFactor", [0.0; 3], 0.0..=1.0)?),
            color_texture: loader.texture_slot(own, "sheenColorTexture", ColorSpace::Srgb)?,
            roughness: loader.factor(own, "sheenRoughnessFactor", 0.0, 0.0..=1.0)?,
            roughness_texture: loader.texture_slot(own, "sheenRoughnessTexture", ColorSpace::Linear)?,
        };
        if sheen.color != Vec3::ZERO {
            out.layers_mut().sheen = Some(sheen);
        }
        Ok(())
    }
}
