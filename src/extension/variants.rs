//! `KHR_materials_variants`: alternative materials for primitives. What a primitive itself says is shown, unless
//! [`LoadOptions::variant`](crate::asset::LoadOptions) chooses one of the alternatives.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};

const NAME: &str = "KHR_materials_variants";

pub(super) struct Variants;

impl Extension for Variants {
    fn name(&self) -> &str {
        NAME
    }

    fn document(&self, loader: &mut Loader<'_>, own: &Json<'_>) -> Result<(), AssetError> {
        let names = names(own)?;
        let Some(wanted) = &loader.options().variant else { return Ok(()) };
        let by_name = names.iter().position(|n| n == wanted);
        loader.chosen_variant = by_name.or_else(|| wanted.parse().ok().filter(|&i: &usize| i < names.len()));
        if loader.chosen_variant.is_none() {
            let known: Vec<String> = names.iter().take(16).map(|n| format!("{n:?}")).collect();
            let message = format!("has no variant {wanted:?}; its variants are {}", known.join(", "));
            return Err(own.error_at("variants", message));
        }
        Ok(())
    }

    fn primitive_material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
    ) -> Result<Option<usize>, AssetError> {
        let Some(chosen) = loader.chosen_variant else { return Ok(None) };
        for mapping in own.array("mappings")? {
            for variant in mapping.array("variants")? {
                if variant.as_f64()? == chosen as f64 {
                    return mapping.usize("material");
                }
            }
        }
        Ok(None)
    }
}

/// Names of the variants of a document.
fn names(own: &Json<'_>) -> Result<Vec<String>, AssetError> {
    let list = own.array("variants")?.into_iter().enumerate();
    list.map(|(i, v)| Ok(v.str("name")?.map_or_else(|| format!("variant {i}"), str::to_owned))).collect()
}
