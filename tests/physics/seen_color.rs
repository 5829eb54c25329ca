//! The inversion from seen colour to albedo, verified by pictures: a half space is rendered straight on in uniform light,
//! and what it shows beside the reflection of its surface has to be the colour that was asked for.
//!
//! Over the whole range the standard error is a quarter per cent of the colour, so |z| < 4 bounds the deviation by one per
//! cent. The few points that are always tested have 0.4 %, for the sake of time.

use crate::lab::*;
use glam::{Affine2, Vec2, Vec3};
use nephrite::author::paint::{Basis, Colors};
use nephrite::optics::seen_color::shares_of_seen_color;
use nephrite::scene::{
    ColorSpace, ImageData, ImagePixels, Minify, Scene, TextureDescription, TextureRef, Wrap,
};
use std::sync::Arc;

/// Extinction, 1/m.
const SIGMA_T: f64 = 1000.0;
/// Depth and half width of the body in diffusion lengths: e^−20 of the light gets that far.
const SIZE: f64 = 20.0;

/// Half the width of a body that is deep for media of these shares of scattering and absorption.
fn half_width(shares: [[f64; 2]; 3], g: f64) -> f32 {
    // 1/√(3 (1 − α)(1 − αg)) mean free paths, and at least a transport mean free path.
    let length = shares
        .map(|[scattered, absorbed]| {
            (1.0 / (3.0 * absorbed * (1.0 - scattered * g)).sqrt()).max(1.0 / (1.0 - g))
        })
        .into_iter()
        .fold(0.0, f64::max);
    (SIZE * length / SIGMA_T) as f32
}

fn check(g: f64, n: f64, colors: [f64; 3], relative_error: f64) {
    let shares = colors.map(|color| shares_of_seen_color(color, g, n));
    let half = half_width(shares, g);
    // The top is at zero, where single precision is finest.
    let mut mesh = cuboid(Vec3::new(2.0 * half, half, 2.0 * half));
    mesh.positions.iter_mut().for_each(|p| p.y = if p.y > 0.0 { 0.0 } else { -half });
    let share = |i: usize| Vec3::from_array(shares.map(|s| (SIGMA_T * s[i]) as f32));
    let material = subsurface(share(1), share(0), g as f32, n as f32, 0.0);
    let scene = Scene::build(single(mesh, material, sky_above(1.0))).expect("builds");
    shows(&scene, n, colors, relative_error, &format!("seen colours {colors:?}, g {g}, index {n}"));
}

/// Looks straight down at the origin of a scene, where the surface of a half space of index `n` should show these colours.
fn shows(scene: &Scene, n: f64, colors: [f64; 3], relative_error: f64, case: &str) {
    let mirror = ((n - 1.0) / (n + 1.0)).powi(2);
    let camera = ortho(Vec3::NEG_Y, 0.01, 0.005);
    let options = options(camera, 24, 0).with(|o| o.settings.seed = seed_of(case));
    let target = colors.map(|color| relative_error * color * (1.0 - mirror));
    let found = measure_to(scene, &options, target);
    for (i, color) in colors.into_iter().enumerate() {
        let [seen, error] = [(found.mean[i] - mirror) / (1.0 - mirror), found.se[i] / (1.0 - mirror)];
        let z = (seen - color) / error;
        println!(
            "{case}: {color} is seen as {seen:.5} ± {error:.5}, {:+.2} %, z {z:+.2}",
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

/// What `edit --from-base-color` makes of a texture of two colours: far from the seam, each half shows its own. Coefficients
/// come from 16-bit textures here, and the walk looks them up.
#[test]
fn painted_halves_show_their_paint() {
    let (n, paint) = (1.5, [[0.3, 0.6, 0.8], [0.7, 0.15, 0.5]]);
    let basis = Basis { sigma_t: [SIGMA_T; 3], g: 0.0, ior: n };
    let texels = paint.map(|c| Vec3::from_array(c.map(|c: f64| c as f32)));
    let painted = basis.paint(&Colors::Picture { width: 2, texels: texels.to_vec() });
    let shares = [0, 1, 2].map(|i| shares_of_seen_color(paint[0][i].max(paint[1][i]), 0.0, n));
    let half = half_width(shares, 0.0);
    for (side, colors) in [(-1.0, paint[0]), (1.0, paint[1])] {
        let mut mesh = cuboid(Vec3::new(4.0 * half, half, 2.0 * half));
        mesh.positions.iter_mut().for_each(|p| p.y = if p.y > 0.0 { 0.0 } else { -half });
        mesh.uvs = vec![mesh.positions.iter().map(|p| Vec2::new(0.5 + p.x / (4.0 * half), 0.5)).collect()];
        mesh.positions.iter_mut().for_each(|p| p.x -= side * half);
        let [a, s] = [painted.sigma_a, painted.sigma_s].map(|v| Vec3::from_array(v.map(|v| v as f32)));
        let mut scene = single(mesh, subsurface(a, s, 0.0, n as f32, 0.0), sky_above(1.0));
        let medium = scene.materials[0].medium.as_mut().expect("a medium");
        for (slot, texture) in [
            (&mut medium.absorption_texture, &painted.absorption),
            (&mut medium.scattering_texture, &painted.scattering),
        ] {
            let (width, texels) = texture.as_ref().expect("a texture");
            let pixels = texels.iter().flat_map(|t| [t[0], t[1], t[2], u16::MAX]).collect();
            let image = ImageData {
                name: String::new(),
                width: *width,
                height: 1,
                pixels: ImagePixels::Rgba16(pixels),
            };
            *slot = Some(TextureRef {
                texture: scene.textures.len(),
                uv_set: 0,
                transform: Affine2::IDENTITY,
                color_space: ColorSpace::Linear,
            });
            scene.textures.push(TextureDescription {
                image: scene.images.len(),
                wrap_u: Wrap::ClampToEdge,
                wrap_v: Wrap::ClampToEdge,
                linear_filter: false,
                minify: Minify::Point,
            });
            scene.images.push(Arc::new(image));
        }
        let scene = Scene::build(scene).expect("builds");
        shows(&scene, n, colors, 0.012, &format!("painted half {side}"));
    }
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
