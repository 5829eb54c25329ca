//! Sampling against look-up, orientation and closed forms of environments.

use super::super::environment_map::EnvironmentMap;
use super::*;
use crate::sampling::{
    SmallRng,
    statistics::{Estimate, chi_square_z},
};
use std::f32::consts::TAU;

fn map(width: usize, height: usize, rotation: f32, value: impl Fn(usize, usize) -> Vec3) -> Environment {
    let pixels = (0..width * height).map(|i| value(i % width, i / width)).collect();
    Environment::new(&EnvironmentDescription::Map { width, height, pixels, scale: Vec3::ONE, rotation })
}

fn one_bright_texel(rotation: f32, x: usize, y: usize) -> Environment {
    map(16, 8, rotation, |i, j| if (i, j) == (x, y) { Vec3::new(300.0, 200.0, 100.0) } else { Vec3::ZERO })
}

fn noise(width: usize, height: usize) -> Environment {
    map(width, height, 0.7, |x, y| {
        let mut rng = SmallRng::for_sample(x as u32, y as u32, 1);
        Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 10f32.powf(3.0 * rng.f32() - 2.0)
    })
}

fn cases() -> Vec<(&'static str, Environment)> {
    vec![
        ("constant", Environment::Constant(Vec3::new(1.0, 2.0, 3.0))),
        ("one texel", map(1, 1, 0.0, |_, _| Vec3::ONE)),
        ("two texels", map(2, 1, 1.0, |x, _| Vec3::splat(x as f32))),
        ("noise", noise(31, 17)),
        ("bright texel", one_bright_texel(0.3, 5, 2)),
        ("bright pole", one_bright_texel(-2.0, 3, 0)),
        ("bright seam", one_bright_texel(0.0, 15, 7)),
    ]
}

const NORMAL: Vec3 = Vec3::new(0.48, -0.6, 0.64);
const FACINGS: [Facing; 3] = [Facing::All, Facing::Surface(NORMAL), Facing::About(NORMAL)];

