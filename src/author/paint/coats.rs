//! What a material is painted with, as pictures of the colour to be seen: one, or several where its primitives have vertex
//! colours that exclude each other.

use super::bake::{Unwrapping, bake};
use super::{PaintError, Tint};
use crate::asset::painting::{PaintedMaterial, PaintedPrimitive, Painting};
use crate::geometry::{MeshGeometry, Topology};
use crate::scene::texture::TextureSampler;
use crate::scene::{ColorSpace, Minify, TextureDescription, TextureRef, Wrap};
use glam::{Affine2, Vec2, Vec3, Vec4};

/// Sides of a picture where there is no texture whose size could be kept.
const SIDE: u32 = 64;
/// Colours that are this near are the same.
const SAME: f32 = 1e-5;

/// The paint of some primitives.
#[derive(Clone, Debug)]
pub struct Coat {
    /// Which of the painting's primitives it is for; all of a material that has one coat, also where they are none.
    pub primitives: Vec<usize>,
    /// Colours, linear, in \[0, 1\].
    pub colors: Colors,
    /// What is left of alpha.
    pub alpha: Alpha,
}

/// Colours of a coat.
#[derive(Clone, Debug, PartialEq)]
pub enum Colors {
    /// The same everywhere.
    Uniform(Vec3),
    /// A picture, row by row.
    Picture {
        /// Pixels in a row.
        width: u32,
        /// All of them.
        texels: Vec<Vec3>,
    },
}

/// Alpha of a coat.
#[derive(Clone, Debug, PartialEq)]
pub struct Alpha {
    /// Factor of all.
    pub factor: f32,
    /// Width of a picture and its texels, in 255ths.
    pub texels: Option<(u32, Vec<u8>)>,
}

/// The coats of one of the painting's materials; the first is for the material itself.
///
/// # Errors
/// Where vertex colours cannot be baked.
pub(crate) fn coats(
    painting: &Painting,
    material: &PaintedMaterial,
    keep_alpha: bool,
) -> Result<Vec<Coat>, PaintError> {
    let all: Vec<usize> = (0..painting.primitives.len())
        .filter(|&i| painting.primitives[i].materials.contains(&material.index))
        .collect();
    let painter = Painter { painting, material, keep_alpha: keep_alpha && material.has_alpha };
    let failed = match painter.coat(&all) {
        Ok(coat) => return Ok(vec![coat]),
        Err(error) => error,
    };
    let mut meshes: Vec<Vec<usize>> = Vec::new();
    for &i in &all {
        let mesh = painting.primitives[i].mesh;
        match meshes.iter_mut().find(|group| painting.primitives[group[0]].mesh == mesh) {
            Some(group) => group.push(i),
            None => meshes.push(vec![i]),
        }
    }
    if all.len() < 2 {
        return Err(failed);
    }
    let mut coats: Vec<Coat> = Vec::new();
    for group in meshes {
        match painter.coat(&group) {
            Ok(coat) => add(&mut coats, coat),
            Err(error) if group.len() == 1 => return Err(error),
            Err(_) => {
                for i in group {
                    let primitive = &painting.primitives[i];
                    if !is_closed(primitive) {
                        return Err(PaintError::OneBody { pointer: primitive.pointer.clone() });
                    }
                    add(&mut coats, painter.coat(&[i])?);
                }
            }
        }
    }
    Ok(coats)
}

/// Adds a coat, to one that is the same if there is one.
fn add(coats: &mut Vec<Coat>, coat: Coat) {
    match coats.iter_mut().find(|other| other.colors == coat.colors && other.alpha == coat.alpha) {
        Some(other) => other.primitives.extend(coat.primitives),
        None => coats.push(coat),
    }
}

fn is_closed(primitive: &PaintedPrimitive) -> bool {
    let shape = &primitive.shape;
    let topology = Topology::analyse(&MeshGeometry::build(&shape.positions, &shape.triangles));
    topology.components.iter().all(|component| component.closed)
}

struct Painter<'a> {
    painting: &'a Painting,
    material: &'a PaintedMaterial,
    keep_alpha: bool,
}

