//! `EXT_mesh_manifold`: how the triangles of a mesh hang together as the boundary of a solid.
//!
//! The mesh has a second list of indices over the same vertices: its sparse accessor replaces, among the indices of all
//! primitives, those of repeated vertices by one that stands for them. Comparing the list with and without the sparse
//! part tells which vertices are one.

use super::Extension;
use crate::asset::{AssetError, Json, Loader, MergedVertices};

pub(super) struct MeshManifold;

impl Extension for MeshManifold {
    fn name(&self) -> &str {
        "EXT_mesh_manifold"
    }

    fn merged_vertices(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
    ) -> Result<Option<MergedVertices>, AssetError> {
        let Some(primitive) = own.object("manifoldPrimitive")? else {
            loader
                .invalid(own.pointer(), "has no `manifoldPrimitive`; equal positions are merged instead")?;
            return Ok(None);
        };
        let Some(index) = primitive.usize("indices")? else {
            loader.invalid(primitive.pointer(), "has no `indices`; equal positions are merged instead")?;
            return Ok(None);
        };
        let accessor = loader.accessor(index, &primitive.pointer_to("indices"))?;
        let (dense, merged) = (accessor.without_sparse().indices()?, accessor.indices()?);
        let mut out = MergedVertices::new();
        for (&from, &to) in dense.iter().zip(&merged).filter(|(from, to)| from != to) {
            if out.insert(from, to).is_some_and(|before| before != to) {
                let message =
                    format!("vertex {from} is merged with several; equal positions are merged instead");
                loader.invalid(primitive.pointer(), message)?;
                return Ok(None);
            }
        }
        Ok(Some(out))
    }
}