/// Each environment, sampled for each kind of receiver that it has light for.
fn sampled_cases() -> impl Iterator<Item = (&'static str, Facing, Environment)> {
    let each = |(name, e): (&'static str, Environment)| FACINGS.map(move |f| (name, f, e.clone()));
    cases().into_iter().flat_map(each).filter(|(_, facing, e)| e.sample(*facing, Vec2::splat(0.5)).is_some())
}

#[test]
fn sampled_pdf_and_radiance_agree_with_the_look_up() {
    for (name, facing, environment) in sampled_cases() {
        let mut rng = SmallRng::new(1);
        for _ in 0..20_000 {
            let Some(s) = environment.sample(facing, rng.vec2()) else { continue };
            assert!((s.direction.length() - 1.0).abs() < 1e-5);
            let radiance = environment.radiance(s.direction);
            // Rounding of the direction moves the look-up by about 1e-6 of the map; relative errors grow only where
            // the radiance vanishes.
            let tolerance = 1e-4 * s.radiance.max_element() + 1e-3 * environment.mean_radiance();
            assert!((radiance - s.radiance).abs().max_element() < tolerance, "{name}: {radiance} {s:?}");
            if s.radiance.max_element() > 0.1 * environment.mean_radiance() && s.direction.y.abs() < 0.999 {
                let pdf = environment.pdf(facing, s.direction);
                assert!((pdf - s.pdf).abs() < 1e-2 * s.pdf, "{name}: {pdf} {s:?}");
            }
        }
    }
}

#[test]
fn pdf_integrates_to_one_and_is_positive_where_there_is_light() {
    for (name, facing, environment) in sampled_cases() {
        let mut rng = SmallRng::new(2);
        let (mut total, mut light) = (Estimate::default(), Estimate::default());
        for _ in 0..400_000 {
            let d = warp::uniform_sphere(rng.vec2());
            let (pdf, radiance) = (environment.pdf(facing, d), environment.radiance(d));
            let counts = match facing {
                Facing::All => true,
                Facing::Surface(n) => n.dot(d) > 0.0,
                Facing::About(_) => false,
            };
            let found = pdf > 0.0 || !counts || radiance.max_element() < 1e-3;
            assert!(pdf.is_finite() && found, "{name} {facing:?}: {d}");
            total.add(f64::from(pdf * warp::SPHERE));
            light.add(f64::from(mean(radiance)));
        }
        assert!(total.z(1.0).abs() < 4.0, "{name} {facing:?}: z = {}", total.z(1.0));
        let z = light.z(f64::from(environment.mean_radiance()));
        assert!(z.abs() < 4.0, "{name}: mean radiance z = {z}");
    }
}

#[test]
fn samples_follow_the_pdf() {
    // χ² over 24 × 24 bins of equal solid angle; expectations by 128 × 64 midpoints in (θ, φ), where
    // the integrand pdf sin θ is smooth up to the poles except for
    // steps between rows of cells and between blocks.
    for (name, facing, environment) in sampled_cases() {
        let bins = 24usize;
        let n = 100_000u32;
        let mut counts = vec![0u64; bins * bins];
        let mut rng = SmallRng::new(3);
        for _ in 0..n {
            if let Some(s) = environment.sample(facing, rng.vec2()) {
                let d = s.direction;
                let y = ((d.y * 0.5 + 0.5) * bins as f32).clamp(0.0, bins as f32 - 1.0) as usize;
                let phi = (d.z.atan2(d.x) / TAU + 0.5) * bins as f32;
                counts[y * bins + phi.clamp(0.0, bins as f32 - 1.0) as usize] += 1;
            }
        }
        let (fine, fine_phi) = (128, 64);
        let expected: Vec<f64> = (0..bins * bins)
            .map(|i| {
                let mut sum = 0.0;
                let theta = |y: usize| (1.0 - 2.0 * y as f32 / bins as f32).acos();
                let (start, end) = (theta(i / bins + 1), theta(i / bins));
                for k in 0..fine * fine_phi {
                    let theta = start + (end - start) * ((k / fine_phi) as f32 + 0.5) / fine as f32;
                    let phi =
                        ((i % bins) as f32 + ((k % fine_phi) as f32 + 0.5) / fine_phi as f32) / bins as f32;
                    let (sin, cos) = theta.sin_cos();
                    let (sin_phi, cos_phi) = (TAU * (phi - 0.5)).sin_cos();
                    // Bins count y upwards from −1.
                    let d = Vec3::new(sin * cos_phi, -cos, sin * sin_phi);
                    sum += f64::from(environment.pdf(facing, d) * sin);
                }
                let area = f64::from((end - start).abs() * TAU / bins as f32);
                sum / f64::from((fine * fine_phi) as u32) * area * f64::from(n)
            })
            .collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "{name} {facing:?}: z = {z}");
    }
}

#[test]
fn radiance_over_pdf_is_nearly_constant_away_from_the_poles() {
    // The promise of sampling the bilinear patch itself: only sin θ within a row of cells varies.
    let environment = map(64, 32, 0.0, |x, y| Vec3::splat(if (x, y) == (20, 16) { 1e5 } else { 1.0 }));
    let mut rng = SmallRng::new(4);
    for _ in 0..10_000 {
        let s = environment.sample(Facing::All, rng.vec2()).unwrap();
        if s.direction.y.abs() < 0.8 {
            let ratio = mean(s.radiance) / s.pdf / (warp::SPHERE * environment.mean_radiance());
            assert!((0.85..1.15).contains(&ratio), "{ratio} at {}", s.direction);
        }
    }
}

#[test]
fn constant_environment_gives_pi_to_every_normal() {
    let environment = Environment::Constant(Vec3::ONE);
    let mut rng = SmallRng::new(5);
    for normal in [Vec3::Y, Vec3::new(0.6, -0.8, 0.0)] {
        for _ in 0..1000 {
            let s = environment.sample(Facing::Surface(normal), rng.vec2()).unwrap();
            assert_eq!(s.pdf, environment.pdf(Facing::Surface(normal), s.direction));
            // Cosine sampling makes every sample exact.
            assert!((s.radiance.x * normal.dot(s.direction) / s.pdf - PI).abs() < 1e-4);
        }
        assert_eq!(environment.pdf(Facing::Surface(normal), -normal), 0.0);
    }
}

