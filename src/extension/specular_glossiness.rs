//! `KHR_materials_pbrSpecularGlossiness` (archived): diffuse and specular colours in place of a base colour and a metal.
//!
//! It is a dielectric whose reflectance at normal incidence is the specular colour, which is what an infinite index with
//! the colour of KHR_materials_specular says, with roughness 1 − glossiness. What the coat reflects is taken from the
//! diffuse base by direction, where the extension takes 1 − max(specular) for all.

use glam::{Vec3, Vec4};

use super::{Extension, order};
use crate::asset::{AssetError, Json, Loader};
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) struct SpecularGlossiness;

impl Extension for SpecularGlossiness {
    fn name(&self) -> &str {
        "KHR_materials_pbrSpecularGlossiness"
    }

    fn order(&self) -> i32 {
        order::SURFACE - 10
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        out.base_color = Vec4::from(loader.factors(own, "diffuseFactor", [1.0; 4], 0.0..=1.0)?);
        out.base_color_texture = loader.texture_slot(own, "diffuseTexture", ColorSpace::Srgb)?;
        out.specular_color = Vec3::from(loader.factors(own, "specularFactor", [1.0; 3], 0.0..=1.0)?);
        let both = loader.texture_slot(own, "specularGlossinessTexture", ColorSpace::Srgb)?;
        out.specular_color_texture = both;
        out.roughness = 1.0 - loader.factor(own, "glossinessFactor", 1.0, 0.0..=1.0)?;
        out.glossiness_texture = both;
        out.ior = super::ior::MIRROR_IOR;
        out.metallic = 0.0;
        out.metallic_roughness_texture = None;
        Ok(())
    }
}
