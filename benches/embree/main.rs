//! Rays per second of the closest-hit query beside Embree's, on one thread; time and memory of both builds.
//!
//! `cargo bench --bench embree [-- --robust] [-- N…]`: bumpy spheres of 12 N² triangles, by default 20 k, 500 k and 5 M.
//! Embree 3 is loaded at run time; without it nephrite is measured alone. Its scenes are built with high quality, its
//! rays are single ones (`rtcIntersect1`), and with `--robust` its intersections are watertight, as nephrite's always are.
//!
//! The programs take turns: a thousand rays each, then the next thousand, and the other one is first in the next round. A
//! thousand has the median of the rounds as its time: what else the machine does falls on some pieces of some rounds.

#[path = "../common/mod.rs"]
mod common;
mod library;

use common::{bumpy_sphere, camera_rays, random_rays, unit};
use glam::Vec3;
use library::{Embree, RayHit, Scene, flush_to_zero};
use nephrite::geometry::{MeshGeometry, MeshHit, Ray};
use std::hint::black_box;
use std::time::Instant;

/// Rays of each kind: about 300 × 300 pixels.
const RAYS: usize = 90_000;
/// Rays that a program traces in one turn.
const TURN: usize = 1000;
const ROUNDS: usize = 9;
/// Mean length of rays in the medium, in sizes of the mesh.
const FREE_PATH: f32 = 0.02;
/// Part of the rays that may hit in one program and miss in the other, or hit another triangle elsewhere: those through an
/// edge or along a surface, where roundings decide, and where Embree without its robust flag may let a ray through.
const EDGE_CASES: f64 = 1.0e-3;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let robust = arguments.iter().any(|a| a == "--robust");
    let only = arguments.iter().find_map(|a| a.strip_prefix("--only=")).unwrap_or_default();
    let mut sizes: Vec<u32> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![41, 204, 645];
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let embree = Embree::load(threads).inspect_err(|e| println!("Embree is left out: {e}")).ok();
    let version = embree.as_ref().and_then(|e| e.version().ok());
    let name = match &version {
        Some(version) if robust => format!("Embree {version}, robust"),
        Some(version) => format!("Embree {version}"),
        None => "no Embree".to_string(),
    };
    let mut builds = Vec::new();
    let mut rates = Vec::new();
    for n in sizes {
        let (positions, triangles) = bumpy_sphere(n);
        let (mesh, seconds) = timed(|| MeshGeometry::build(&positions, &triangles));
        let count = triangles.len();
        builds.push(format!("| {count} | nephrite | {seconds:.2} | {:.0} |", per(mesh.memory(), count)));
        let scene = embree.as_ref().map(|embree| {
            let (scene, seconds) = timed(|| embree.build(&positions, &triangles, robust));
            let scene = scene.expect("every function is in the library");
            let bytes = per(scene.bytes.unsigned_abs(), count);
            builds.push(format!("| {count} | {name} | {seconds:.2} | {bytes:.0} |"));
            scene
        });
        drop((positions, triangles));
        for (kind, rays) in kinds_of_rays(&mesh).into_iter().filter(|(kind, _)| kind.contains(only)) {
            let row = compare(&mesh, scene.as_ref(), &rays);
            println!("{count} {kind}: {row}");
            rates.push(format!("| {count} | {kind} | {row} |"));
        }
    }
    println!(
        "\n| triangles | program | build, s, {threads} threads | bytes a triangle |\n| --- | --- | --- | --- |"
    );
    println!("{}", builds.join("\n"));
    println!("\n| triangles | rays | nephrite, M/s | {name}, M/s | ratio | hit | edge cases |");
    println!("| --- | --- | --- | --- | --- | --- | --- |\n{}", rates.join("\n"));
}

fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let out = f();
    (out, start.elapsed().as_secs_f64())
}

fn per(bytes: usize, count: usize) -> f64 {
    bytes as f64 / count as f64
}

fn kinds_of_rays(mesh: &MeshGeometry) -> [(&'static str, Vec<Ray>); 3] {
    let bounds = mesh.bounds();
    let size = bounds.extent().max_element();
    let flight = |state: &mut u64| -(1.0 - unit(state)).ln() * FREE_PATH * size;
    [
        ("primary", camera_rays(&bounds, 300)),
        ("incoherent", random_rays(&bounds, RAYS, |_| f32::INFINITY, |_| true)),
        ("in medium", random_rays(&bounds, RAYS, flight, |p: Vec3| mesh.contains(p))),
    ]
}

/// Cells of a row of the table.
fn compare(mesh: &MeshGeometry, scene: Option<&Scene>, rays: &[Ray]) -> String {
    let mut ours = Vec::with_capacity(rays.len());
    let mut theirs = Vec::with_capacity(rays.len());
    // Program, piece, round.
    let mut seconds = [(); 2].map(|()| vec![Vec::with_capacity(ROUNDS); rays.len().div_ceil(TURN)]);
    for round in 0..ROUNDS {
        ours.clear();
        theirs.clear();
        for (number, piece) in rays.chunks(TURN).enumerate() {
            for turn in 0..2 {
                let program = (round + turn) % 2;
                let start = Instant::now();
                match (program, scene) {
                    (0, _) => ours.extend(piece.iter().map(|ray| mesh.intersect(black_box(ray)))),
                    (_, Some(scene)) => flush_to_zero(|| {
                        theirs.extend(piece.iter().map(|ray| scene.intersect(black_box(ray))));
                    }),
                    _ => {}
                }
                seconds[program][number].push(start.elapsed().as_secs_f64());
            }
        }
    }
    let [a, b] = seconds.map(|pieces| pieces.into_iter().map(median).sum::<f64>());
    let million = rays.len() as f64 / 1.0e6;
    let hits = ours.iter().flatten().count();
    let hit = format!("{:.1} %", 100.0 * hits as f64 / rays.len() as f64);
    if scene.is_none() {
        return format!("{:.2} | | | {hit} |", million / a);
    }
    let unequal = ours.iter().zip(&theirs).filter(|(a, b)| !agree(a.as_ref(), b)).count();
    assert!((unequal as f64) < EDGE_CASES * rays.len() as f64, "{unequal} of {} rays disagree", rays.len());
    format!("{:.2} | {:.2} | {:.2} | {hit} | {unequal}", million / a, million / b, b / a)
}

/// Both miss, or both hit at the same distance, up to roundings.
fn agree(ours: Option<&MeshHit>, theirs: &RayHit) -> bool {
    match ours {
        Some(hit) => theirs.is_hit() && (hit.t - theirs.t_far).abs() <= 1.0e-4 * hit.t.max(1.0e-2),
        None => !theirs.is_hit(),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
