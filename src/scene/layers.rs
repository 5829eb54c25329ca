//! What a material may have beyond metallic-roughness and a refracting boundary: layers on top of it, and other shapes of
//! its lobes. Most materials have none of it, so it is kept apart from what every hit reads.

use super::{AlphaMode, MaterialDescription, TextureRef};
use glam::{Mat2, Vec3};

/// Everything optional about a surface. `None` is as if the extension were not there.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// KHR_materials_clearcoat, or KHR_materials_coat, which takes its place.
    pub coat: Option<Coat>,
    /// KHR_materials_fuzz.
    pub fuzz: Option<Fuzz>,
    /// KHR_materials_sheen.
    pub sheen: Option<Sheen>,
    /// KHR_materials_anisotropy.
    pub anisotropy: Option<Anisotropy>,
    /// KHR_materials_iridescence.
    pub iridescence: Option<Iridescence>,
    /// KHR_materials_diffuse_transmission.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// KHR_materials_scatter of a thin wall.
    pub thin_scatter: Option<ThinScatter>,
    /// KHR_materials_diffuse_roughness.
    pub diffuse_roughness: Option<DiffuseRoughness>,
    /// KHR_materials_dispersion: 20 over the Abbe number of the medium, ≥ 0; 0 for none.
    pub dispersion: f32,
}

/// A dielectric coat.
#[derive(Clone, Debug)]
pub struct Coat {
    /// What `inspect` calls it: `clearcoat` or `coat`.
    pub name: &'static str,
    /// Strength, \[0, 1\].
    pub factor: f32,
    /// Multiplies `factor` (R).
    pub texture: Option<TextureRef>,
    /// Perceptual roughness, \[0, 1\].
    pub roughness: f32,
    /// Multiplies `roughness` (G).
    pub roughness_texture: Option<TextureRef>,
    /// Tangent-space normals of the coat; without it the coat has the interpolated normal, not that of the base.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the x and y of `normal_texture`.
    pub normal_scale: f32,
    /// Index of refraction, ≥ 1; 1.5 of a clear coat.
    pub ior: f32,
    /// Linear colour of white seen through the coat at normal incidence, \[0, 1\].
    pub color: Vec3,
    /// Multiplies `color` (RGB).
    pub color_texture: Option<TextureRef>,
    /// How much of the darkening by reflections inside of the coat is there, \[0, 1\]; 0 of a clear coat.
    pub darkening: f32,
    /// Microfacets of the coat that are rougher along one tangent.
    pub anisotropy: Option<Anisotropy>,
}

/// A layer of fibres or dust on top of everything.
#[derive(Clone, Debug)]
pub struct Fuzz {
    /// Share of the surface that it covers, \[0, 1\].
    pub factor: f32,
    /// Multiplies `factor` (R).
    pub texture: Option<TextureRef>,
    /// Linear colour, \[0, 1\].
    pub color: Vec3,
    /// Multiplies `color` (RGB).
    pub color_texture: Option<TextureRef>,
    /// 0 upright fibres, 1 dust.
    pub roughness: f32,
    /// Multiplies `roughness` (A).
    pub roughness_texture: Option<TextureRef>,
}

/// Diffuse microfacets.
#[derive(Clone, Debug)]
pub struct DiffuseRoughness {
    /// 0 is Lambert's law; \[0, 1\].
    pub factor: f32,
    /// Multiplies `factor` (R).
    pub texture: Option<TextureRef>,
}

/// Fibres that stand on the surface.
#[derive(Clone, Debug)]
pub struct Sheen {
    /// Linear colour, \[0, 1\].
    pub color: Vec3,
    /// Multiplies `color` (RGB).
    pub color_texture: Option<TextureRef>,
    /// How far the fibres lean, \[0, 1\].
    pub roughness: f32,
    /// Multiplies `roughness` (A).
    pub roughness_texture: Option<TextureRef>,
}

/// Microfacets that are rougher along one tangent.
#[derive(Clone, Debug)]
pub struct Anisotropy {
    /// Strength, \[0, 1\].
    pub strength: f32,
    /// From the tangent, counter-clockwise, radians.
    pub rotation: f32,
    /// Direction (RG, −1 to 1 as 0 to 1) and strength (B).
    pub texture: Option<TextureRef>,
}

/// A thin film on the surface.
#[derive(Clone, Debug)]
pub struct Iridescence {
    /// Strength, \[0, 1\].
    pub factor: f32,
    /// Multiplies `factor` (R).
    pub texture: Option<TextureRef>,
    /// Index of refraction of the film, ≥ 1.
    pub ior: f32,
    /// Thickness where `thickness_texture` is 0 and 1, nanometres.
    pub thickness: [f32; 2],
    /// Blends the two thicknesses (G); without it the second counts.
    pub thickness_texture: Option<TextureRef>,
}

/// Light that comes out on the other side in all directions.
#[derive(Clone, Debug)]
pub struct DiffuseTransmission {
    /// Share of the diffuse light that is transmitted, \[0, 1\].
    pub factor: f32,
    /// Multiplies `factor` (A).
    pub texture: Option<TextureRef>,
    /// Linear colour of the transmitted light, \[0, 1\].
    pub color: Vec3,
    /// Multiplies `color` (RGB).
    pub color_texture: Option<TextureRef>,
}

/// What a thin wall scatters of the light that it would transmit.
#[derive(Clone, Debug)]
pub struct ThinScatter {
    /// Share that is scattered, \[0, 1\].
    pub strength: f32,
    /// Multiplies `strength` (A).
    pub strength_texture: Option<TextureRef>,
    /// Linear colour of the scattered light, \[0, 1\].
    pub color: Vec3,
    /// Multiplies `color` (RGB).
    pub color_texture: Option<TextureRef>,
    /// (1 + g)/2 of the scattered light goes on, (1 − g)/2 comes back; in \[−1, 1\].
    pub anisotropy: f32,
}

