//! From the options of a scene to a scene that can be rendered: what all commands that render begin with.

use super::Failure;
use super::animation::ShutterArgs;
use super::args::SceneArgs;
use super::job::{check_not_inputs, file_name};
use super::message::Reporter;
use super::pipeline::{
    self, Asset, Cosines, Microfacet, Moment, Registry, RenderControl, RenderOptions, Rendered, SampleRange,
    Scene, Settings, Shutter, View,
};
use super::progress::Progress;
use super::stats::Stopwatch;
use super::values::{EnvArg, GroundArg};
use super::view::{self, Size, focused, say_what_lens_options_do, view};
use super::warnings::warn_of_open_media;
use crate::scene::{CameraDescription, EnvironmentDescription, SceneDescription};
use glam::Vec3;
use serde_json::{Value, json};
use std::path::Path;

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
        let camera = view::choose_camera(args.camera.as_deref(), &description).ok().flatten().cloned();
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

fn environment_name(wanted: Option<&EnvArg>, is_studio: bool) -> String {
    match wanted {
        Some(EnvArg::Constant(c)) => format!("{},{},{}", c.x, c.y, c.z),
        Some(EnvArg::File(path)) => file_name(path),
        _ if is_studio => "studio".to_owned(),
        _ => "none".to_owned(),
    }
}
