//! The facts of an inspection.
//!
//! | name | symbol | |
//! | --- | --- | --- |
//! | `mean_free_path` | 1 / σt, σt = σa + σs | how far light goes between events |
//! | `single_scattering_albedo` | α = σs / σt | survival at one event |
//! | `effective_albedo` | ρ = (1 − s)(1 − 0.139 s) / (1 + 1.17 s), s = √((1 − α) / (1 − g α)) | diffuse reflectance of infinite depth without a boundary, van de Hulst's fit (Multiple Light Scattering, 1980, via Kulla and Conty 2017) |

use super::lamps::{LampReport, lamps};
use crate::cli::pipeline::{Diagnostic, Loaded, Summary};
use crate::scene::{Analysed, InstanceDescription, MediumDescription, SceneDescription};
use glam::{DVec3, Vec3};
use serde::Serialize;
use std::collections::HashMap;
use std::path::Path;

/// Leaks told of one object.
const MOST_LEAKS: usize = 4;

/// Everything that `inspect` tells.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    pub file: String,
    #[serde(flatten)]
    pub summary: &'a Summary,
    pub objects: usize,
    /// Materials that emit.
    pub lamps: Vec<LampReport>,
    pub media: Vec<MediumReport>,
    pub diagnostics: &'a [Diagnostic],
}

/// A medium and the objects filled with it. Lengths are world metres, coefficients 1/m, before textures.
#[derive(Debug, Serialize)]
pub(super) struct MediumReport {
    pub material: usize,
    pub name: String,
    pub pointer: String,
    pub sigma_a: [f32; 3],
    pub sigma_s: [f32; 3],
    pub anisotropy: f32,
    pub ior: f32,
    pub priority: i32,
    /// `None` where light is never stopped.
    pub mean_free_path: [Option<f32>; 3],
    pub single_scattering_albedo: [Option<f32>; 3],
    pub effective_albedo: [Option<f32>; 3],
    pub textured: bool,
    pub objects: Vec<ObjectReport>,
}

/// An object that holds a medium, and whether it can.
#[derive(Debug, Serialize)]
pub(super) struct ObjectReport {
    pub name: String,
    pub pointer: String,
    /// Every part of it is closed, or is once the parts that face the wrong way have been turned.
    pub closed: bool,
    /// Connected parts.
    pub parts: usize,
    /// Vertices that are put where others are, which closes seams.
    pub welded_vertices: usize,
    /// Parts that are not closed.
    pub open_parts: usize,
    /// Parts that face the wrong way and are turned.
    pub inside_out_parts: usize,
    /// Edges of one triangle.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// A few of the places where light leaks out, world metres.
    pub leaks: Vec<[f32; 3]>,
}

impl<'a> Report<'a> {
    pub fn new(file: &Path, loaded: &'a Loaded) -> Self {
        Self {
            file: file.to_string_lossy().into_owned(),
            summary: &loaded.summary,
            objects: loaded.scene.instances.len(),
            lamps: lamps(&loaded.scene),
            media: media(&loaded.scene),
            diagnostics: &loaded.diagnostics,
        }
    }
}

fn media(scene: &SceneDescription) -> Vec<MediumReport> {
    // Found once for a mesh, however often it is placed.
    let mut analysed: HashMap<usize, Analysed<'_>> = HashMap::new();
    let mut reports = Vec::new();
    for (index, material) in scene.materials.iter().enumerate() {
        let Some(medium) = &material.medium else { continue };
        let mut objects = Vec::new();
        for instance in &scene.instances {
            let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
            if mesh.triangle_materials.iter().any(|&m| m as usize == index) {
                let found = analysed.entry(instance.mesh).or_insert_with(|| scene.analyse(instance.mesh));
                objects.push(object(instance, found, scene.origin));
            }
        }
        reports.push(MediumReport {
            name: material.name.clone(),
            pointer: material.pointer.clone(),
            objects,
            ..coefficients(index, medium)
        });
    }
    reports
}

fn coefficients(material: usize, medium: &MediumDescription) -> MediumReport {
    let sigma_t = medium.sigma_a + medium.sigma_s;
    let stopped = |value: [f32; 3]| [0, 1, 2].map(|i| (sigma_t[i] > 0.0).then_some(value[i]));
    let albedo = medium.sigma_s / sigma_t;
    MediumReport {
        material,
        name: String::new(),
        pointer: String::new(),
        sigma_a: medium.sigma_a.to_array(),
        sigma_s: medium.sigma_s.to_array(),
        anisotropy: medium.anisotropy,
        ior: medium.ior,
        priority: medium.priority,
        mean_free_path: stopped(sigma_t.recip().to_array()),
        single_scattering_albedo: stopped(albedo.to_array()),
        effective_albedo: stopped(albedo.to_array().map(|a| effective_albedo(a, medium.anisotropy))),
        textured: medium.is_textured(),
        objects: Vec::new(),
    }
}

fn effective_albedo(albedo: f32, g: f32) -> f32 {
    let s = ((1.0 - albedo) / (1.0 - g * albedo)).max(0.0).sqrt();
    (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)
}

fn object(instance: &InstanceDescription, found: &Analysed<'_>, origin: DVec3) -> ObjectReport {
    let parts = &found.topology.components;
    let world = |p: Vec3| (instance.transform.transform_point3(p).as_dvec3() + origin).as_vec3();
    let leaks = parts.iter().filter(|part| !part.closable).flat_map(|part| &part.leaks);
    ObjectReport {
        name: instance.name.clone(),
        pointer: instance.pointer.clone(),
        closed: !parts.is_empty() && parts.iter().all(|part| part.closable),
        parts: parts.len(),
        welded_vertices: found.moved,
        open_parts: parts.iter().filter(|part| !part.closable).count(),
        inside_out_parts: parts.iter().filter(|part| part.inside_out).count(),
        open_edges: parts.iter().map(|part| part.open_edges).sum(),
        non_manifold_edges: parts.iter().map(|part| part.non_manifold_edges).sum(),
        leaks: leaks.take(MOST_LEAKS).map(|&p| world(p).to_array()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_effective_albedo_is_that_of_the_published_fit() {
        assert_eq!(effective_albedo(1.0, 0.3), 1.0);
        assert_eq!(effective_albedo(0.0, 0.3), 0.0);
        // s = √(0.1 / 1) = 0.316228: 0.683772 · 0.956044 / 1.369987
        assert!((effective_albedo(0.9, 0.0) - 0.477_17).abs() < 1e-4, "{}", effective_albedo(0.9, 0.0));
        assert!(effective_albedo(0.9, 0.8) < effective_albedo(0.9, 0.0));
    }

    #[test]
    fn clear_media_have_no_mean_free_path_and_json_says_null() {
        let medium = MediumDescription {
            sigma_a: Vec3::new(0.0, 1.0, 0.0),
            sigma_s: Vec3::new(0.0, 3.0, 0.0),
            anisotropy: 0.0,
            ior: 1.5,
            priority: 0,
            absorption_texture: None,
            scattering_texture: None,
            multi_scatter: None,
        };
        let report = coefficients(0, &medium);
        assert_eq!(report.mean_free_path, [None, Some(0.25), None]);
        assert_eq!(report.single_scattering_albedo, [None, Some(0.75), None]);
        assert!(serde_json::to_string(&report).unwrap().contains("\"mean_free_path\":[null,0.25,null]"));
    }
}
