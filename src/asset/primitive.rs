//! One primitive of a mesh: attributes and indices, from accessors or from an extension that decompresses them.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use super::accessor::{Accessor, Component};
use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::marks::Marks;
use super::texture::MOST_UV_SETS;
use super::topology::Topology;
use crate::scene::NO_MATERIAL;

/// What an extension makes of a compressed primitive.
#[derive(Clone, Debug, Default)]
pub struct DecodedPrimitive {
    /// By semantic (`POSITION`, `TEXCOORD_0`, …): elements padded with zeros to four numbers, normalised integers
    /// already turned into fractions, and the number of components they really have.
    pub attributes: BTreeMap<String, (usize, Vec<[f32; 4]>)>,
    /// Indices, if the primitive has any.
    pub indices: Option<Vec<u32>>,
    /// What the indices mean, where it is not what the primitive's `mode` says.
    pub topology: Option<Topology>,
}

/// A primitive as plain vectors; attributes are empty or as long as `positions`, indices are in range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Primitive {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tangents: Vec<Vec4>,
    pub uvs: Vec<Vec<Vec2>>,
    pub colors: Vec<Vec4>,
    pub triangles: Vec<[u32; 3]>,
    /// The triangles after vertices that are one were merged; empty where that is not known.
    pub merged: Vec<[u32; 3]>,
    pub material: u32,
    /// Read only for skins.
    pub influences: Vec<Influences>,
    /// Whether morph targets displaced the colours, which then have to be brought back to \[0, 1\].
    pub morphed_colors: bool,
    /// Points or lines and their indices, which are yet to be given a surface.
    pub marks: Option<(Marks, Vec<u32>)>,
}

/// Four influences of joints on each vertex: `JOINTS_n` and `WEIGHTS_n`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Influences {
    pub joints: Vec<[f32; 4]>,
    pub weights: Vec<[f32; 4]>,
}

/// Sets of four influences beyond this many are not read.
const MOST_INFLUENCE_SETS: usize = 64;

/// Elements of an attribute and the number of their components.
pub(crate) type Elements = (usize, Vec<[f32; 4]>);

