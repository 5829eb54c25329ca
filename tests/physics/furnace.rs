//! White furnaces: in a uniform environment of radiance 1 an object that absorbs nothing cannot be seen.

use crate::lab::*;
use glam::{Affine3A, Vec3};
use nephrite::asset::{self, LoadOptions};
use nephrite::scene::{
    CameraDescription, EnvironmentDescription, MeshDescription, Scene, SceneDescription, auto_camera,
};
use nephrite::transport::render;
use std::path::Path;

/// Scattering that differs between the channels by a factor of ten: weights that gain or lose show as colour.
const SIGMA_S: Vec3 = Vec3::new(50.0, 150.0, 500.0);
/// Channels that differ by a ninth each: the weights of the channels scatter less, so that means can be held to 0.1 % in
/// reasonable time. An error of the weights that grows with contrast shows at [`SIGMA_S`].
const MILD_SIGMA_S: Vec3 = Vec3::new(90.0, 100.0, 111.0);
/// How far the mean of a picture may be from 1.
const SMOOTH: f64 = 1e-3;
const ROUGH: f64 = 5e-3;

/// Standard error of a channel's mean, in tolerances: at most a third of it, so that chance fails one case in a thousand
/// of those whose mean is right.
const NOISE: f64 = 0.3;

/// Seeds of independent pictures.
const PICTURES: u32 = 16;

/// Renders pictures and asserts that each pixel is 1, and the mean of all of them within `tolerance`.
fn furnace(scene: SceneDescription, tolerance: f64, what: &str) {
    furnace_seen_from(ortho(Vec3::new(-0.4, -0.3, -0.9), 0.2, 0.022), scene, tolerance, what);
}

fn furnace_seen_from(camera: CameraDescription, scene: SceneDescription, tolerance: f64, what: &str) {
    let scene = Scene::build(scene).expect("builds");
    let options = options(camera, 32, 16);
    let spp = {
        let pilot = measure(&scene, &options.clone().with(|o| o.settings.seed = 99));
        let need = pilot.se.iter().map(|se| (se / (NOISE * tolerance)).powi(2)).fold(0.0, f64::max);
        (need * 1.2 * 16.0 / f64::from(PICTURES)).clamp(4.0, 16384.0) as u32
    };
    let case = seed_of(what);
    let mut truncated = 0;
    let pictures: Vec<Vec<Vec3>> = (0..PICTURES)
        .map(|seed| {
            let rendered = render(
                &scene,
                &options.clone().with(|o| {
                    o.settings.seed = case + seed;
                    o.samples.count = spp;
                }),
                &(),
            )
            .expect("renders");
            assert_eq!(rendered.stats.invalid_samples, 0, "{what}");
            truncated += rendered.stats.truncated_paths;
            rendered.picture.pixels
        })
        .collect();
    // Rounding lets a path in a million through the mesh without an exit.
    let samples = f64::from(spp * PICTURES) * pictures[0].len() as f64;
    assert!(truncated as f64 <= 2e-6 * samples + 1.0, "{what}: {truncated} of {samples} paths never ended");
    let all: Vec<[f64; 3]> = pictures.iter().flatten().map(|p| p.as_dvec3().to_array()).collect();
    let whole = Estimate::of(&all);
    // What the channels have in common has far less noise than each of them: weights only move light among them.
    let grey = Estimate::of(&all.iter().map(|p| [(p[0] + p[1] + p[2]) / 3.0; 3]).collect::<Vec<_>>());
    let mut worst: f64 = 0.0;
    for i in 0..pictures[0].len() {
        let pixel: Vec<_> = pictures.iter().map(|p| p[i].as_dvec3().to_array()).collect();
        let pixel = Estimate::of(&pixel);
        worst = (0..3).map(|c| (pixel.mean[c] - 1.0).abs() / pixel.se[c].max(1e-5)).fold(worst, f64::max);
    }
    let z = [0, 1, 2].map(|c| (whole.mean[c] - 1.0) / whole.se[c].max(1e-6));
    println!(
        "{what}: spp {spp}, {truncated} truncated, mean {:.5?} ± {:.5?}, z {z:.2?}, grey {:.6} ± {:.6}, worst pixel t {worst:.1}",
        whole.mean, whole.se, grey.mean[0], grey.se[0]
    );
    for (c, z) in z.iter().enumerate() {
        assert!(whole.se[c] < 1.5 * NOISE * tolerance, "{what} [{c}]: too noisy: ± {}", whole.se[c]);
        assert!((whole.mean[c] - 1.0).abs() < tolerance, "{what} [{c}]: mean {} z {z}", whole.mean[c]);
        assert!(z.abs() < 4.0, "{what} [{c}]: mean {} z {z}", whole.mean[c]);
    }
    assert!((grey.mean[0] - 1.0).abs() < tolerance, "{what}: the mean of the channels is {}", grey.mean[0]);
    // With 16 pictures the pixel's own error is itself uncertain: Student's t with 15 degrees of freedom, two-sided 1e-7
    // (3072 pixel channels), is 9. Means of some tens of samples are not normal, hence more.
    assert!(worst < 21.0, "{what}: a pixel is off by t = {worst}");
}

