//! Instances: a mesh at a node, if its transform leaves something of it.
//!
//! A transform without an inverse flattens a mesh; the flat mesh is baked, since instances must be invertible. What
//! reaches beyond [`FARTHEST`] is left out, since single precision cannot square it and go on. So is an opaque object in
//! the very place of another one of the same mesh: it cannot be seen, and a ray that meets a million of them would meet
//! them all. What light passes is kept, as often as it is there.

use std::collections::HashSet;

use glam::{Affine3A, BVec3, DAffine3, DVec3, Vec3};

use super::error::AssetError;
use super::loader::Loader;
use super::mesh::FARTHEST;
use super::node::NodeContext;
use super::rebase;
use crate::scene::{InstanceDescription, MaterialDescription, MeshDescription};

/// Below this volume, relative to the lengths of its columns, a transform counts as flat.
const FLAT: f64 = 1e-9;

impl Loader<'_> {
    /// Adds an instance of a mesh of the scene.
    ///
    /// # Errors
    /// Where there are more instances than the limits allow.
    pub fn place(&mut self, mesh: usize, node: &NodeContext, world: &DAffine3) -> Result<(), AssetError> {
        let limit = self.options.limits.instances;
        let needed = self.scene.instances.len() as u64 + 1;
        Self::within(needed, limit, &node.pointer, "the scene, in instances,", "instances")?;
        let center = self.centers.get(&mesh).copied().unwrap_or_default();
        let world = &DAffine3 { translation: world.transform_point3(center), ..*world };
        let transform = Affine3A::from_mat3_translation(world.matrix3.as_mat3(), world.translation.as_vec3());
        let reach = |p: DVec3| world.transform_point3(p).abs().max_element();
        if !transform.is_finite() || !self.corners(mesh).into_iter().all(|c| reach(c) <= FARTHEST) {
            let message = format!("the object is left out, since it reaches beyond {FARTHEST:e} m");
            self.warn(&node.pointer, message, None);
            return Ok(());
        }
        let (mesh, transform, translation) = if invertible(world) && transform.inverse().is_finite() {
            (mesh, transform, world.translation)
        } else {
            // What is far away stays at its own origin: baked there, its places would be rounded.
            let corners = self.corners(mesh).map(|c| world.transform_point3(c));
            let far = rebase::far_center(corners.into_iter()) != DVec3::ZERO;
            let translation = if far { world.translation } else { DVec3::ZERO };
            let bake = if far { Affine3A::from_mat3(transform.matrix3.into()) } else { transform };
            let Some(flat) = self.flattened(mesh, &bake, &node.pointer)? else {
                let message = "the object is left out, since its scale leaves nothing of it";
                self.warn(&node.pointer, message, None);
                return Ok(());
            };
            self.warn(&node.pointer, "the scale of the object flattens it", None);
            (flat, Affine3A::from_translation(translation.as_vec3()), translation)
        };
        self.exact.instances.push((self.scene.instances.len(), translation));
        self.scene.instances.push(InstanceDescription {
            name: node.name.clone(),
            pointer: node.pointer.clone(),
            mesh,
            transform,
        });
        Ok(())
    }

    /// Leaves out opaque objects in the very place of others.
    pub(crate) fn drop_repeated_objects(&mut self) {
        let scene = &mut self.scene;
        let opaque: Vec<bool> = scene.meshes.iter().map(|mesh| is_opaque(mesh, &scene.materials)).collect();
        let mut placed = HashSet::new();
        let before = scene.instances.len();
        scene.instances.retain(|instance| {
            let place = (instance.mesh, instance.transform.to_cols_array().map(f32::to_bits));
            placed.insert(place) || opaque.get(instance.mesh) == Some(&false)
        });
        self.totals.repeated_objects = before - scene.instances.len();
    }

    /// The corners of a mesh's bounding box.
    pub(crate) fn corners(&mut self, mesh: usize) -> [DVec3; 8] {
        let meshes = &self.scene.meshes;
        let bounds = || meshes.get(mesh).map_or([Vec3::ZERO; 2], MeshDescription::bounds);
        let [low, high] = self.bounds.entry(mesh).or_insert_with(bounds).map(|c| c.as_dvec3());
        std::array::from_fn(|i| {
            let bit = |k: usize| i >> k & 1 == 1;
            DVec3::select(BVec3::new(bit(0), bit(1), bit(2)), high, low)
        })
    }

    /// A copy of a mesh under a transform that has no inverse; `None` if no area is left.
    fn flattened(
        &mut self,
        mesh: usize,
        transform: &Affine3A,
        pointer: &str,
    ) -> Result<Option<usize>, AssetError> {
        let Some(mesh) = self.scene.meshes.get(mesh) else { return Ok(None) };
        let mut flat = mesh.clone();
        self.spend(flat.positions.len(), flat.triangles.len(), pointer)?;
        for p in &mut flat.positions {
            *p = transform.transform_point3(*p);
        }
        flat.normals.clear();
        flat.tangents.clear();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| flat.positions[i as usize]);
            (b - a).cross(c - a).length_squared()
        };
        let solid: Vec<bool> = flat.triangles.iter().map(|t| area(t) > 0.0).collect();
        let mut keep = solid.iter();
        flat.triangles.retain(|_| keep.next().copied().unwrap_or(false));
        let mut keep = solid.iter();
        flat.triangle_materials.retain(|_| keep.next().copied().unwrap_or(false));
        if flat.triangles.is_empty() {
            return Ok(None);
        }
        self.scene.meshes.push(flat);
        Ok(Some(self.scene.meshes.len() - 1))
    }
}

/// Whether no light passes the triangles of a mesh.
fn is_opaque(mesh: &MeshDescription, materials: &[MaterialDescription]) -> bool {
    let mut used = mesh.triangle_materials.iter().filter_map(|&m| materials.get(m as usize));
    used.all(MaterialDescription::is_opaque)
}

/// Whether the columns of a transform span space, whatever their lengths.
fn invertible(world: &DAffine3) -> bool {
    let m = &world.matrix3;
    let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    m.determinant().abs() > FLAT * lengths
}
