//! `KHR_materials_volume`: an absorbing medium behind a transmissive boundary.
//!
//! The attenuation colour c is what is left of white light after the attenuation distance d, so σa = −ln(c)/d. The
//! thickness only tells a volume (> 0) from a thin wall (0): a path tracer knows how far light travels.

use glam::Vec3;

use super::{Extension, order};
use crate::asset::{AssetError, Json, Loader};
use crate::scene::{MaterialDescription, MediumDescription};

/// Stands for a colour of zero, whose logarithm is infinite.
const MIN_COLOR: f32 = 1e-30;

/// Coefficients beyond this many per metre are as opaque as any and stay clear of overflow.
pub(super) const MAX_COEFFICIENT: f32 = 1e12;

pub(super) struct Volume;

impl Extension for Volume {
    fn name(&self) -> &str {
        "KHR_materials_volume"
    }

    fn order(&self) -> i32 {
        order::VOLUME
    }

    fn material(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut MaterialDescription,
    ) -> Result<(), AssetError> {
        let thickness = loader.factor(own, "thicknessFactor", 0.0, 0.0..=f64::from(f32::MAX))?;
        let color = loader.factors(own, "attenuationColor", [1.0; 3], 0.0..=1.0)?;
        let distance = match own.f64("attenuationDistance")? {
            Some(d) if d > 0.0 => d as f32,
            Some(d) => {
                let message = format!("{d} is not above 0; light is not attenuated");
                loader.invalid(&own.pointer_to("attenuationDistance"), message)?;
                f32::INFINITY
            }
            None => f32::INFINITY,
        };
        if thickness == 0.0 || !out.is_see_through() {
            return Ok(());
        }
        let sigma_a = Vec3::from(color).max(Vec3::splat(MIN_COLOR)).map(|c| -c.ln() / distance);
        out.medium = Some(MediumDescription {
            sigma_a: sigma_a.clamp(Vec3::ZERO, Vec3::splat(MAX_COEFFICIENT)),
            sigma_s: Vec3::ZERO,
            anisotropy: 0.0,
            // Diffuse transmission does not refract.
            ior: if out.transmission > 0.0 { out.ior } else { 1.0 },
            priority: 0,
            absorption_texture: None,
            scattering_texture: None,
            multi_scatter: None,
        });
        Ok(())
    }
}
