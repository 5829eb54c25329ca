//! Where the light ends on coarse bodies with smooth normals.

use crate::lab::*;
use glam::{Vec2, Vec3};
use nephrite::scene::*;

const PIXELS: u32 = 48;

fn sun(direction: Vec3) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(std::f32::consts::PI),
        position: Vec3::ZERO,
        direction,
        range: None,
        kind: PunctualKind::Directional,
    }
}

/// On a sphere of 80 triangles under the sun each point is as bright as its shading normal says, from one end of the
/// light to the other: the picture's mean to 1 %, and that of the last 15° before the terminator to 3 %: noise, and the
/// few rays that meet a facet from just above the smooth surface.
#[test]
fn light_falls_off_with_the_shading_normal() {
    for levels in [1, 2] {
        let mut scene = single(icosphere(1.0, levels, true), matte(0.8), EnvironmentDescription::default());
        let towards_sun = Vec3::new(1.0, 0.3, 0.1).normalize();
        scene.lights = vec![sun(-towards_sun)];
        let scene = Scene::build(scene).expect("builds");
        let view = ortho(Vec3::new(0.1, -0.2, -1.0), 3.0, 1.0);
        let camera = Camera::new(&view, PIXELS, PIXELS);
        // What the shading normal says, at 64 points of a pixel.
        let told = |x: u32, y: u32| {
            let mut sum = 0.0;
            for i in 0..64 {
                let at = Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / 8.0;
                if let Some(hit) = scene.geometry.intersect(&camera.ray(Vec2::new(x as f32, y as f32) + at)) {
                    sum += Surface::new(&scene, &hit).normal.dot(towards_sun).max(0.0);
                }
            }
            0.8 * f64::from(sum) / 64.0
        };
        let rendered =
            nephrite::transport::render(&scene, &options(view.clone(), PIXELS, 256), &()).expect("renders");
        let (mut all, mut late) = ([0.0f64; 2], [0.0f64; 2]);
        for (i, pixel) in rendered.picture.pixels.iter().enumerate() {
            let expected = told(i as u32 % PIXELS, i as u32 / PIXELS);
            let found = [f64::from(pixel.x), expected];
            (0..2).for_each(|k| all[k] += found[k]);
            if expected > 0.0 && expected < 0.8 * 15f64.to_radians().sin() {
                (0..2).for_each(|k| late[k] += found[k]);
            }
        }
        println!("{levels}: all {} late {}", all[0] / all[1], late[0] / late[1]);
        assert!((all[0] / all[1] - 1.0).abs() < 0.01, "{levels} levels: {} of {}", all[0], all[1]);
        assert!((late[0] / late[1] - 1.0).abs() < 0.03, "{levels} levels: {} of {}", late[0], late[1]);
    }
}

/// Sampled light and light met by chance share what goes through triangles, and together they are all of it.
#[test]
fn a_coarse_white_sphere_vanishes_in_a_white_sky() {
    for levels in 0..3 {
        let scene =
            single(icosphere(1.0, levels, true), matte(1.0), EnvironmentDescription::Constant(Vec3::ONE));
        let scene = Scene::build(scene).expect("builds");
        let found = measure(&scene, &options(ortho(Vec3::new(0.3, -0.2, -1.0), 3.0, 0.6), 24, 64));
        found.assert_matches([1.0; 3], [1e-4; 3], &format!("{levels} levels"));
    }
}
