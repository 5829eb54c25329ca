//! A scene as plain data: meshes, materials, textures, instances, cameras and lights, in world units.
//!
//! The loader fills it, tests build it by hand, and the tracer compiles it. Nothing here knows glTF beyond the
//! meaning of its parameters, and nothing here traces a ray. Indices refer to the vectors of [`SceneDescription`].

use std::sync::Arc;

pub use super::image::{ColorSpace, ImageData, ImagePixels, Minify, TextureDescription, TextureRef, Wrap};

use super::{AreaLight, DerivedLimits, Layers, Lens, TurnedWeb};
use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};

/// Everything that can be seen, as plain data.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Geometry, shared by instances.
    pub meshes: Vec<MeshDescription>,
    /// Materials; triangles without one use [`MaterialDescription::default`].
    pub materials: Vec<MaterialDescription>,
    /// Textures: an image with a sampler.
    pub textures: Vec<TextureDescription>,
    /// Decoded images, which several descriptions may share.
    pub images: Vec<Arc<ImageData>>,
    /// Placed meshes. One instance is one *object*: exit points are searched on, and media belong to, an object.
    pub instances: Vec<InstanceDescription>,
    /// Cameras, in the order of the file's node traversal.
    pub cameras: Vec<CameraDescription>,
    /// Point, spot and directional lights.
    pub lights: Vec<PunctualLight>,
    /// Lights with an area that are no mesh.
    pub area_lights: Vec<AreaLight>,
    /// Light from infinitely far away.
    pub environment: EnvironmentDescription,
    /// Where the zero of all positions here is in the world of the file. Single precision counts from here; what is
    /// told of positions adds it. Zero unless the file puts things far away, measured by their size.
    pub origin: DVec3,
    /// How far the ends of open edges of a mesh with a medium may be apart and yet be one, in metres: then they are put
    /// into one place. By default 1e-5 of the largest coordinate of the mesh; 0 for none.
    pub weld_tolerance: Option<f32>,
    /// How much memory what is derived from it may take.
    pub limits: DerivedLimits,
}

/// A triangle mesh in its own space. Attribute vectors are empty where the mesh lacks the attribute, otherwise as
/// long as `positions`.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// Name for messages.
    pub name: String,
    /// JSON pointer of the source, for messages.
    pub pointer: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals; empty means flat shading.
    pub normals: Vec<Vec3>,
    /// Unit tangents and the sign of the bitangent in `w`; empty where no normal map needs them.
    pub tangents: Vec<Vec4>,
    /// Texture coordinate sets.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear vertex colours.
    pub colors: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle ([`NO_MATERIAL`] for the default), as long as `triangles`.
    pub triangle_materials: Vec<u32>,
    /// The triangles by vertices of which those that are one have been merged, as long as `triangles`; every edge then
    /// has two triangles of opposite direction. Empty where equal positions are to be taken for one vertex.
    pub merged: Vec<[u32; 3]>,
}

/// The material index of a triangle that names no material.
pub const NO_MATERIAL: u32 = u32::MAX;

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Name for messages (the node's).
    pub name: String,
    /// JSON pointer of the node.
    pub pointer: String,
    /// Index of the mesh.
    pub mesh: usize,
    /// Mesh space to world space; any invertible affine map, mirrored ones included.
    pub transform: Affine3A,
}

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Present where alpha ≥ cutoff.
    Mask(f32),
    /// Coverage: a fraction alpha of the light meets the surface.
    Blend,
}

