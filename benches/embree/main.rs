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
    let mut costs = Vec::new();
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
            let measured = compare(&mesh, scene.as_ref(), &rays);
            let row = measured.row();
            println!("{count} {kind}: {row}");
            rates.push(format!("| {count} | {kind} | {row} |"));
            costs.push((kind, count, measured.nanoseconds));
        }
    }
    println!(
        "\n| triangles | program | build, s, {threads} threads | bytes a triangle |\n| --- | --- | --- | --- |"
    );
    println!("{}", builds.join("\n"));
    println!("\n| triangles | rays | nephrite, M/s | {name}, M/s | ratio | hit | edge cases |");
    println!("| --- | --- | --- | --- | --- | --- | --- |\n{}", rates.join("\n"));
    print_growth(&costs, &name);
}

/// How many times as long a ray takes as in the first mesh, beside the growth of the logarithm of the triangles.
fn print_growth(costs: &[(&str, usize, [f64; 2])], name: &str) {
    println!(
        "\n| rays | triangles | log(triangles) grows by | nephrite | {name} |\n| --- | --- | --- | --- | --- |"
    );
    for (kind, count, cost) in costs {
        let Some((_, least, first)) =
            costs.iter().find(|(k, ..)| k == kind).filter(|(_, least, _)| least < count)
        else {
            continue;
        };
        let logarithm = (*count as f64).ln() / (*least as f64).ln();
        let [a, b] = [0, 1].map(|program| cost[program] / first[program]);
        println!("| {kind} | {least} to {count} | {logarithm:.2} | {a:.2} | {b:.2} |");
    }
}

fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let out = f();
    (out, start.elapsed().as_secs_f64())
}

fn per(bytes: usize, count: usize) -> f64 {
    bytes as f64 / count as f64
}

fn kinds_of_rays(mesh: &MeshGeometry) -> [(&'static str, Vec<Ray>); 4] {
    let bounds = mesh.bounds();
    let size = bounds.extent().max_element();
    let flight = |state: &mut u64| -(1.0 - unit(state)).ln() * FREE_PATH * size;
    let in_medium = random_rays(&bounds, RAYS, flight, |p: Vec3| mesh.contains(p));
    [
        ("primary", camera_rays(&bounds, 300)),
        ("incoherent", random_rays(&bounds, RAYS, |_| f32::INFINITY, |_| true)),
        ("walk", walks(mesh, &in_medium)),
        ("in medium", in_medium),
    ]
}

/// The same flights as those of walks: each starts where the last one ended, or anew where that one met the boundary.
fn walks(mesh: &MeshGeometry, flights: &[Ray]) -> Vec<Ray> {
    let mut inside = None;
    let walk = |flight: &Ray| {
        let ray = Ray { origin: inside.unwrap_or(flight.origin), ..*flight };
        inside = mesh.intersect(&ray).is_none().then(|| ray.at(ray.t_max));
        ray
    };
    flights.iter().map(walk).collect()
}

/// What rays of one kind took.
struct Measured {
    rays: usize,
    hits: usize,
    unequal: usize,
    /// Of nephrite and of Embree, a ray; zero where there is no Embree.
    nanoseconds: [f64; 2],
}

impl Measured {
    /// Cells of a row of the table.
    fn row(&self) -> String {
        let [a, b] = self.nanoseconds;
        let hit = format!("{:.1} %", 100.0 * self.hits as f64 / self.rays as f64);
        if b == 0.0 {
            return format!("{:.2} | | | {hit} |", 1.0e3 / a);
        }
        format!("{:.2} | {:.2} | {:.2} | {hit} | {}", 1.0e3 / a, 1.0e3 / b, b / a, self.unequal)
    }
}

/// Both programs keep the distance of each ray and nothing else: how large the records of their hits are is no matter.
fn compare(mesh: &MeshGeometry, scene: Option<&Scene>, rays: &[Ray]) -> Measured {
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
                    (0, _) => ours.extend(piece.iter().map(|ray| distance(mesh.intersect(black_box(ray))))),
                    (_, Some(scene)) => flush_to_zero(|| {
                        theirs.extend(piece.iter().map(|ray| distance_of(&scene.intersect(black_box(ray)))));
                    }),
                    _ => {}
                }
                seconds[program][number].push(start.elapsed().as_secs_f64());
            }
        }
    }
    let nanoseconds =
        seconds.map(|pieces| 1.0e9 * pieces.into_iter().map(median).sum::<f64>() / rays.len() as f64);
    let hits = ours.iter().filter(|t| t.is_finite()).count();
    if scene.is_none() {
        return Measured { rays: rays.len(), hits, unequal: 0, nanoseconds: [nanoseconds[0], 0.0] };
    }
    let unequal = ours.iter().zip(&theirs).filter(|(a, b)| !agree(**a, **b)).count();
    assert!((unequal as f64) < EDGE_CASES * rays.len() as f64, "{unequal} of {} rays disagree", rays.len());
    Measured { rays: rays.len(), hits, unequal, nanoseconds }
}

fn distance(hit: Option<MeshHit>) -> f32 {
    hit.map_or(f32::INFINITY, |hit| hit.t)
}

fn distance_of(hit: &RayHit) -> f32 {
    if hit.is_hit() { hit.t_far } else { f32::INFINITY }
}

/// Both miss, or both hit at the same distance, up to roundings.
fn agree(ours: f32, theirs: f32) -> bool {
    if ours.is_finite() { (ours - theirs).abs() <= 1.0e-4 * ours.max(1.0e-2) } else { theirs.is_infinite() }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
