//! `EXT_camera_physical`: the lens and the sensor that a perspective camera stands for (glTF pull request 2608, a proposal).
//!
//! What is seen follows from the projection alone. The f-number and the distance of focus blur what is not at that
//! distance ([`crate::scene::Lens`]); the sensor is told. Exposure, blades and animation are not part of the proposal.

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::{CameraDescription, Lens, Projection};

/// Fields of view that differ by a smaller part are the same.
const SAME_VIEW: f64 = 0.01;

pub(super) struct CameraPhysical;

impl Extension for CameraPhysical {
    fn name(&self) -> &str {
        "EXT_camera_physical"
    }

    fn shortfall(&self) -> Option<&str> {
        Some("a proposal, which may still change")
    }

    fn camera(
        &self,
        loader: &mut Loader<'_>,
        own: &Json<'_>,
        _: &Json<'_>,
        out: &mut CameraDescription,
    ) -> Result<(), AssetError> {
        let Projection::Perspective { yfov, aspect } = out.projection else {
            return loader.invalid(own.pointer(), "is only for perspective cameras; it is ignored");
        };
        let focal_length = above_zero(loader, own, "focalLength", true)?;
        let f_stop = above_zero(loader, own, "fStop", false)?;
        let sensor = own.numbers::<2>("sensorSize")?.filter(|s| s.iter().all(|side| *side > 0.0));
        if sensor.is_none() {
            loader.invalid(&own.pointer_to("sensorSize"), "two numbers above 0 are expected")?;
        }
        let focus = own.f64("focusDistance")?;
        if let Some(focus) = focus.filter(|focus| *focus < 0.0) {
            loader.invalid(&own.pointer_to("focusDistance"), format!("{focus} is below 0; it is ignored"))?;
        }
        let focus = focus.filter(|focus| *focus >= 0.0);
        if loader.requires(self.name()) {
            let message = "should not be required: the projection says all that is needed without it";
            loader.warn(own.pointer(), message, Some("list it in extensionsUsed alone"));
        }
        let Some(focal_length) = focal_length else { return Ok(()) };
        if f_stop.is_some() && focus.is_none_or(|focus| focus == 0.0) {
            let message = "has an f-number and no distance of focus, so that everything is sharp";
            loader.note(own.pointer(), message);
        }
        if let Some([width, height]) = sensor {
            let tangent = (0.5 * f64::from(yfov)).tan();
            let upright = 0.5 * height / focal_length;
            let across = aspect.map(|aspect| 0.5 * width / focal_length / f64::from(aspect));
            let fits = |other: f64| (other / tangent - 1.0).abs() < SAME_VIEW;
            if !fits(upright) && !across.is_some_and(fits) {
                let message = format!(
                    "sees {:.1}° upright, and the camera {:.1}°, which counts",
                    2.0 * upright.atan().to_degrees(),
                    f64::from(yfov).to_degrees()
                );
                loader.note(own.pointer(), message);
            }
        }
        let single = |x: f64| x as f32;
        out.lens = Some(Lens {
            focal_length: single(focal_length),
            sensor: sensor.map_or([0.0; 2], |s| s.map(single)),
            f_stop: f_stop.map(single),
            focus_distance: focus.map(single),
        });
        Ok(())
    }
}

fn above_zero(
    loader: &mut Loader<'_>,
    own: &Json<'_>,
    key: &str,
    required: bool,
) -> Result<Option<f64>, AssetError> {
    match own.f64(key)? {
        Some(value) if value > 0.0 => Ok(Some(value)),
        Some(value) => {
            loader.invalid(&own.pointer_to(key), format!("{value} is not above 0; it is ignored"))?;
            Ok(None)
        }
        None if required => {
            loader.invalid(&own.pointer_to(key), "is missing, and with it the lens")?;
            Ok(None)
        }
        None => Ok(None),
    }
}
