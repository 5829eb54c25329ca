//! `KHR_materials_diffuse_roughness` (draft, pull request 2481): diffuse light from microfacets, as of plaster or sand.
//! Its first name was `EXT_materials_diffuse_roughness`, which exporters have written; where both are there the later wins.

use super::{Extension, drafts, order};
use crate::asset::{AssetError, Json, Loader, MutableProperty, PropertyKind};
use crate::scene::layers::DiffuseRoughness as Facets;
use crate::scene::{ColorSpace, MaterialDescription};

pub(super) const NAME: &str = "KHR_materials_diffuse_roughness";
pub(super) const FIRST_NAME: &str = "EXT_materials_diffuse_roughness";

const fn factor(template: &'static str) -> MutableProperty {
    MutableProperty { template, kind: PropertyKind::Float, range: [0.0, 1.0] }
}

const MUTABLE: &[MutableProperty] = &[
    factor("/materials/{}/extensions/KHR_materials_diffuse_roughness/diffuseRoughnessFactor"),
    factor("/materials/{}/extensions/EXT_materials_diffuse_roughness/diffuseRoughnessFactor"),
];

/// The extension under one of its names.
pub(super) struct DiffuseRoughness(pub &'static str);

impl Extension for DiffuseRoughness {
    fn name(&self) -> &str {
        self.0
    }

    fn order(&self) -> i32 {
        order::SURFACE + i32::from(self.0 == NAME)
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        material: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        drafts::exclude(loader, self.0, material)?;
        let facets = Facets {
            factor: loader.factor(own, "diffuseRoughnessFactor", 0.0, 0.0..=1.0)?,
            texture: loader.texture_slot(own, "diffuseRoughnessTexture", ColorSpace::Linear)?,
        };
        drafts::tell_default(loader, own, "diffuseRoughnessFactor", "0", "1");
        if facets.factor > 0.0 {
            out.layers_mut().diffuse_roughness = Some(facets);
        } else if let Some(layers) = &mut out.layers {
            layers.diffuse_roughness = None;
        }
        Ok(())
    }

    fn mutable_properties(&self) -> &[MutableProperty] {
        MUTABLE
    }
}
