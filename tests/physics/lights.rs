//! Direct light of every kind on a Lambertian plane, against closed forms.

use crate::lab::*;
use glam::{Affine3A, Vec3, Vec4};
use nephrite::scene::*;
use std::f32::consts::PI;

/// At y = 0, facing up.
fn quad(half: f32) -> MeshDescription {
    MeshDescription {
        positions: vec![
            Vec3::new(-half, 0.0, -half),
            Vec3::new(-half, 0.0, half),
            Vec3::new(half, 0.0, half),
            Vec3::new(half, 0.0, -half),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Default::default()
    }
}

fn ground() -> SceneDescription {
    single(quad(50.0), matte(0.5), EnvironmentDescription::default())
}

fn check(scene: SceneDescription, expected: f32, what: &str) {
    let scene = Scene::build(scene).expect("builds");
    let camera = ortho(Vec3::new(0.2, -1.0, 0.1), 0.5, 1e-4);
    let estimate = measure(&scene, &options(camera, 24, 64));
    estimate.assert_matches([f64::from(expected); 3], [1e-5; 3], what);
}

#[test]
fn punctual_lights_follow_khr_lights_punctual() {
    let light = |kind, position: Vec3, direction: Vec3| PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(3.0),
        position,
        direction,
        range: None,
        kind,
    };
    let brdf = 0.5 / PI;
    let at = Vec3::new(1.0, 2.0, 0.0);
    let cosine = at.normalize().y;
    let mut scene = ground();
    scene.lights = vec![light(PunctualKind::Point, at, Vec3::NEG_Y)];
    check(scene, brdf * 3.0 * cosine / at.length_squared(), "point");

    let mut scene = ground();
    scene.lights = vec![light(PunctualKind::Directional, Vec3::ZERO, -at.normalize())];
    check(scene, brdf * 3.0 * cosine, "directional");

    let mut scene = ground();
    scene.lights = vec![light(PunctualKind::Spot { inner: 0.1, outer: 0.6 }, at, Vec3::NEG_Y)];
    let scale = 1.0 / (0.1f32.cos() - 0.6f32.cos());
    let angular = ((cosine - 0.6f32.cos()) * scale).clamp(0.0, 1.0).powi(2);
    check(scene, brdf * 3.0 * angular * cosine / at.length_squared(), "spot");

    let mut scene = ground();
    let mut ranged = light(PunctualKind::Point, at, Vec3::NEG_Y);
    ranged.range = Some(3.0);
    scene.lights = vec![ranged];
    let window = (1.0 - (at.length() / 3.0).powi(4)).clamp(0.0, 1.0);
    check(scene, brdf * 3.0 * window * cosine / at.length_squared(), "point with range");
}

#[test]
fn an_area_light_and_an_environment_give_their_irradiance() {
    let mut scene = ground();
    scene.environment = EnvironmentDescription::Constant(Vec3::splat(0.7));
    check(scene, 0.5 * 0.7, "environment");

    let mut scene = ground();
    let mut lamp = quad(0.5);
    lamp.triangle_materials = vec![1; 2];
    scene.meshes.push(lamp);
    scene.materials.push(MaterialDescription {
        emission: Vec3::splat(5.0),
        base_color: Vec4::ZERO,
        ..Default::default()
    });
    let flip = Affine3A::from_rotation_x(PI);
    scene.instances.push(place(1, Affine3A::from_translation(Vec3::Y) * flip));
    // Four right corners of half size a at height h: configuration factor of a rectangle above a differential element.
    let x = 0.5f32 / 1.0;
    let corner = x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan() * 2.0 / (2.0 * PI);
    check_off_axis(scene, 0.5 * 5.0 * 4.0 * corner);
}

/// The lamp is straight above, so the camera looks from below it.
fn check_off_axis(scene: SceneDescription, expected: f32) {
    let scene = Scene::build(scene).expect("builds");
    let camera = ortho(Vec3::new(0.2, -1.0, 0.1), 0.5, 1e-4);
    let estimate = measure(&scene, &options(camera, 24, 256));
    estimate.assert_matches([f64::from(expected); 3], [1e-5; 3], "lamp");
}
