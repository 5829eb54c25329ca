//! Who looks, and on how large a picture: the camera that was asked for, its lens, and the size that follows from it.

use super::args::SceneArgs;
use super::message::Reporter;
use super::{Failure, names, pipeline};
use crate::scene::{CameraDescription, Lens, Projection, SceneDescription};

/// Aspect ratios that differ by less than this are the same.
const ASPECT_TOLERANCE: f32 = 0.01;
/// Aspect ratio where neither the command line nor the camera gives one.
const DEFAULT_ASPECT: f32 = 4.0 / 3.0;

/// The size of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    /// What was asked for, if anything was.
    pub asked: Option<(u32, u32)>,
    /// Otherwise the longest side.
    pub longest_side: u32,
}

/// The camera with the lens that was asked for: its own, or that of a full-frame camera, with another opening or focus.
pub(super) fn focused(mut camera: CameraDescription, args: &SceneArgs) -> CameraDescription {
    if let Projection::Perspective { yfov, .. } = camera.projection
        && (args.f_stop.is_some() || args.focus_distance.is_some())
    {
        let lens = camera.lens.unwrap_or_else(|| Lens::full_frame(yfov));
        let (f_stop, focus_distance) =
            (args.f_stop.or(lens.f_stop), args.focus_distance.or(lens.focus_distance));
        camera.lens = Some(Lens { f_stop, focus_distance, ..lens });
    }
    camera
}

/// One of two options that belong together is more likely a mistake.
pub(super) fn say_what_lens_options_do(args: &SceneArgs, camera: &CameraDescription, reporter: &Reporter) {
    let asked = match (args.f_stop, args.focus_distance) {
        (Some(_), _) => "--f-stop",
        (None, Some(_)) => "--focus-distance",
        (None, None) => return,
    };
    let why = match (camera.projection, camera.lens) {
        (Projection::Orthographic { .. }, _) => "parallel rays have no lens",
        (_, Some(lens)) if lens.aperture().is_some() => return,
        (_, Some(Lens { focus_distance: None, .. })) => "nothing says at which distance (--focus-distance)",
        _ => "nothing says how wide the lens is open (--f-stop)",
    };
    reporter.note(format!("{asked} does nothing: {why}"));
}

/// The camera and the size of the picture.
pub(super) fn view(
    wanted: Option<&str>,
    size: Size,
    scene: &SceneDescription,
    reporter: &Reporter,
) -> Result<(CameraDescription, (u32, u32)), Failure> {
    let chosen = choose_camera(wanted, scene)?;
    let own_aspect = chosen.and_then(|camera| match camera.projection {
        Projection::Perspective { aspect, .. } | Projection::Orthographic { aspect, .. } => aspect,
    });
    let (width, height) = size.with_aspect(own_aspect);
    let aspect = width as f32 / height as f32;
    if let Some(own) = own_aspect.filter(|own| (own / aspect - 1.0).abs() > ASPECT_TOLERANCE) {
        reporter.note(format!(
            "the camera's aspect ratio is {own:.3}, the picture's {aspect:.3}: what is seen to the sides changes"
        ));
    }
    let camera = match chosen {
        Some(camera) => camera.clone(),
        None => {
            reporter.note("the file has no camera; the whole scene is framed");
            pipeline::automatic_camera(scene, aspect)
        }
    };
    Ok((camera, (width, height)))
}

impl Size {
    /// What was asked for, else the longest side with the camera's aspect ratio.
    pub fn with_aspect(self, camera: Option<f32>) -> (u32, u32) {
        let aspect = camera.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(DEFAULT_ASPECT);
        let longest = self.longest_side;
        let shorter = |ratio: f32| ((longest as f32 * ratio).round() as u32).clamp(1, longest);
        self.asked.unwrap_or(if aspect >= 1.0 {
            (longest, shorter(1.0 / aspect))
        } else {
            (shorter(aspect), longest)
        })
    }
}

/// The camera that was asked for, by name or else by index; the first where none was; `None` if there is none.
pub(super) fn choose_camera<'a>(
    wanted: Option<&str>,
    scene: &'a SceneDescription,
) -> Result<Option<&'a CameraDescription>, Failure> {
    let Some(wanted) = wanted else { return Ok(scene.cameras.first()) };
    if let Some(found) = CameraDescription::find(&scene.cameras, wanted) {
        return Ok(scene.cameras.get(found));
    }
    if scene.cameras.is_empty() {
        return Err(Failure::advise(
            format!("there is no camera {wanted:?}: the file has none"),
            "leave --camera out, and the whole scene is framed",
        ));
    }
    let known = scene.cameras.iter().map(|camera| camera.name.as_str());
    Err(Failure::advise(
        names::unknown("camera", wanted, known),
        format!("give a name, or an index from 0 to {}", scene.cameras.len() - 1),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;

    fn scene(names: &[&str]) -> SceneDescription {
        let camera = |name: &&str| CameraDescription {
            name: (*name).to_owned(),
            transform: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov: 1.0, aspect: Some(2.0) },
            clip: crate::scene::Clip::NONE,
            lens: None,
        };
        SceneDescription { cameras: names.iter().map(camera).collect(), ..Default::default() }
    }

    #[test]
    fn cameras_are_found_by_name_before_index() {
        let scene = scene(&["Front", "0", "Side"]);
        let name = |wanted| choose_camera(wanted, &scene).unwrap().map(|c| c.name.clone());
        assert_eq!(name(None).as_deref(), Some("Front"));
        assert_eq!(name(Some("0")).as_deref(), Some("0"));
        assert_eq!(name(Some("2")).as_deref(), Some("Side"));
        for wrong in ["3", "Sidee", "-1"] {
            let Err(Failure::Cannot { message, advice }) = choose_camera(Some(wrong), &scene) else {
                panic!("{wrong} was found")
            };
            assert!(message.contains("Side") && advice.unwrap().contains("0 to 2"), "{message}");
        }
        assert!(choose_camera(None, &SceneDescription::default()).unwrap().is_none());
    }

    #[test]
    fn default_sizes_have_the_longest_side_that_is_asked_for() {
        let size = |aspect| Size { asked: None, longest_side: 1024 }.with_aspect(aspect);
        assert_eq!(size(None), (1024, 768));
        assert_eq!(size(Some(16.0 / 9.0)), (1024, 576));
        assert_eq!(size(Some(0.5)), (512, 1024));
        assert_eq!(size(Some(1.0)), (1024, 1024));
        assert_eq!(size(Some(1e9)), (1024, 1));
        assert_eq!(size(Some(f32::NAN)), (1024, 768));
        assert_eq!(Size { asked: Some((3, 4)), longest_side: 9 }.with_aspect(Some(2.0)), (3, 4));
    }
}
