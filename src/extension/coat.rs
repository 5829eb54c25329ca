//! `KHR_materials_coat` (draft, pull request 2534): a clear coat with an index, a colour, darkening and brushing. It takes
//! the place of `KHR_materials_clearcoat` on the same material.

use glam::Vec3;

use super::{Extension, clearcoat, drafts, ior, order};
use crate::asset::{AssetError, Json, Loader, MutableProperty, PropertyKind};
use crate::scene::layers::Anisotropy;
use crate::scene::{ColorSpace, MaterialDescription};

const NAME: &str = "KHR_materials_coat";

/// JSON pointer of a property, type, least and greatest value.
const fn property(template: &'static str, kind: PropertyKind, low: f64, high: f64) -> MutableProperty {
    MutableProperty { template, kind, range: [low, high] }
}

const MUTABLE: &[MutableProperty] = {
    use PropertyKind::{Float, Float3};
    const ANY: f64 = f64::INFINITY;
    &[
        property("/materials/{}/extensions/KHR_materials_coat/coatFactor", Float, 0.0, 1.0),
        property("/materials/{}/extensions/KHR_materials_coat/coatRoughnessFactor", Float, 0.0, 1.0),
        property("/materials/{}/extensions/KHR_materials_coat/coatNormalTexture/scale", Float, -ANY, ANY),
        property("/materials/{}/extensions/KHR_materials_coat/coatIor", Float, 1.0, ANY),
        property("/materials/{}/extensions/KHR_materials_coat/coatColorFactor", Float3, 0.0, 1.0),
        property("/materials/{}/extensions/KHR_materials_coat/coatDarkeningFactor", Float, 0.0, 1.0),
        property("/materials/{}/extensions/KHR_materials_coat/coatAnisotropyStrength", Float, 0.0, 1.0),
        property("/materials/{}/extensions/KHR_materials_coat/coatAnisotropyRotation", Float, -ANY, ANY),
    ]
};

pub(super) struct Coat;

impl Extension for Coat {
    fn name(&self) -> &str {
        NAME
    }

    /// After `KHR_materials_clearcoat`.
    fn order(&self) -> i32 {
        order::SURFACE + 10
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        drafts::exclude(loader, NAME, material)?;
        drafts::replaces(loader, NAME, clearcoat::NAME, material);
        let keys =
            ["coatFactor", "coatTexture", "coatRoughnessFactor", "coatRoughnessTexture", "coatNormalTexture"];
        let mut coat = clearcoat::clear(loader, own, "coat", keys)?;
        match own.f64("coatIor")? {
            None => {}
            // The text allows it without saying what for; its formula makes it a mirror.
            Some(0.0) => coat.ior = ior::MIRROR_IOR,
            Some(index) if index >= 1.0 => coat.ior = (index as f32).min(ior::MIRROR_IOR),
            Some(index) => {
                let message = format!("{index} is neither 0 nor at least 1; 1.5 is used");
                loader.invalid(&own.pointer_to("coatIor"), message)?;
            }
        }
        coat.color = Vec3::from(loader.factors(own, "coatColorFactor", [1.0; 3], 0.0..=1.0)?);
        coat.color_texture = loader.texture_slot(own, "coatColorTexture", ColorSpace::Srgb)?;
        coat.darkening = loader.factor(own, "coatDarkeningFactor", 1.0, 0.0..=1.0)?;
        let rotation = own.f64("coatAnisotropyRotation")?.unwrap_or(0.0) % std::f64::consts::TAU;
        let brushed = Anisotropy {
            strength: loader.factor(own, "coatAnisotropyStrength", 0.0, 0.0..=1.0)?,
            rotation: rotation as f32,
            texture: loader.texture_slot(own, "coatAnisotropyTexture", ColorSpace::Linear)?,
        };
        coat.anisotropy = Some(brushed).filter(|b| b.strength > 0.0);
        if coat.factor > 0.0 {
            out.layers_mut().coat = Some(coat);
        } else if let Some(layers) = &mut out.layers {
            layers.coat = None;
        }
        Ok(())
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        MUTABLE
    }
}
