//! `KHR_materials_ior`: the index of refraction of the boundary. Zero stands for an infinite one, which does not disperse.

use super::{Extension, order};
use crate::asset::{AssetError, Json, Loader};
use crate::scene::MaterialDescription;

/// Stands for the special value 0, "reflects everything": 99.96 % at normal incidence.
pub(super) const MIRROR_IOR: f32 = 1e4;

pub(super) const NAME: &str = "KHR_materials_ior";

pub(super) struct Ior;

impl Extension for Ior {
    fn name(&self) -> &str {
        NAME
    }

    /// After `KHR_materials_dispersion`.
    fn order(&self) -> i32 {
        order::SURFACE + 1
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        match own.f64("ior")? {
            None => {}
            Some(0.0) => {
                out.ior = MIRROR_IOR;
                if let Some(layers) = &mut out.layers {
                    layers.dispersion = 0.0;
                }
            }
            Some(ior) if ior >= 1.0 => out.ior = (ior as f32).min(MIRROR_IOR),
            Some(ior) => {
                loader.invalid(
                    &own.pointer_to("ior"),
                    format!("{ior} is neither 0 nor at least 1; 1.5 is used"),
                )?;
            }
        }
        Ok(())
    }
}
