//! The scattering function of a material with layers, or with lobes of another shape: textures of
//! [`super::layers::Layers`] read, and the parts put together.

use super::layers::{Anisotropy, Coat as Coating, Fuzz as Fuzzy, Iridescence, Layers, Sheen};
use super::material::Shading;
use super::{Scene, Surface, TextureRef};
use crate::optics::{
    Base, Coat, CoatParameters, DielectricBoundary, Facets, Fuzz, Layered, Microfacet, Mixed,
    Sheen as Fibres, Stack, Substrate, SubstrateParameters, ThinFilm, TreatedBoundary,
};
use glam::{Vec2, Vec3, Vec4};

/// The parameters of layers at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layering {
    coat: Option<PlacedCoat>,
    fuzz: Option<PlacedFuzz>,
    sheen: Option<(Vec3, f32)>,
    /// Strength, and direction in world space.
    anisotropy: Option<(f32, Vec3)>,
    /// Share, index, thickness in nanometres.
    film: Option<(f32, f32, f32)>,
    diffuse_transmission: (f32, Vec3),
    scatter: (f32, Vec3, f32),
    diffuse_roughness: f32,
}

/// A coat with its normal and the direction along which it is rougher, in world space.
#[derive(Clone, Copy, Debug)]
struct PlacedCoat {
    parameters: CoatParameters,
    normal: Vec3,
    tangent: Option<Vec3>,
}

/// Weight, colour, roughness and normal of fuzz.
#[derive(Clone, Copy, Debug)]
struct PlacedFuzz {
    weight: f32,
    color: Vec3,
    roughness: f32,
    normal: Vec3,
}

/// Nothing beside the plain surface.
const NONE: Layering = Layering {
    coat: None,
    fuzz: None,
    sheen: None,
    anisotropy: None,
    film: None,
    diffuse_transmission: (0.0, Vec3::ONE),
    scatter: (0.0, Vec3::ONE, 1.0),
    diffuse_roughness: 0.0,
};

impl Layering {
    /// Reads the textures at a point.
    pub fn new(scene: &Scene, surface: &Surface, layers: &Layers, normal: Vec3) -> Self {
        let texel = |t: &Option<TextureRef>| t.as_ref().map_or(Vec4::ONE, |t| surface.texture(scene, t));
        let diffuse = layers.diffuse_transmission.as_ref();
        let thin = layers.thin_scatter.as_ref();
        let unit = |x: f32| x.clamp(0.0, 1.0);
        let coat = layers.coat.as_ref().map(|c| coat(scene, surface, c));
        let coat = coat.filter(|c| c.parameters.weight > 0.0);
        let fuzz = layers.fuzz.as_ref().map(|f| fuzz(scene, surface, f, normal, coat.as_ref()));
        Self {
            coat,
            fuzz: fuzz.filter(|f| f.weight > 0.0),
            sheen: layers.sheen.as_ref().map(|s: &Sheen| {
                let color = s.color * texel(&s.color_texture).truncate();
                (color, unit(s.roughness * texel(&s.roughness_texture).w))
            }),
            anisotropy: layers.anisotropy.as_ref().and_then(|a| brushed(scene, surface, a, normal)),
            film: layers.iridescence.as_ref().map(|i: &Iridescence| {
                let share = unit(i.factor * texel(&i.texture).x);
                let t = texel(&i.thickness_texture).y;
                (share, i.ior, i.thickness[0] + t * (i.thickness[1] - i.thickness[0]))
            }),
            diffuse_transmission: diffuse.map_or((0.0, Vec3::ONE), |d| {
                (unit(d.factor * texel(&d.texture).w), d.color * texel(&d.color_texture).truncate())
            }),
            scatter: thin.map_or((0.0, Vec3::ONE, 1.0), |t| {
                let strength = unit(t.strength * texel(&t.strength_texture).w);
                let color = t.color * texel(&t.color_texture).truncate();
                (strength, color, 0.5 * (1.0 + t.anisotropy))
            }),
            diffuse_roughness: layers
                .diffuse_roughness
                .as_ref()
                .map_or(0.0, |d| unit(d.factor * texel(&d.texture).x)),
        }
    }
}

fn coat(scene: &Scene, surface: &Surface, c: &Coating) -> PlacedCoat {
    let read = |t: &Option<TextureRef>| t.as_ref().map_or(Vec4::ONE, |t| surface.texture(scene, t));
    let roughness = c.roughness * read(&c.roughness_texture).y;
    let normal = match &c.normal_texture {
        Some(t) => surface.mapped_normal(scene, t, c.normal_scale),
        None => surface.normal,
    };
    let brushed = c.anisotropy.as_ref().and_then(|a| brushed(scene, surface, a, normal));
    let brushed = brushed.filter(|b| b.0 > 0.0);
    let parameters = CoatParameters {
        weight: (c.factor * read(&c.texture).x).clamp(0.0, 1.0),
        alpha: widths((roughness * roughness).clamp(0.0, 1.0), brushed.map_or(0.0, |b| b.0)),
        ior: c.ior,
        color: c.color * read(&c.color_texture).truncate(),
        darkening: c.darkening,
    };
    PlacedCoat { parameters, normal, tangent: brushed.map(|b| b.1) }
}

