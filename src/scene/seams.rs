//! Seams of meshes that hold media: what was meant to be closed is closed before it is analysed.

use super::{MeshDescription, SceneDescription};
use crate::geometry::{MeshGeometry, Similarity, Topology, close_seams};
use glam::Vec3;
use std::borrow::Cow;

/// The tolerance without another one, relative to the largest coordinate of a mesh: what borders of patches differ by that
/// were computed and rounded each by itself in single precision (several roundings of 6e-8), or written with six digits
/// on the way (5e-6 at most).
const TOLERANCE: f32 = 1e-5;

impl SceneDescription {
    /// How far the ends of open edges may be apart that are one, in units of a mesh; where instances have several scales,
    /// the largest counts.
    fn weld_tolerance(&self, mesh: usize) -> f32 {
        let Some(length) = self.weld_tolerance else {
            let [low, high] = self.meshes[mesh].bounds();
            return TOLERANCE * low.abs().max(high.abs()).max_element();
        };
        let instances = self.instances.iter().filter(|i| i.mesh == mesh);
        let scales = instances.map(|i| match Similarity::from_affine(&i.transform) {
            Some(similarity) => similarity.scale,
            None => [i.transform.matrix3.x_axis, i.transform.matrix3.y_axis, i.transform.matrix3.z_axis]
                .into_iter()
                .map(|axis| Vec3::from(axis).length())
                .fold(0.0, f32::max),
        });
        length / scales.fold(0.0, f32::max)
    }

    /// Closes the seams of a mesh; how many of its vertices were moved.
    pub(super) fn close_seams(&mut self, mesh: usize) -> usize {
        let tolerance = self.weld_tolerance(mesh);
        let MeshDescription { positions, triangles, .. } = &mut self.meshes[mesh];
        close_seams(positions, triangles, tolerance)
    }

    /// Analyses a mesh as it is once its seams are closed.
    pub fn analyse(&self, mesh: usize) -> Analysed<'_> {
        let MeshDescription { positions, triangles, merged, .. } = &self.meshes[mesh];
        let analyse =
            |positions: &[Vec3]| Topology::analyse_merged(&MeshGeometry::build(positions, triangles), merged);
        let topology = analyse(positions);
        if topology.has_open_edges() {
            let mut welded = positions.clone();
            let moved = close_seams(&mut welded, triangles, self.weld_tolerance(mesh));
            if moved > 0 {
                return Analysed { topology: analyse(&welded), positions: Cow::Owned(welded), moved };
            }
        }
        Analysed { topology, positions: Cow::Borrowed(positions), moved: 0 }
    }
}

/// What [`SceneDescription::analyse`] finds.
#[derive(Clone, Debug)]
pub struct Analysed<'a> {
    /// Which parts are closed.
    pub topology: Topology,
    /// Where the vertices are.
    pub positions: Cow<'a, [Vec3]>,
    /// How many of them were moved to close seams.
    pub moved: usize,
}