impl Painter<'_> {
    fn coat(&self, primitives: &[usize]) -> Result<Coat, PaintError> {
        let sampler = self.material.texture.as_ref().and_then(|reference| {
            // Of the picture itself: its transform is that of the coordinates.
            let plain = TextureRef { transform: Affine2::IDENTITY, ..*reference };
            let sampler = TextureSampler::new(&self.painting.textures, &self.painting.images, &plain)?;
            Some((sampler, self.painting.textures.get(reference.texture)?, reference))
        });
        let tints: Vec<Tint> = primitives.iter().map(|&i| Tint::of(&self.painting.primitives[i])).collect();
        let common = tints.first().copied().unwrap_or(Tint::White);
        let one = match common {
            Tint::White => Some(Vec4::ONE),
            Tint::Constant(color) => Some(color.clamp(Vec4::ZERO, Vec4::ONE)),
            Tint::Varying => None,
        };
        let one = one.filter(|_| tints.iter().all(|tint| *tint == common));
        let factor = self.material.factor;
        let (width, texels) = match (one, sampler) {
            (Some(color), None) => (1, vec![factor * color]),
            (Some(color), Some((sampler, ..))) => {
                let [width, height] = sampler.size();
                let texel = |i: u32| factor * color * sampler.texel(i % width, i / width);
                (width, (0..width * height).map(texel).collect())
            }
            (None, sampler) => {
                let size = sampler.map_or([SIDE; 2], |(sampler, ..)| sampler.size());
                let unwrapping = match sampler {
                    Some((_, texture, reference)) => Unwrapping { texture: *texture, reference: *reference },
                    None => PLAIN,
                };
                let list: Vec<(&PaintedPrimitive, bool)> = primitives
                    .iter()
                    .zip(&tints)
                    .map(|(&i, tint)| (&self.painting.primitives[i], *tint == Tint::White))
                    .collect();
                let baked = bake(&list, &unwrapping, size)?;
                let centre = |i: u32, n: u32| (i as f32 + 0.5) / n as f32;
                let texel = |(i, color): (usize, &Vec4)| {
                    let (x, y) = (i as u32 % baked.width, i as u32 / baked.width);
                    let own = match sampler {
                        Some((sampler, ..)) if [baked.width, baked.height] == size => sampler.texel(x, y),
                        Some((sampler, ..)) => {
                            sampler.sample(Vec2::new(centre(x, baked.width), centre(y, baked.height)))
                        }
                        None => Vec4::ONE,
                    };
                    factor * color * own
                };
                (baked.width, baked.colors.iter().enumerate().map(texel).collect())
            }
        };
        Ok(Coat {
            primitives: primitives.to_vec(),
            colors: colors(width, &texels),
            alpha: self.alpha(width, &texels),
        })
    }

    fn alpha(&self, width: u32, texels: &[Vec4]) -> Alpha {
        let largest = texels.iter().map(|t| t.w).fold(0.0, f32::max);
        if !self.keep_alpha {
            return Alpha { factor: 1.0, texels: None };
        }
        if texels.iter().all(|t| largest - t.w < 0.5 / 255.0) {
            return Alpha { factor: largest, texels: None };
        }
        let factor = self.material.factor.w;
        let texel = |t: &Vec4| (t.w / factor * 255.0 + 0.5).clamp(0.0, 255.0) as u8;
        Alpha { factor, texels: Some((width, texels.iter().map(texel).collect())) }
    }
}

/// How a texture of ours is looked up where there was none.
const PLAIN: Unwrapping = Unwrapping {
    texture: TextureDescription {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        linear_filter: true,
        minify: Minify::Footprint,
    },
    reference: TextureRef {
        texture: 0,
        uv_set: 0,
        transform: Affine2::IDENTITY,
        color_space: ColorSpace::Linear,
    },
};

fn colors(width: u32, texels: &[Vec4]) -> Colors {
    let color = |t: &Vec4| t.truncate().clamp(Vec3::ZERO, Vec3::ONE);
    let first = texels.first().map_or(Vec3::ONE, color);
    if texels.iter().all(|t| (color(t) - first).abs().max_element() < SAME) {
        return Colors::Uniform(first);
    }
    Colors::Picture { width, texels: texels.iter().map(color).collect() }
}
