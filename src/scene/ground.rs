//! A ground below a scene, for turntables and product shots.

use super::{InstanceDescription, MaterialDescription, MeshDescription, SceneDescription};
use glam::{Affine3A, Vec3};
use std::f32::consts::TAU;

/// Radius of the disk, in radii of the scene: its edge is far out of view.
const REACH: f32 = 200.0;
/// Gap below the lowest point, in heights of the scene: what stands on the ground does not share a plane with it.
const GAP: f32 = 1e-4;
/// Corners of the disk.
const CORNERS: u32 = 64;

impl SceneDescription {
    /// The height of a horizontal plane just below everything; `None` for a scene without anything.
    pub fn ground_height(&self) -> Option<f32> {
        self.bounds().map(height_below)
    }

    /// Adds a large matte disk of that linear reflectance (0 … 1) just below everything. False: there is nothing.
    pub fn add_ground(&mut self, reflectance: Vec3) -> bool {
        let bounds = self.bounds();
        if let Some(bounds) = bounds {
            self.add_ground_below(bounds, reflectance);
        }
        bounds.is_some()
    }

    /// As [`Self::add_ground`], below a box from a lower to an upper corner: for a scene that moves above it.
    pub fn add_ground_below(&mut self, [low, high]: [Vec3; 2], reflectance: Vec3) {
        let center = (0.5 * (low + high)).with_y(height_below([low, high]));
        let radius = (REACH * 0.5 * (high - low).length()).max(f32::MIN_POSITIVE);
        let corner = |i: u32| {
            let (sin, cos) = (TAU * i as f32 / CORNERS as f32).sin_cos();
            Vec3::new(radius * cos, 0.0, -radius * sin)
        };
        let triangles: Vec<[u32; 3]> =
            (1..=CORNERS).map(|i| [0, i, if i == CORNERS { 1 } else { i + 1 }]).collect();
        self.materials.push(MaterialDescription {
            name: "ground".into(),
            base_color: reflectance.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0),
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            double_sided: true,
            ..Default::default()
        });
        self.meshes.push(MeshDescription {
            name: "ground".into(),
            positions: std::iter::once(Vec3::ZERO).chain((0..CORNERS).map(corner)).collect(),
            triangle_materials: vec![self.materials.len() as u32 - 1; triangles.len()],
            triangles,
            ..Default::default()
        });
        self.instances.push(InstanceDescription {
            name: "ground".into(),
            pointer: String::new(),
            mesh: self.meshes.len() - 1,
            transform: Affine3A::from_translation(center),
        });
    }
}

fn height_below([low, high]: [Vec3; 2]) -> f32 {
    (low.y - GAP * (high - low).max_element()).min(low.y.next_down())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disk_faces_up_and_lies_below_all() {
        let mut scene = SceneDescription::default();
        assert!(!scene.add_ground(Vec3::ONE) && scene.ground_height().is_none());
        scene.meshes.push(MeshDescription {
            positions: vec![Vec3::new(0.0, -0.5, 0.0), Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![u32::MAX],
            ..Default::default()
        });
        scene.instances.push(InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh: 0,
            transform: Affine3A::from_translation(Vec3::new(5.0, 10.0, 0.0)),
        });
        let height = scene.ground_height().unwrap();
        assert!(height < 9.5 && height > 9.49);
        assert!(scene.add_ground(Vec3::splat(0.5)));
        let mesh = &scene.meshes[1];
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).y > 0.0);
        }
        let low = scene.bounds().unwrap()[0];
        assert_eq!(low.y, height);
        assert!(low.x < -100.0);
    }
}