/// A material: the glTF metallic-roughness model, a transmissive boundary, what is below it and what is on top.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// Name for messages.
    pub name: String,
    /// JSON pointer of the source, for messages.
    pub pointer: String,
    /// Linear base colour and alpha.
    pub base_color: Vec4,
    /// Multiplies `base_color`.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness; GGX alpha is its square.
    pub roughness: f32,
    /// Multiplies roughness (G) and metallic (B).
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the x and y of `normal_texture`.
    pub normal_scale: f32,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Multiplies `emission`.
    pub emission_texture: Option<TextureRef>,
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
    /// Shaded and emitting on both sides.
    pub double_sided: bool,
    /// KHR_materials_unlit: the base colour is what the camera sees.
    pub unlit: bool,
    /// What an [`AreaLight`] is made of: from behind it is not there, and the camera does not see it straight.
    pub area_light: bool,
    /// Index of refraction of the boundary.
    pub ior: f32,
    /// Strength of the dielectric specular reflection (KHR_materials_specular's factor; 1 without it).
    pub specular: f32,
    /// Colour of the dielectric reflection at normal incidence (KHR_materials_specular; white without it).
    pub specular_color: Vec3,
    /// Multiplies `specular` (A).
    pub specular_texture: Option<TextureRef>,
    /// Multiplies `specular_color` (RGB).
    pub specular_color_texture: Option<TextureRef>,
    /// Fraction of the non-reflected light that goes through instead of to the diffuse base.
    pub transmission: f32,
    /// Multiplies `transmission` (R).
    pub transmission_texture: Option<TextureRef>,
    /// The medium inside; `None` with `transmission > 0` is a thin wall that does not refract.
    pub medium: Option<MediumDescription>,
    /// KHR_materials_pbrSpecularGlossiness: with it the roughness is 1 − (1 − `roughness`) · A.
    pub glossiness_texture: Option<TextureRef>,
    /// Layers on top, and other shapes of the lobes.
    pub layers: Option<Box<Layers>>,
}

impl Default for MaterialDescription {
    fn default() -> Self {
        Self {
            name: String::new(),
            pointer: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            area_light: false,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            specular_texture: None,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            medium: None,
            glossiness_texture: None,
            layers: None,
        }
    }
}

impl MaterialDescription {
    /// Every place that refers to a texture, those of the medium included.
    pub fn texture_slots_mut(&mut self) -> impl Iterator<Item = &mut Option<TextureRef>> {
        let medium = self.medium.iter_mut().flat_map(MediumDescription::texture_slots_mut);
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.emission_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
            &mut self.glossiness_texture,
        ]
        .into_iter()
        .chain(medium)
        .chain(self.layers.iter_mut().flat_map(|l| l.texture_slots_mut()))
    }

    /// Every texture in use, those of the medium included.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        let medium = self.medium.iter().flat_map(MediumDescription::texture_slots);
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.emission_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
            &self.glossiness_texture,
        ]
        .into_iter()
        .chain(medium)
        .flatten()
        .chain(self.layers.iter().flat_map(|l| l.textures()))
    }
}

/// What fills the inside of a closed mesh: coefficients per world metre, before textures.
#[derive(Clone, Debug)]
pub struct MediumDescription {
    /// Absorption coefficient, 1/m, ≥ 0 (density already multiplied in).
    pub sigma_a: Vec3,
    /// Scattering coefficient, 1/m, ≥ 0 (density already multiplied in).
    pub sigma_s: Vec3,
    /// Mean cosine of Henyey–Greenstein, in (−1, 1).
    pub anisotropy: f32,
    /// Index of refraction of the medium and its boundary, ≥ 1.
    pub ior: f32,
    /// Where closed meshes overlap, the higher priority fills the overlap.
    pub priority: i32,
    /// Multiplies `sigma_a` at the nearest boundary point.
    pub absorption_texture: Option<TextureRef>,
    /// Multiplies `sigma_s` at the nearest boundary point.
    pub scattering_texture: Option<TextureRef>,
    /// Splits the extinction `sigma_a + sigma_s` anew at the nearest boundary point, instead of those two textures.
    pub multi_scatter: Option<Box<MultiScatter>>,
}

/// A medium of the Khronos drafts whose albedo comes from textures: extinction is the same everywhere, and how much of it
/// scatters follows from the multi-scatter albedo ρ at each place.
#[derive(Clone, Debug)]
pub struct MultiScatter {
    /// ρ before textures, which are at most 1.
    pub rho: Vec3,
    /// The anisotropy in the step from ρ to the single-scattering albedo.
    pub mapping_anisotropy: f32,
    /// Its alpha multiplies ρ.
    pub strength_texture: Option<TextureRef>,
    /// Its colour multiplies ρ.
    pub color_texture: Option<TextureRef>,
}

