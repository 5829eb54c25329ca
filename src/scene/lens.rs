//! The lens of a physical camera (EXT_camera_physical): what blurs that is not at the distance of focus.
//!
//! A thin lens of diameter A = f/N, focused at the distance s, images a point at the distance d onto a disk. In the plane of
//! the point that disk has the diameter A |d − s| / s, whatever is behind the lens; on the sensor it is the circle of
//! confusion A |d − s| / d · f / (s − f). The field of view is that of the focused picture, so that focusing does not zoom.

/// A lens and the sensor behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Focal length f, metres, above 0.
    pub focal_length: f32,
    /// Width and height of the sensor, metres. Told, not used: the projection says what is seen.
    pub sensor: [f32; 2],
    /// The f-number N = f/A, above 0. Without it everything is sharp.
    pub f_stop: Option<f32>,
    /// Distance s of the plane of focus from the lens, metres in the world. Without it, or at 0, everything is sharp.
    pub focus_distance: Option<f32>,
}

/// Width and height of the sensor that photographers compare with, metres: small-format film, 24 mm × 36 mm.
const FULL_FRAME: [f32; 2] = [0.036, 0.024];

impl Lens {
    /// The lens that gives a vertical field of view, in radians, on the sensor of a full-frame camera;
    /// neither f-number nor focus.
    pub fn full_frame(yfov: f32) -> Self {
        let focal_length = 0.5 * FULL_FRAME[1] / (0.5 * yfov).tan().max(f32::MIN_POSITIVE);
        Self { focal_length, sensor: FULL_FRAME, f_stop: None, focus_distance: None }
    }

    /// Radius of the opening and distance of focus, metres; `None` where everything is sharp.
    pub fn aperture(&self) -> Option<(f32, f32)> {
        let radius = 0.5 * self.focal_length / self.f_stop?;
        let focus = self.focus_distance?;
        (radius > 0.0 && radius.is_finite() && focus > 0.0 && focus.is_finite()).then_some((radius, focus))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opening_is_focal_length_over_f_number() {
        let lens = Lens { f_stop: Some(2.0), focus_distance: Some(5.0), ..Lens::full_frame(0.471_0) };
        // 50 mm on 24 mm have 2 atan(12/50) = 0.4711.
        assert!((lens.focal_length - 0.05).abs() < 2e-5, "{}", lens.focal_length);
        let (radius, focus) = lens.aperture().expect("open");
        assert!((radius - lens.focal_length / 4.0).abs() < 1e-9 && focus == 5.0);
        assert_eq!(Lens { f_stop: None, ..lens }.aperture(), None);
        assert_eq!(Lens { focus_distance: None, ..lens }.aperture(), None);
        assert_eq!(Lens { focus_distance: Some(0.0), ..lens }.aperture(), None);
        assert_eq!(Lens { f_stop: Some(f32::MIN_POSITIVE), focal_length: 1e9, ..lens }.aperture(), None);
    }
}