#[test]
fn map_orientation_is_that_of_three_js() {
    // 16 × 8: texel column 12 is centred on u = 12.5/16, φ = 2π(u − ½) = 0.5625·π, row 2 on v = 2.5/8 from the top.
    let phi = TAU * (12.5 / 16.0 - 0.5f32);
    let theta = PI * 2.5 / 8.0;
    let expected = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
    assert!(expected.y > 0.0 && expected.z > 0.0);
    let plain = one_bright_texel(0.0, 12, 2);
    assert!((plain.radiance(expected) - Vec3::new(300.0, 200.0, 100.0)).length() < 0.1);
    // +Z is u = ¾, +X is u = ½, the top row is +Y.
    let z = map(4, 2, 0.0, |x, y| Vec3::new(x as f32, y as f32, 0.0));
    let at = |d: Vec3| z.radiance(d);
    assert!((at(Vec3::Z).x - 2.5).abs() < 1e-5 && (at(Vec3::X).x - 1.5).abs() < 1e-5);
    assert!(at(Vec3::new(0.1, 0.99, 0.0).normalize()).y == 0.0);
    assert!(at(Vec3::new(0.1, -0.99, 0.0).normalize()).y == 1.0);
    // Turning by +90° about +Y brings what was at +Z to +X: counter-clockwise seen from above.
    let turned = map(4, 2, PI / 2.0, |x, y| Vec3::new(x as f32, y as f32, 0.0));
    assert!((turned.radiance(Vec3::X) - z.radiance(Vec3::Z)).length() < 1e-5);
    assert!((turned.radiance(-Vec3::Z) - z.radiance(Vec3::X)).length() < 1e-5);
}

#[test]
fn unusable_maps_are_darkness_and_bad_pixels_are_counted() {
    assert!(map(2, 2, 0.0, |_, _| Vec3::ZERO).is_none());
    assert!(map(2, 2, 0.0, |_, _| Vec3::NAN).is_none());
    assert!(EnvironmentMap::new(3, 2, &[Vec3::ONE; 5], Vec3::ONE, 0.0).is_none());
    assert!(EnvironmentMap::new(0, 0, &[], Vec3::ONE, 0.0).is_none());
    let pixels = [Vec3::new(f32::NAN, 1.0, -1.0), Vec3::splat(f32::INFINITY), Vec3::ONE, Vec3::ONE];
    let map = EnvironmentMap::new(2, 2, &pixels, Vec3::ONE, 0.0).unwrap();
    assert_eq!(map.repaired(), 2);
    for d in [Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, Vec3::NAN] {
        let pdf = map.pdf(Facing::All, d);
        assert!(d.is_nan() || (map.radiance(d).is_finite() && pdf.is_finite()));
    }
    let mut rng = SmallRng::new(6);
    for _ in 0..1000 {
        assert!(map.sample(Facing::All, rng.vec2()).unwrap().pdf.is_finite());
    }
}

#[test]
fn maps_are_sampled_by_radiance_times_cosine() {
    // A bright sky in the upper half, a tenth of it below, seen by a surface that faces down and aside: the variance of the
    // irradiance, relative to its square, is a fifth of what it is without the normal, or less.
    let environment = map(64, 32, 0.0, |_, y| if y < 16 { Vec3::ONE } else { Vec3::splat(0.1) });
    let normal = Vec3::new(0.6, -0.8, 0.0);
    let variance = |facing| {
        let mut rng = SmallRng::new(7);
        let (mut sum, mut squares) = (0.0, 0.0);
        const N: u32 = 100_000;
        for _ in 0..N {
            let s = environment.sample(facing, rng.vec2()).expect("light");
            let value = f64::from(mean(s.radiance) * normal.dot(s.direction).max(0.0) / s.pdf);
            sum += value;
            squares += value * value;
        }
        let n = f64::from(N);
        (sum / n, squares / n / (sum / n).powi(2) - 1.0)
    };
    let (plain, product) = (variance(Facing::All), variance(Facing::Surface(normal)));
    assert!((plain.0 / product.0 - 1.0).abs() < 0.05, "{plain:?} {product:?}");
    assert!(product.1 < 0.2 * plain.1, "{plain:?} {product:?}");
}
