//! The library as the commands see it: every call into the loader, the scene and the tracer is made here, and their
//! errors become [`Failure`]s.

use super::Failure;
use super::args::EnvArg;
use super::message::Reporter;
use crate::asset::{self, environment::load_environment};
use crate::geometry::{MeshGeometry, Topology};
use crate::light::studio::studio;
use crate::scene::{
    CameraDescription, EnvironmentDescription, MeshDescription, SceneDescription, auto_camera,
};
use crate::{subsurface, transport};
use glam::Vec3;
use std::path::Path;

pub(super) use crate::asset::{Diagnostic, Loaded, Severity, Summary};
pub(super) use crate::optics::Microfacet;
pub(super) use crate::scene::Scene;
pub(super) use crate::transport::{RenderControl, RenderOptions, RenderStats, Rendered};

/// Names of the subsurface models.
pub(super) fn subsurface_models() -> Vec<String> {
    subsurface::Registry::standard().iter().map(|model| model.name().to_owned()).collect()
}

/// Loads a glTF file.
pub(super) fn load(path: &Path, scene: Option<usize>, strict: bool) -> Result<Loaded, Failure> {
    let options = asset::LoadOptions { scene, strict, ..Default::default() };
    asset::load(path, &options).map_err(|error| {
        let text = error.to_string();
        let shown = path.display().to_string();
        let message = if text.contains(&shown) { text } else { format!("{shown}: {text}") };
        Failure::Cannot { message, advice: error.advice() }
    })
}

/// Compiles a scene.
pub(super) fn build(description: SceneDescription) -> Result<Scene, Failure> {
    Scene::build(description).map_err(Failure::cannot)
}

/// Renders a picture.
pub(super) fn render(
    scene: &Scene,
    options: &RenderOptions,
    control: &dyn RenderControl,
) -> Result<Rendered, Failure> {
    transport::render(scene, options, control).map_err(Failure::cannot)
}

/// Everything a render counts, by name, in a fixed order.
pub(super) fn counters(stats: &RenderStats) -> Vec<(&'static str, u64)> {
    vec![
        ("scattering_events", stats.scattering_events),
        ("truncated_paths", stats.truncated_paths),
        ("leaked_paths", stats.leaked_paths),
        ("invalid_samples", stats.invalid_samples),
    ]
}

/// Whether anything in the scene shines.
pub(super) fn is_lit(scene: &SceneDescription) -> bool {
    let sky = match &scene.environment {
        EnvironmentDescription::Constant(radiance) => radiance.max_element() > 0.0,
        EnvironmentDescription::Map { .. } => true,
    };
    let shines = |&material: &u32| {
        scene.materials.get(material as usize).is_some_and(|m| m.emission.max_element() > 0.0)
    };
    let mut meshes = scene.instances.iter().filter_map(|instance| scene.meshes.get(instance.mesh));
    sky || !scene.lights.is_empty() || meshes.any(|mesh| mesh.triangle_materials.iter().any(shines))
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
                    "{}: {} texels are negative or not finite and count as black",
                    path.display(),
                    loaded.replaced_texels
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

/// A camera that sees the whole scene: three-quarter view from slightly above, vertical field of view 35°.
pub(super) fn automatic_camera(scene: &SceneDescription, aspect: f32) -> CameraDescription {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for instance in &scene.instances {
        for &position in scene.meshes.get(instance.mesh).map_or(&[][..], |mesh| &mesh.positions) {
            let point = instance.transform.transform_point3(position);
            if point.is_finite() {
                (min, max) = (min.min(point), max.max(point));
            }
        }
    }
    if min.cmpgt(max).any() {
        (min, max) = (Vec3::NEG_ONE, Vec3::ONE);
    }
    auto_camera(min, max, aspect)
}

/// Whether a mesh is closed, and where it is not.
pub(super) fn topology(mesh: &MeshDescription) -> Topology {
    Topology::analyse(&MeshGeometry::build(&mesh.positions, &mesh.triangles))
}
