//! Random walks per second in a thick dense medium: the exact one, the accelerated one, and a plain one.
//!
//! `cargo bench --bench walks`: a bumpy sphere of 101,568 triangles, 400 mean free paths in size, isotropic, without absorption, of
//! index 1, so that a walk ends where it meets the boundary. Walks set out at random triangles, inwards. The plain walk asks
//! `obvhs`'s CWBVH from its root at every step. With `-- --ordered` they set out along the surface, as those of neighbouring
//! pixels do, which finds more in the caches. All take turns on one thread. Beside the rates stands what must agree: the
//! mean distance from outset to exit, and for exact walks that of the events (4V/S mean free paths).

mod common;

use common::bumpy_sphere;
use glam::{Affine3A, Vec2, Vec3, Vec3A};
use nephrite::geometry::offset_origin;
use nephrite::light::LightSample;
use nephrite::optics::HenyeyGreenstein;
use nephrite::sampling::{Sampler, SmallRng};
use nephrite::scene::{
    InstanceDescription, MaterialDescription, MediumDescription, MeshDescription, Scene, SceneDescription,
    Surface,
};
use nephrite::subsurface::{
    Aim, Aimed, Arrival, Connection, Connector, Flight, PathHead, Registry, Start, Stop,
};
use nephrite::{geometry::Hit, transport::Enclosure};
use obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris, ray::RayHit, triangle::Triangle};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Size of the object in mean free paths.
const SIZE: f32 = 400.0;
/// Turns of each walk; the median counts.
const TURNS: usize = 7;
/// Walks in a turn.
const WALKS: u32 = 30_000;
/// Walks before the first turn, which fill the distance bound: a picture has millions.
const EARLIER: u32 = 300_000;

/// What walks did: seconds, events and distances, in all.
#[derive(Clone, Copy, Default)]
struct Tally {
    seconds: f64,
    events: f64,
    distance: f64,
}

/// Nothing is connected to light.
struct Dark;

impl Connector for Dark {
    fn scattered(&mut self, _: Vec3, _: Vec3, _: Vec3, _: HenyeyGreenstein, _: u32, _: &mut Sampler) {}
    fn redirected(&mut self, _: Vec3, _: f32) {}
    fn light(&mut self, _: Vec3, _: &mut Sampler) -> Option<LightSample> {
        None
    }
    fn closest_light(&mut self, _: Vec3, _: &mut Sampler) -> Option<LightSample> {
        None
    }
    fn deliver(&mut self, _: &Surface, _: &LightSample, _: f32, _: Vec3, _: &mut Sampler) {}
    fn aim(&self, _: Vec3, _: Vec3, _: &mut Aim) -> bool {
        false
    }
    fn draw(&self, _: Vec3, _: &mut Aim, _: &mut Sampler) -> Option<(Vec3, f32)> {
        None
    }
    fn emerge(&mut self, _: &Hit, _: Vec3, _: Vec3, _: &Aim, _: Aimed, _: &mut Sampler) {}
}

