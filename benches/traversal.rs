//! Rays per second of the ray queries on one thread, beside `obvhs`'s own CWBVH traversal of the same mesh.
//!
//! `cargo bench --bench traversal [-- FILE.obj]`: without a file, a bumpy sphere of 101,568 triangles.

use glam::{Vec3, Vec3A};
use nephrite::geometry::{Aabb, DistanceBound, MeshGeometry, Ray, Topology};
use obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris, ray::RayHit, triangle::Triangle};
use std::hint::black_box;
use std::time::{Duration, Instant};

fn main() {
    let file = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let (positions, triangles) = match &file {
        Some(path) => read_obj(&std::fs::read_to_string(path).expect("the file can be read")),
        None => bumpy_sphere(92),
    };
    println!("{} triangles", triangles.len());
    let mesh = timed("build", || MeshGeometry::build(&positions, &triangles));
    timed("topology", || Topology::analyse(&mesh));
    let bound = DistanceBound::new(&mesh);

    let corner = |i: u32| Vec3A::from(positions[i as usize]);
    let soup: Vec<Triangle> =
        triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
    let build = || build_cwbvh_from_tris(&soup, BvhBuildParams::medium_build(), &mut Duration::default());
    let compressed = timed("obvhs medium build", build);
    let ordered: Vec<Triangle> = compressed.primitive_indices.iter().map(|&i| soup[i as usize]).collect();

    let bounds = mesh.bounds();
    let size = bounds.extent().max_element();
    for (name, rays) in [
        ("camera", camera_rays(&bounds)),
        ("incoherent", random_rays(&bounds, f32::INFINITY, |_| true)),
        ("inside, 1/20 of the size", random_rays(&bounds, 0.05 * size, |p| mesh.contains(p))),
        ("inside, 1/200 of the size", random_rays(&bounds, 0.005 * size, |p| mesh.contains(p))),
    ] {
        println!("{name}");
        rate("closest", &rays, |ray| mesh.intersect(ray).is_some());
        rate("any", &rays, |ray| mesh.occluded(ray));
        let mut hits = Vec::new();
        rate("all", &rays, |ray| {
            mesh.intersect_all(ray, &mut hits);
            !hits.is_empty()
        });
        rate("obvhs closest", &rays, |ray| {
            let theirs = obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), 0.0, ray.t_max);
            let mut hit = RayHit::none();
            compressed.ray_traverse(theirs, &mut hit, |ray, id| ordered[id].intersect(ray))
        });
        if name.starts_with("inside") {
            rate("bound skips", &rays, |ray| bound.bound(&mesh, ray.origin) > ray.t_max);
        }
    }
}

fn timed<T>(name: &str, f: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let out = f();
    println!("{name:>24} {:8.1} ms", start.elapsed().as_secs_f64() * 1.0e3);
    out
}

/// Sum over short pieces of the best of twenty passes, since the machine may have other work.
fn rate(name: &str, rays: &[Ray], mut query: impl FnMut(&Ray) -> bool) {
    let mut best = vec![f64::INFINITY; rays.len().div_ceil(1000)];
    let mut hits = 0;
    for _ in 0..20 {
        hits = 0;
        for (piece, best) in rays.chunks(1000).zip(&mut best) {
            let start = Instant::now();
            hits += piece.iter().filter(|ray| black_box(query(black_box(ray)))).count();
            *best = start.elapsed().as_secs_f64().min(*best);
        }
    }
    let million = rays.len() as f64 / best.iter().sum::<f64>() / 1.0e6;
    println!("{name:>24} {million:8.2} Mrays/s, {:.1} % hit", 100.0 * hits as f64 / rays.len() as f64);
}

/// SplitMix64.
fn unit(state: &mut u64) -> f32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
}

fn direction(state: &mut u64) -> Vec3 {
    let z = 2.0 * unit(state) - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * unit(state)).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

fn camera_rays(bounds: &Aabb) -> Vec<Ray> {
    let (center, size) = (bounds.center(), bounds.extent().max_element());
    let eye = center + Vec3::new(0.3, 0.4, 1.5) * size;
    let pixel = |i: u32| {
        let at = Vec3::new((i % 200) as f32 / 199.0 - 0.5, (i / 200) as f32 / 199.0 - 0.5, 0.0);
        Ray::new(eye, (center + at * size - eye).normalize())
    };
    (0..200 * 200).map(pixel).collect()
}

fn random_rays(bounds: &Aabb, t_max: f32, keep: impl Fn(Vec3) -> bool) -> Vec<Ray> {
    let mut state = 1;
    let mut point = || Vec3::new(unit(&mut state), unit(&mut state), unit(&mut state));
    let points: Vec<Vec3> = std::iter::repeat_with(|| bounds.min + point() * bounds.extent())
        .filter(|&p| keep(p))
        .take(40_000)
        .collect();
    let mut state = 2;
    points.into_iter().map(|origin| Ray { origin, direction: direction(&mut state), t_max }).collect()
}

/// A cube's six grids, pushed onto a sphere with waves.
fn bumpy_sphere(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
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

fn read_obj(text: &str) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f32> = words.filter_map(|w| w.parse().ok()).collect();
                positions.push(Vec3::from_slice(&x));
            }
            Some("f") => {
                let v: Vec<u32> =
                    words.filter_map(|w| w.split('/').next()?.parse::<u32>().ok()).map(|i| i - 1).collect();
                triangles.extend((2..v.len()).map(|i| [v[0], v[i - 1], v[i]]));
            }
            _ => {}
        }
    }
    (positions, triangles)
}
