//! The facts of an inspection.
//!
//! | name | symbol | |
//! | --- | --- | --- |
//! | `mean_free_path` | 1 / σt, σt = σa + σs | how far light goes between events |
//! | `single_scattering_albedo` | α = σs / σt | survival at one event |
//! | `effective_albedo` | ρ = (1 − s)(1 − 0.139 s) / (1 + 1.17 s), s = √((1 − α) / (1 − g α)) | diffuse reflectance of infinite depth without a boundary, van de Hulst's fit (Multiple Light Scattering, 1980, via Kulla and Conty 2017) |

use crate::cli::pipeline::{Diagnostic, Loaded, Summary, open_edges};
use crate::scene::{InstanceDescription, MediumDescription, SceneDescription};
use glam::Vec3;
use serde::Serialize;
use std::collections::HashMap;
use std::path::Path;

/// Everything that `inspect` tells.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    pub file: String,
    #[serde(flatten)]
    pub summary: &'a Summary,
    pub objects: usize,
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
    pub closed: bool,
    pub open_edges: usize,
    /// Where light leaks out, largest first.
    pub holes: Vec<Hole>,
}

/// Connected open edges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Hole {
    /// Centre of its bounds, world metres.
    pub center: [f32; 3],
    /// Diagonal of its bounds, world metres.
    pub size: f32,
    pub edges: usize,
}

impl<'a> Report<'a> {
    pub fn new(file: &Path, loaded: &'a Loaded) -> Self {
        Self {
            file: file.to_string_lossy().into_owned(),
            summary: &loaded.summary,
            objects: loaded.scene.instances.len(),
            media: media(&loaded.scene),
            diagnostics: &loaded.diagnostics,
        }
    }
}

fn media(scene: &SceneDescription) -> Vec<MediumReport> {
    // Open edges of each mesh that holds a medium, in its own space; found once however often it is placed.
    let mut edges: HashMap<usize, Vec<[Vec3; 2]>> = HashMap::new();
    let mut reports = Vec::new();
    for (index, material) in scene.materials.iter().enumerate() {
        let Some(medium) = &material.medium else { continue };
        let mut objects = Vec::new();
        for instance in &scene.instances {
            let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
            if mesh.triangle_materials.iter().any(|&m| m as usize == index) {
                let open = edges.entry(instance.mesh).or_insert_with(|| open_edges(mesh));
                objects.push(object(instance, open));
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
        textured: medium.absorption_texture.is_some() || medium.scattering_texture.is_some(),
        objects: Vec::new(),
    }
}

fn effective_albedo(albedo: f32, g: f32) -> f32 {
    let s = ((1.0 - albedo) / (1.0 - g * albedo)).max(0.0).sqrt();
    (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)
}

fn object(instance: &InstanceDescription, open: &[[Vec3; 2]]) -> ObjectReport {
    let placed: Vec<[Vec3; 2]> =
        open.iter().map(|edge| edge.map(|point| instance.transform.transform_point3(point))).collect();
    ObjectReport {
        name: instance.name.clone(),
        pointer: instance.pointer.clone(),
        closed: open.is_empty(),
        open_edges: open.len(),
        holes: holes(&placed),
    }
}

/// Groups edges that share end points.
fn holes(edges: &[[Vec3; 2]]) -> Vec<Hole> {
    let key = |point: Vec3| point.to_array().map(|c| (c + 0.0).to_bits());
    let mut group: Vec<usize> = (0..edges.len()).collect();
    fn root(group: &mut [usize], mut i: usize) -> usize {
        while group[i] != i {
            group[i] = group[group[i]];
            i = group[i];
        }
        i
    }
    let mut first_at = HashMap::new();
    for (i, edge) in edges.iter().enumerate() {
        for &point in edge {
            let other = *first_at.entry(key(point)).or_insert(i);
            let (a, b) = (root(&mut group, i), root(&mut group, other));
            group[a.max(b)] = a.min(b);
        }
    }
    let mut bounds: Vec<(usize, Vec3, Vec3, usize)> = Vec::new();
    let mut index = HashMap::new();
    for (i, edge) in edges.iter().enumerate() {
        let hole = *index.entry(root(&mut group, i)).or_insert_with(|| {
            bounds.push((0, Vec3::INFINITY, Vec3::NEG_INFINITY, i));
            bounds.len() - 1
        });
        let (count, min, max, _) = &mut bounds[hole];
        *count += 1;
        *min = min.min(edge[0]).min(edge[1]);
        *max = max.max(edge[0]).max(edge[1]);
    }
    let mut holes: Vec<Hole> = bounds
        .into_iter()
        .map(|(edges, min, max, _)| Hole {
            center: (0.5 * (min + max)).to_array(),
            size: min.distance(max),
            edges,
        })
        .collect();
    holes.sort_by(|a, b| b.size.total_cmp(&a.size));
    holes
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
        };
        let report = coefficients(0, &medium);
        assert_eq!(report.mean_free_path, [None, Some(0.25), None]);
        assert_eq!(report.single_scattering_albedo, [None, Some(0.75), None]);
        assert!(serde_json::to_string(&report).unwrap().contains("\"mean_free_path\":[null,0.25,null]"));
    }

    #[test]
    fn two_holes_are_two_and_the_larger_comes_first() {
        let square = |at: Vec3, side: f32| {
            let c = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|p| at + p * side);
            [[c[0], c[1]], [c[1], c[2]], [c[2], c[3]], [c[3], c[0]]]
        };
        let edges = [square(Vec3::ZERO, 1.0), square(Vec3::splat(10.0), 2.0)].concat();
        let holes = holes(&edges);
        assert_eq!(holes.len(), 2);
        assert_eq!(holes[0].center, [11.0, 11.0, 10.0]);
        assert_eq!((holes[0].edges, holes[1].edges), (4, 4));
        assert!((holes[1].size - 2f32.sqrt()).abs() < 1e-6);
    }
}
