//! From the options of a scene to a scene that can be rendered: what all commands that render begin with.

use super::Failure;
use super::animation::ShutterArgs;
use super::args::SceneArgs;
use super::job::{check_not_inputs, file_name};
use super::message::Reporter;
use super::names;
use super::pipeline::{
    self, Asset, Cosines, Microfacet, Moment, Registry, RenderControl, RenderOptions, Rendered, SampleRange,
    Scene, Settings, Shutter, View,
};
use super::progress::Progress;
use super::stats::Stopwatch;
use super::values::{EnvArg, GroundArg};
use super::warnings::warn_of_open_media;
use crate::scene::{CameraDescription, EnvironmentDescription, Lens, Projection, SceneDescription};
use glam::Vec3;
use serde_json::{Value, json};
use std::path::Path;

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

/// A scene with everything that was asked for, compiled.
pub(super) struct Prepared {
    pub scene: Scene,
    pub camera: CameraDescription,
    pub width: u32,
    pub height: u32,
    /// Height of a ground that catches shadows.
    pub ground: Option<f32>,
    /// Of the scene without a ground.
    bounds: Option<[Vec3; 2]>,
    /// What the environment is called in the files written.
    pub environment: String,
    /// Whether Blender's exporter wrote the file.
    pub of_blender: bool,
    /// The file, for other moments.
    asset: Asset,
    moment: Moment,
    /// If it is open while something may move; then the moment is that of its opening.
    shutter: Option<Shutter>,
    pub load_seconds: f64,
    pub build_seconds: f64,
}

impl Prepared {
    /// Loads and compiles what `args` ask for; none of the files may be an output.
    pub fn new(
        args: &SceneArgs,
        size: Size,
        blur: &ShutterArgs,
        outputs: &[&Path],
        reporter: &Reporter,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let mut watch = Stopwatch::start();
        let loading = format!("loading {}", file_name(&args.load.input));
        progress.phase(&loading);
        let asset = pipeline::open(args);
        progress.clear();
        let mut asset = asset?;
        check_not_inputs(outputs, &asset.files())?;
        let mut moment = args.play.moment(&asset, blur.shutter.is_some(), reporter)?;
        moment.time += blur.shutter.map_or(0.0, |[open, _]| open);
        progress.phase(&loading);
        let loaded = pipeline::load(&args.load.input, &mut asset, &moment);
        progress.clear();
        let loaded = loaded?;
        reporter.diagnostics(&loaded.diagnostics);
        let of_blender = loaded.summary.generator.is_some_and(|generator| generator.contains("Blender"));
        let mut description = loaded.scene;
        args.lights.adjust(&mut description);
        args.lights.say_what_they_do(&description, reporter);
        let (environment, is_studio) =
            pipeline::choose_environment(args.env.as_ref(), &description, reporter)?;
        description.environment = environment;
        say_what_environment_options_do(args, &description, reporter);
        pipeline::adjust_environment(&mut description.environment, args.env_rotation, args.env_intensity);
        let (camera, (width, height)) = view(args.camera.as_deref(), size, &description, reporter)?;
        let camera = focused(camera, args);
        say_what_lens_options_do(args, &camera, reporter);
        let bounds = match args.ground {
            GroundArg::Color(_) => description.bounds(),
            _ => None,
        };
        let ground = set_ground(args.ground, &mut description, reporter);
        let load_seconds = watch.lap();

        progress.phase("building");
        let scene = pipeline::build(description);
        progress.clear();
        let scene = scene?;
        let build_seconds = watch.lap();
        warn_of_open_media(&scene, reporter);
        let environment = environment_name(args.env.as_ref(), is_studio);
        Ok(Self {
            scene,
            camera,
            width,
            height,
            ground,
            bounds,
            environment,
            of_blender,
            asset,
            shutter: blur.at(&moment),
            moment,
            load_seconds,
            build_seconds,
        })
    }

    /// Renders a picture, or a mean of pictures while the shutter is open.
    pub fn render(
        &mut self,
        args: &SceneArgs,
        options: &RenderOptions,
        models: &Registry,
        control: &dyn RenderControl,
    ) -> Result<Rendered, Failure> {
        match self.shutter {
            None => pipeline::render(&self.scene, options, models, control),
            Some(shutter) => {
                let pose = |time| self.at(time, args);
                pipeline::render_shutter(&shutter, options, models, control, pose)
            }
        }
    }

    /// The scene and the camera at another moment, under the light and on the ground of this one. A camera that frames the
    /// scene stays where it is, and so does one that is not there at that moment.
    fn at(&mut self, time: f64, args: &SceneArgs) -> Result<(Scene, CameraDescription), Failure> {
        let moment = Moment { time, ..self.moment.clone() };
        let mut description = pipeline::load(&args.load.input, &mut self.asset, &moment)?.scene;
        args.lights.adjust(&mut description);
        let camera = choose_camera(args.camera.as_deref(), &description).ok().flatten().cloned();
        description.environment = self.scene.description.environment.clone();
        if let (GroundArg::Color(reflectance), Some(bounds)) = (args.ground, self.bounds) {
            description.add_ground_below(bounds, reflectance);
        }
        let camera = camera.map_or_else(|| self.camera.clone(), |camera| focused(camera, args));
        Ok((pipeline::build(description)?, camera))
    }

