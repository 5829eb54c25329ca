//! The library as the commands see it: every call into the loader, the scene and the tracer is made here, and their
//! errors become [`Failure`]s.

use super::Failure;
use super::args::{LoadArgs, SceneArgs};
use super::authored::cannot_read;
use super::documents::is_standard_input;
use super::message::Reporter;
use super::values::EnvArg;
use crate::asset::{self, environment::load_environment};
use crate::light::studio::studio;
use crate::plural::count;
use crate::scene::{
    CameraDescription, EnvironmentDescription, MaterialDescription, SceneDescription, auto_camera,
};
use crate::{subsurface, transport};
use glam::Vec3;
use std::path::Path;

pub(super) use crate::asset::{Asset, Diagnostic, Loaded, Moment, Severity, Summary};
pub(super) use crate::optics::Microfacet;
pub(super) use crate::optics::diffusion::Cosines;
pub(super) use crate::scene::Scene;
pub(super) use crate::subsurface::Registry;
pub(super) use crate::transport::{
    RenderControl, RenderOptions, RenderStats, Rendered, SampleRange, Settings, Shutter, View,
};

/// Names of the subsurface models.
pub(super) fn subsurface_models() -> Vec<String> {
    Registry::standard().iter().map(|model| model.name().to_owned()).collect()
}

/// The subsurface models, with that choice of cosines where there is one.
pub(super) fn models(cosines: Cosines) -> Registry {
    let mut models = Registry::standard();
    models.register(Box::new(subsurface::BrdfApproximation { cosines }));
    models.register(Box::new(subsurface::LightBiased { cosines }));
    models
}

/// Starts the threads that do everything from now on; as many as the machine has, if nothing else is asked for.
pub(super) fn start_threads(asked: Option<usize>) -> Result<(), Failure> {
    let started = rayon::ThreadPoolBuilder::new().num_threads(asked.unwrap_or(0)).build_global();
    started.map_err(|error| {
        let number = asked.map_or("threads".to_owned(), |n| count(n, "thread", "threads"));
        Failure::advise(
            format!("cannot start {number}: {error}"),
            "ask for fewer with --threads, or let this user have more processes and memory (ulimit)",
        )
    })
}

/// Opens a glTF file.
pub(super) fn open(args: &SceneArgs) -> Result<Asset, Failure> {
    let (variant, camera) = (args.variant.clone(), args.camera.clone());
    let (scene, strict) = (args.scene, args.strict);
    open_with(&args.load, asset::LoadOptions { scene, variant, strict, camera, ..Default::default() })
}

/// Options of the loader, to which those of the arguments are added.
pub(super) fn load_options(args: &LoadArgs, mut options: asset::LoadOptions) -> asset::LoadOptions {
    options.allow_outside = args.allow_outside;
    options.weld_tolerance = args.weld_tolerance;
    for (name, value) in &args.limits {
        options.limits.set(name, *value);
    }
    options
}

/// Opens a glTF file with options, to which those of the arguments are added.
pub(super) fn open_with(args: &LoadArgs, options: asset::LoadOptions) -> Result<Asset, Failure> {
    let options = load_options(args, options);
    let path = &args.input;
    let opened = if is_standard_input(path) {
        Asset::from_stream(std::io::stdin().lock(), &options)
    } else {
        Asset::open(path, &options)
    };
    opened.map_err(|error| cannot_read(path, &error))
}

/// Reads the scene of a glTF file at a moment.
pub(super) fn load(path: &Path, asset: &mut Asset, moment: &Moment) -> Result<Loaded, Failure> {
    asset.load(moment).map_err(|error| cannot_read(path, &error))
}

/// Compiles a scene.
pub(super) fn build(description: SceneDescription) -> Result<Scene, Failure> {
    Scene::build(description).map_err(|e| Failure::Cannot { advice: e.advice(), message: e.to_string() })
}

/// Renders a picture.
pub(super) fn render(
    scene: &Scene,
    options: &RenderOptions,
    models: &Registry,
    control: &dyn RenderControl,
) -> Result<Rendered, Failure> {
    transport::render_with(scene, options, control, models).map_err(Failure::cannot)
}

/// Renders a picture while the shutter is open; `pose` gives the scene and the camera of a moment.
pub(super) fn render_shutter(
    shutter: &Shutter,
    options: &RenderOptions,
    models: &Registry,
    control: &dyn RenderControl,
    pose: impl FnMut(f64) -> Result<(Scene, CameraDescription), Failure>,
) -> Result<Rendered, Failure> {
    transport::render_shutter(shutter, options, control, models, pose)
}

impl From<transport::RenderError> for Failure {
    fn from(error: transport::RenderError) -> Self {
        Self::cannot(error)
    }
}

/// Everything a render counts, by name, in a fixed order.
pub(super) fn counters(stats: &RenderStats) -> Vec<(&'static str, u64)> {
    vec![
        ("scattering_events", stats.scattering_events),
        ("truncated_paths", stats.truncated_paths),
        ("leaked_paths", stats.leaked_paths),
        ("lost_paths", stats.lost_paths),
        ("invalid_samples", stats.invalid_samples),
    ]
}

/// Whether a material makes triangles into lamps. Emissive textures do not: they are mostly details, such as the
/// lights of a dashboard, on models that are meant to be seen in some environment.
pub(super) fn is_lamp(material: &MaterialDescription) -> bool {
    material.emission.max_element() > 0.0 && material.emission_texture.is_none()
}

