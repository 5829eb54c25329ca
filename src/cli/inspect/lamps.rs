//! The lamps of a scene: punctual lights, and materials that emit, with their power and their place.

use super::format::{length, number, triple};
use crate::asset::LightSummary;
use crate::cli::lights::LUMENS_A_WATT;
use crate::scene::SceneDescription;
use glam::{DVec3, Vec3};
use serde::Serialize;
use std::f64::consts::PI;

/// A material that emits, and all triangles of the scene that are of it. Before textures and coverage.
#[derive(Debug, Serialize)]
pub(super) struct LampReport {
    pub material: usize,
    pub name: String,
    pub pointer: String,
    /// Emitted luminance, cd/m².
    pub radiance: [f32; 3],
    /// Whether a texture varies it.
    pub textured: bool,
    /// Area of its triangles, m².
    pub area: f64,
    /// Luminous flux, lumens: π × luminance × area × sides.
    pub power: [f64; 3],
    /// Middle of its triangles by area, world metres; `None` where there are none.
    pub position: Option<[f64; 3]>,
}

/// Every material that emits.
pub(super) fn lamps(scene: &SceneDescription) -> Vec<LampReport> {
    let emits = |&i: &usize| scene.materials[i].emission.max_element() > 0.0;
    let all: Vec<usize> = (0..scene.materials.len()).filter(emits).collect();
    let mut areas = vec![0.0; scene.materials.len()];
    let mut moments = vec![DVec3::ZERO; scene.materials.len()];
    for instance in &scene.instances {
        let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
        let world = |i: u32| {
            let position = mesh.positions.get(i as usize).copied().unwrap_or(Vec3::ZERO);
            instance.transform.transform_point3(position).as_dvec3()
        };
        for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_materials) {
            if !scene.materials.get(material as usize).is_some_and(|m| m.emission.max_element() > 0.0) {
                continue;
            }
            let [a, b, c] = triangle.map(world);
            let area = 0.5 * (b - a).cross(c - a).length();
            areas[material as usize] += area;
            moments[material as usize] += area * (a + b + c) / 3.0;
        }
    }
    all.into_iter()
        .map(|i| {
            let (material, area) = (&scene.materials[i], areas[i]);
            let sides = if material.double_sided { 2.0 } else { 1.0 };
            LampReport {
                material: i,
                name: material.name.clone(),
                pointer: material.pointer.clone(),
                radiance: material.emission.to_array(),
                textured: material.emission_texture.is_some(),
                area,
                power: (PI * area * sides * material.emission.as_dvec3()).to_array(),
                position: (area > 0.0).then(|| (moments[i] / area + scene.origin).to_array()),
            }
        })
        .collect()
}

/// A light in words; `of_blender` adds the strength that it has there, if it was written in candela.
pub(super) fn describe_light(light: &LightSummary, of_blender: bool) -> String {
    let LightSummary { name, intensity, unit, power, .. } = light;
    let mut text = format!("{name:?}: {} {unit}", triple(intensity.map(Some)));
    match (light.kind, light.size) {
        ("ies", _) => text += " at most",
        ("disk", Some([width, height])) if width == height => text += &format!(", {} across", length(width)),
        (_, Some([width, height])) => text += &format!(", {} × {}", length(width), length(height)),
        (_, None) => {}
    }
    if let Some(power) = power {
        text += &format!(", power {} lm", triple(power.map(Some)));
    }
    if of_blender && ["point", "spot", "directional"].contains(&light.kind) {
        let strongest = f64::from(Vec3::from(*intensity).max_element()) / LUMENS_A_WATT;
        text += &match power {
            Some(_) => format!(" ({} W in Blender)", number((4.0 * PI * strongest) as f32)),
            None => format!(" ({} W/m² in Blender)", number(strongest as f32)),
        };
    }
    if let Some(position) = light.position {
        text += &format!(", at {} m", place(position));
    }
    if let Some(direction) = light.direction {
        text += &format!(", along {}", place(direction.map(f64::from)));
    }
    if let Some([inner, outer]) = light.cone {
        let [inner, outer] = [inner, outer].map(|angle| number(angle.to_degrees()));
        text += &format!(", cone {inner}° to {outer}° from its axis");
    }
    if let Some(range) = light.range {
        text += &format!(", range {}", length(range));
    }
    text
}

/// A material that emits in words.
pub(super) fn describe_lamp(lamp: &LampReport) -> String {
    let LampReport { material, name, pointer, radiance, area, .. } = lamp;
    let textured = if lamp.textured { " times a texture" } else { "" };
    let shown =
        format!("material {material} {name:?} ({pointer}): {} cd/m²{textured}", triple(radiance.map(Some)));
    match lamp.position {
        None => format!("{shown}, on nothing that the scene shows"),
        Some(position) => {
            let power = triple(lamp.power.map(|p| Some(p as f32)));
            format!("{shown}, {} m², power {power} lm, around {} m", number(*area as f32), place(position))
        }
    }
}

/// Coordinates that are far from the origin keep their metres.
fn place(position: [f64; 3]) -> String {
    let shown = position.map(|x| {
        // Rounding leaves no −0.
        let rounded = (x * 1e3).round() / 1e3 + 0.0;
        if x.abs() < 1.0 { number(x as f32) } else { format!("{rounded}") }
    });
    format!("({})", shown.join(", "))
}