impl MediumDescription {
    /// Whether coefficients come from textures.
    pub fn is_textured(&self) -> bool {
        self.texture_slots().any(Option::is_some)
    }

    /// Every place that may refer to a texture.
    pub fn texture_slots(&self) -> impl Iterator<Item = &Option<TextureRef>> {
        let split = self.multi_scatter.iter().flat_map(|m| [&m.strength_texture, &m.color_texture]);
        [&self.absorption_texture, &self.scattering_texture].into_iter().chain(split)
    }

    fn texture_slots_mut(&mut self) -> impl Iterator<Item = &mut Option<TextureRef>> {
        let split =
            self.multi_scatter.iter_mut().flat_map(|m| [&mut m.strength_texture, &mut m.color_texture]);
        [&mut self.absorption_texture, &mut self.scattering_texture].into_iter().chain(split)
    }
}

/// A camera: looks along −Z of its own frame, +Y up.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// Name (the camera's, else the node's).
    pub name: String,
    /// Camera to world, rotation and translation only.
    pub transform: Affine3A,
    /// Lens.
    pub projection: Projection,
    /// Between which depths it sees.
    pub clip: Clip,
    /// The lens that it stands for, if its file says; without one it is a pinhole.
    pub lens: Option<Lens>,
}

/// The planes, perpendicular to the view, between which a camera sees (`znear` and `zfar` of glTF), metres from the eye.
///
/// They bound what is seen straight, also through alpha and clear media without contrast; reflections, refractions and
/// shadows know nothing of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Where camera rays start. Below 0, behind the eye, only for parallel rays.
    pub near: f32,
    /// Beyond it only the environment is seen; above `near`.
    pub far: f32,
}

impl Clip {
    /// All that is before the eye is seen.
    pub const NONE: Self = Self { near: 0.0, far: f32::INFINITY };
}

impl Default for Clip {
    fn default() -> Self {
        Self::NONE
    }
}

/// A camera's lens. The image's own aspect ratio sets the horizontal extent.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Pinhole with a full vertical field of view in radians.
    Perspective {
        /// Full vertical angle, radians, in (0, π).
        yfov: f32,
        /// The file's own aspect ratio, if it gave one (a hint for the default image size).
        aspect: Option<f32>,
    },
    /// Parallel rays; `ymag` is half the height of the view in metres.
    Orthographic {
        /// Half height, metres.
        ymag: f32,
        /// The file's `xmag / ymag` (a hint for the default image size).
        aspect: Option<f32>,
    },
}

/// A light without size, in the units of KHR_lights_punctual.
#[derive(Clone, Debug)]
pub struct PunctualLight {
    /// Name for messages.
    pub name: String,
    /// Linear colour × intensity: candela for point and spot, lux for directional; the largest candela of a web.
    pub intensity: Vec3,
    /// World position (all but directional).
    pub position: Vec3,
    /// Unit world direction in which the light shines (all but point).
    pub direction: Vec3,
    /// Distance beyond which a point or spot light has no effect (KHR_lights_punctual's windowed fall-off).
    pub range: Option<f32>,
    /// Which kind.
    pub kind: PunctualKind,
}

/// The kinds of punctual light.
#[derive(Clone, Debug, PartialEq)]
pub enum PunctualKind {
    /// All directions.
    Point,
    /// A cone, angles in radians from the axis.
    Spot {
        /// Full strength inside.
        inner: f32,
        /// Nothing outside.
        outer: f32,
    },
    /// Parallel light.
    Directional,
    /// As a luminaire was measured (EXT_lights_ies).
    Web(Arc<TurnedWeb>),
}

/// Light from infinitely far away.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    /// The same radiance from everywhere (zero for none).
    Constant(Vec3),
    /// An equirectangular map: u = atan2(d.z, d.x)/2π + ½, v = ½ + asin(d.y)/π from the bottom; row 0 is the top.
    Map {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Linear radiance, `width * height`.
        pixels: Vec<Vec3>,
        /// Multiplies the radiance.
        scale: Vec3,
        /// Rotation of the map about +Y, radians.
        rotation: f32,
    },
}

impl Default for EnvironmentDescription {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}
