//! Homogeneous spheres in a uniform environment: the fraction of the light that comes back.
//!
//! Source: an independent Monte Carlo simulation with the standard errors given (and, for index 1 and isotropic
//! scattering, a Nyström solution of Peierls' integral equation, accurate to about 1e-6). The mesh is a subdivided
//! icosahedron inscribed in the ball.

use crate::lab::*;
use glam::Vec3;
use nephrite::scene::{EnvironmentDescription, Scene};
use nephrite::transport::render;

struct Sphere {
    optical_radius: f32,
    albedo: f32,
    reflected: f64,
    se: f64,
}

struct Group {
    g: f32,
    n: f32,
    channels: [Sphere; 3],
}

#[rustfmt::skip]
const SPHERES: [Group; 4] = [
    Group {
        g: 0.0,
        n: 1.0,
        channels: [
            Sphere { optical_radius: 0.5, albedo: 0.9, reflected: 0.93601887, se: 2.0e-06 },
            Sphere { optical_radius: 2.0, albedo: 0.99, reflected: 0.97391934, se: 2.0e-06 },
            Sphere { optical_radius: 8.0, albedo: 0.5, reflected: 0.17801166, se: 2.0e-06 },
        ],
    },
    Group {
        g: 0.0,
        n: 1.33,
        channels: [
            Sphere { optical_radius: 0.5, albedo: 0.9, reflected: 0.89597502, se: 6.2e-05 },
            Sphere { optical_radius: 2.0, albedo: 0.99, reflected: 0.95477605, se: 5.4e-05 },
            Sphere { optical_radius: 8.0, albedo: 0.5, reflected: 0.13872378, se: 7.4e-05 },
        ],
    },
    Group {
        g: 0.8,
        n: 1.0,
        channels: [
            Sphere { optical_radius: 0.5, albedo: 0.5, reflected: 0.72203149, se: 6.9e-05 },
            Sphere { optical_radius: 2.0, albedo: 0.9, reflected: 0.77183492, se: 6.5e-05 },
            Sphere { optical_radius: 8.0, albedo: 0.99, reflected: 0.90152587, se: 4.7e-05 },
        ],
    },
    Group {
        g: 0.8,
        n: 1.33,
        channels: [
            Sphere { optical_radius: 0.5, albedo: 0.5, reflected: 0.64693857, se: 1.1e-04 },
            Sphere { optical_radius: 2.0, albedo: 0.9, reflected: 0.66789623, se: 1.4e-04 },
            Sphere { optical_radius: 8.0, albedo: 0.99, reflected: 0.83745134, se: 1.6e-04 },
        ],
    },
];

/// 20·4⁶ triangles, whose distance from the middle is less than the radius by 5e-5 at most.
const LEVELS: u32 = 6;

#[test]
fn spheres_return_the_light_they_should() {
    for group in &SPHERES {
        let radius = 0.02;
        let sigma_t = Vec3::from_array([0, 1, 2].map(|c| group.channels[c].optical_radius)) / radius;
        let albedo = Vec3::from_array([0, 1, 2].map(|c| group.channels[c].albedo));
        let material = subsurface(sigma_t * (Vec3::ONE - albedo), sigma_t * albedo, group.g, group.n, 0.0);
        let environment = EnvironmentDescription::Constant(Vec3::ONE);
        let mesh = icosphere(radius, LEVELS, false);
        let scene = Scene::build(single(mesh, material, environment)).expect("builds");
        // Radiance averaged over the square around the disk: 1 outside of it.
        let camera = ortho(Vec3::new(0.3, -0.5, -0.8), 0.1, radius);
        let disk = std::f64::consts::PI / 4.0;
        let case = format!("sphere g {} n {}", group.g, group.n);
        let options = options(camera, 96, 16).with(|o| o.settings.seed = seed_of(&case));
        let estimate = measure_pictures(&scene, &options, 16)[0];
        let expected = [0, 1, 2].map(|c| 1.0 - disk + disk * group.channels[c].reflected);
        let se = [0, 1, 2].map(|c| disk * group.channels[c].se);
        estimate.assert_matches(expected, se, &case);
    }
}

/// What gets out of walks from the middle of a ball of forward scattering, whose channels differ in mean free path and albedo:
/// of plain walks of another program in an exact sphere, with their relative standard errors.
const FROM_THE_MIDDLE: [(f64, f64); 3] =
    [(0.728_544, 0.000_23), (0.359_105, 0.000_94), (0.886_520, 0.000_13)];

/// As bright is what a camera there sees of a sky of radiance 1. The index is not quite 1, where light is asked for at every
/// event and no walk jumps: 1.0001 adds 0.02 % to the radiance, and reflects a 5000th of what comes to the boundary.
#[test]
fn the_middle_of_a_ball_is_as_bright_as_what_gets_out_of_it() {
    const INDEX: f32 = 1.0001;
    let (sigma_t, albedo) = (Vec3::new(1.0, 2.0, 2.0), Vec3::new(0.999, 0.999, 0.9999));
    let material = subsurface(sigma_t * (Vec3::ONE - albedo), sigma_t * albedo, 0.9, INDEX, 0.0);
    let environment = EnvironmentDescription::Constant(Vec3::ONE);
    // Its facets are nearer than the radius by a 5000th at most, which is worth as little.
    let scene = Scene::build(single(icosphere(75.0, 5, false), material, environment)).expect("builds");
    let events = |model: &str, allowed: f64, spp: u32| {
        let camera = ortho(Vec3::new(0.3, -0.5, -0.8), 0.1, 0.1);
        let case = format!("middle of a ball, {model}");
        let options = options(camera, 24, spp).with(|o| {
            o.settings.subsurface = model.to_owned();
            o.settings.seed = seed_of(&case);
        });
        let rendered = render(&scene, &options, &()).expect("renders");
        let (pixels, stats) = (rendered.picture.pixels, rendered.stats);
        assert_eq!((stats.truncated_paths, stats.invalid_samples), (0, 0), "{case}");
        let found = Estimate::of(&pixels.iter().map(|p| p.as_dvec3().to_array()).collect::<Vec<_>>());
        for (c, (expected, error)) in FROM_THE_MIDDLE.into_iter().enumerate() {
            let (off, se) = (found.mean[c] / expected - 1.0, (found.se[c] / expected).hypot(error));
            println!("{case} [{c}]: {off:+.4} ± {se:.4}");
            assert!(se < 0.005 && off.abs() < allowed + 4.0 * se, "{case} [{c}]: {off} ± {se}");
        }
        stats.scattering_events as f64 / f64::from(spp * 24 * 24)
    };
    // What the index and the mesh may add up to.
    let walked = events("random-walk", 5e-4, 256);
    // What is said of the bias of jumps.
    let jumped = events("accelerated-walk", 0.005, 512);
    // Otherwise this says nothing of jumps.
    assert!(jumped < 0.7 * walked, "{jumped} events, {walked} without jumps");
}