impl Layers {
    /// Every place that refers to a texture.
    pub fn texture_slots_mut(&mut self) -> impl Iterator<Item = &mut Option<TextureRef>> {
        let coat = self.coat.iter_mut().flat_map(|c| {
            let own = [&mut c.texture, &mut c.roughness_texture, &mut c.normal_texture, &mut c.color_texture];
            own.into_iter().chain(c.anisotropy.iter_mut().map(|a| &mut a.texture))
        });
        let fuzz = self
            .fuzz
            .iter_mut()
            .flat_map(|f| [&mut f.texture, &mut f.color_texture, &mut f.roughness_texture]);
        let rough = self.diffuse_roughness.iter_mut().map(|d| &mut d.texture);
        let sheen = self.sheen.iter_mut().flat_map(|s| [&mut s.color_texture, &mut s.roughness_texture]);
        let anisotropy = self.anisotropy.iter_mut().map(|a| &mut a.texture);
        let film = self.iridescence.iter_mut().flat_map(|i| [&mut i.texture, &mut i.thickness_texture]);
        let diffuse =
            self.diffuse_transmission.iter_mut().flat_map(|d| [&mut d.texture, &mut d.color_texture]);
        let thin = self.thin_scatter.iter_mut().flat_map(|t| [&mut t.strength_texture, &mut t.color_texture]);
        coat.chain(fuzz).chain(sheen).chain(anisotropy).chain(film).chain(diffuse).chain(thin).chain(rough)
    }

    /// Names of what is there.
    pub fn names(&self) -> Vec<&'static str> {
        let all = [
            (self.fuzz.is_some(), "fuzz"),
            (self.coat.is_some(), self.coat.as_ref().map_or("coat", |c| c.name)),
            (self.sheen.is_some(), "sheen"),
            (self.anisotropy.is_some(), "anisotropy"),
            (self.iridescence.is_some(), "iridescence"),
            (self.diffuse_transmission.is_some(), "diffuse transmission"),
            (self.thin_scatter.is_some(), "thin scattering"),
            (self.diffuse_roughness.is_some(), "diffuse roughness"),
            (self.dispersion > 0.0, "dispersion"),
        ];
        all.into_iter().filter(|(there, _)| *there).map(|(_, name)| name).collect()
    }

    /// Every texture in use.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        let coat = self.coat.iter().flat_map(|c| {
            let own = [&c.texture, &c.roughness_texture, &c.normal_texture, &c.color_texture];
            own.into_iter().chain(c.anisotropy.iter().map(|a| &a.texture))
        });
        let fuzz = self.fuzz.iter().flat_map(|f| [&f.texture, &f.color_texture, &f.roughness_texture]);
        let rough = self.diffuse_roughness.iter().map(|d| &d.texture);
        let sheen = self.sheen.iter().flat_map(|s| [&s.color_texture, &s.roughness_texture]);
        let anisotropy = self.anisotropy.iter().map(|a| &a.texture);
        let film = self.iridescence.iter().flat_map(|i| [&i.texture, &i.thickness_texture]);
        let diffuse = self.diffuse_transmission.iter().flat_map(|d| [&d.texture, &d.color_texture]);
        let thin = self.thin_scatter.iter().flat_map(|t| [&t.strength_texture, &t.color_texture]);
        let below = anisotropy.chain(film).chain(diffuse).chain(thin).chain(rough);
        coat.chain(fuzz).chain(sheen).chain(below).flatten()
    }
}

impl MaterialDescription {
    /// The layers, made if there were none.
    pub fn layers_mut(&mut self) -> &mut Layers {
        self.layers.get_or_insert_default()
    }

    /// The set of texture coordinates that tells the direction of tangents, and the linear part of the transform that the
    /// texture applies to it; `None` where nothing needs tangents.
    pub fn tangent_uvs(&self) -> Option<(usize, Mat2)> {
        let uvs = |t: &Option<TextureRef>| t.as_ref().map(|t| (t.uv_set, t.transform.matrix2));
        let layers = self.layers.as_ref();
        let coat = || layers.and_then(|l| uvs(&l.coat.as_ref()?.normal_texture));
        let of = |a: &Anisotropy| uvs(&a.texture).unwrap_or((0, Mat2::IDENTITY));
        let brushed = || layers.and_then(|l| l.anisotropy.as_ref().map(of));
        let brushed_coat = || layers.and_then(|l| l.coat.as_ref()?.anisotropy.as_ref().map(of));
        uvs(&self.normal_texture).or_else(coat).or_else(brushed).or_else(brushed_coat)
    }

    /// Whether light can come through the surface, other than by alpha.
    pub fn is_see_through(&self) -> bool {
        let diffuse = || self.layers.as_ref()?.diffuse_transmission.as_ref().filter(|d| d.factor > 0.0);
        self.transmission > 0.0 || diffuse().is_some()
    }

    /// Whether a path that meets a side of the surface passes it as if it were not there: an area light from behind, or as
    /// what the camera sees straight.
    #[inline]
    pub fn is_absent(&self, front: bool, direct_view: bool) -> bool {
        self.area_light && (direct_view || !front)
    }

    /// Whether nothing behind the surface can be seen through it: no blending, no transmission, no medium.
    pub fn is_opaque(&self) -> bool {
        self.alpha_mode != AlphaMode::Blend && !self.is_see_through() && self.medium.is_none()
    }

    /// 20 over the Abbe number; 0 where all wavelengths refract alike.
    pub fn dispersion(&self) -> f32 {
        self.layers.as_ref().map_or(0.0, |l| l.dispersion)
    }
}