/// Fuzz has the normal of what is below, between those of the base and of a coat by the weight of the coat.
fn fuzz(scene: &Scene, surface: &Surface, f: &Fuzzy, normal: Vec3, coat: Option<&PlacedCoat>) -> PlacedFuzz {
    let read = |t: &Option<TextureRef>| t.as_ref().map_or(Vec4::ONE, |t| surface.texture(scene, t));
    PlacedFuzz {
        weight: (f.factor * read(&f.texture).x).clamp(0.0, 1.0),
        color: f.color * read(&f.color_texture).truncate(),
        roughness: (f.roughness * read(&f.roughness_texture).w).clamp(0.0, 1.0),
        normal: coat.map_or(normal, |c| normal.lerp(c.normal, c.parameters.weight).normalize_or(normal)),
    }
}

/// GGX widths along and across the brushing, of the width without it and a strength.
fn widths(alpha: f32, strength: f32) -> Vec2 {
    let along = alpha + (1.0 - alpha) * strength * strength;
    // A mirror that is rough one way only has no finite density.
    const LEAST_ACROSS: f32 = 1.1e-3;
    let across = if strength > 0.0 { alpha.max(LEAST_ACROSS) } else { alpha };
    Vec2::new(along.max(across), across)
}

/// Strength and world direction of the rougher tangent; `None` where there are no tangents.
fn brushed(scene: &Scene, surface: &Surface, a: &Anisotropy, normal: Vec3) -> Option<(f32, Vec3)> {
    let (tangent, bitangent) = surface.tangents(scene, normal)?;
    let texel = a.texture.as_ref().map_or(Vec3::new(1.0, 0.5, 1.0), |t| surface.texture(scene, t).truncate());
    let direction = (texel.truncate() * 2.0 - Vec2::ONE).normalize_or(Vec2::X);
    let turned = Vec2::from_angle(a.rotation).rotate(direction);
    Some(((a.strength * texel.z).clamp(0.0, 1.0), tangent * turned.x + bitangent * turned.y))
}

impl Shading<'_> {
    /// The scattering function with all its layers; as [`Shading::bsdf`]. It is to be placed in its frame.
    pub(super) fn layered(&self, eta: f32, boundary: bool, microfacet: Microfacet) -> Layered {
        let l = self.layering.unwrap_or(NONE);
        let stack = Stack {
            fuzz: l.fuzz.map(|f| Fuzz::new(f.weight, f.color, f.roughness)),
            coat: l.coat.map(|c| Coat::with(&c.parameters)),
            sheen: l.sheen.filter(|s| s.0 != Vec3::ZERO).map(|(color, r)| Fibres::new(color, r)),
        };
        let (base, rest) = if boundary { self.boundary(&l, eta, microfacet) } else { (None, None) };
        let base = base.unwrap_or_else(|| self.opaque(&l, self.metallic, self.transmission, eta, microfacet));
        let rest = rest.map(|(metallic, share)| (self.opaque(&l, metallic, 0.0, eta, microfacet), share));
        let mut layered = Layered::stacked(stack, base, rest);
        if let Some((_, tangent)) = l.anisotropy.filter(|a| a.0 > 0.0) {
            layered = layered.with_tangent(tangent);
        }
        if let Some(coat) = l.coat {
            if coat.normal != self.normal {
                layered = layered.with_coat_normal(coat.normal);
            }
            if let Some(tangent) = coat.tangent {
                layered = layered.with_coat_tangent(tangent);
            }
        }
        match l.fuzz {
            Some(fuzz) if fuzz.normal != self.normal => layered.with_fuzz_normal(fuzz.normal),
            _ => layered,
        }
    }

    fn facets(&self, l: &Layering) -> Facets {
        let strength = l.anisotropy.map_or(0.0, |a| a.0);
        Facets { alpha: widths(self.alpha, strength), tangent: Vec2::X }
    }

    /// The boundary, if there is one, with the metallic parameter of the opaque rest and the boundary's share.
    fn boundary(&self, l: &Layering, eta: f32, microfacet: Microfacet) -> (Option<Base>, Option<(f32, f32)>) {
        let (share, metallic) = Mixed::division(self.metallic, self.transmission);
        if share <= 0.0 {
            return (None, None);
        }
        let facets = self.facets(l);
        let treated = facets.alpha.x != facets.alpha.y || l.film.is_some() || self.is_specular_treated();
        let base = if treated {
            let b = TreatedBoundary::new(eta, facets, microfacet, self.base_color)
                .with_specular(self.specular, self.specular_color);
            let film = l.film.map(|(share, ior, thickness)| (share, ThinFilm::new(ior, thickness, b.f0())));
            Base::Treated(film.map_or(b, |(share, film)| b.with_film(share, film)), self.base_color)
        } else {
            let b = DielectricBoundary::new(eta, self.alpha, microfacet);
            Base::Boundary(b.with_transmission_tint(self.base_color), self.base_color)
        };
        (Some(base), (share < 1.0).then_some((metallic, share)))
    }

    /// An opaque surface or thin wall.
    fn opaque(
        &self,
        l: &Layering,
        metallic: f32,
        transmission: f32,
        eta: f32,
        microfacet: Microfacet,
    ) -> Base {
        let plain = self.parameters(metallic, transmission, microfacet);
        let brushed = l.anisotropy.is_some_and(|a| a.0 > 0.0);
        let diffuse = l.diffuse_transmission.0 > 0.0 || l.scatter.0 > 0.0 || l.diffuse_roughness > 0.0;
        if !brushed && l.film.is_none() && !diffuse {
            return Base::surface(&plain);
        }
        Base::Substrate(Substrate::new(&SubstrateParameters {
            plain,
            facets: self.facets(l),
            film: l.film,
            diffuse_transmission: l.diffuse_transmission,
            scatter: l.scatter,
            eta,
            diffuse_roughness: l.diffuse_roughness,
        }))
    }
}
