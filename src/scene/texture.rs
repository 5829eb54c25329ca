//! Evaluation of images: coordinate transform, wrapping, filtering, decoding.
//!
//! Coordinates are those of glTF 2.0 §3.8.4: (0, 0) is the *upper left corner* of the first texel of the first row, u
//! goes right, v goes down, and the centre of texel i of n is at (i + ½)/n. Colours are decoded from sRGB
//! (IEC 61966-2-1) before they are blended; alpha is never encoded. Missing data read as white, so that a factor
//! alone remains.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec4};

use super::Pyramid;
use super::description::{
    ColorSpace, ImageData, ImagePixels, SceneDescription, TextureDescription, TextureRef, Wrap,
};

/// Linear value of an sRGB-encoded number in \[0, 1\] (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: f32) -> f32 {
    let c = f64::from(encoded);
    (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
}

static SRGB8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear((i as f64 / 255.0) as f32)));

static SRGB16: LazyLock<Box<[f32]>> =
    LazyLock::new(|| (0..=u16::MAX).map(|i| srgb_to_linear((f64::from(i) / 65535.0) as f32)).collect());

/// A texture made ready for many look-ups.
#[derive(Clone, Copy, Debug)]
pub struct TextureSampler<'a> {
    image: &'a ImageData,
    texture: TextureDescription,
    reference: TextureRef,
}

impl<'a> TextureSampler<'a> {
    /// Looks up what a reference refers to; `None` if it is not there or has no pixels.
    pub fn new(
        textures: &'a [TextureDescription],
        images: &'a [Arc<ImageData>],
        reference: &TextureRef,
    ) -> Option<Self> {
        let texture = *textures.get(reference.texture)?;
        let image = images.get(texture.image)?;
        let numbers = (image.width as usize).checked_mul(image.height as usize)?.checked_mul(4)?;
        let found = match &image.pixels {
            ImagePixels::Rgba8(p) => p.len(),
            ImagePixels::Rgba16(p) => p.len(),
            ImagePixels::Rgba32F(p) => p.len(),
        };
        let usable = numbers > 0 && found == numbers && image.width.max(image.height) <= i32::MAX as u32;
        usable.then_some(Self { image, texture, reference: *reference })
    }

    /// The decoded, filtered RGBA value at a texture coordinate of the mesh, before the reference's transform. A
    /// coordinate that is no number counts as 0.
    #[inline]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        let (w, h) = (self.image.width, self.image.height);
        let uv = self.folded(uv);
        if !self.texture.linear_filter {
            let x = ((uv.x * w as f32) as u32).min(w - 1);
            let y = ((uv.y * h as f32) as u32).min(h - 1);
            return self.texel(x, y);
        }
        self.bilinear(uv, w, h, |x, y| self.texel(x, y))
    }

    /// As [`Self::sample`], averaged: blended between levels of `pyramid`, which is that of [`Self::pyramid`]. `level` is
    /// log₂ of the width of a texel, above 0.
    pub fn sample_wide(&self, uv: Vec2, level: f32, pyramid: &Pyramid) -> Vec4 {
        let lower = level.min(64.0).floor();
        let of_level = |i: usize| match pyramid.level(i) {
            Some(l) if i > 0 => self.bilinear(self.folded(uv), l.width, l.height, |x, y| l.texel(x, y)),
            _ => self.sample(uv),
        };
        of_level(lower as usize).lerp(of_level(lower as usize + 1), (level - lower).clamp(0.0, 1.0))
    }

    /// The image at lower resolutions, decoded.
    pub fn pyramid(&self) -> Pyramid {
        let float = matches!(self.image.pixels, ImagePixels::Rgba32F(_));
        Pyramid::new(self.image.width, self.image.height, float, |x, y| self.texel(x, y))
    }

    /// Texels in a unit square of texture coordinates of the mesh.
    pub fn texels_per_uv(&self) -> f32 {
        let area = self.reference.transform.matrix2.determinant().abs();
        area * self.image.width as f32 * self.image.height as f32
    }

    #[inline]
    fn folded(&self, uv: Vec2) -> Vec2 {
        let uv = self.reference.transform.transform_point2(uv);
        Vec2::new(fold(uv.x, self.texture.wrap_u), fold(uv.y, self.texture.wrap_v))
    }

    #[inline]
    fn bilinear(&self, uv: Vec2, w: u32, h: u32, texel: impl Fn(u32, u32) -> Vec4) -> Vec4 {
        let (x0, x1, fx) = neighbours(uv.x, w, self.texture.wrap_u);
        let (y0, y1, fy) = neighbours(uv.y, h, self.texture.wrap_v);
        let top = texel(x0, y0).lerp(texel(x1, y0), fx);
        let bottom = texel(x0, y1).lerp(texel(x1, y1), fx);
        top.lerp(bottom, fy)
    }

    /// Width and height of the image.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.image.width, self.image.height]
    }

    /// The mean of all texels, decoded: what a light or a medium with this texture amounts to as a whole.
    pub fn mean(&self) -> Vec4 {
        let (w, h) = (self.image.width, self.image.height);
        let mut sum = glam::DVec4::ZERO;
        for y in 0..h {
            let row: Vec4 = (0..w).map(|x| self.texel(x, y)).sum();
            sum += row.as_dvec4();
        }
        (sum / (f64::from(w) * f64::from(h))).as_vec4()
    }

    /// One texel, decoded; `x` and `y` are in range.
    #[inline]
    pub(crate) fn texel(&self, x: u32, y: u32) -> Vec4 {
        let at = 4 * (y as usize * self.image.width as usize + x as usize);
        match (&self.image.pixels, self.reference.color_space) {
            (ImagePixels::Rgba8(p), space) => {
                let [r, g, b, a] = four(p, at).map(usize::from);
                let linear = |c: usize| c as f32 / 255.0;
                match space {
                    ColorSpace::Srgb => {
                        let table = &*SRGB8;
                        Vec4::new(table[r], table[g], table[b], linear(a))
                    }
                    ColorSpace::Linear => Vec4::new(linear(r), linear(g), linear(b), linear(a)),
                }
            }
            (ImagePixels::Rgba16(p), space) => {
                let [r, g, b, a] = four(p, at).map(usize::from);
                let linear = |c: usize| c as f32 / 65535.0;
                match space {
                    ColorSpace::Srgb => {
                        let table = &*SRGB16;
                        Vec4::new(table[r], table[g], table[b], linear(a))
                    }
                    ColorSpace::Linear => Vec4::new(linear(r), linear(g), linear(b), linear(a)),
                }
            }
            (ImagePixels::Rgba32F(p), _) => Vec4::from(four(p, at)),
        }
    }
}

