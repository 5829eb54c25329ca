//! `KHR_materials_clearcoat`: a dielectric coat with a roughness and normals of its own.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::Clearcoat as Coat;
use crate::scene::{ColorSpace, MaterialDescription};

/// Normal maps stretched beyond this are noise.
const MAX_NORMAL_SCALE: f64 = 1e4;

pub(super) struct Clearcoat;

impl Extension for Clearcoat {
    fn name(&self) -> &str {
        "KHR_materials_clearcoat"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let mut coat = Coat {
            factor: loader.factor(own, "clearcoatFactor", 0.0, 0.0..=1.0)?,
            texture: loader.texture_slot(own, "clearcoatTexture", ColorSpace::Linear)?,
            roughness: loader.factor(own, "clearcoatRoughnessFactor", 0.0, 0.0..=1.0)?,
            roughness_texture: loader.texture_slot(own, "clearcoatRoughnessTexture", ColorSpace::Linear)?,
            normal_texture: loader.texture_slot(own, "clearcoatNormalTexture", ColorSpace::Linear)?,
            normal_scale: 1.0,
        };
        if let Some(info) = own.object("clearcoatNormalTexture")? {
            let range = -MAX_NORMAL_SCALE..=MAX_NORMAL_SCALE;
            coat.normal_scale = loader.factor(&info, "scale", 1.0, range)?;
        }
        if coat.factor > 0.0 {
            out.layers_mut().clearcoat = Some(coat);
        }
        Ok(())
    }
}