    /// What to render with one model.
    pub fn options(&self, args: &SceneArgs, spp: u32, subsurface: &str) -> RenderOptions {
        RenderOptions {
            view: View {
                width: self.width,
                height: self.height,
                camera: self.camera.clone(),
                ground: self.ground,
                transparent: false,
                light_layers: Vec::new(),
            },
            settings: Settings {
                subsurface: subsurface.to_owned(),
                seed: args.seed,
                max_depth: args.max_depth,
                microfacet: args.microfacet,
                aim: !args.no_aim,
                texture_filter: if args.no_texture_filter { 0.0 } else { args.texture_filter },
            },
            samples: SampleRange { first: 0, count: spp },
            threads: args.threads.unwrap_or(0),
        }
    }

    /// The options that change a picture, for its record; the model and the tone map are left to the caller.
    pub fn record(&self, args: &SceneArgs) -> Value {
        let mut recorded = json!({
            "size": [self.width, self.height],
            "camera": self.camera.name,
            "env": self.environment,
            "env_rotation": args.env_rotation,
            "env_intensity": args.env_intensity,
            "texture_filter": if args.no_texture_filter { 0.0 } else { args.texture_filter },
            "max_depth": args.max_depth,
            "microfacet": match args.microfacet {
                Microfacet::Multiple => "multiple",
                Microfacet::Single => "single",
            },
            "brdf_cosines": match args.brdf_cosines {
                Cosines::Refracted => "refracted",
                Cosines::Unrefracted => "unrefracted",
            },
        });
        match args.ground {
            GroundArg::None => {}
            GroundArg::Shadow => recorded["ground"] = json!("shadow"),
            GroundArg::Color(c) => recorded["ground"] = json!(c.to_array()),
        }
        if args.lights.is_asked() {
            recorded["light_scale"] = json!(args.lights.light_scale);
            recorded["light_units"] = json!(args.lights.light_units.name());
        }
        if let Some((radius, focus)) = self.camera.lens.and_then(|lens| lens.aperture()) {
            recorded["aperture_diameter"] = json!(2.0 * radius);
            recorded["focus_distance"] = json!(focus);
        }
        if let Some(variant) = &args.variant {
            recorded["variant"] = json!(variant);
        }
        if let Some(tolerance) = args.load.weld_tolerance {
            recorded["weld_tolerance"] = json!(tolerance);
        }
        if let Some(scene) = args.scene {
            recorded["scene"] = json!(scene);
        }
        if !self.moment.animations.is_empty() {
            recorded["animations"] = json!(self.moment.animations);
            recorded["at"] = json!(args.play.at.unwrap_or(0.0));
        }
        if let Some(shutter) = self.shutter {
            recorded["shutter"] = json!([shutter.open, shutter.close]);
            recorded["shutter_slices"] = json!(shutter.slices);
        }
        recorded
    }
}

/// Puts the ground into the scene, or tells how high it is where it only catches shadows.
fn set_ground(wanted: GroundArg, scene: &mut SceneDescription, reporter: &Reporter) -> Option<f32> {
    let (found, height) = match wanted {
        GroundArg::None => return None,
        GroundArg::Shadow => {
            let height = scene.ground_height();
            (height.is_some(), height)
        }
        GroundArg::Color(reflectance) => (scene.add_ground(reflectance), None),
    };
    if !found {
        reporter.note("--ground does nothing: there is nothing to stand on it");
    }
    height
}

/// Options that turn or dim what is not there, or looks the same from all sides, are more likely a mistake.
fn say_what_environment_options_do(args: &SceneArgs, scene: &SceneDescription, reporter: &Reporter) {
    if let EnvironmentDescription::Constant(radiance) = scene.environment {
        if args.env_rotation != 0.0 {
            reporter.note("--env-rotation does nothing: the environment is the same from all sides");
        }
        if args.env_intensity != 1.0 && radiance.max_element() <= 0.0 {
            reporter.note("--env-intensity does nothing: there is no environment (choose one with --env)");
        }
    }
}

/// The camera with the lens that was asked for: its own, or that of a full-frame camera, with another opening or focus.
fn focused(mut camera: CameraDescription, args: &SceneArgs) -> CameraDescription {
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
fn say_what_lens_options_do(args: &SceneArgs, camera: &CameraDescription, reporter: &Reporter) {
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
fn view(
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
    fn with_aspect(self, camera: Option<f32>) -> (u32, u32) {
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

fn environment_name(wanted: Option<&EnvArg>, is_studio: bool) -> String {
    match wanted {
        Some(EnvArg::Constant(c)) => format!("{},{},{}", c.x, c.y, c.z),
        Some(EnvArg::File(path)) => file_name(path),
        _ if is_studio => "studio".to_owned(),
        _ => "none".to_owned(),
    }
}

/// The camera that was asked for, by name or else by index; the first where none was; `None` if there is none.
fn choose_camera<'a>(
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
