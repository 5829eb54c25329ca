//! `KHR_materials_emissive_strength`: multiplies the emissive factor, so that radiance may exceed 1.

use super::{Extension, order};
use crate::asset::{AssetError, Json, Loader};
use crate::scene::MaterialDescription;

/// Emission beyond this radiance overflows the sums of a picture.
pub(super) const MAX_RADIANCE: f32 = 1e16;

pub(super) struct EmissiveStrength;

impl Extension for EmissiveStrength {
    fn name(&self) -> &str {
        "KHR_materials_emissive_strength"
    }

    fn order(&self) -> i32 {
        order::SURFACE
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        out.emission *= loader.factor(own, "emissiveStrength", 1.0, 0.0..=f64::from(MAX_RADIANCE))?;
        Ok(())
    }
}
