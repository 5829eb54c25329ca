//! White furnaces: in a uniform environment of radiance 1 an object that absorbs nothing cannot be seen.

use crate::lab::*;
use glam::Vec3;
use nephrite::scene::{EnvironmentDescription, MeshDescription, Scene};
use nephrite::transport::render;

/// Scattering that differs between the channels by a factor of ten: weights that gain or lose show as colour.
const SIGMA_S: Vec3 = Vec3::new(100.0, 300.0, 1000.0);

fn furnace(mesh: MeshDescription, ior: f32, roughness: f32, tolerance: f64, spp: u32) {
    let material = subsurface(Vec3::ZERO, SIGMA_S, 0.3, ior, roughness);
    let environment = EnvironmentDescription::Constant(Vec3::ONE);
    let scene = Scene::build(single(mesh, material, environment)).expect("builds");
    let camera = ortho(Vec3::new(-0.4, -0.3, -0.9), 0.2, 0.022);
    let mut sums = Vec::new();
    const PICTURES: u32 = 8;
    for seed in 0..PICTURES {
        let options = nephrite::transport::RenderOptions { seed, ..options(camera.clone(), 40, spp) };
        let rendered = render(&scene, &options, &()).expect("renders");
        assert_eq!(rendered.stats.invalid_samples, 0);
        sums.push(rendered.film.pixels);
    }
    let n = f64::from(PICTURES);
    let pixels = sums[0].len();
    let mut worst: f64 = 0.0;
    for c in 0..3 {
        let mut total = 0.0;
        for i in 0..pixels {
            let mean = sums.iter().map(|s| f64::from(s[i][c])).sum::<f64>() / n;
            let var = sums.iter().map(|s| (f64::from(s[i][c]) - mean).powi(2)).sum::<f64>() / (n - 1.0);
            total += mean;
            // With 8 pictures the pixel's own error is itself uncertain: Student's t with 7 degrees of freedom,
            // two-sided 1e-7 (4800 pixel channels), is 21.
            let t = (mean - 1.0) / (var / n).sqrt().max(1e-5);
            worst = worst.max(t.abs());
        }
        let mean = total / pixels as f64;
        println!("ior {ior} roughness {roughness} [{c}]: mean {mean:.5}, worst pixel t {worst:.1}");
        assert!((mean - 1.0).abs() < tolerance, "ior {ior} roughness {roughness} [{c}]: mean {mean}");
    }
    assert!(worst < 21.0, "ior {ior} roughness {roughness}: a pixel is off by t = {worst}");
}

#[test]
fn smooth_boundaries_of_any_index_conserve_energy() {
    for ior in [1.0, 1.33, 1.5, 2.4] {
        furnace(icosphere(0.02, 4, false), ior, 0.0, 1e-3, 16);
        furnace(icosphere(0.02, 3, true), ior, 0.0, 1e-3, 16);
    }
}

#[test]
fn rough_boundaries_conserve_energy() {
    for (ior, roughness) in
        [(1.33, 0.25), (1.5, 0.1), (1.5, 0.3), (1.5, 0.55), (1.5, 1.0), (1.01, 0.5), (2.4, 0.5), (2.4, 1.0)]
    {
        furnace(icosphere(0.02, 3, true), ior, roughness, 5e-3, 16);
        furnace(cuboid(Vec3::splat(0.02)), ior, roughness, 5e-3, 16);
    }
}

#[test]
fn the_plain_model_loses_energy_as_known() {
    // A negative control: Mitsuba 3's rough dielectric around a medium without absorption returns 0.698 for alpha 0.3.
    let material = subsurface(Vec3::ZERO, Vec3::splat(1000.0), 0.0, 1.5, 0.3f32.sqrt());
    let environment = EnvironmentDescription::Constant(Vec3::ONE);
    let scene = Scene::build(single(icosphere(0.02, 4, false), material, environment)).expect("builds");
    let mut options = options(ortho(Vec3::NEG_Z, 0.2, 0.004), 16, 256);
    options.microfacet = nephrite::optics::Microfacet::Single;
    let estimate = measure(&scene, &options);
    assert!((0.6..0.8).contains(&estimate.mean[1]), "{:?}", estimate.mean);
}
