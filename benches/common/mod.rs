//! What benches of ray queries share: meshes of any size, and the rays that ask about them.

#![allow(dead_code, reason = "each bench is a crate of its own and uses some of it")]

use glam::Vec3;
use nephrite::geometry::{Aabb, Ray};

/// SplitMix64 (Steele, Lea & Flood 2014), as a number in \[0, 1).
pub fn unit(state: &mut u64) -> f32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
}

/// Uniform on the sphere.
pub fn direction(state: &mut u64) -> Vec3 {
    let z = 2.0 * unit(state) - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * unit(state)).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// Rays from one eye through the pixels of a square picture that shows all of the box, row by row.
pub fn camera_rays(bounds: &Aabb, side: u32) -> Vec<Ray> {
    let (center, size) = (bounds.center(), bounds.extent().max_element());
    let eye = center + Vec3::new(0.3, 0.4, 1.5) * size;
    let last = (side - 1) as f32;
    let pixel = |i: u32| {
        let at = Vec3::new((i % side) as f32 / last - 0.5, (i / side) as f32 / last - 0.5, 0.0);
        Ray::new(eye, (center + at * size - eye).normalize())
    };
    (0..side * side).map(pixel).collect()
}

/// Rays from uniform points of the box that are to be kept, in uniform directions; `t_max` draws their lengths.
pub fn random_rays(
    bounds: &Aabb,
    count: usize,
    mut t_max: impl FnMut(&mut u64) -> f32,
    keep: impl Fn(Vec3) -> bool,
) -> Vec<Ray> {
    let mut state = 1;
    let mut point = || Vec3::new(unit(&mut state), unit(&mut state), unit(&mut state));
    let points: Vec<Vec3> = std::iter::repeat_with(|| bounds.min + point() * bounds.extent())
        .filter(|&p| keep(p))
        .take(count)
        .collect();
    let mut state = 2;
    let ray = |origin| Ray { origin, direction: direction(&mut state), t_max: t_max(&mut state) };
    points.into_iter().map(ray).collect()
}

/// A cube's six grids of n × n squares, pushed onto a sphere with waves: 12 n² triangles, closed.
pub fn bumpy_sphere(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for face in 0..6 {
        let first = positions.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                // Integers, so that faces agree on their common edges to the bit.
                let (a, b) = (2 * i as i32 - n as i32, 2 * j as i32 - n as i32);
                let n = n as i32;
                let p = match face {
                    0 => [n, a, b],
                    1 => [-n, b, a],
                    2 => [b, n, a],
                    3 => [a, -n, b],
                    4 => [a, b, n],
                    _ => [b, a, -n],
                };
                let p = Vec3::from(p.map(|x| x as f32)).normalize();
                let wave = (9.0 * p.x).sin() * (11.0 * p.y).sin() * (10.0 * p.z).sin();
                positions.push(p * (1.0 + 0.2 * wave));
            }
        }
        for j in 0..n {
            for i in 0..n {
                let at = |i: u32, j: u32| first + j * (n + 1) + i;
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    (positions, triangles)
}