#[inline]
fn four<T: Copy>(pixels: &[T], at: usize) -> [T; 4] {
    let texel = &pixels[at..at + 4];
    [texel[0], texel[1], texel[2], texel[3]]
}

/// A coordinate brought back to \[0, 1\].
#[inline]
fn fold(t: f32, wrap: Wrap) -> f32 {
    if !t.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => t - t.floor(),
        Wrap::MirroredRepeat => {
            let t = t.rem_euclid(2.0);
            if t > 1.0 { 2.0 - t } else { t }
        }
        Wrap::ClampToEdge => t.clamp(0.0, 1.0),
    }
}

/// The two texels around a folded coordinate, and the weight of the second.
#[inline]
fn neighbours(t: f32, n: u32, wrap: Wrap) -> (u32, u32, f32) {
    let x = t * n as f32 - 0.5;
    let floor = x.floor();
    let (first, last) = (floor as i32, n as i32 - 1);
    let bring = |i: i32| {
        let i = match wrap {
            Wrap::Repeat if i < 0 => last,
            Wrap::Repeat if i > last => 0,
            _ => i.clamp(0, last),
        };
        i as u32
    };
    (bring(first), bring(first + 1), x - floor)
}

/// The value of a texture of a scene at a texture coordinate of the mesh; white where there is none.
pub fn sample(scene: &SceneDescription, reference: &TextureRef, uv: Vec2) -> Vec4 {
    TextureSampler::new(&scene.textures, &scene.images, reference).map_or(Vec4::ONE, |s| s.sample(uv))
}

#[cfg(test)]
mod tests {
    use glam::{Affine2, Mat2, Vec2, Vec4};

    use super::super::Minify;
    use super::*;

    /// Two by two grey texels: 0, 51 / 102, 255, with alpha 255, 255 / 0, 255.
    fn scene(wrap: Wrap, linear_filter: bool) -> SceneDescription {
        let texel = |v: u8, a: u8| [v, v, v, a];
        let pixels = [texel(0, 255), texel(51, 255), texel(102, 0), texel(255, 255)].concat();
        SceneDescription {
            images: vec![Arc::new(ImageData {
                name: String::new(),
                width: 2,
                height: 2,
                pixels: ImagePixels::Rgba8(pixels),
            })],
            textures: vec![TextureDescription {
                image: 0,
                wrap_u: wrap,
                wrap_v: wrap,
                linear_filter,
                minify: Minify::Footprint,
            }],
            ..SceneDescription::default()
        }
    }

