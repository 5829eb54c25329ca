//! A material at a point: its textures read, and the scattering function they make.

use super::layering::Layering;
use super::{MaterialDescription, Scene, Surface};
use crate::optics::{Bsdf, DielectricBoundary, Microfacet, Mixed, Surface as Opaque, SurfaceParameters};
use glam::{Vec3, Vec4};

/// The parameters of a material at one surface point.
#[derive(Clone, Copy, Debug)]
pub struct Shading<'a> {
    material: &'a MaterialDescription,
    /// Base colour, without alpha.
    pub base_color: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// GGX width, the square of the roughness.
    pub alpha: f32,
    /// Fraction of the non-reflected light that is transmitted.
    pub transmission: f32,
    /// Strength and colour of the dielectric reflection.
    pub(super) specular: f32,
    pub(super) specular_color: Vec3,
    /// Layers and other shapes of lobes, where there are any.
    pub(super) layering: Option<Layering>,
    /// Shading normal, to the geometric front.
    pub normal: Vec3,
}

impl<'a> Shading<'a> {
    /// Reads the textures of the material at a point.
    pub fn new(scene: &'a Scene, surface: &Surface) -> Self {
        let material = scene.material(surface.material);
        let (mut metallic, mut roughness) = (material.metallic, material.roughness);
        if let Some(t) = &material.metallic_roughness_texture {
            let texel = surface.texture(scene, t);
            roughness *= texel.y;
            metallic *= texel.z;
        }
        if let Some(t) = &material.glossiness_texture {
            roughness = 1.0 - (1.0 - roughness) * surface.texture(scene, t).w;
        }
        let (mut specular, mut specular_color) = (material.specular, material.specular_color);
        if let Some(t) = &material.specular_texture {
            specular *= surface.texture(scene, t).w;
        }
        if let Some(t) = &material.specular_color_texture {
            specular_color *= surface.texture(scene, t).truncate();
        }
        let mut transmission = material.transmission;
        if let Some(t) = &material.transmission_texture {
            transmission *= surface.texture(scene, t).x;
        }
        let normal = match &material.normal_texture {
            Some(t) => surface.mapped_normal(scene, t, material.normal_scale),
            None => surface.normal,
        };
        Self {
            material,
            base_color: scene.base_color(surface).truncate(),
            metallic: metallic.clamp(0.0, 1.0),
            alpha: (roughness * roughness).clamp(0.0, 1.0),
            transmission: transmission.clamp(0.0, 1.0),
            specular,
            specular_color,
            layering: material.layers.as_ref().map(|l| Layering::new(scene, surface, l, normal)),
            normal,
        }
    }
}

impl Scene {
    /// Base colour and alpha at a point, vertex colours included.
    pub fn base_color(&self, surface: &Surface) -> Vec4 {
        let material = self.material(surface.material);
        let mut color = material.base_color * surface.color(self);
        if let Some(t) = &material.base_color_texture {
            color *= surface.color_texture(self, t, material.alpha_mode);
        }
        color.clamp(Vec4::ZERO, Vec4::ONE)
    }

    /// Coverage at a point.
    pub fn alpha(&self, surface: &Surface) -> f32 {
        let material = self.material(surface.material);
        if material.alpha_mode == super::AlphaMode::Opaque {
            return 1.0;
        }
        self.base_color(surface).w
    }

    /// What a boundary between equal indices lets through in a straight line.
    pub fn straight_transmission(&self, surface: &Surface) -> Vec3 {
        let shading = Shading::new(self, surface);
        shading.base_color * ((1.0 - shading.metallic) * shading.transmission)
    }

    /// Whether no part of a boundary is opaque.
    pub fn transmits_all(&self, surface: &Surface) -> bool {
        let shading = Shading::new(self, surface);
        shading.metallic <= 0.0 && shading.transmission >= 1.0
    }

    /// Whether a boundary between equal indices does nothing at all to light.
    pub fn is_clear(&self, surface: &Surface) -> bool {
        self.straight_transmission(surface) == Vec3::ONE
    }
}

impl Shading<'_> {
    /// The scattering function; `eta` is the index inside over outside.
    pub fn bsdf(&self, eta: f32, boundary: bool, microfacet: Microfacet) -> Bsdf {
        if self.layering.is_some() || (boundary && self.is_specular_treated()) {
            return Bsdf::Layered(Box::new(self.layered(eta, boundary, microfacet)));
        }
        if !boundary {
            return Bsdf::Surface(Opaque::new(&self.parameters(
                self.metallic,
                self.transmission,
                microfacet,
            )));
        }
        let interface =
            DielectricBoundary::new(eta, self.alpha, microfacet).with_transmission_tint(self.base_color);
        let (share, metallic) = Mixed::division(self.metallic, self.transmission);
        if share >= 1.0 {
            return Bsdf::Boundary(interface);
        }
        let opaque = Opaque::new(&self.parameters(metallic, 0.0, microfacet));
        Bsdf::Mixed(Mixed::new(interface, opaque, share))
    }

    /// Whether KHR_materials_specular changes the reflection.
    pub(super) fn is_specular_treated(&self) -> bool {
        self.specular != 1.0 || self.specular_color != Vec3::ONE
    }

    pub(super) fn parameters(
        &self,
        metallic: f32,
        transmission: f32,
        microfacet: Microfacet,
    ) -> SurfaceParameters {
        SurfaceParameters {
            base_color: self.base_color,
            metallic,
            alpha: self.alpha,
            ior: self.material.ior,
            specular: self.specular,
            specular_color: self.specular_color,
            transmission,
            microfacet,
        }
    }
}
