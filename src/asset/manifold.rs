//! Which vertices of a mesh are one, where an extension says so (`EXT_mesh_manifold`), and whether that is true.
//!
//! Without such knowledge vertices are merged where their positions are equal, which is wrong where two parts of a solid
//! only touch. The extension's claim counts once it has been verified: merged vertices are at the same place, and every
//! edge of every triangle has exactly one other that runs the opposite way.

use std::collections::{HashMap, HashSet};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::primitive::Primitive;

/// For vertices of a mesh that are stored more than once, the one that stands for all. Vertices are numbered as in the
/// accessors that all primitives of the mesh share.
pub type MergedVertices = HashMap<u32, u32>;

impl Loader<'_> {
    /// What extensions know of the vertices of a mesh, if its primitives share them.
    pub(crate) fn merged_vertices(&mut self, mesh: &Json<'_>) -> Result<Option<MergedVertices>, AssetError> {
        if mesh.get("extensions").is_none() {
            return Ok(None);
        }
        for extension in self.options.registry.iter() {
            if let Some(own) = mesh.extension(extension.name())
                && let Some(merged) = extension.merged_vertices(self, &own, mesh)?
            {
                let mut accessors = HashSet::new();
                for primitive in mesh.array("primitives")? {
                    let attributes = primitive.object("attributes")?;
                    accessors.insert(attributes.map(|a| a.usize("POSITION")).transpose()?.flatten());
                }
                if accessors.len() == 1 {
                    return Ok(Some(merged));
                }
                let message = "the primitives do not share their positions; equal ones are merged instead";
                self.invalid(own.pointer(), message)?;
            }
        }
        Ok(None)
    }
}

/// Whether merged vertices are where those are that stand for them.
pub(crate) fn agrees(primitive: &Primitive, merged: &MergedVertices) -> bool {
    let at = |i: u32| primitive.positions.get(i as usize);
    merged.iter().all(|(&from, &to)| at(from).is_some() && at(from) == at(to))
}

/// Whether every edge of the triangles has exactly one partner that runs the opposite way.
pub(crate) fn is_manifold(triangles: impl Iterator<Item = [u32; 3]>) -> bool {
    let mut edges: Vec<(u32, u32, bool)> = Vec::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.push((from.min(to), from.max(to), from < to));
        }
    }
    edges.sort_unstable();
    let mut groups = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    groups.all(|edge| matches!(edge, [a, b] if a.0 != a.1 && a.2 != b.2))
}

#[cfg(test)]
mod tests {
    use super::is_manifold;

    #[test]
    fn every_edge_needs_one_partner() {
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert!(is_manifold(tetrahedron.into_iter()));
        assert!(!is_manifold(tetrahedron[1..].iter().copied()), "open");
        let mut turned = tetrahedron;
        turned[0].swap(1, 2);
        assert!(!is_manifold(turned.into_iter()), "one triangle is inside out");
        let twice = tetrahedron.into_iter().chain(tetrahedron);
        assert!(!is_manifold(twice), "four triangles at an edge");
    }
}
