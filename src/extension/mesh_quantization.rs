//! `KHR_mesh_quantization`: attributes may be small integers. The accessor reader converts every component type, so
//! there is nothing left to do but to know the name.

use super::Extension;

pub(super) struct MeshQuantization;

impl Extension for MeshQuantization {
    fn name(&self) -> &str {
        "KHR_mesh_quantization"
    }
}
