//! The inversion from seen colour to albedo, verified by pictures: a half space is rendered straight on in uniform light,
//! and what it shows beside the reflection of its surface has to be the colour that was asked for.
//!
//! Over the whole range the standard error is a quarter per cent of the colour, so |z| < 4 bounds the deviation by one per
//! cent. The few points that are always tested have 0.4 %, for the sake of time.

use crate::lab::*;
use glam::Vec3;
use nephrite::optics::seen_color::shares_of_seen_color;
use nephrite::scene::Scene;
use nephrite::transport::RenderOptions;

/// Extinction, 1/m.
const SIGMA_T: f64 = 1000.0;
/// Depth and half width of the body in diffusion lengths: e^−20 of the light gets that far.
const SIZE: f64 = 20.0;

fn check(g: f64, n: f64, colors: [f64; 3], relative_error: f64) {
    let shares = colors.map(|color| shares_of_seen_color(color, g, n));
    // 1/√(3 (1 − α)(1 − αg)) mean free paths, and at least a transport mean free path.
    let length = shares
        .map(|[scattered, absorbed]| {
            (1.0 / (3.0 * absorbed * (1.0 - scattered * g)).sqrt()).max(1.0 / (1.0 - g))
        })
        .into_iter()
        .fold(0.0, f64::max);
    let half = (SIZE * length / SIGMA_T) as f32;
    // The top is at zero, where single precision is finest.
    let mut mesh = cuboid(Vec3::new(2.0 * half, half, 2.0 * half));
    mesh.positions.iter_mut().for_each(|p| p.y = if p.y > 0.0 { 0.0 } else { -half });
    let share = |i: usize| Vec3::from_array(shares.map(|s| (SIGMA_T * s[i]) as f32));
    let material = subsurface(share(1), share(0), g as f32, n as f32, 0.0);
    let scene = Scene::build(single(mesh, material, sky_above(1.0))).expect("builds");
    let mirror = ((n - 1.0) / (n + 1.0)).powi(2);
    let case = format!("seen colours {colors:?}, g {g}, index {n}");
    let camera = ortho(Vec3::NEG_Y, 0.01, 0.005);
    let options = RenderOptions { seed: seed_of(&case), ..options(camera, 24, 0) };
    let target = colors.map(|color| relative_error * color * (1.0 - mirror));
    let found = measure_to(&scene, &options, target);
    for (i, color) in colors.into_iter().enumerate() {
        let [seen, error] = [(found.mean[i] - mirror) / (1.0 - mirror), found.se[i] / (1.0 - mirror)];
        let z = (seen - color) / error;
        println!(
            "g {g:4} index {n}: {color} is seen as {seen:.5} ± {error:.5}, {:+.2} %, z {z:+.2}",
            100.0 * (seen / color - 1.0)
        );
        assert!(z.abs() < 4.0, "{case} [{i}]: {seen} ± {error} (z {z:+.2})");
        assert!(error < 1.5 * relative_error * color, "{case} [{i}]: too noisy to tell, ± {error}");
    }
}

#[test]
fn a_half_space_shows_the_colour_that_was_asked_for() {
    check(0.0, 1.5, [0.3, 0.6, 0.8], 0.004);
    check(0.9, 1.4, [0.4, 0.6, 0.8], 0.004);
    check(-0.5, 1.0, [0.3, 0.6, 0.8], 0.004);
}

/// The whole range, for a release build and some minutes.
#[test]
#[ignore = "takes minutes"]
fn all_half_spaces_show_the_colours_that_were_asked_for() {
    for g in [-0.5, 0.0, 0.5, 0.9] {
        for n in [1.0, 1.2, 1.4, 1.6] {
            check(g, n, [0.05, 0.1, 0.2], 0.0025);
            check(g, n, [0.4, 0.6, 0.8], 0.0025);
            check(g, n, [0.9, 0.95, 0.98], 0.0025);
        }
    }
}
