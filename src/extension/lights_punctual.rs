//! `KHR_lights_punctual`: point, spot and directional lights.
//!
//! Intensities are candela (point, spot) and lux (directional); the scale of a node changes neither them nor the
//! range. A light shines along −Z of its node.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec3, Vec3};

use super::Extension;
use super::emissive_strength::MAX_RADIANCE;
use crate::asset::{AssetError, Json, Loader, NodeContext};
use crate::scene::{PunctualKind, PunctualLight};

const NAME: &str = "KHR_lights_punctual";

pub(super) struct LightsPunctual;

impl Extension for LightsPunctual {
    fn name(&self) -> &str {
        NAME
    }

    fn node(&self, loader: &mut Loader<'_>, own: &Json<'_>, node: &NodeContext) -> Result<(), AssetError> {
        let Some(index) = own.usize("light")? else {
            return Ok(());
        };
        let lights = loader.root().extension(NAME).and_then(|e| e.get("lights"));
        let Some(light) = lights.and_then(|list| list.item(index)) else {
            return Err(own.error_at("light", format!("there is no light {index}")));
        };
        light.as_object()?;
        let kind = match light.str("type")? {
            Some("point") => PunctualKind::Point,
            Some("directional") => PunctualKind::Directional,
            Some("spot") => spot(loader, &light)?,
            Some(other) => {
                let other = other.chars().take(40).collect::<String>();
                let message = format!("`{other}` is no kind of light; it is left out");
                return loader.invalid(&light.pointer_to("type"), message);
            }
            None => return loader.invalid(light.pointer(), "has no `type`; it is left out"),
        };
        let top = f64::from(MAX_RADIANCE);
        let color = Vec3::from(loader.factors(&light, "color", [1.0; 3], 0.0..=top)?);
        let intensity = loader.factor(&light, "intensity", 1.0, 0.0..=top)?;
        let range = match light.f64("range")? {
            Some(range) if range > 0.0 => Some(range as f32),
            Some(range) => {
                loader
                    .invalid(&light.pointer_to("range"), format!("{range} is not above 0; it is ignored"))?;
                None
            }
            None => None,
        };
        let position = node.world.translation.as_vec3();
        let direction = (node.world.matrix3 * DVec3::NEG_Z).try_normalize();
        let (true, Some(direction)) = (position.is_finite(), direction) else {
            loader.warn(&node.pointer, "the light is left out, since its node has no direction", None);
            return Ok(());
        };
        let light = PunctualLight {
            name: light.name_or(|| node.name.clone()),
            intensity: (color * intensity).min(Vec3::splat(MAX_RADIANCE)),
            position,
            direction: direction.as_vec3().normalize(),
            range,
            kind,
        };
        loader.add_light(light, node.world.translation);
        Ok(())
    }
}

fn spot(loader: &mut Loader<'_>, light: &Json<'_>) -> Result<PunctualKind, AssetError> {
    let Some(spot) = light.object("spot")? else {
        loader.invalid(light.pointer(), "has no `spot`; its angles are the default ones")?;
        return Ok(PunctualKind::Spot { inner: 0.0, outer: FRAC_PI_4 as f32 });
    };
    let inner = spot.f64("innerConeAngle")?.unwrap_or(0.0);
    let outer = spot.f64("outerConeAngle")?.unwrap_or(FRAC_PI_4);
    if !(0.0 <= inner && inner < outer && outer <= FRAC_PI_2 + 1e-6) {
        let message = format!("0 ≤ inner ({inner}) < outer ({outer}) ≤ π/2 does not hold");
        loader.invalid(spot.pointer(), message)?;
    }
    let outer = if outer > 0.0 { outer.min(FRAC_PI_2) } else { FRAC_PI_4 };
    Ok(PunctualKind::Spot { inner: inner.clamp(0.0, outer) as f32, outer: outer as f32 })
}
