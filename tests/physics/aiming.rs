//! Aiming at light through a boundary changes the noise and nothing else: pictures with and without it have one mean.

use crate::lab::*;
use glam::{Vec3, Vec4};
use nephrite::scene::*;

/// A few mean free paths, so that walks are short.
const RADIUS: f32 = 0.004;

/// So many that their mean is about as far from the truth as its standard error says: with eight, one comparison in a
/// thousand is four errors off, and the 75 here are asked to be right together.
const PICTURES: u32 = 32;

/// A sphere of wax on a matte ground, which it touches.
fn wax(roughness: f32, environment: EnvironmentDescription) -> SceneDescription {
    let material =
        subsurface(Vec3::new(1.0, 4.0, 16.0), Vec3::new(800.0, 600.0, 400.0), 0.2, 1.45, roughness);
    let mut scene = single(icosphere(RADIUS, 3, true), material, environment);
    let ground = MaterialDescription {
        base_color: Vec4::new(0.5, 0.4, 0.3, 1.0),
        metallic: 0.0,
        roughness: 1.0,
        ..Default::default()
    };
    add_panel(&mut scene, Vec3::new(0.0, -RADIUS, 0.0), Vec3::Y, 0.1, ground);
    scene
}

fn add_lamp(scene: &mut SceneDescription, center: Vec3, half: f32, radiance: Vec3) {
    let material = MaterialDescription { emission: radiance, ..Default::default() };
    add_panel(scene, center, -center.normalize(), half, material);
}

/// Compares [`PICTURES`] pictures of `spp` samples with as many of twice the samples that do without aiming.
fn compare(scene: SceneDescription, spp: u32, what: &str) {
    let scene = Scene::build(scene).expect("builds");
    let aimed = options(ortho(Vec3::new(-0.3, -0.4, -0.9), 0.1, 0.9 * RADIUS), 24, spp).with(|o| {
        o.settings.aim = true;
        o.settings.seed = seed_of(what);
    });
    let plain = aimed.clone().with(|o| {
        o.settings.aim = false;
        o.settings.seed = aimed.settings.seed ^ 0xabcd;
        o.samples.count = 2 * spp;
    });
    let aimed = measure_pictures(&scene, &aimed, PICTURES);
    let plain = measure_pictures(&scene, &plain, PICTURES);
    for (part, (a, b)) in aimed.iter().zip(&plain).enumerate() {
        a.assert_same(b, &format!("{what}, part {part}"));
    }
}

#[test]
fn lamps_around_and_a_patch_of_sky_have_their_light() {
    let pixels = (0..32 * 16)
        .map(|i| if (20..23).contains(&(i % 32)) && (3..6).contains(&(i / 32)) { 30.0 } else { 0.3 })
        .map(Vec3::splat)
        .collect();
    let sky = EnvironmentDescription::Map { width: 32, height: 16, pixels, scale: Vec3::ONE, rotation: 0.0 };
    // Light from all sides, some of it grazing and below the horizon of most points.
    for (roughness, what) in [(0.35, "rough"), (0.1, "nearly smooth"), (0.0, "smooth")] {
        let mut scene = wax(roughness, sky.clone());
        add_lamp(&mut scene, Vec3::new(0.05, 0.04, 0.02), 0.01, Vec3::new(40.0, 30.0, 20.0));
        add_lamp(&mut scene, Vec3::new(-0.04, 0.0, -0.03), 0.006, Vec3::new(20.0, 40.0, 60.0));
        add_lamp(&mut scene, Vec3::new(0.0, 0.06, -0.06), 0.02, Vec3::splat(10.0));
        compare(scene, if roughness == 0.0 { 64 } else { 32 }, what);
    }
}

#[test]
fn a_point_light_has_its_light() {
    let mut scene = wax(0.5, EnvironmentDescription::default());
    scene.lights = vec![PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(0.01),
        position: Vec3::new(0.03, 0.03, -0.02),
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    }];
    compare(scene, 64, "point light");
}

#[test]
fn textured_wax_has_the_same_light_with_and_without_aiming() {
    // Coefficients that differ by a factor of four from place to place, so that the density of arriving is only a guess.
    for (roughness, what) in [(0.35, "textured rough"), (0.0, "textured smooth")] {
        let mut scene = wax(roughness, EnvironmentDescription::Constant(Vec3::splat(0.2)));
        scene.meshes[0] = with_uvs(icosphere(RADIUS, 2, true));
        let texels = [Vec3::ONE, Vec3::splat(0.25), Vec3::new(0.4, 0.7, 1.0), Vec3::new(1.0, 0.5, 0.3)];
        let texture = add_texture(&mut scene, 2, &texels);
        if let Some(medium) = &mut scene.materials[0].medium {
            medium.scattering_texture = Some(texture);
        }
        // Large, so that it is found by chance often enough to compare with.
        add_lamp(&mut scene, Vec3::new(0.05, 0.04, 0.02), 0.03, Vec3::new(4.0, 3.0, 2.0));
        compare(scene, 8, what);
    }
}
