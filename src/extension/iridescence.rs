//! `KHR_materials_iridescence`: a thin film on the surface, in which light interferes.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::layers::Iridescence as Film;
use crate::scene::{ColorSpace, MaterialDescription};

/// Thicker films, nanometres, and denser ones show no colours.
const MAX_THICKNESS: f64 = 1e6;
const MAX_IOR: f64 = 1e4;

pub(super) struct Iridescence;

impl Extension for Iridescence {
    fn name(&self) -> &str {
        "KHR_materials_iridescence"
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let mut thickness = |key, default| loader.factor(own, key, default, 0.0..=MAX_THICKNESS);
        let least = thickness("iridescenceThicknessMinimum", 100.0)?;
        let most = thickness("iridescenceThicknessMaximum", 400.0)?;
        let film = Film {
            factor: loader.factor(own, "iridescenceFactor", 0.0, 0.0..=1.0)?,
            texture: loader.texture_slot(own, "iridescenceTexture", ColorSpace::Linear)?,
            ior: loader.factor(own, "iridescenceIor", 1.3, 1.0..=MAX_IOR)?,
            thickness: [least, most],
            thickness_texture: loader.texture_slot(own, "iridescenceThicknessTexture", ColorSpace::Linear)?,
        };
        if film.factor > 0.0 {
            out.layers_mut().iridescence = Some(film);
        }
        Ok(())
    }
}
