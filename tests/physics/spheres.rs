//! Homogeneous spheres in a uniform environment: the fraction of the light that comes back.
//!
//! Source: an independent Monte Carlo simulation with the standard errors given (and, for index 1 and isotropic
//! scattering, a Nyström solution of Peierls' integral equation, accurate to about 1e-6). The mesh is a subdivided
//! icosahedron with the radius that gives the ball's volume.

use crate::lab::*;
use glam::Vec3;
use nephrite::scene::{EnvironmentDescription, Scene};
use nephrite::transport::RenderOptions;

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

/// The inscribed polyhedron of 20·4⁶ triangles has less volume than the ball by this factor's cube.
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
        let options = RenderOptions { seed: seed_of(&case), ..options(camera, 96, 16) };
        let estimate = measure_pictures(&scene, &options, 16)[0];
        let expected = [0, 1, 2].map(|c| 1.0 - disk + disk * group.channels[c].reflected);
        let se = [0, 1, 2].map(|c| disk * group.channels[c].se);
        estimate.assert_matches(expected, se, &case);
    }
}
