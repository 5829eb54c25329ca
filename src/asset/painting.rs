//! What some materials of a document are painted with: base colour textures decoded, and the vertex colours of every
//! primitive that uses them, in any scene. For whoever makes something else of the paint ([`crate::author::paint`]).

use std::sync::Arc;

use glam::Vec4;
use serde_json::Value;

use super::error::AssetError;
use super::loader::Loader;
use super::opened::Asset;
use super::primitive::Primitive;
use crate::scene::{ColorSpace, ImageData, TextureDescription, TextureRef};

/// The paint of some materials.
#[derive(Debug, Default)]
pub(crate) struct Painting {
    /// One for each material that was asked for, in that order.
    pub materials: Vec<PaintedMaterial>,
    /// Every primitive with triangles that one of them may be shown on.
    pub primitives: Vec<PaintedPrimitive>,
    /// Decoded images, and textures that refer to them.
    pub images: Vec<Arc<ImageData>>,
    pub textures: Vec<TextureDescription>,
}

/// The base colour of a material.
#[derive(Debug)]
pub(crate) struct PaintedMaterial {
    /// Index in the file.
    pub index: usize,
    /// Linear colour and alpha.
    pub factor: Vec4,
    pub texture: Option<TextureRef>,
    /// The `textureInfo` as it is in the file, where there is a texture that can be used.
    pub info: Option<Value>,
    /// Index in `samplers` of the texture.
    pub sampler: Option<usize>,
    /// Whether alpha counts.
    pub has_alpha: bool,
}

/// A primitive.
#[derive(Debug)]
pub(crate) struct PaintedPrimitive {
    /// Indices of its mesh in the file, and its own in the mesh.
    pub mesh: usize,
    pub index: usize,
    pub pointer: String,
    /// The materials it may be shown with: its own and those of variants, each once.
    pub materials: Vec<usize>,
    /// Attributes and triangles.
    pub shape: Primitive,
}

impl Asset {
    /// The paint of materials, by their indices.
    ///
    /// # Errors
    /// Where the document cannot be read that far.
    pub(crate) fn painting(&self, wanted: &[usize]) -> Result<Painting, AssetError> {
        let mut loader = self.loader();
        loader.extensions()?;
        let mut painting = Painting::default();
        for &index in wanted {
            painting.materials.push(loader.painted_material(index)?);
        }
        loader.decode_images()?;
        for material in &mut painting.materials {
            let textures = &loader.scene.textures;
            let usable = |r: &TextureRef| loader.usable_images.contains(&textures[r.texture].image);
            if !material.texture.as_ref().is_some_and(usable) {
                (material.texture, material.info) = (None, None);
            }
        }
        painting.images = std::mem::take(&mut loader.scene.images);
        painting.textures = std::mem::take(&mut loader.scene.textures);
        for mesh in 0..loader.count("meshes") {
            let json = loader.entry("meshes", mesh, "/meshes")?;
            for (index, primitive) in json.array("primitives")?.into_iter().enumerate() {
                let materials = shown_with(primitive.value());
                if !materials.iter().any(|m| wanted.contains(m)) {
                    continue;
                }
                let Some(shape) = loader.primitive(&primitive, false)? else { continue };
                loader.spend(shape.positions.len(), shape.triangles.len(), primitive.pointer())?;
                if shape.marks.is_none() && !shape.triangles.is_empty() {
                    let pointer = primitive.pointer().to_owned();
                    painting.primitives.push(PaintedPrimitive { mesh, index, pointer, materials, shape });
                }
            }
        }
        Ok(painting)
    }
}

impl Loader<'_> {
    fn painted_material(&mut self, index: usize) -> Result<PaintedMaterial, AssetError> {
        let json = self.entry("materials", index, "/materials")?;
        let mut out = PaintedMaterial {
            index,
            factor: Vec4::ONE,
            texture: None,
            info: None,
            sampler: None,
            has_alpha: matches!(json.str("alphaMode")?, Some("MASK" | "BLEND")),
        };
        if let Some(pbr) = json.object("pbrMetallicRoughness")? {
            out.factor = Vec4::from(self.factors(&pbr, "baseColorFactor", [1.0; 4], 0.0..=1.0)?);
            out.texture = self.texture_slot(&pbr, "baseColorTexture", ColorSpace::Srgb)?;
            if let Some(info) = pbr.object("baseColorTexture")?.filter(|_| out.texture.is_some()) {
                out.info = Some(info.value().clone());
                let texture = info.usize("index")?.unwrap_or(0);
                out.sampler = self.entry("textures", texture, info.pointer())?.usize("sampler")?;
            }
        }
        Ok(out)
    }
}

/// The materials that a primitive may be shown with, its own first.
pub(crate) fn shown_with(primitive: &Value) -> Vec<usize> {
    let index =
        |value: &Value| value.get("material").and_then(Value::as_u64).and_then(|i| usize::try_from(i).ok());
    let mappings = primitive.pointer("/extensions/KHR_materials_variants/mappings").and_then(Value::as_array);
    let mut found: Vec<usize> = Vec::new();
    for material in index(primitive).into_iter().chain(mappings.into_iter().flatten().filter_map(index)) {
        if !found.contains(&material) {
            found.push(material);
        }
    }
    found
}
