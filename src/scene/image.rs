//! Images, samplers, and the references of materials to them, as plain data: part of [`super::description`].

use glam::Affine2;

/// Decoded pixels, row 0 at the top, tightly packed.
#[derive(Clone, Debug)]
pub struct ImageData {
    /// Name or URI for messages.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four channels a pixel.
    pub pixels: ImagePixels,
}

/// Storage of an image's RGBA pixels; `width * height * 4` numbers.
#[derive(Clone, Debug)]
pub enum ImagePixels {
    /// 8 bits a channel.
    Rgba8(Vec<u8>),
    /// 16 bits a channel.
    Rgba16(Vec<u16>),
    /// Linear floating point.
    Rgba32F(Vec<f32>),
}

/// How a texture coordinate outside \[0, 1\] is brought back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Tile.
    #[default]
    Repeat,
    /// Tile, every other one mirrored.
    MirroredRepeat,
    /// The edge texel.
    ClampToEdge,
}

/// What to do where a pixel sees many texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Minify {
    /// Average over what a sample sees ([`super::Footprint`]), where light depends linearly on the texture.
    #[default]
    Footprint,
    /// Look up single points, and leave averages to the samples of the pixel.
    Point,
}

/// An image with its sampler.
#[derive(Clone, Copy, Debug)]
pub struct TextureDescription {
    /// Index of the image.
    pub image: usize,
    /// Wrapping of u.
    pub wrap_u: Wrap,
    /// Wrapping of v.
    pub wrap_v: Wrap,
    /// Whether texels are blended bilinearly (otherwise the nearest is taken).
    pub linear_filter: bool,
    /// Where a pixel sees many texels.
    pub minify: Minify,
}

/// What the numbers of a texture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorSpace {
    /// The RGB channels are sRGB encoded (alpha never is).
    Srgb,
    /// The numbers are the data.
    Linear,
}

/// A reference from a material to a texture.
#[derive(Clone, Copy, Debug)]
pub struct TextureRef {
    /// Index of the texture.
    pub texture: usize,
    /// Texture coordinate set.
    pub uv_set: usize,
    /// KHR_texture_transform as one affine map of (u, v).
    pub transform: Affine2,
    /// How to decode it.
    pub color_space: ColorSpace,
}
