//! The file's punctual lights, where their numbers are not those that are to be rendered: `--light-units`, `--light-scale`.
//!
//! glTF has candela and lux (KHR_lights_punctual), and so they are taken: the picture is then luminance in cd/m². Blender
//! has a strength S instead, in W (point, spot) or W/m² (sun), and its exporter writes it in one of three lighting modes
//! (`export_import_convert_lighting_mode`, `PBR_WATTS_TO_LUMENS` = 683 lm/W):
//!
//! | mode | point, spot | sun | option |
//! | --- | --- | --- | --- |
//! | Standard (`SPEC`, the default) | 683 S/4π cd | 683 S lx | `blender` |
//! | Unitless (`COMPAT`) | S/4π | S | `unitless` |
//! | Raw (`RAW`) | S | S | `watts` |
//!
//! Cycles shows radiance. Its point lamp of radius r has the radiance S/(4π² r²) and is seen as a disk of π r², so it has the
//! radiant intensity S/4π in W/sr, whatever r; its spot has the same in the middle of its cone; its sun has the irradiance
//! S. So all three options give S/4π and S, and one picture, in which lamps are to emission and environments as they are
//! in Blender.

use super::message::Reporter;
use super::names;
use crate::scene::{PunctualKind, SceneDescription};
use glam::Vec3;
use std::f64::consts::PI;

/// Lumens of a watt, by convention: those at 555 nm.
pub(super) const LUMENS_A_WATT: f64 = 683.0;
/// No intensity is above this, so that sums of light stay finite.
const MOST: f32 = 1e16;

/// What the numbers of a file's punctual lights mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum LightUnits {
    /// Candela and lux, as glTF has it; they are rendered as they are.
    #[default]
    Candela,
    /// Candela and lux that Blender's exporter made of watts.
    Blender,
    /// W/sr and W/m².
    Unitless,
    /// W in all directions (point, spot) and W/m² (sun).
    Watts,
}

impl LightUnits {
    const ALL: [Self; 4] = [Self::Candela, Self::Blender, Self::Unitless, Self::Watts];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Candela => "candela",
            Self::Blender => "blender",
            Self::Unitless => "unitless",
            Self::Watts => "watts",
        }
    }

    /// What the number of a light is multiplied by.
    fn factor(self, kind: &PunctualKind) -> f64 {
        match (self, kind) {
            // Blender's exporter writes no profiles.
            (_, PunctualKind::Web(_)) => 1.0,
            (Self::Candela | Self::Unitless, _) | (Self::Watts, PunctualKind::Directional) => 1.0,
            (Self::Blender, _) => 1.0 / LUMENS_A_WATT,
            (Self::Watts, PunctualKind::Point | PunctualKind::Spot { .. }) => 1.0 / (4.0 * PI),
        }
    }
}

/// Reads the name of a unit.
pub(super) fn light_units(text: &str) -> Result<LightUnits, String> {
    let found = LightUnits::ALL.into_iter().find(|units| units.name() == text);
    found.ok_or_else(|| names::unknown("unit of lights", text, LightUnits::ALL.map(LightUnits::name)))
}

/// How the numbers of the file's punctual lights are read.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct LightArgs {
    /// Multiply the intensity of the file's punctual and area lights
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = super::values::positive)]
    pub light_scale: f32,

    /// What the numbers of the file's punctual lights are: candela, as glTF has it (also lux); or what Blender's exporter
    /// writes: blender, in its default lighting mode; unitless; or watts, in the mode Raw. With the last three the picture
    /// is as bright as in Cycles
    #[arg(long, value_name = "candela|blender|unitless|watts", default_value = "candela", value_parser = light_units)]
    pub light_units: LightUnits,
}

impl LightArgs {
    /// Whether they change anything.
    pub fn is_asked(&self) -> bool {
        self.light_scale != 1.0 || self.light_units != LightUnits::Candela
    }

    /// Converts the lights of a scene.
    pub fn adjust(&self, scene: &mut SceneDescription) {
        for light in &mut scene.lights {
            let factor = f64::from(self.light_scale) * self.light_units.factor(&light.kind);
            light.intensity = (light.intensity.as_dvec3() * factor).as_vec3().min(Vec3::splat(MOST));
        }
        for light in &mut scene.area_lights {
            light.radiance = (light.radiance * self.light_scale).min(Vec3::splat(MOST));
        }
    }

    /// Lights that are not there are not converted.
    pub fn say_what_they_do(&self, scene: &SceneDescription, reporter: &Reporter) {
        if self.light_units != LightUnits::Candela && scene.lights.is_empty() {
            reporter.note("--light-units does nothing: the file has no punctual lights");
        }
        if self.light_scale != 1.0 && scene.lights.is_empty() && scene.area_lights.is_empty() {
            reporter.note("--light-scale does nothing: the file has no punctual lights and no area lights");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PunctualLight;

    /// What each mode writes of a lamp of strength S, computed by hand: 1000/4π = 79.577472, times 683 = 54351.413.
    #[test]
    fn one_lamp_in_three_lighting_modes_is_one_lamp() {
        let kinds = [
            (PunctualKind::Point, [54_351.41, 79.577_47, 1000.0], 79.577_47),
            (PunctualKind::Spot { inner: 0.1, outer: 0.5 }, [16_305.424, 23.873_24, 300.0], 23.873_24),
            (PunctualKind::Directional, [2049.0, 3.0, 3.0], 3.0),
        ];
        for (kind, written, radiometric) in kinds {
            let modes = [LightUnits::Blender, LightUnits::Unitless, LightUnits::Watts];
            for (units, intensity) in modes.into_iter().zip(written) {
                let light = PunctualLight {
                    name: String::new(),
                    intensity: Vec3::new(intensity, 0.0, 0.5 * intensity),
                    position: Vec3::ZERO,
                    direction: Vec3::NEG_Z,
                    range: None,
                    kind: kind.clone(),
                };
                let mut scene = SceneDescription { lights: vec![light], ..Default::default() };
                LightArgs { light_scale: 2.0, light_units: units }.adjust(&mut scene);
                let expected = 2.0 * Vec3::new(radiometric, 0.0, 0.5 * radiometric);
                let found = scene.lights[0].intensity;
                assert!(
                    (found - expected).length() < 1e-6 * expected.length(),
                    "{units:?} {kind:?}: {found}"
                );
            }
        }
    }
}