    fn reference(color_space: ColorSpace) -> TextureRef {
        TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY, color_space }
    }

    #[track_caller]
    fn close(a: f32, b: f32) {
        assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    }

    #[test]
    fn texel_centres_are_exact() {
        for filter in [false, true] {
            let scene = scene(Wrap::ClampToEdge, filter);
            let at = |u, v| sample(&scene, &reference(ColorSpace::Linear), Vec2::new(u, v));
            close(at(0.25, 0.25).x, 0.0);
            close(at(0.75, 0.25).x, 0.2);
            close(at(0.25, 0.75).x, 0.4);
            close(at(0.75, 0.75).x, 1.0);
            close(at(0.25, 0.75).w, 0.0);
        }
    }

    #[test]
    fn bilinear_weights() {
        let scene = scene(Wrap::ClampToEdge, true);
        let at = |u, v| sample(&scene, &reference(ColorSpace::Linear), Vec2::new(u, v)).x;
        close(at(0.5, 0.25), 0.1);
        close(at(0.375, 0.25), 0.05);
        close(at(0.5, 0.5), 0.4);
        close(at(0.0, 0.0), 0.0);
        close(at(1.0, 0.0), 0.2);
        close(at(-7.0, 9.0), 0.4);
    }

    #[test]
    fn repeat_blends_across_the_seam() {
        let scene = scene(Wrap::Repeat, true);
        let at = |u, v| sample(&scene, &reference(ColorSpace::Linear), Vec2::new(u, v)).x;
        close(at(0.0, 0.25), 0.1);
        close(at(1.0, 0.25), 0.1);
        close(at(3.75, 0.25), 0.2);
        close(at(-0.25, -0.75), 0.2);
        close(at(0.0, 0.0), 0.4);
    }

    #[test]
    fn mirror_turns_every_other_tile() {
        let scene = scene(Wrap::MirroredRepeat, false);
        let at = |u| sample(&scene, &reference(ColorSpace::Linear), Vec2::new(u, 0.25)).x;
        for (u, expected) in
            [(0.25, 0.0), (0.75, 0.2), (1.25, 0.2), (1.75, 0.0), (2.25, 0.0), (-0.25, 0.0), (-0.75, 0.2)]
        {
            close(at(u), expected);
        }
    }

    #[test]
    fn srgb_is_decoded_before_blending_and_alpha_never() {
        let scene = scene(Wrap::ClampToEdge, true);
        let at = |u, v| sample(&scene, &reference(ColorSpace::Srgb), Vec2::new(u, v));
        // 51/255 = 0.2 → ((0.2 + 0.055)/1.055)^2.4 = 0.033104767
        close(at(0.75, 0.25).x, 0.033_104_767);
        close(at(0.5, 0.25).x, 0.033_104_767 / 2.0);
        close(at(0.25, 0.5).w, 0.5);
        close(srgb_to_linear(0.04045), 0.04045 / 12.92);
        close(srgb_to_linear(1.0), 1.0);
    }

    #[test]
    fn transform_is_applied_before_wrapping() {
        let scene = scene(Wrap::Repeat, false);
        let mut reference = reference(ColorSpace::Linear);
        reference.transform =
            Affine2::from_mat2_translation(Mat2::from_diagonal(Vec2::new(2.0, 1.0)), Vec2::new(0.0, 0.5));
        // (0.125, 0.25) → (0.25, 0.75)
        close(sample(&scene, &reference, Vec2::new(0.125, 0.25)).x, 0.4);
        // (0.625, 0.25) → (1.25, 0.75), one tile further
        close(sample(&scene, &reference, Vec2::new(0.625, 0.25)).x, 0.4);
    }

    #[test]
    fn absurd_coordinates_give_numbers() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [false, true] {
                let scene = scene(wrap, filter);
                for t in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN, 1e-45, -1e-45, 1e9] {
                    let value = sample(&scene, &reference(ColorSpace::Srgb), Vec2::new(t, t));
                    assert!(value.is_finite() && value.max_element() <= 1.0, "{wrap:?} {t} {value}");
                }
            }
        }
    }

    #[test]
    fn sixteen_bits_and_floats() {
        let mut scene = scene(Wrap::Repeat, false);
        let at = |scene: &SceneDescription, space| sample(scene, &reference(space), Vec2::splat(0.25));
        scene.images[0] = Arc::new(ImageData {
            name: String::new(),
            width: 1,
            height: 1,
            pixels: ImagePixels::Rgba16(vec![13107, 0, 65535, 32768]),
        });
        close(at(&scene, ColorSpace::Linear).x, 0.2);
        close(at(&scene, ColorSpace::Srgb).x, 0.033_104_767);
        close(at(&scene, ColorSpace::Srgb).w, 32768.0 / 65535.0);
        Arc::make_mut(&mut scene.images[0]).pixels = ImagePixels::Rgba32F(vec![7.5, -1.0, 0.0, 1.0]);
        assert_eq!(at(&scene, ColorSpace::Srgb), Vec4::new(7.5, -1.0, 0.0, 1.0));
    }

    #[test]
    fn what_is_missing_is_white_and_the_mean_is_a_mean() {
        let mut scene = scene(Wrap::Repeat, true);
        let reference = reference(ColorSpace::Linear);
        let sampler = TextureSampler::new(&scene.textures, &scene.images, &reference).expect("it is there");
        close(sampler.mean().x, (0.0 + 0.2 + 0.4 + 1.0) / 4.0);
        Arc::make_mut(&mut scene.images[0]).pixels = ImagePixels::Rgba8(vec![0; 3]);
        assert_eq!(sample(&scene, &reference, Vec2::ZERO), Vec4::ONE);
        scene.images.clear();
        assert_eq!(sample(&scene, &reference, Vec2::ZERO), Vec4::ONE);
    }
}
