//! `KHR_materials_fuzz` (draft, pull request 2538): fibres or dust on top of everything. It takes the place of
//! `KHR_materials_sheen` on the same material.

use glam::Vec3;

use super::{Extension, drafts, order, sheen};
use crate::asset::{AssetError, Json, Loader, MutableProperty, PropertyKind};
use crate::scene::layers::Fuzz as Layer;
use crate::scene::{ColorSpace, MaterialDescription};

const NAME: &str = "KHR_materials_fuzz";

const MUTABLE: &[MutableProperty] = &[
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_fuzz/fuzzFactor",
        kind: PropertyKind::Float,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_fuzz/fuzzColorFactor",
        kind: PropertyKind::Float3,
        range: [0.0, 1.0],
    },
    MutableProperty {
        template: "/materials/{}/extensions/KHR_materials_fuzz/fuzzRoughnessFactor",
        kind: PropertyKind::Float,
        range: [0.0, 1.0],
    },
];

pub(super) struct Fuzz;

impl Extension for Fuzz {
    fn name(&self) -> &str {
        NAME
    }

    /// After `KHR_materials_sheen`.
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
        drafts::replaces(loader, NAME, sheen::NAME, material);
        let fuzz = Layer {
            factor: loader.factor(own, "fuzzFactor", 0.0, 0.0..=1.0)?,
            texture: loader.texture_slot(own, "fuzzTexture", ColorSpace::Linear)?,
            color: Vec3::from(loader.factors(own, "fuzzColorFactor", [1.0; 3], 0.0..=1.0)?),
            color_texture: loader.texture_slot(own, "fuzzColorTexture", ColorSpace::Srgb)?,
            roughness: loader.factor(own, "fuzzRoughnessFactor", 0.5, 0.0..=1.0)?,
            roughness_texture: loader.texture_slot(own, "fuzzRoughnessTexture", ColorSpace::Linear)?,
        };
        if fuzz.factor > 0.0 {
            drafts::tell_default(loader, own, "fuzzRoughnessFactor", "0.5", "0");
            out.layers_mut().fuzz = Some(fuzz);
        }
        if let Some(layers) = &mut out.layers {
            layers.sheen = None;
        }
        Ok(())
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        MUTABLE
    }
}
