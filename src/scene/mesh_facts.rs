//! What is asked of a mesh for each of its instances, found once.

use super::MeshDescription;

/// A mesh, summed up.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshFacts {
    /// Its materials, that of the first triangle first, each once.
    pub materials: Vec<u32>,
    /// Enclosed volume in cubic units of the mesh's space, whichever way it is wound.
    pub volume: f64,
    /// Area in square units.
    pub area: f64,
}

impl MeshFacts {
    pub fn new(mesh: &MeshDescription) -> Self {
        let mut materials = mesh.triangle_materials.clone();
        materials.sort_unstable();
        materials.dedup();
        let first = mesh.triangle_materials.first();
        if let Some(first) = materials.iter().position(|m| Some(m) == first) {
            materials[..=first].rotate_right(1);
        }
        let corner = |i: u32| mesh.positions[i as usize].as_dvec3();
        let corners = || mesh.triangles.iter().map(|t| t.map(corner));
        let volume = (corners().map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() / 6.0).abs();
        let area = corners().map(|[a, b, c]| (b - a).cross(c - a).length()).sum::<f64>() / 2.0;
        Self { materials, volume, area }
    }
}
