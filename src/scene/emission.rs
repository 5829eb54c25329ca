//! Emission that varies over a triangle, for sampling lights: textures, and the coverage of alpha.
//!
//! A ray that finds an emitter by chance passes where it is not covered, so light sampling multiplies by the coverage;
//! [`super::Scene::emission`] does not.

use super::texture;
use super::{AlphaMode, MaterialDescription, MeshDescription, SceneDescription, TextureRef};
use crate::light::EmissionField;
use glam::{Vec2, Vec3};
use std::ops::{Add, Mul};
use std::sync::Arc;

/// The emission of a scene's triangles.
pub(super) struct SceneEmission(pub Arc<SceneDescription>);

impl SceneEmission {
    /// Whether the emission of a material varies over its triangles.
    pub fn varies(material: &MaterialDescription) -> bool {
        material.emission_texture.is_some() || material.alpha_mode != AlphaMode::Opaque
    }
}

impl EmissionField for SceneEmission {
    fn radiance(&self, instance: u32, triangle: u32, barycentrics: Vec2) -> Vec3 {
        let scene = &*self.0;
        let mesh = &scene.meshes[scene.instances[instance as usize].mesh];
        let Some(material) = scene.materials.get(mesh.triangle_materials[triangle as usize] as usize) else {
            return Vec3::ZERO;
        };
        let point = Point { mesh, triangle: mesh.triangles[triangle as usize], barycentrics };
        let mut emission = material.emission;
        if let Some(t) = &material.emission_texture {
            emission *= texture::sample(scene, t, point.uv(t)).truncate();
        }
        emission * point.coverage(scene, material)
    }
}

/// A point of a mesh.
struct Point<'a> {
    mesh: &'a MeshDescription,
    triangle: [u32; 3],
    barycentrics: Vec2,
}

impl Point<'_> {
    fn interpolate<T: Copy + Mul<f32, Output = T> + Add<Output = T>>(&self, values: &[T]) -> Option<T> {
        let [a, b, c] = self.triangle.map(|i| values.get(i as usize).copied());
        let Vec2 { x, y } = self.barycentrics;
        Some(a? * (1.0 - x - y) + b? * x + c? * y)
    }

    fn uv(&self, texture: &TextureRef) -> Vec2 {
        self.mesh.uvs.get(texture.uv_set).and_then(|uvs| self.interpolate(uvs)).unwrap_or(Vec2::ZERO)
    }

    fn coverage(&self, scene: &SceneDescription, material: &MaterialDescription) -> f32 {
        if material.alpha_mode == AlphaMode::Opaque {
            return 1.0;
        }
        let mut alpha = material.base_color.w * self.interpolate(&self.mesh.colors).map_or(1.0, |c| c.w);
        if let Some(t) = &material.base_color_texture {
            alpha *= texture::sample(scene, t, self.uv(t)).w;
        }
        match material.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(alpha >= cutoff),
            AlphaMode::Blend => alpha.clamp(0.0, 1.0),
        }
    }
}