fn main() {
    let (positions, triangles) = bumpy_sphere(92);
    let (low, high) = positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b): (Vec3, Vec3), &p| (a.min(p), b.max(p)));
    let sigma_t = SIZE / (high - low).max_element();
    let medium = MediumDescription {
        sigma_a: Vec3::ZERO,
        sigma_s: Vec3::splat(sigma_t),
        anisotropy: 0.0,
        ior: 1.0,
        priority: 0,
        absorption_texture: None,
        scattering_texture: None,
        multi_scatter: None,
    };
    let scene = Scene::build(SceneDescription {
        meshes: vec![MeshDescription {
            positions: positions.clone(),
            triangle_materials: vec![0; triangles.len()],
            triangles: triangles.clone(),
            ..Default::default()
        }],
        materials: vec![MaterialDescription {
            medium: Some(medium),
            transmission: 1.0,
            ..Default::default()
        }],
        instances: vec![InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh: 0,
            transform: Affine3A::IDENTITY,
        }],
        ..Default::default()
    })
    .expect("builds");

    let corner = |i: u32| Vec3A::from(positions[i as usize]);
    let soup: Vec<Triangle> =
        triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
    let tree = build_cwbvh_from_tris(&soup, BvhBuildParams::medium_build(), &mut Duration::default());
    let ordered: Vec<Triangle> = tree.primitive_indices.iter().map(|&i| soup[i as usize]).collect();
    let plain = |start: &Hit, rng: &mut SmallRng, tally: &mut Tally| {
        let surface = Surface::new(&scene, start);
        let mut d = -surface.geometric_normal;
        let mut p = offset_origin(surface.position, surface.error, surface.geometric_normal, d);
        loop {
            let t = -rng.open01().ln() / sigma_t;
            let mut hit = RayHit::none();
            let ray = obvhs::ray::Ray::new(p.into(), d.into(), 0.0, t);
            if tree.ray_traverse(ray, &mut hit, |ray, id| ordered[id].intersect(ray)) {
                tally.distance += f64::from((p + d * hit.t).distance(surface.position) * sigma_t);
                return;
            }
            // Rounding let it out.
            if (p - 0.5 * (low + high)).length() > (high - low).length() {
                return;
            }
            p += d * t;
            tally.events += 1.0;
            d = direction(rng);
        }
    };

    let models = Registry::standard();
    let exact = models.get("random-walk").expect("a model").prepare(&scene);
    let accelerated = models.get("accelerated-walk").expect("a model").prepare(&scene);
    let object = &scene.objects[0];
    let flight = Flight {
        scene: &scene,
        enclosure: Enclosure { instance: 0, material: 0, rank: object.rank },
        object,
        medium: scene.medium(0).expect("a medium"),
        eta: 1.0,
        budget: u32::MAX,
        connection: Connection::None,
        stop: Stop::NEVER,
    };
    let ordered = std::env::args().any(|argument| argument == "--ordered");
    let mut turns: [Vec<Tally>; 3] = Default::default();
    for turn in 0..=TURNS as u32 {
        for (which, tallies) in turns.iter_mut().enumerate() {
            let mut tally = Tally::default();
            let began = processor_seconds();
            let count = if turn > 0 { WALKS } else { EARLIER };
            for walk in 0..count {
                let mut sampler = Sampler::new(walk, turn, which as u32);
                let place = if ordered { walk as f32 / count as f32 } else { sampler.rng().f32() };
                let triangle = (place * triangles.len() as f32) as u32 % triangles.len() as u32;
                let start = Hit::at(0, triangle, 0.3, 0.3);
                let model = match which {
                    0 => {
                        plain(&start, sampler.rng(), &mut tally);
                        continue;
                    }
                    1 => &exact,
                    _ => &accelerated,
                };
                let surface = Surface::new(&scene, &start);
                let mut head = PathHead {
                    position: surface.position,
                    direction: -surface.geometric_normal,
                    throughput: Vec3::ONE,
                    events: 0,
                    start: Some(Start { instance: 0, triangle, barycentric: Vec2::splat(0.3) }),
                    aimed: Aimed::default(),
                };
                if let Arrival::Surface(_) = model.propagate(&flight, &mut head, &mut sampler, &mut Dark) {
                    tally.distance += f64::from(head.position.distance(surface.position) * sigma_t);
                }
                tally.events += f64::from(head.events);
            }
            tally.seconds = processor_seconds() - began;
            if turn > 0 {
                tallies.push(tally);
            }
        }
    }
    println!("| walk | walks a second | over plain, median (least to most) | events | distance |");
    println!("| --- | --- | --- | --- | --- |");
    let seconds: [Vec<f64>; 3] = [0, 1, 2].map(|i| turns[i].iter().map(|t| t.seconds).collect());
    for (i, name) in ["plain, obvhs CWBVH", "random-walk", "accelerated-walk"].into_iter().enumerate() {
        let mut ratios: Vec<f64> =
            seconds[0].iter().zip(&seconds[i]).map(|(plain, own)| plain / own).collect();
        ratios.sort_by(f64::total_cmp);
        let walks = f64::from(WALKS) * TURNS as f64;
        let sum = |of: fn(&Tally) -> f64| turns[i].iter().map(of).sum::<f64>();
        println!(
            "| {name} | {:.0} | {:.1} ({:.1} to {:.1}) | {:.1} | {:.2} |",
            walks / sum(|t| t.seconds),
            ratios[TURNS / 2],
            ratios[0],
            ratios[TURNS - 1],
            sum(|t| t.events) / walks,
            sum(|t| t.distance) / walks
        );
    }
}

/// Seconds that this thread has had a processor, which other programs do not change much; those of the clock where the system
/// does not tell.
fn processor_seconds() -> f64 {
    static BEGAN: OnceLock<Instant> = OnceLock::new();
    // Nanoseconds of this thread, the first of three numbers.
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| BEGAN.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// Uniform over the sphere.
fn direction(rng: &mut SmallRng) -> Vec3 {
    let z = 2.0 * rng.f32() - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * rng.f32()).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}