/// Whether the scene brings its own light: punctual and area lights, an environment, or lamps.
pub(super) fn is_lit(scene: &SceneDescription) -> bool {
    let sky = match &scene.environment {
        EnvironmentDescription::Constant(radiance) => radiance.max_element() > 0.0,
        EnvironmentDescription::Map { .. } => true,
    };
    let shines = |&material: &u32| scene.materials.get(material as usize).is_some_and(is_lamp);
    let mut meshes = scene.instances.iter().filter_map(|instance| scene.meshes.get(instance.mesh));
    let lights = !scene.lights.is_empty() || scene.area_lights.iter().any(|l| l.radiance != Vec3::ZERO);
    sky || lights || meshes.any(|mesh| mesh.triangle_materials.iter().any(shines))
}

/// The environment that was asked for, or the studio where nothing else would shine. Says whether it is the studio.
pub(super) fn choose_environment(
    wanted: Option<&EnvArg>,
    scene: &SceneDescription,
    reporter: &Reporter,
) -> Result<(EnvironmentDescription, bool), Failure> {
    Ok(match wanted {
        Some(EnvArg::Studio) => (studio(), true),
        Some(EnvArg::None) => (EnvironmentDescription::Constant(Vec3::ZERO), false),
        Some(EnvArg::Constant(radiance)) => (EnvironmentDescription::Constant(*radiance), false),
        Some(EnvArg::File(path)) => {
            let loaded = load_environment(path).map_err(Failure::cannot)?;
            if loaded.replaced_texels > 0 {
                reporter.warning(format!(
                    "{}: {} negative or not finite; channels of +∞ count as 65504, the others as 0",
                    path.display(),
                    count(loaded.replaced_texels, "texel is", "texels are")
                ));
            }
            if !loaded.is_two_to_one {
                reporter.warning(format!(
                    "{}: an equirectangular map is twice as wide as high; this one will look squeezed",
                    path.display()
                ));
            }
            (loaded.environment, false)
        }
        None if is_lit(scene) => (scene.environment.clone(), false),
        None => {
            reporter.note("the file has no lights; the built-in studio lights the scene (choose with --env)");
            (studio(), true)
        }
    })
}

/// Turns an environment by `degrees` about +Y and multiplies its radiance.
pub(super) fn adjust_environment(environment: &mut EnvironmentDescription, degrees: f32, intensity: f32) {
    match environment {
        EnvironmentDescription::Constant(radiance) => *radiance *= intensity,
        EnvironmentDescription::Map { scale, rotation, .. } => {
            *scale *= intensity;
            *rotation += degrees.to_radians();
        }
    }
}

/// A camera that sees the whole scene: three-quarter view from slightly above, vertical field of view 35°. It frames
/// the sphere around the middle of the bounds that holds every triangle, which is tighter than the one around the
/// corners of the bounds.
pub(super) fn automatic_camera(scene: &SceneDescription, aspect: f32) -> CameraDescription {
    let Some((center, radius)) = scene.bounding_sphere() else {
        return auto_camera(Vec3::NEG_ONE, Vec3::ONE, aspect);
    };
    // The cube whose corners lie on that sphere.
    let half = Vec3::splat(radius / 3f32.sqrt());
    auto_camera(center - half, center + half, aspect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ColorSpace, InstanceDescription, MeshDescription, TextureRef};
    use glam::{Affine2, Affine3A};

    fn octahedron(material: MaterialDescription) -> SceneDescription {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        let mesh = MeshDescription {
            positions: axes.to_vec(),
            triangles: (0..8)
                .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|k| 3 * k))
                .map(|[a, b, c]| [a, b + 1, c + 2])
                .collect(),
            triangle_materials: vec![0; 8],
            ..Default::default()
        };
        let instance = InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh: 0,
            transform: Affine3A::from_translation(Vec3::splat(5.0)),
        };
        SceneDescription {
            meshes: vec![mesh],
            materials: vec![material],
            instances: vec![instance],
            ..Default::default()
        }
    }

    #[test]
    fn lamps_light_a_scene_and_glowing_textures_do_not() {
        let glow = MaterialDescription { emission: Vec3::ONE, ..Default::default() };
        let texture =
            TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY, color_space: ColorSpace::Srgb };
        let display = MaterialDescription { emission_texture: Some(texture), ..glow.clone() };
        assert!(!is_lit(&octahedron(MaterialDescription::default())));
        assert!(is_lit(&octahedron(glow.clone())));
        assert!(!is_lit(&octahedron(display)));
        let mut unused = octahedron(glow);
        unused.instances.clear();
        assert!(!is_lit(&unused));
    }

    #[test]
    fn the_automatic_camera_frames_the_vertices_not_the_corners_of_their_bounds() {
        let camera = automatic_camera(&octahedron(MaterialDescription::default()), 1.5);
        let distance = Vec3::from(camera.transform.translation).distance(Vec3::splat(5.0));
        // A sphere of radius 1 seen under 35° is 1 / sin 17.5° = 3.33 away, and some margin.
        assert!((3.3..3.9).contains(&distance), "{distance}");
        assert!(automatic_camera(&SceneDescription::default(), 1.0).transform.is_finite());
    }
}
