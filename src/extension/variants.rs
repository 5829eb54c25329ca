//! `KHR_materials_variants`: alternative materials for primitives. What a primitive itself says is the default
//! variant, and that is what is shown.

use super::Extension;

pub(super) struct Variants;

impl Extension for Variants {
    fn name(&self) -> &str {
        "KHR_materials_variants"
    }

    fn shortfall(&self) -> Option<&str> {
        Some("only the default variant is shown")
    }
}
