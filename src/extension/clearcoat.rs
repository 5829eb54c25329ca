//! `KHR_materials_clearcoat`: a dielectric coat with a roughness and normals of its own.

use glam::Vec3;

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::Coat;
use crate::scene::{ColorSpace, MaterialDescription};

/// Normal maps stretched beyond this are noise.
const MAX_NORMAL_SCALE: f64 = 1e4;

pub(super) const NAME: &str = "KHR_materials_clearcoat";

pub(super) struct Clearcoat;

/// What both extensions of a coat have, under their own keys: strength, roughness and normals, of a clear coat.
pub(super) fn clear(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    name: &'static str,
    [factor, texture, roughness, roughness_texture, normal_texture]: [&str; 5],
) -> Result<Coat, AssetError> {
    let mut coat = Coat {
        name,
        factor: loader.factor(own, factor, 0.0, 0.0..=1.0)?,
        texture: loader.texture_slot(own, texture, ColorSpace::Linear)?,
        roughness: loader.factor(own, roughness, 0.0, 0.0..=1.0)?,
        roughness_texture: loader.texture_slot(own, roughness_texture, ColorSpace::Linear)?,
        normal_texture: loader.texture_slot(own, normal_texture, ColorSpace::Linear)?,
        normal_scale: 1.0,
        ior: 1.5,
        color: Vec3::ONE,
        color_texture: None,
        darkening: 0.0,
        anisotropy: None,
    };
    if let Some(info) = own.object(normal_texture)? {
        let range = -MAX_NORMAL_SCALE..=MAX_NORMAL_SCALE;
        coat.normal_scale = loader.factor(&info, "scale", 1.0, range)?;
    }
    Ok(coat)
}

impl Extension for Clearcoat {
    fn name(&self) -> &str {
        NAME
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let keys = [
            "clearcoatFactor",
            "clearcoatTexture",
            "clearcoatRoughnessFactor",
            "clearcoatRoughnessTexture",
            "clearcoatNormalTexture",
        ];
        let coat = clear(loader, own, "clearcoat", keys)?;
        if coat.factor > 0.0 {
            out.layers_mut().coat = Some(coat);
        }
        Ok(())
    }
}
