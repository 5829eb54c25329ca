//! A box that is a half space for its medium: its upper face is the plane z = 0, around the origin, and its unit of length
//! is the transport mean free path.
//!
//! The face is made of squares of growing size, so that the rounding of a point on it is small against its distance from
//! the origin.

use crate::optics::diffusion::Coefficients;
use crate::scene::{
    EnvironmentDescription, InstanceDescription, MaterialDescription, MediumDescription, MeshDescription,
    SceneDescription,
};
use glam::{Affine3A, Vec3};

/// Edge of the box in diffuse mean free paths, and the least and largest in transport mean free paths. Light that
/// would have come back from farther away is less than the second's inverse.
const EDGE: f64 = 60.0;
const LEAST_EDGE: f64 = 400.0;
const LARGEST_EDGE: f64 = 4000.0;
/// Half the edge of the innermost square, in transport mean free paths.
const INNERMOST: f32 = 1e-3;
/// A half space for the medium, and the number of triangles of its upper face, which come first.
pub(super) fn build(c: &Coefficients) -> (SceneDescription, u32) {
    let unit = c.transport_mean_free_path();
    let edge = (EDGE * c.diffuse_mean_free_path() / unit).clamp(LEAST_EDGE, LARGEST_EDGE) as f32;
    let half = 0.5 * edge;
    let square = |s: f32, z: f32| [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, y)| Vec3::new(x, y, z));
    let mut positions = vec![Vec3::ZERO];
    let mut triangles: Vec<[u32; 3]> = (0..4).map(|j| [0, 1 + j, 1 + (j + 1) % 4]).collect();
    let mut size = INNERMOST;
    positions.extend(square(size, 0.0));
    let mut first = 1;
    while size < half {
        size = (2.0 * size).min(half);
        positions.extend(square(size, 0.0));
        for (j, k) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let [inner, next_inner, outer, next_outer] = [first + j, first + k, first + 4 + j, first + 4 + k];
            triangles.extend([[inner, outer, next_outer], [inner, next_outer, next_inner]]);
        }
        first += 4;
    }
    let face = triangles.len() as u32;
    positions.extend(square(half, -edge));
    for (j, k) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        let [top, next_top, bottom, next_bottom] = [first + j, first + k, first + 4 + j, first + 4 + k];
        triangles.extend([[bottom, next_bottom, next_top], [bottom, next_top, top]]);
    }
    triangles.extend([[0, 2, 1], [0, 3, 2]].map(|t| t.map(|j| first + 4 + j)));

    let scaled = |sigma: f64| Vec3::splat((sigma * unit) as f32);
    let medium = MediumDescription {
        sigma_a: scaled(c.sigma_a),
        sigma_s: scaled(c.sigma_s),
        anisotropy: c.g as f32,
        ior: c.eta as f32,
        priority: 0,
        absorption_texture: None,
        scattering_texture: None,
        multi_scatter: None,
    };
    let material = MaterialDescription {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ior: c.eta as f32,
        medium: Some(medium),
        ..Default::default()
    };
    let mesh = MeshDescription {
        positions,
        triangle_materials: vec![0; triangles.len()],
        triangles,
        ..Default::default()
    };
    let instance = InstanceDescription {
        name: String::new(),
        pointer: String::new(),
        mesh: 0,
        transform: Affine3A::IDENTITY,
    };
    let description = SceneDescription {
        meshes: vec![mesh],
        materials: vec![material],
        instances: vec![instance],
        environment: EnvironmentDescription::Constant(Vec3::ONE),
        ..Default::default()
    };
    (description, face)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn the_box_is_closed_and_its_face_comes_first() {
        for sigma_a in [0.0, 1.0, 1e4] {
            let (description, face) = build(&Coefficients::isotropic(sigma_a, 1000.0, 1.3));
            let mesh = description.meshes[0].clone();
            let scene = Scene::build(description).unwrap();
            assert!(scene.objects[0].closed && scene.objects[0].has_medium);
            for (i, triangle) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
                let up = (b - a).cross(c - a).normalize().z;
                assert_eq!(up > 0.5, i < face as usize, "triangle {i}");
            }
            assert_eq!(mesh.positions[mesh.triangles[0][0] as usize], Vec3::ZERO);
        }
    }
}
