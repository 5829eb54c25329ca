//! From the base colour of a material to coefficient textures of its medium.
//!
//! A base colour tints light at every crossing of a boundary. What was meant is a body of that colour: so the paint of a
//! material is gathered into *coats* ([`coats`]), pictures of the colour
//! to be seen with vertex colours baked in ([`bake`]), and each colour is inverted into a single-scattering albedo behind
//! the boundary ([`coefficients`]). [`document`] writes what comes of it.

pub mod bake;
pub mod coats;
pub mod coefficients;
pub mod document;
pub mod images;
pub mod mean;

pub use coats::{Alpha, Coat, Colors};
pub use coefficients::{Basis, Painted};

use crate::asset::painting::PaintedPrimitive;
use glam::Vec4;

/// Why paint cannot be taken into a medium.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PaintError {
    /// Colours at vertices, and nowhere to put them.
    #[error(
        "{pointer}/attributes/COLOR_0: the colours vary and cannot be baked into a texture: there is no TEXCOORD_{set}"
    )]
    NoTexCoords {
        /// The primitive.
        pointer: String,
        /// The set of texture coordinates that would be needed.
        set: usize,
    },
    /// Places of different colour share texels.
    #[error(
        "{pointer}/attributes/COLOR_0: the colours cannot be baked into a texture: {:.1} % of the surface {why}",
        100.0 * share
    )]
    Shared {
        /// The primitive with most of such surface.
        pointer: String,
        /// That part of all surface, by area.
        share: f64,
        /// How they come to share them.
        why: Why,
    },
    /// The primitives of a mesh have colours that exclude each other, and are one body.
    #[error(
        "{pointer}/attributes/COLOR_0: the colours of this primitive and of others of its mesh need the same texels, and \
         it is not closed by itself, so that it cannot get a medium of its own"
    )]
    OneBody {
        /// The primitive.
        pointer: String,
    },
    /// A picture that cannot be written.
    #[error("the texture cannot be made: {0}")]
    Picture(String),
}

/// How places of different colour come to share texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// Texture coordinates of different places are the same.
    Overlap,
    /// Texture coordinates outside of 0 to 1 come back to places that have another colour.
    Tiling,
    /// All of a triangle, or most of it, is on one texel.
    Tiny,
}

impl std::fmt::Display for Why {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Overlap => "shares its texture coordinates with surface of another colour",
            Self::Tiling => {
                "has texture coordinates outside of 0 to 1, which repeat the texture where the colours do not repeat"
            }
            Self::Tiny => "is smaller in texture coordinates than the texels of the largest texture that is made",
        })
    }
}

impl PaintError {
    /// What could be done.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::NoTexCoords { .. } => {
                "unwrap the mesh, or give the material one colour by --color and drop the vertex colours by --fix-surface"
            }
            Self::Shared { .. } => {
                "unwrap the mesh so that every place has texels of its own, or drop the vertex colours by --fix-surface"
            }
            Self::OneBody { .. } => {
                "unwrap the mesh so that its primitives have texels of their own, or drop the vertex colours by --fix-surface"
            }
            Self::Picture(_) => "make the base colour texture smaller",
        }
    }
}

/// The vertex colours of a primitive as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tint {
    /// None, or white but for alpha: they may stay.
    White,
    /// The same at all vertices.
    Constant(Vec4),
    /// Others.
    Varying,
}

impl Tint {
    /// Judges the vertices that triangles use.
    pub(crate) fn of(primitive: &PaintedPrimitive) -> Self {
        // Half a step of 8 bits.
        const SAME: f32 = 0.5 / 255.0;
        let colors = &primitive.shape.colors;
        let mut used = primitive.shape.triangles.iter().flatten().filter_map(|&i| colors.get(i as usize));
        let Some(&first) = used.next() else { return Self::White };
        let (low, high) = used.fold((first, first), |(low, high), c| (low.min(*c), high.max(*c)));
        if low.truncate().min_element() >= 1.0 - SAME {
            Self::White
        } else if (high - low).max_element() <= SAME {
            Self::Constant(0.5 * (low + high))
        } else {
            Self::Varying
        }
    }
}

#[cfg(test)]
mod tests;
