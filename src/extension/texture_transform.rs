//! `KHR_texture_transform`: uv' = T(offset) · R(rotation) · S(scale) · uv, and a texture coordinate set of its own.
//!
//! The specification's rotation matrix, in row-major form, is (cos, sin; −sin, cos): positive angles turn the *uv*
//! clockwise in the (u right, v down) frame, which turns the picture counter-clockwise.

use glam::{Affine2, Mat2, Vec2};

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::TextureRef;

/// Offsets and scales beyond this leave no digits for the fraction of a coordinate in single precision.
const MAX_COORDINATE: f64 = 1e6;

pub(super) struct TextureTransform;

impl Extension for TextureTransform {
    fn name(&self) -> &str {
        "KHR_texture_transform"
    }

    fn texture_info(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        out: &mut TextureRef,
    ) -> Result<(), AssetError> {
        let range = -MAX_COORDINATE..=MAX_COORDINATE;
        let offset = Vec2::from(loader.factors(own, "offset", [0.0; 2], range.clone())?);
        let scale = Vec2::from(loader.factors(own, "scale", [1.0; 2], range)?);
        let rotation = own.f64("rotation")?.unwrap_or(0.0) % std::f64::consts::TAU;
        let (sin, cos) = rotation.sin_cos();
        let (sin, cos) = (sin as f32, cos as f32);
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        out.transform = Affine2::from_mat2_translation(rotation * Mat2::from_diagonal(scale), offset);
        if let Some(set) = own.usize("texCoord")? {
            out.uv_set = loader.uv_set(&own.pointer_to("texCoord"), set)?;
        }
        Ok(())
    }
}
