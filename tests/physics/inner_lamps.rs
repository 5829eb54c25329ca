//! Lamps inside bodies that absorb nothing: their power leaves whole.

use crate::lab::*;
use glam::{Affine3A, Vec3, Vec4};
use nephrite::scene::*;
use std::f64::consts::PI;

const RADIUS: f32 = 0.01;
/// Of the medium, 1/m: three mean free paths from the middle to the boundary.
const SIGMA_S: f32 = 300.0;

// Flat: interpolated normals do not send light out as they let it in, and a coarse mesh of them shows it in per cents.
fn ball(ior: f32, roughness: f32) -> SceneDescription {
    let material = subsurface(Vec3::ZERO, Vec3::splat(SIGMA_S), 0.0, ior, roughness);
    single(icosphere(RADIUS, 4, false), material, EnvironmentDescription::default())
}

/// A ball of another index around it.
fn wrap(mut scene: SceneDescription, radius: f32, ior: f32, roughness: f32) -> SceneDescription {
    scene.materials.push(subsurface(Vec3::ZERO, Vec3::splat(0.5 * SIGMA_S), 0.3, ior, roughness));
    let material = scene.materials.len() as u32 - 1;
    let mut mesh = icosphere(radius, 4, false);
    mesh.triangle_materials.fill(material);
    scene.meshes.push(mesh);
    scene.instances.push(place(scene.meshes.len() - 1, Affine3A::IDENTITY));
    scene
}

/// A white ball that shines, of 1 W.
fn add_globe(scene: &mut SceneDescription, center: Vec3, radius: f32) {
    let mut mesh = icosphere(radius, 2, false);
    let area: f32 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    scene.materials.push(MaterialDescription {
        base_color: Vec4::ONE,
        metallic: 0.0,
        roughness: 1.0,
        specular: 0.0,
        emission: Vec3::splat(1.0 / (std::f32::consts::PI * area)),
        ..Default::default()
    });
    mesh.triangle_materials.fill(scene.materials.len() as u32 - 1);
    scene.meshes.push(mesh);
    scene.instances.push(place(scene.meshes.len() - 1, Affine3A::from_translation(center)));
}

/// A point light of 1 W.
fn point(position: Vec3, kind: PunctualKind, power: f64) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity: Vec3::splat((1.0 / power) as f32),
        position,
        direction: Vec3::new(0.6, 0.0, 0.8),
        range: None,
        kind,
    }
}

/// Power that leaves the scene within a sphere of that radius, from the intensity in the directions of an icosahedron's
/// vertices: exact for angular variation up to the fifth order.
fn power(scene: SceneDescription, radius: f32, spp: u32, case: &str) -> Estimate {
    let scene = Scene::build(scene).expect("builds");
    let directions = icosphere(1.0, 0, false).positions;
    let half = 1.02 * radius;
    let estimates: Vec<Estimate> = directions
        .iter()
        .enumerate()
        .map(|(i, d)| {
            let options = options(ortho(*d, 0.1, half), 12, spp)
                .with(|o| o.settings.seed = seed_of(case) + 100 * i as u32);
            measure_pictures(&scene, &options, 8)[0]
        })
        .collect();
    let scale = 4.0 * PI * 4.0 * f64::from(half * half) / estimates.len() as f64;
    Estimate {
        mean: [0, 1, 2].map(|c| scale * estimates.iter().map(|e| e.mean[c]).sum::<f64>()),
        se: [0, 1, 2].map(|c| scale * estimates.iter().map(|e| e.se[c].powi(2)).sum::<f64>().sqrt()),
    }
}

/// Room for what twelve directions cannot tell of the intensity.
const ANGULAR: f64 = 0.001;

/// Asserts |z| < 4, with an error of 4 % at most: near a point light radiance grows with the square of nearness, so that
/// pictures of it are noisy.
fn check(found: &Estimate, expected: f64, what: &str) {
    check_to(found, expected, 0.04, what);
}

