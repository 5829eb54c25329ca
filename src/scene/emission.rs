//! Emission that varies over a triangle, for sampling lights: textures, the coverage of alpha, and a clear coat.
//!
//! A coat lies on top of the emission and dims it by what it reflects, 1 − c (f0 + (1 − f0)(1 − |cos θ|)⁵), f0 = 0.04 for
//! KHR_materials_clearcoat; a coloured one colours it as light that passes once. Fuzz, on top of that, holds back its share.
//! θ is the angle with the triangle's normal, so that whoever finds the light, by sampling it or by chance, finds the same.
//!
//! A ray that finds an emitter by chance passes where it is not covered, so light sampling multiplies by the coverage;
//! [`Scene::emission`] does not.

use super::layers::Layers;
use super::texture;
use super::{AlphaMode, MaterialDescription, MeshDescription, Scene, SceneDescription, Surface, TextureRef};
use crate::light::EmissionField;
use crate::optics::{self, fresnel};
use glam::{Vec2, Vec3, Vec4};
use std::ops::{Add, Mul};
use std::sync::Arc;

/// The emission of a scene's triangles.
pub(super) struct SceneEmission(pub Arc<SceneDescription>);

impl SceneEmission {
    /// Whether the emission of a material varies over its triangles.
    pub fn varies(material: &MaterialDescription) -> bool {
        material.emission_texture.is_some()
            || material.alpha_mode != AlphaMode::Opaque
            || material.layers.as_ref().is_some_and(|l| l.coat.is_some() || l.fuzz.is_some())
    }
}

/// What layers let pass at a cosine; `read` looks a texture up.
fn passed(layers: &Layers, cos: f32, read: impl Fn(&TextureRef) -> Vec4) -> Vec3 {
    let texel = |t: &Option<TextureRef>| t.as_ref().map_or(Vec4::ONE, &read);
    let mut passed = Vec3::ONE;
    if let Some(coat) = &layers.coat {
        let f0 = fresnel::f0_from_eta(coat.ior);
        let reflected = f0 + (1.0 - f0) * fresnel::schlick_weight(cos);
        let color = coat.color * texel(&coat.color_texture).truncate();
        let strength = (coat.factor * texel(&coat.texture).x).clamp(0.0, 1.0);
        let crossed = (1.0 - reflected) * optics::crossing(coat.ior, color, cos);
        passed += strength * (crossed - Vec3::ONE);
    }
    if let Some(fuzz) = &layers.fuzz {
        let weight = fuzz.factor * texel(&fuzz.texture).x;
        let roughness = fuzz.roughness * texel(&fuzz.roughness_texture).w;
        passed *= 1.0 - optics::Fuzz::new(weight, Vec3::ONE, roughness).held(cos);
    }
    passed
}

impl Scene {
    /// Radiance that a surface emits to its front, towards the unit vector `direction`.
    pub fn emission(&self, surface: &Surface, direction: Vec3) -> Vec3 {
        let material = self.material(surface.material);
        let mut emission = material.emission;
        if let Some(t) = &material.emission_texture {
            emission *= surface.color_texture(self, t, material.alpha_mode).truncate();
        }
        if let Some(layers) = &material.layers {
            let cos = surface.geometric_normal.dot(direction).abs();
            emission *= passed(layers, cos, |t| surface.texture(self, t));
        }
        emission
    }
}

impl EmissionField for SceneEmission {
    fn radiance(&self, instance: u32, triangle: u32, barycentrics: Vec2, cos: f32) -> Vec3 {
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
        if let Some(layers) = &material.layers {
            emission *= passed(layers, cos, |t| texture::sample(scene, t, point.uv(t)));
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