fn of_glass(mesh: MeshDescription, sigma_s: Vec3, ior: f32, roughness: f32, tolerance: f64) {
    let material = subsurface(Vec3::ZERO, sigma_s, 0.3, ior, roughness);
    let scene = single(mesh, material, EnvironmentDescription::Constant(Vec3::ONE));
    furnace(scene, tolerance, &format!("ior {ior} roughness {roughness}"));
}

#[test]
fn smooth_boundaries_of_any_index_conserve_energy() {
    for ior in [1.0, 1.33, 1.5, 2.4] {
        of_glass(icosphere(0.02, 4, false), MILD_SIGMA_S, ior, 0.0, SMOOTH);
    }
    // Shading normals that differ from the triangles' must not lose light either.
    for ior in [1.33, 2.4] {
        of_glass(icosphere(0.02, 3, true), MILD_SIGMA_S, ior, 0.0, SMOOTH);
    }
    of_glass(icosphere(0.02, 3, false), SIGMA_S, 1.5, 0.0, 2.0 * SMOOTH);
}

#[test]
fn rough_boundaries_conserve_energy() {
    for (ior, roughness) in [
        (1.01, 0.5),
        (1.33, 0.25),
        (1.33, 1.0),
        (1.5, 0.1),
        (1.5, 0.3),
        (1.5, 0.55),
        (1.5, 0.8),
        (1.5, 1.0),
        (2.4, 0.15),
        (2.4, 0.5),
        (2.4, 1.0),
    ] {
        of_glass(icosphere(0.02, 3, true), SIGMA_S, ior, roughness, ROUGH);
        of_glass(cuboid(Vec3::splat(0.02)), SIGMA_S, ior, roughness, ROUGH);
    }
}

/// The largest mesh with a medium of every sample, with its own shading normals and scale.
#[test]
fn sample_meshes_conserve_energy() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut tested = 0;
    for entry in std::fs::read_dir(samples).expect("samples") {
        let folder = entry.expect("an entry").path();
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        let Ok(loaded) = asset::load(&folder.join(format!("{name}.glb")), &LoadOptions::default()) else {
            continue;
        };
        let scene = loaded.scene;
        let has_medium = |mesh: &&MeshDescription| {
            let mut own = mesh.triangle_materials.iter();
            own.any(|&m| scene.materials.get(m as usize).is_some_and(|m| m.medium.is_some()))
        };
        let largest = scene.meshes.iter().filter(has_medium).max_by_key(|mesh| mesh.triangles.len());
        let Some(mut mesh) = largest.cloned() else { continue };
        let low = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        mesh.triangle_materials.fill(0);
        let sigma_s = MILD_SIGMA_S * (0.05 / (high - low).length());
        for (roughness, tolerance) in [(0.0, SMOOTH), (0.4, ROUGH)] {
            let material = subsurface(Vec3::ZERO, sigma_s, 0.3, 1.5, roughness);
            let white = EnvironmentDescription::Constant(Vec3::ONE);
            let what = format!("{name} roughness {roughness}");
            let camera = auto_camera(low, high, 1.0);
            furnace_seen_from(camera, single(mesh.clone(), material, white), tolerance, &what);
        }
        tested += 1;
    }
    assert!(tested >= 7, "only {tested} samples have a medium");
}

