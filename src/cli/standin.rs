//! Stand-ins for the loader and the tracer, with the signatures agreed on, until those land. To be deleted.
#![allow(dead_code)]

use crate::film::Film;
use crate::scene::{CameraDescription, MeshDescription, Projection, SceneDescription};
use glam::{Affine3A, Mat3, Vec3};
use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Severity {
    Note,
    Warning,
    Error,
}

#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(super) struct Diagnostic {
    pub severity: Severity,
    pub pointer: String,
    pub message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<String>,
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.pointer.is_empty() {
            write!(f, "{}: ", self.pointer)?;
        }
        f.write_str(&self.message)?;
        self.advice.as_ref().map_or(Ok(()), |advice| write!(f, " ({advice})"))
    }
}

#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct AssetError(String);

impl AssetError {
    pub fn advice(&self) -> Option<String> {
        None
    }
}

#[derive(Default)]
pub(super) struct LoadOptions {
    pub scene: Option<usize>,
    pub strict: bool,
}

#[derive(Clone, Debug, Default, serde::Serialize)]
pub(super) struct ExtensionSummary {
    pub name: String,
    pub required: bool,
    pub places: usize,
    pub supported: bool,
    pub ignored: Option<String>,
}

#[derive(Clone, Debug, Default, serde::Serialize)]
pub(super) struct Summary {
    pub generator: Option<String>,
    pub copyright: Option<String>,
    pub scenes: Vec<String>,
    pub vertices: usize,
    pub triangles: usize,
    pub instanced_triangles: usize,
    pub animations: Vec<String>,
    pub extensions: Vec<ExtensionSummary>,
}

pub(super) struct Loaded {
    pub scene: SceneDescription,
    pub diagnostics: Vec<Diagnostic>,
    pub summary: Summary,
}

pub(super) fn load(path: &Path, _: &LoadOptions) -> Result<Loaded, AssetError> {
    let bytes = std::fs::read(path).map_err(|e| AssetError(format!("{}: {e}", path.display())))?;
    if !bytes.starts_with(b"glTF") {
        serde_json::from_slice::<serde_json::Value>(&bytes)
            .map_err(|e| AssetError(format!("the glTF document is not valid JSON: {e}")))?;
    }
    Ok(Loaded { scene: SceneDescription::default(), diagnostics: Vec::new(), summary: Summary::default() })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Microfacet {
    Multiple,
    Single,
}

#[derive(Debug, thiserror::Error)]
#[error("no")]
pub(super) struct SceneError;

pub(super) struct Scene;

impl Scene {
    pub fn build(_: SceneDescription) -> Result<Self, SceneError> {
        Ok(Self)
    }
}

#[derive(Clone, Debug)]
pub(super) struct RenderOptions {
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    pub seed: u32,
    pub threads: usize,
    pub camera: CameraDescription,
    pub subsurface: String,
    pub max_depth: u32,
    pub microfacet: Microfacet,
}

pub(super) trait RenderControl: Sync {
    fn advance(&self, samples_done: u64, samples_total: u64);
    fn cancelled(&self) -> bool;
}

#[derive(Default)]
pub(super) struct RenderStats {
    pub rays: u64,
    pub scattering_events: u64,
    pub truncated_paths: u64,
    pub leaked_paths: u64,
    pub invalid_samples: u64,
}

pub(super) struct Rendered {
    pub film: Film,
    pub spp: u32,
    pub stats: RenderStats,
}

#[derive(Debug, thiserror::Error)]
#[error("no")]
pub(super) struct RenderError;

pub(super) fn render(
    _: &Scene,
    o: &RenderOptions,
    control: &dyn RenderControl,
) -> Result<Rendered, RenderError> {
    let mut film = Film::new(o.width, o.height);
    for (i, p) in film.pixels.iter_mut().enumerate() {
        *p = Vec3::splat(i as f32 / (o.width * o.height) as f32);
    }
    let mut spp = 0;
    while spp < o.spp && !control.cancelled() {
        std::thread::sleep(std::time::Duration::from_millis(1));
        spp += 1;
        control.advance(u64::from(spp), u64::from(o.spp));
    }
    Ok(Rendered { film, spp, stats: RenderStats::default() })
}

pub(super) fn subsurface_models() -> Vec<String> {
    vec!["random-walk".to_owned()]
}

pub(super) fn auto_camera(_: Vec3, _: Vec3, _: f32) -> CameraDescription {
    CameraDescription {
        name: "automatic".to_owned(),
        transform: Affine3A::from_mat3_translation(Mat3::IDENTITY, Vec3::Z),
        projection: Projection::Perspective { yfov: 0.6, aspect: None },
    }
}

pub(super) fn open_edges(_: &MeshDescription) -> Vec<[Vec3; 2]> {
    Vec::new()
}
