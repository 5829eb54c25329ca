//! `KHR_materials_anisotropy`: microfacets that are rougher along one tangent, as on brushed metal.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::Anisotropy as Brushed;
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) struct Anisotropy;

impl Extension for Anisotropy {
    fn name(&self) -> &str {
        "KHR_materials_anisotropy"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let rotation = own.f64("anisotropyRotation")?.unwrap_or(0.0) % std::f64::consts::TAU;
        let brushed = Brushed {
            strength: loader.factor(own, "anisotropyStrength", 0.0, 0.0..=1.0)?,
            rotation: rotation as f32,
            texture: loader.texture_slot(own, "anisotropyTexture", ColorSpace::Linear)?,
        };
        if brushed.strength > 0.0 {
            out.layers_mut().anisotropy = Some(brushed);
        }
        Ok(())
    }
}
