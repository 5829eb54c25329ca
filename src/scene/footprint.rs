//! How wide a sample is, and looking up textures over that width.
//!
//! **Idea.** A pixel is a mean of many look-ups at places of its own, so a sample need not average a texture over all of
//! the pixel, which would blur twice. It averages over a fraction w of the pixel's width, an eighth unless somebody asks
//! for another (what pbrt never goes below): a square of 1/64 of the pixel. Noise from texels that 64 samples could not
//! tell apart is gone, and what filtering does wrong (blurring before a non-linear function, bleeding across the seams of
//! an atlas) stays within an eighth of a pixel. At a bounce of density p the direction stands for a solid angle of w²/p
//! (path differentials: Suykens & Willems 2001, "Path Differentials and Applications").
//!
//! The width is a constant of the picture. If it followed from the number of samples, what a pixel converges to would
//! depend on that number, and parts of a picture that were rendered apart would not add up to the whole.
//!
//! **What is filtered.** Light depends linearly on base colour and emission: these. Roughness, metalness, normals,
//! transmission and the coefficients of media enter non-linearly, coverage is a threshold, and a mean of colours of
//! covered and uncovered texels is no colour of the surface: none of these, and no base colour with an alpha mode.
//!
//! The footprint is a disk across the ray; on a slanted surface its narrow side counts, the rest is left to the samples.
//! Bending by curved mirrors and lenses is ignored, so a footprint behind them may be too narrow or too wide by their
//! magnification, which costs noise or sharpness.

use super::texture::TextureSampler;
use super::{AlphaMode, ColorSpace, Minify, Pyramid, Scene, SceneDescription, Surface, TextureRef};
use glam::Vec4;

/// A box as wide as a footprint and the bilinear look-up of a level have the same variance if texels are 0.58 (2^−0.79) of
/// the width: (1/6 + 1/12) s² = w²/12.
const SHARPEN: f32 = 0.79;
/// Widest spread, radians: directions of tiny density stand for no more than this.
const WIDEST: f32 = 1.0;

/// The width of a path: how far apart its neighbours are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Footprint {
    /// Diameter at the head, metres.
    pub width: f32,
    /// Growth of the diameter, metres a metre.
    pub spread: f32,
    /// w², the share of a pixel, and of the directions of a bounce, that it stands for.
    share: f32,
}

impl Footprint {
    /// Width of averages in pixels unless another is asked for.
    pub const DEFAULT_FILTER: f32 = 0.125;

    /// Of a camera ray whose pixel is `width` wide at its origin and grows by `spread` a metre, averaged over a width of
    /// `filter` pixels; 0 averages nothing.
    pub fn of_pixel(width: f32, spread: f32, filter: f32) -> Self {
        Self { width: width * filter, spread: spread * filter, share: filter * filter }
    }

    /// After a way of that length.
    #[inline]
    pub fn travel(&mut self, length: f32) {
        self.width += self.spread * length;
    }

    /// After a bounce into a direction that was drawn with density `pdf` per steradian.
    #[inline]
    pub fn scatter(&mut self, pdf: f32) {
        self.spread = self.spread.hypot((self.share / pdf).sqrt()).min(WIDEST);
    }

    /// After events that share out space in ways that are not followed: a point, from which nothing spreads.
    #[inline]
    pub fn forget(&mut self) {
        (self.width, self.spread) = (0.0, 0.0);
    }
}

impl Surface {
    /// A base colour or emission texture, averaged over the footprint of the path.
    #[inline]
    pub fn color_texture(&self, scene: &Scene, texture: &TextureRef, alpha: AlphaMode) -> Vec4 {
        if self.footprint <= 0.0 || alpha != AlphaMode::Opaque {
            return self.texture(scene, texture);
        }
        self.wide_texture(scene, texture).unwrap_or_else(|| self.texture(scene, texture))
    }

    fn wide_texture(&self, scene: &Scene, texture: &TextureRef) -> Option<Vec4> {
        let pyramid = scene.pyramids.pyramid(texture.texture, texture.color_space)?;
        let sampler = TextureSampler::new(&scene.description.textures, &scene.description.images, texture)?;
        let mesh = scene.mesh(self.instance);
        let triangle = mesh.triangles[self.triangle as usize].map(|i| i as usize);
        let place = &scene.description.instances[self.instance as usize].transform;
        let [a, b, c] = triangle.map(|i| place.transform_point3(mesh.positions[i]));
        let uvs = mesh.uvs.get(texture.uv_set).filter(|uvs| !uvs.is_empty())?;
        let [s, t, r] = triangle.map(|i| uvs[i]);
        let area = (b - a).cross(c - a).length();
        let texels = (t - s).perp_dot(r - s).abs() * sampler.texels_per_uv();
        let level = 0.5 * (self.footprint * self.footprint * texels / area).log2() - SHARPEN;
        if level.is_nan() || level <= 0.0 {
            return None;
        }
        Some(sampler.sample_wide(self.uv(scene, texture.uv_set), level, pyramid))
    }
}

/// The pyramids of a scene: one for each image and colour space, however many textures and materials show it.
pub(super) struct Pyramids {
    pyramids: Vec<Pyramid>,
    /// Of each texture, in sRGB and linear: an index, or [`Self::NONE`].
    of_texture: Vec<[u32; 2]>,
}

impl Pyramids {
    const NONE: u32 = u32::MAX;

    pub fn new(description: &SceneDescription) -> Self {
        let images = description.averaged_images();
        let mut of_texture = vec![[Self::NONE; 2]; description.textures.len()];
        for (slots, texture) in of_texture.iter_mut().zip(&description.textures) {
            for (slot, space) in slots.iter_mut().zip([ColorSpace::Srgb, ColorSpace::Linear]) {
                if texture.minify == Minify::Footprint
                    && let Ok(found) = images
                        .binary_search_by_key(&(texture.image, space as u8), |(image, r)| {
                            (*image, r.color_space as u8)
                        })
                {
                    *slot = found as u32;
                }
            }
        }
        let build = |(_, reference): &(usize, TextureRef)| {
            let sampler = TextureSampler::new(&description.textures, &description.images, reference);
            sampler.map_or_else(|| Pyramid::new(1, 1, false, |_, _| Vec4::ONE), |sampler| sampler.pyramid())
        };
        Self { pyramids: images.iter().map(build).collect(), of_texture }
    }

    /// That of the image of a texture in a colour space; `None` where look-ups are not averaged.
    #[inline]
    pub fn pyramid(&self, texture: usize, space: ColorSpace) -> Option<&Pyramid> {
        let slot = *self.of_texture.get(texture)?.get(usize::from(space as u8))?;
        self.pyramids.get(slot as usize)
    }
}

impl SceneDescription {
    /// Images whose look-ups may be averaged, each with one of the references that do so, in the order of images and then
    /// of colour spaces.
    pub(super) fn averaged_images(&self) -> Vec<(usize, TextureRef)> {
        let materials = self.materials.iter().filter(|m| m.alpha_mode == AlphaMode::Opaque);
        let references = materials.flat_map(|m| m.base_color_texture.iter().chain(&m.emission_texture));
        let averaged = references.filter_map(|reference| {
            let texture = self.textures.get(reference.texture)?;
            (texture.minify == Minify::Footprint).then_some((texture.image, *reference))
        });
        let mut images: Vec<(usize, TextureRef)> = averaged.collect();
        images.sort_by_key(|(image, r)| (*image, r.color_space as u8));
        images.dedup_by_key(|(image, r)| (*image, r.color_space as u8));
        images
    }
}