/// Asserts |z| < 4, with that error at most.
fn check_to(found: &Estimate, expected: f64, most: f64, what: &str) {
    for c in 0..3 {
        let se = found.se[c].hypot(ANGULAR);
        let z = (found.mean[c] - expected) / se;
        println!("{what} [{c}]: {:.4} ± {se:.4}, expected {expected:.4}, z {z:+.2}", found.mean[c]);
        assert!(se < most && z.abs() < 4.0, "{what} [{c}]: {} ± {se} is not {expected}", found.mean[c]);
    }
}

#[test]
fn the_power_of_an_emitter_inside_leaves_whole() {
    for (ior, roughness) in [(1.0, 0.0), (1.5, 0.0), (1.5, 0.4)] {
        for center in [Vec3::ZERO, Vec3::new(0.003, 0.002, -0.004)] {
            let mut scene = ball(ior, roughness);
            add_globe(&mut scene, center, 0.001);
            let case = format!("globe at {center}, index {ior}, roughness {roughness}");
            check_to(&power(scene, RADIUS, 16, &case), 1.0, 0.02, &case);
        }
    }
}

#[test]
fn the_power_of_an_emitter_in_nested_bodies_leaves_whole() {
    let mut scene = wrap(ball(1.3, 0.3), 2.0 * RADIUS, 1.6, 0.4);
    add_globe(&mut scene, Vec3::new(0.002, 0.0, 0.003), 0.001);
    check_to(&power(scene, 2.0 * RADIUS, 16, "nested globe"), 1.0, 0.02, "nested globe");
}

/// A camera cannot see a point, so what comes from it in a straight line is lacking where nothing scatters it.
#[test]
fn the_power_of_a_point_light_inside_leaves_whole() {
    let through = (-f64::from(SIGMA_S * RADIUS)).exp();
    let everywhere = 4.0 * PI;
    // The ball is a polyhedron, of a mean radius that is 0.08 % less.
    let index_one = 1.0 - through * (1.0 + 0.0008 * f64::from(SIGMA_S * RADIUS));
    // Reflected by the boundary, straight light passes the middle again.
    let fresnel = 0.04;
    let smooth = 1.0 - (1.0 - fresnel) * through / (1.0 - fresnel * through * through);
    for (ior, roughness, expected) in [(1.0, 0.0, index_one), (1.5, 0.0, smooth), (1.5, 0.4, 1.0)] {
        let mut scene = ball(ior, roughness);
        scene.lights = vec![point(Vec3::ZERO, PunctualKind::Point, everywhere)];
        let case = format!("point light, index {ior}, roughness {roughness}");
        check(&power(scene, RADIUS, 24, &case), expected, &case);
    }
}

#[test]
fn the_power_of_a_point_light_in_nested_bodies_leaves_whole() {
    for (inner, outer) in [(1.3, 1.6), (1.6, 1.3)] {
        let mut scene = wrap(ball(inner, 0.4), 2.0 * RADIUS, outer, 0.4);
        scene.lights = vec![point(Vec3::new(0.0, 0.002, 0.001), PunctualKind::Point, 4.0 * PI)];
        let case = format!("point light, index {inner} in {outer}");
        check(&power(scene, 2.0 * RADIUS, 48, &case), 1.0, &case);
    }
}

#[test]
fn the_power_of_a_spot_inside_leaves_whole() {
    let versine = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
    let (inner, outer) = (0.2, 0.5);
    // 2π ∫ ramp² d(1 − cos θ).
    let solid_angle = 2.0 * PI * (versine(inner) + (versine(outer) - versine(inner)) / 3.0);
    let kind = PunctualKind::Spot { inner: inner as f32, outer: outer as f32 };
    let mut scene = ball(1.5, 0.4);
    scene.lights = vec![point(Vec3::new(-0.003, 0.0, -0.004), kind, solid_angle)];
    check(&power(scene, RADIUS, 24, "spot"), 1.0, "spot");
}
