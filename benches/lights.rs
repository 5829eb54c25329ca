//! Cost and noise of choosing among many lights: nanoseconds for a light sample and for the density of a given direction,
//! and the variance of the irradiance of a floor under lamps, relative to its square.
//!
//! `cargo bench --bench lights`

use glam::{Vec2, Vec3};
use nephrite::light::{EmissiveRadiance, EmissiveTriangle, LightPoint, Lights};
use nephrite::sampling::SmallRng;
use nephrite::scene::{EnvironmentDescription, PunctualKind, PunctualLight};
use std::f32::consts::PI;
use std::hint::black_box;
use std::time::Instant;

/// Edge of the floor that lamps hang above, metres, and their height.
const SIDE: f32 = 20.0;
const HEIGHT: f32 = 3.0;
const SAMPLES: u32 = 200_000;

/// Points above the floor; lamps of equal area in all, whatever their number.
fn places(n: usize) -> impl Iterator<Item = (Vec3, f32)> {
    let mut rng = SmallRng::new(1);
    (0..n).map(move |i| {
        let at = Vec3::new((rng.f32() - 0.5) * SIDE, HEIGHT + rng.f32(), (rng.f32() - 0.5) * SIDE);
        (at, 1.0 + (i % 5) as f32)
    })
}

fn lamps(n: usize) -> Lights {
    let size = (10.0 / n as f32).sqrt();
    let triangle = |(i, (at, radiance)): (usize, (Vec3, f32))| {
        let vertices = [at, at + size * Vec3::X, at + size * Vec3::Z];
        EmissiveTriangle {
            instance: 0,
            triangle: i as u32,
            vertices,
            geometric_normal: Vec3::NEG_Y,
            double_sided: false,
            power: Vec3::splat(radiance * 0.5 * size * size * PI),
            radiance: EmissiveRadiance::Constant(Vec3::splat(radiance)),
        }
    };
    let emitters = places(n).enumerate().map(triangle).collect();
    Lights::build(emitters, &[], &EnvironmentDescription::default())
}

fn points(n: usize) -> Lights {
    let light = |(position, intensity): (Vec3, f32)| PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(intensity / n as f32),
        position,
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    };
    let punctual: Vec<PunctualLight> = places(n).map(light).collect();
    Lights::build(Vec::new(), &punctual, &EnvironmentDescription::default())
}

fn main() {
    println!(
        "{:>8} {:>10} {:>12} {:>12} {:>12} {:>12}",
        "lights", "kind", "build, ms", "sample, ns", "pdf, ns", "variance"
    );
    for n in [10, 100, 1_000, 10_000, 100_000] {
        for (kind, build) in [("triangles", lamps as fn(usize) -> Lights), ("points", points)] {
            let start = Instant::now();
            let lights = build(n);
            let built = start.elapsed().as_secs_f64() * 1e3;
            measure(n, kind, built, &lights);
        }
    }
}

fn measure(n: usize, kind: &str, built: f64, lights: &Lights) {
    let mut rng = SmallRng::new(7);
    let mut floor = || Vec3::new((rng.f32() - 0.5) * SIDE, 0.0, (rng.f32() - 0.5) * SIDE);
    let anchors: Vec<Vec3> = (0..64).map(|_| floor()).collect();
    let mut rng = SmallRng::new(9);
    let start = Instant::now();
    let mut found = Vec::with_capacity(SAMPLES as usize);
    let mut relative = 0.0;
    for point in &anchors {
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        let each = SAMPLES / anchors.len() as u32;
        for _ in 0..each {
            let (select, u) = (rng.f32(), Vec2::new(rng.f32(), rng.f32()));
            let sample = black_box(lights.sample(*point, Some(Vec3::Y), select, u));
            let value = sample.map_or(0.0, |s| f64::from(s.radiance.x * s.direction.y.max(0.0) / s.pdf));
            sum += value;
            squares += value * value;
            found.extend(sample.map(|s| (*point, s)));
        }
        let mean = sum / f64::from(each);
        relative += (squares / f64::from(each) / (mean * mean) - 1.0) / anchors.len() as f64;
    }
    let sampled = start.elapsed().as_secs_f64() * 1e9 / f64::from(SAMPLES);
    let start = Instant::now();
    for (point, s) in &found {
        if let LightPoint::Emitter(id, position) = s.point {
            black_box(lights.emitter_pdf(id, *point, Some(Vec3::Y), position));
        }
    }
    let weighed = start.elapsed().as_secs_f64() * 1e9 / found.len().max(1) as f64;
    println!("{n:>8} {kind:>10} {built:>12.1} {sampled:>12.0} {weighed:>12.0} {relative:>12.3}");
}
