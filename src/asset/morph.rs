//! Morph targets (glTF 2.0 §3.7.2.2): weighted displacements of positions, normals, tangents, texture coordinates and
//! colours.
//!
//! Where a primitive has no normals of its own they are computed after morphing, so that they are those of the shape
//! that is shown. The sign of a tangent's bitangent is not morphed; colours end in \[0, 1\].

use glam::Vec4;

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::pose::Pose;
use super::primitive::Primitive;

/// What a target may displace.
#[derive(Clone, Copy, Debug)]
enum Attribute {
    Position,
    Normal,
    Tangent,
    TexCoord(usize),
    Color,
}

impl Attribute {
    /// The attribute of a key; `None` for those that nothing is made of.
    fn of(key: &str) -> Option<Self> {
        Some(match key {
            "POSITION" => Self::Position,
            "NORMAL" => Self::Normal,
            "TANGENT" => Self::Tangent,
            "COLOR_0" => Self::Color,
            _ => Self::TexCoord(key.strip_prefix("TEXCOORD_")?.parse().ok()?),
        })
    }

    fn has_width(self, width: usize) -> bool {
        match self {
            Self::Position | Self::Normal | Self::Tangent => width == 3,
            Self::TexCoord(_) => width == 2,
            Self::Color => width == 3 || width == 4,
        }
    }
}

impl Loader<'_> {
    /// Morphs a primitive, whose JSON is `json`.
    pub(crate) fn morph(
        &mut self,
        primitive: &mut Primitive,
        json: &Json<'_>,
        pose: &Pose,
    ) -> Result<(), AssetError> {
        let Some(targets) = json.get("targets") else { return Ok(()) };
        let mut count = 0;
        for (i, target) in targets.items()?.enumerate() {
            count = i + 1;
            let weight = pose.weights.get(i).copied().unwrap_or(0.0);
            for key in target.as_object()?.keys() {
                if let Some(attribute) = Attribute::of(key) {
                    self.displace(primitive, &target, key, attribute, weight)?;
                }
            }
        }
        if pose.weights.len() > count {
            let message = format!("more weights ({}) than targets ({count}) are there", pose.weights.len());
            self.invalid(targets.pointer(), message)?;
        }
        Ok(())
    }

    fn displace(
        &mut self,
        primitive: &mut Primitive,
        target: &Json<'_>,
        key: &str,
        attribute: Attribute,
        weight: f32,
    ) -> Result<(), AssetError> {
        let pointer = target.pointer_to(key);
        let Some(index) = target.usize(key)? else { return Ok(()) };
        let vertices = primitive.positions.len();
        let promised = self.entry("accessors", index, &pointer).and_then(|a| a.usize("count"));
        let promised = match promised {
            Err(e) if weight == 0.0 => {
                let message = e.message();
                return self.invalid(&pointer, format!("the target is ignored: {message}"));
            }
            promised => promised?.unwrap_or(0),
        };
        if promised != vertices {
            let message =
                format!("its number of elements is {promised}, that of POSITION {vertices}; it is ignored");
            return self.invalid(&pointer, message);
        }
        if weight == 0.0 {
            return Ok(());
        }
        let mut accessor = self.accessor(index, &pointer)?;
        let width = accessor.shape.0 * accessor.shape.1;
        if !attribute.has_width(width) {
            let message =
                format!("has {width} components, which {key} of a target cannot have; it is ignored");
            return self.invalid(&pointer, message);
        }
        self.spend_pose(vertices, &pointer)?;
        self.promote(&mut accessor, target, key)?;
        let by = accessor.floats::<4>();
        let moved = |d: &[f32; 4]| Vec4::from(*d) * weight;
        match attribute {
            Attribute::Position => {
                primitive.positions.iter_mut().zip(&by).for_each(|(p, d)| *p += moved(d).truncate());
            }
            Attribute::Normal => {
                primitive.normals.iter_mut().zip(&by).for_each(|(n, d)| *n += moved(d).truncate());
            }
            Attribute::Tangent => {
                let turn = |(t, d): (&mut Vec4, _)| *t += moved(d).truncate().extend(0.0);
                primitive.tangents.iter_mut().zip(&by).for_each(turn);
            }
            Attribute::TexCoord(set) => {
                let uvs = primitive.uvs.get_mut(set).into_iter().flatten();
                uvs.zip(&by).for_each(|(uv, d)| *uv += moved(d).truncate().truncate());
            }
            Attribute::Color => {
                // An absent fourth component reads as zero: alpha stays.
                primitive.morphed_colors = true;
                primitive.colors.iter_mut().zip(&by).for_each(|(c, d)| *c += moved(d));
            }
        }
        Ok(())
    }
}
