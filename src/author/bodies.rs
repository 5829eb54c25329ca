//! How large the bodies are that a medium fills: needed to say whether its units make sense, and by the fallbacks for
//! other readers.

use crate::scene::{InstanceDescription, MeshDescription, SceneDescription};
use glam::Vec3;

/// One object with a material.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    /// The object.
    pub instance: &'a InstanceDescription,
    /// Its mesh.
    pub mesh: &'a MeshDescription,
    /// Edges of the box around its triangles of that material, in units of the mesh.
    pub size: Vec3,
    /// Metres in a unit of the mesh: the cube root of the change of volume.
    pub scale: f64,
}

impl Body<'_> {
    /// The shortest edge of its box, in units of the mesh.
    pub fn thickness(&self) -> f64 {
        f64::from(self.size.min_element())
    }

    /// The longest edge of its box, in metres.
    pub fn extent(&self) -> f64 {
        f64::from(self.size.max_element()) * self.scale
    }
}

/// The objects of a scene that use a material.
pub fn with_material(scene: &SceneDescription, material: usize) -> impl Iterator<Item = Body<'_>> {
    let boxes: Vec<Option<Vec3>> = scene.meshes.iter().map(|mesh| size(mesh, material)).collect();
    scene.instances.iter().filter_map(move |instance| {
        let size = *boxes.get(instance.mesh)?;
        let volume = f64::from(instance.transform.matrix3.determinant().abs());
        Some(Body { instance, mesh: scene.meshes.get(instance.mesh)?, size: size?, scale: volume.cbrt() })
    })
}

fn size(mesh: &MeshDescription, material: usize) -> Option<Vec3> {
    let used = mesh.triangles.iter().zip(&mesh.triangle_materials).filter(|(_, m)| **m as usize == material);
    let corners = used.flat_map(|(triangle, _)| triangle).filter_map(|&i| mesh.positions.get(i as usize));
    let bounds = corners.fold(None, |bounds: Option<[Vec3; 2]>, &p| {
        let [low, high] = bounds.unwrap_or([p; 2]);
        Some([low.min(p), high.max(p)])
    });
    bounds.map(|[low, high]| high - low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;

    #[test]
    fn only_the_triangles_of_the_material_count() {
        let mesh = MeshDescription {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 2.0, 0.5), Vec3::splat(9.0)],
            triangles: vec![[0, 1, 2], [1, 2, 3]],
            triangle_materials: vec![4, 1],
            ..Default::default()
        };
        let instance = |scale: f32| InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh: 0,
            transform: Affine3A::from_scale(Vec3::splat(scale)),
        };
        let scene = SceneDescription {
            meshes: vec![mesh],
            instances: vec![instance(1.0), instance(3.0)],
            ..Default::default()
        };
        let found: Vec<_> = with_material(&scene, 4).collect();
        assert_eq!((found.len(), found[1].size), (2, Vec3::new(1.0, 2.0, 0.5)));
        assert!((found[1].extent() - 6.0).abs() < 1e-5 && found[1].thickness() == 0.5);
        assert_eq!(with_material(&scene, 0).count(), 0);
    }
}