impl Loader<'_> {
    /// Reads a primitive, with the influences of joints if it is `skinned`; `None`, with a message, if it has no
    /// triangles.
    pub(crate) fn primitive(
        &mut self,
        json: &Json<'_>,
        skinned: bool,
    ) -> Result<Option<Primitive>, AssetError> {
        json.as_object()?;
        let mode = json.usize("mode")?.unwrap_or(4);
        let mut marks = Marks::from_mode(mode);
        let topology = match mode {
            0..=4 => Topology::Triangles,
            5 => Topology::Strip,
            6 => Topology::Fan,
            mode => {
                self.invalid(&json.pointer_to("mode"), format!("{mode} is no mode of glTF"))?;
                return Ok(None);
            }
        };
        let mut decoded = self.decompressed(json)?.unwrap_or_default();
        let topology = decoded.topology.inspect(|_| marks = None).unwrap_or(topology);
        let Some(attributes) = json.object("attributes")? else {
            self.invalid(json.pointer(), "has no `attributes` and is left out")?;
            return Ok(None);
        };
        let Some((components, positions)) = self.attribute(&attributes, "POSITION", &mut decoded, None)?
        else {
            self.warn(attributes.pointer(), "there is no POSITION, so the primitive is left out", None);
            return Ok(None);
        };
        if components != 3 {
            return Err(attributes.error_at("POSITION", "positions must be VEC3"));
        }
        let count = positions.len();
        let mut out = Primitive {
            positions: positions.into_iter().map(|p| Vec4::from(p).truncate()).collect(),
            ..Primitive::default()
        };
        let mut fitting = |loader: &mut Self, key: &str, widths: &[usize]| {
            let Some((width, elements)) = loader.attribute(&attributes, key, &mut decoded, Some(count))?
            else {
                return Ok(None);
            };
            if widths.contains(&width) {
                return Ok(Some((width, elements)));
            }
            let message = format!("has {width} components, which {key} cannot have; it is ignored");
            loader.invalid(&attributes.pointer_to(key), message)?;
            Ok::<_, AssetError>(None)
        };
        if let Some((_, normals)) = fitting(self, "NORMAL", &[3])? {
            out.normals = normals.into_iter().map(|n| Vec4::from(n).truncate()).collect();
        }
        if let Some((_, tangents)) = fitting(self, "TANGENT", &[4])? {
            out.tangents = tangents.into_iter().map(Vec4::from).collect();
        }
        for set in 0..MOST_UV_SETS {
            let key = format!("TEXCOORD_{set}");
            if attributes.get(&key).is_none() {
                break;
            }
            let uvs = match fitting(self, &key, &[2])? {
                Some((_, uvs)) => uvs.into_iter().map(|t| Vec2::new(t[0], t[1])).collect(),
                None => vec![Vec2::ZERO; count],
            };
            out.uvs.push(uvs);
        }
        if let Some((width, colors)) = fitting(self, "COLOR_0", &[3, 4])? {
            let alpha = |c: Vec4| if width == 3 { c.truncate().extend(1.0) } else { c };
            let finite = |c: Vec4| if c.is_finite() { c.max(Vec4::ZERO) } else { Vec4::ONE };
            out.colors = colors.into_iter().map(|c| finite(alpha(Vec4::from(c)))).collect();
        }
        for set in 0.. {
            let keys = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            if !skinned || attributes.get(&keys[0]).is_none() {
                break;
            }
            if set == MOST_INFLUENCE_SETS {
                let message = format!("more than {} influences on a vertex; others are ignored", 4 * set);
                self.warn(&attributes.pointer_to(&keys[0]), message, None);
                break;
            }
            if attributes.get(&keys[1]).is_none() {
                self.invalid(&attributes.pointer_to(&keys[0]), format!("has no {}; it is ignored", keys[1]))?;
                break;
            }
            let joints = fitting(self, &keys[0], &[4])?;
            let weights = fitting(self, &keys[1], &[4])?;
            if let (Some((_, joints)), Some((_, weights))) = (joints, weights) {
                out.influences.push(Influences { joints, weights });
            }
        }
        let indices = match decoded.indices.take() {
            Some(indices) => indices,
            None => match json.usize("indices")? {
                Some(index) => self.accessor(index, &json.pointer_to("indices"))?.indices()?,
                None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
            },
        };
        let indices_pointer = json.pointer_to("indices");
        if !marks.map_or_else(|| topology.is_whole(indices.len()), |marks| marks.is_whole(indices.len())) {
            let what = if marks.is_some() { "lines" } else { "triangles" };
            self.invalid(&indices_pointer, format!("{} indices do not make whole {what}", indices.len()))?;
        }
        if let Some(&index) = indices.iter().find(|&&i| i as usize >= count) {
            let message = format!("index {index} is beyond the {count} vertices of the primitive");
            if marks.is_some() {
                self.invalid(&indices_pointer, format!("{message}; its points or lines are left out"))?;
                return Ok(None);
            }
            return Err(AssetError::invalid(indices_pointer, message));
        }
        match marks {
            Some(marks) => out.marks = Some((marks, indices)),
            None => out.triangles = topology.triangles(&indices),
        }
        out.material = match self.alternative(json)?.or(json.usize("material")?) {
            Some(index) => {
                self.entry("materials", index, &json.pointer_to("material"))?;
                u32::try_from(index).unwrap_or(NO_MATERIAL)
            }
            None => NO_MATERIAL,
        };
        Ok(Some(out))
    }

    /// The material that an extension puts in place of the primitive's own.
    pub(super) fn alternative(&mut self, json: &Json<'_>) -> Result<Option<usize>, AssetError> {
        let mut chosen = None;
        if json.get("extensions").is_some() {
            for extension in self.options.registry.iter() {
                if let Some(own) = json.extension(extension.name()) {
                    chosen = extension.primitive_material(self, &own)?.or(chosen);
                }
            }
        }
        Ok(chosen)
    }

    fn decompressed(&mut self, json: &Json<'_>) -> Result<Option<DecodedPrimitive>, AssetError> {
        if json.get("extensions").is_none() {
            return Ok(None);
        }
        for extension in self.options.registry.iter() {
            if let Some(own) = json.extension(extension.name())
                && let Some(decoded) = extension.decode_primitive(self, &own, json)?
            {
                return Ok(Some(decoded));
            }
        }
        Ok(None)
    }

    /// The elements of an attribute; `None` if it is absent or, with a message, has not as many as it should.
    fn attribute(
        &mut self,
        attributes: &Json<'_>,
        key: &str,
        decoded: &mut DecodedPrimitive,
        expected: Option<usize>,
    ) -> Result<Option<Elements>, AssetError> {
        let elements = decoded.attributes.remove(key);
        let mut accessor = match (&elements, attributes.usize(key)?) {
            (Some(_), _) => None,
            (None, Some(index)) => Some(self.accessor(index, &attributes.pointer_to(key))?),
            (None, None) => return Ok(None),
        };
        let found = accessor.as_ref().map_or(0, |a| a.count) + elements.as_ref().map_or(0, |e| e.1.len());
        if let Some(expected) = expected.filter(|&n| n != found) {
            let message =
                format!("its number of elements is {found}, that of POSITION {expected}; it is ignored");
            self.invalid(&attributes.pointer_to(key), message)?;
            return Ok(None);
        }
        if let Some(accessor) = &mut accessor {
            self.promote(accessor, attributes, key)?;
            let (rows, columns) = accessor.shape;
            return Ok(Some((rows * columns, accessor.floats::<4>())));
        }
        Ok(elements)
    }

    /// Colours and weights in integers are fractions, even where the file forgot to say so; positions, normals and
    /// tangents in integers need KHR_mesh_quantization.
    pub(crate) fn promote(
        &mut self,
        accessor: &mut Accessor,
        attributes: &Json<'_>,
        key: &str,
    ) -> Result<(), AssetError> {
        let integer = accessor.component != Component::F32;
        if integer && !accessor.normalized && (key.starts_with("COLOR") || key.starts_with("WEIGHTS")) {
            let what = if key.starts_with("COLOR") { "colours" } else { "weights" };
            let message = format!("integer {what} must be `normalized`; they are taken to be");
            self.invalid(&attributes.pointer_to(key), message)?;
            accessor.normalized = true;
        }
        if integer && matches!(key, "POSITION" | "NORMAL" | "TANGENT") && !self.uses("KHR_mesh_quantization")
        {
            let message = "integers are allowed only with KHR_mesh_quantization, which is not declared";
            self.invalid(&attributes.pointer_to(key), message)?;
        }
        Ok(())
    }
}
