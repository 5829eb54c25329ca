//! Core materials (glTF 2.0 §3.9): metallic-roughness, normals, emission, alpha; then the extensions, in their order.

use glam::{Vec3, Vec4};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use crate::scene::{AlphaMode, ColorSpace, MaterialDescription};

/// Normal maps stretched beyond this are noise.
const MAX_NORMAL_SCALE: f64 = 1e4;

/// Emission beyond this radiance overflows the sums of a picture.
const MAX_RADIANCE: f32 = 1e16;

impl Loader<'_> {
    /// Reads all materials, so that their indices are those of the file.
    pub(crate) fn materials(&mut self) -> Result<(), AssetError> {
        for index in 0..self.count("materials") {
            let json = self.entry("materials", index, "/materials")?;
            let material = self.material(index, &json)?;
            self.scene.materials.push(material);
        }
        Ok(())
    }

    fn material(&mut self, index: usize, json: &Json<'_>) -> Result<MaterialDescription, AssetError> {
        let mut out = MaterialDescription {
            name: json.name_or(|| format!("material {index}")),
            pointer: json.pointer().to_owned(),
            ..MaterialDescription::default()
        };
        if let Some(pbr) = json.object("pbrMetallicRoughness")? {
            out.base_color = Vec4::from(self.factors(&pbr, "baseColorFactor", [1.0; 4], 0.0..=1.0)?);
            out.base_color_texture = self.texture_slot(&pbr, "baseColorTexture", ColorSpace::Srgb)?;
            out.metallic = self.factor(&pbr, "metallicFactor", 1.0, 0.0..=1.0)?;
            out.roughness = self.factor(&pbr, "roughnessFactor", 1.0, 0.0..=1.0)?;
            out.metallic_roughness_texture =
                self.texture_slot(&pbr, "metallicRoughnessTexture", ColorSpace::Linear)?;
        }
        out.normal_texture = self.texture_slot(json, "normalTexture", ColorSpace::Linear)?;
        if let Some(info) = json.object("normalTexture")? {
            out.normal_scale = self.factor(&info, "scale", 1.0, -MAX_NORMAL_SCALE..=MAX_NORMAL_SCALE)?;
        }
        let range = 0.0..=f64::from(MAX_RADIANCE);
        out.emission = Vec3::from(self.factors(json, "emissiveFactor", [0.0; 3], range)?);
        if out.emission.max_element() > 1.0 {
            let message = "is above 1, which needs KHR_materials_emissive_strength; it is taken as it is";
            self.invalid(&json.pointer_to("emissiveFactor"), message)?;
        }
        out.emission_texture = self.texture_slot(json, "emissiveTexture", ColorSpace::Srgb)?;
        out.alpha_mode = match json.str("alphaMode")? {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => {
                AlphaMode::Mask(self.factor(json, "alphaCutoff", 0.5, 0.0..=f64::from(f32::MAX))?)
            }
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => return Err(json.error_at("alphaMode", "is none of OPAQUE, MASK and BLEND")),
        };
        out.double_sided = json.bool("doubleSided")?.unwrap_or(false);
        if json.get("extensions").is_some() {
            for extension in self.options.registry.iter() {
                if let Some(own) = json.extension(extension.name()) {
                    own.as_object()?;
                    extension.material(self, &own, json, &mut out)?;
                }
            }
        }
        out.emission = out.emission.min(Vec3::splat(MAX_RADIANCE));
        Ok(out)
    }
}
