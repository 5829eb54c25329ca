//! Rays per second of the ray queries on one thread, beside `obvhs`'s own CWBVH traversal of the same mesh.
//!
//! `cargo bench --bench traversal [-- FILE.obj]`: without a file, a bumpy sphere of 101,568 triangles.

mod common;

use common::{bumpy_sphere, camera_rays, random_rays};
use glam::{Vec3, Vec3A};
use nephrite::geometry::{DistanceBound, MeshGeometry, Ray, Topology};
use obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris, ray::RayHit, triangle::Triangle};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Rays of each kind.
const RAYS: usize = 40_000;

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
        ("camera", camera_rays(&bounds, 200)),
        ("incoherent", random_rays(&bounds, RAYS, |_| f32::INFINITY, |_| true)),
        ("inside, 1/20 of the size", random_rays(&bounds, RAYS, |_| 0.05 * size, |p| mesh.contains(p))),
        ("inside, 1/200 of the size", random_rays(&bounds, RAYS, |_| 0.005 * size, |p| mesh.contains(p))),
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