#[test]
fn scattering_that_varies_in_space_conserves_energy() {
    let mut scene = single(
        with_uvs(icosphere(0.02, 4, false)),
        subsurface(Vec3::ZERO, 2.0 * MILD_SIGMA_S, 0.3, 1.4, 0.0),
        EnvironmentDescription::Constant(Vec3::ONE),
    );
    let texels: Vec<Vec3> = (0..64)
        .map(|i| Vec3::new((i % 8) as f32 / 7.0, 1.0 - (i / 8) as f32 / 7.0, ((i * 37) % 64) as f32 / 63.0))
        .collect();
    let texture = add_texture(&mut scene, 8, &texels);
    scene.materials[0].medium.as_mut().expect("a medium").scattering_texture = Some(texture);
    // Three times the tolerance of homogeneous media: a sample takes ten times as long here.
    furnace(scene, 3.0 * SMOOTH, "textured scattering");
}

#[test]
fn mirrored_and_stretched_instances_conserve_energy() {
    for (what, scale) in [("mirrored", Vec3::new(-1.0, 1.0, 1.0)), ("stretched", Vec3::new(1.2, -0.4, 0.9))] {
        let turn = Affine3A::from_rotation_y(0.4);
        let material = subsurface(Vec3::ZERO, MILD_SIGMA_S, 0.3, 1.5, 0.0);
        let environment = EnvironmentDescription::Constant(Vec3::ONE);
        let mut scene = single(icosphere(0.02, 3, true), material, environment);
        scene.instances = vec![place(0, turn * Affine3A::from_scale(scale))];
        furnace(scene, SMOOTH, what);
    }
}

#[test]
fn overlapping_solids_conserve_energy() {
    let ball = |sigma_s: Vec3, ior, roughness, priority| {
        let mut material = subsurface(Vec3::ZERO, sigma_s, 0.0, ior, roughness);
        material.medium.as_mut().expect("a medium").priority = priority;
        material
    };
    let mut other = icosphere(0.012, 3, false);
    other.triangle_materials.fill(1);
    let mut scene = single(
        icosphere(0.015, 3, false),
        ball(MILD_SIGMA_S, 1.33, 0.0, 0),
        EnvironmentDescription::Constant(Vec3::ONE),
    );
    scene.materials.push(ball(Vec3::new(140.0, 90.0, 60.0), 1.6, 0.0, 1));
    scene.meshes.push(other);
    scene.instances.push(place(1, Affine3A::from_translation(Vec3::new(0.01, 0.0, 0.005))));
    scene.instances.push(place(
        0,
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.3),
            glam::Quat::IDENTITY,
            Vec3::new(-0.002, 0.0, 0.0),
        ),
    ));
    furnace(scene, SMOOTH, "overlapping solids");
}

#[test]
fn the_plain_model_loses_energy_as_known() {
    // A negative control: Mitsuba 3's rough dielectric around a medium without absorption returns 0.698 for alpha 0.3.
    let material = subsurface(Vec3::ZERO, Vec3::splat(1000.0), 0.0, 1.5, 0.3f32.sqrt());
    let environment = EnvironmentDescription::Constant(Vec3::ONE);
    let scene = Scene::build(single(icosphere(0.02, 4, false), material, environment)).expect("builds");
    let mut options = options(ortho(Vec3::NEG_Z, 0.2, 0.004), 16, 256);
    options.settings.microfacet = nephrite::optics::Microfacet::Single;
    let estimate = measure(&scene, &options);
    assert!((0.6..0.8).contains(&estimate.mean[1]), "{:?}", estimate.mean);
}
