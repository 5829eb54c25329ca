//! What the camera sees besides objects: the ground by its shadow, transparent backgrounds, media around orthographic
//! cameras, and textures that are small in the picture.

use crate::lab::*;
use glam::{Affine3A, Vec2, Vec3};
use nephrite::scene::*;
use nephrite::subsurface::Registry;
use nephrite::transport::{RenderError, RenderOptions, Shutter, render, render_shutter};
use std::f32::consts::PI;

fn square(half: f32) -> MeshDescription {
    MeshDescription {
        positions: [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, z]| half * Vec3::new(x, 0.0, z))
            .to_vec(),
        uvs: vec![vec![Vec2::ZERO, Vec2::Y, Vec2::ONE, Vec2::X]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Default::default()
    }
}

fn two_sided(material: MaterialDescription) -> MaterialDescription {
    MaterialDescription { double_sided: true, ..material }
}

/// Part of the sky over a point that a square of half size `x` one metre above it takes away: four times the
/// configuration factor of a rectangle above a corner (Howell's catalogue, B-4).
fn hidden(x: f32) -> f32 {
    let s = x / (1.0 + x * x).sqrt();
    4.0 * s * s.atan() * 2.0 / (2.0 * PI)
}

#[test]
fn the_shadow_of_a_black_square_is_its_configuration_factor() {
    let sky = EnvironmentDescription::Constant(Vec3::new(0.7, 0.35, 1.4));
    let mut description = single(square(0.5), two_sided(matte(0.0)), sky);
    description.instances[0] = place(0, Affine3A::from_translation(Vec3::Y));
    let scene = Scene::build(description).expect("builds");
    let camera = ortho(Vec3::new(1.0, -0.3, 0.0), 0.3, 1e-4);
    let shadow = options(camera, 24, 64).with(|o| o.view.ground = Some(0.0));
    let kept = 1.0 - hidden(0.5);
    let expected = [0.7, 0.35, 1.4].map(|c| f64::from(c * kept));
    measure(&scene, &shadow).assert_matches(expected, [1e-5; 3], "shadow");

    let clear = shadow.with(|o| o.view.transparent = true);
    let picture = render(&scene, &clear, &()).expect("renders").picture;
    assert!(picture.pixels.iter().all(|p| *p == Vec3::ZERO), "a shadow is black");
    let alpha: Vec<[f64; 3]> = picture.alpha.expect("alpha").iter().map(|&a| [f64::from(a); 3]).collect();
    Estimate::of(&alpha).assert_matches([f64::from(1.0 - kept); 3], [1e-5; 3], "alpha");
    let layer = &picture.layers[0];
    assert_eq!(layer.name, "shadow");
    let values: Vec<[f64; 3]> =
        (0..24 * 24).map(|i| [0, 1, 2].map(|c| f64::from(layer.channels[c].values[i]))).collect();
    Estimate::of(&values).assert_matches([f64::from(kept); 3], [1e-5; 3], "layer");
}

#[test]
fn nothing_in_the_way_leaves_the_background_as_it_is() {
    let sky = EnvironmentDescription::Constant(Vec3::splat(0.6));
    let mut description = single(square(0.5), two_sided(matte(0.0)), sky);
    // Below the ground, so that it hides nothing; a sun and a lamp add no noise either.
    description.instances[0] = place(0, Affine3A::from_translation(Vec3::NEG_Y));
    description.lights.push(PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(5.0),
        position: Vec3::new(0.3, 2.0, 0.0),
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    });
    let scene = Scene::build(description).expect("builds");
    let camera = ortho(Vec3::new(1.0, -1.0, 0.0), 3.0, 2.0);
    let plain = options(camera, 8, 2).with(|o| o.view.ground = Some(0.0));
    let picture = render(&scene, &plain, &()).expect("renders").picture;
    assert!(picture.pixels.iter().all(|p| (*p - 0.6).abs().max_element() < 1e-6), "{:?}", picture.pixels);
    let clear = plain.with(|o| o.view.transparent = true);
    let alpha = render(&scene, &clear, &()).expect("renders").picture.alpha.expect("alpha");
    assert!(alpha.iter().all(|a| a.abs() < 1e-6));
}

#[test]
fn alpha_is_coverage_and_colours_are_premultiplied() {
    // A square over the left half of the picture, in a furnace: radiance is that of the sky where it covers.
    let sky = EnvironmentDescription::Constant(Vec3::splat(0.8));
    let mut description = single(square(1.0), two_sided(matte(1.0)), sky);
    description.instances[0] = place(0, Affine3A::from_translation(Vec3::NEG_X));
    let scene = Scene::build(description).expect("builds");
    let camera = CameraDescription {
        name: String::new(),
        transform: Affine3A::from_rotation_x(-0.5 * PI) * Affine3A::from_translation(Vec3::Z),
        projection: Projection::Orthographic { ymag: 0.75, aspect: None },
        clip: nephrite::scene::Clip::NONE,
        lens: None,
    };
    // Three columns: covered, half covered, open.
    let clear = options(camera, 3, 1024).with(|o| o.view.transparent = true);
    let picture = render(&scene, &clear, &()).expect("renders").picture;
    let alpha = picture.alpha.expect("alpha");
    for row in 0..3 {
        let at = |x: usize| (picture.pixels[3 * row + x].x, alpha[3 * row + x]);
        assert_eq!(at(2), (0.0, 0.0));
        assert_eq!(at(0).1, 1.0);
        // 1024 stratified samples.
        assert!((at(1).1 - 0.5).abs() < 0.01, "{:?}", at(1));
        for x in 0..2 {
            assert!((at(x).0 / at(x).1 - 0.8).abs() < 0.02, "{:?}", at(x));
        }
    }
}

#[test]
fn orthographic_rays_start_inside_or_beside_an_object() {
    // The view plane cuts a ball of clear, absorbing medium of index 1 in its middle: rays inside of it have half a chord to
    // go, rays beside it meet nothing.
    let sky = EnvironmentDescription::Constant(Vec3::ONE);
    let medium = subsurface(Vec3::splat(2.0), Vec3::ZERO, 0.0, 1.0, 0.0);
    let scene = Scene::build(single(icosphere(1.0, 5, false), medium, sky)).expect("builds");
    let camera = ortho(Vec3::NEG_Z, 0.0, 1.5);
    let rendered = render(&scene, &options(camera, 60, 64), &()).expect("renders");
    assert_eq!(rendered.stats.leaked_paths, 0);
    for (i, p) in rendered.picture.pixels.iter().enumerate() {
        let at = (Vec2::new((i % 60) as f32, (i / 60) as f32) + 0.5) * 0.05 - 1.5;
        let r = at.length();
        if (r - 1.0).abs() < 0.1 {
            continue;
        }
        let expected = if r > 1.0 { 1.0 } else { (-2.0 * (1.0 - r * r).sqrt()).exp() };
        // The ball is an icosahedron split five times, 0.1 % smaller; pixels are 0.05 wide.
        assert!((p.x - expected).abs() < 0.02 * expected, "{at}: {} is not {expected}", p.x);
    }
}

/// An unlit square of black and white texels, seen by 16² pixels that are `texels` texels wide.
pub fn checkers(texels: u32, minify: Minify) -> SceneDescription {
    let n = 16 * texels;
    let mut scene = single(square(1.0), two_sided(matte(1.0)), EnvironmentDescription::default());
    let values: Vec<Vec3> = (0..n * n).map(|i| Vec3::splat(((i % n + i / n) % 2) as f32)).collect();
    let texture = add_texture(&mut scene, n, &values);
    scene.textures[0].minify = minify;
    scene.textures[0].linear_filter = false;
    scene.materials[0].unlit = true;
    scene.materials[0].base_color_texture = Some(texture);
    scene
}

/// Straight down on the square.
pub fn above() -> CameraDescription {
    CameraDescription {
        name: String::new(),
        transform: Affine3A::from_rotation_x(-0.5 * PI) * Affine3A::from_translation(Vec3::Z),
        projection: Projection::Orthographic { ymag: 1.0, aspect: None },
        clip: nephrite::scene::Clip::NONE,
        lens: None,
    }
}

#[test]
fn small_textures_are_averaged_over_a_part_of_the_pixel() {
    let camera = above;
    // 37 × 37 texels a pixel, an eighth of its width: nearly 5 × 5 of them.
    let noise = |minify, texture_filter| {
        let scene = Scene::build(checkers(37, minify)).expect("builds");
        let options = options(camera(), 16, 16).with(|o| o.settings.texture_filter = texture_filter);
        let estimate = measure(&scene, &options);
        println!("{minify:?} {texture_filter}: {} ± {}", estimate.mean[0], estimate.se[0]);
        (estimate.mean[0] - 0.5, 16.0 * estimate.se[0])
    };
    let (bias, filtered) = noise(Minify::Footprint, Footprint::DEFAULT_FILTER);
    assert!(bias.abs() < 1e-3 && filtered < 0.005, "{bias}, noise {filtered}");
    for (minify, filter) in [(Minify::Point, Footprint::DEFAULT_FILTER), (Minify::Footprint, 0.0)] {
        // Independent black or white samples: ½/√16 a pixel.
        let (bias, point) = noise(minify, filter);
        assert!(
            (point / 0.125 - 1.0).abs() < 0.25 && bias.abs() < 4.0 * 0.125 / 16.0,
            "{bias}, noise {point}"
        );
    }
    // Texels larger than the part are looked up as they are: pictures are equal.
    let scene = Scene::build(checkers(1, Minify::Footprint)).expect("builds");
    let picture = |texture_filter| {
        let options = options(camera(), 16, 4).with(|o| o.settings.texture_filter = texture_filter);
        render(&scene, &options, &()).expect("renders").picture.pixels
    };
    assert_eq!(picture(Footprint::DEFAULT_FILTER), picture(0.0));
}

/// A picture is a function of its scene, its options and the numbers of its samples, not of how many were planned at once.
#[test]
fn parts_of_a_picture_add_up_to_it_with_textures_and_an_open_shutter() {
    // 9 × 9 texels a pixel: a part of a pixel is about a texel wide, where widths matter.
    let scene = || Scene::build(checkers(9, Minify::Footprint)).expect("builds");
    let whole = options(above(), 16, 16);
    let picture = |options: &RenderOptions| render(&scene(), options, &()).expect("renders").picture.pixels;
    let first = picture(&whole.clone().with(|o| o.samples.count = 3));
    let second = picture(&whole.clone().with(|o| {
        o.samples.count = 13;
        o.samples.first = 3;
    }));
    let shutter = Shutter { open: 0.0, close: 1.0, slices: 5 };
    let pose = |_| Ok::<_, RenderError>((scene(), above()));
    let exposed = render_shutter(&shutter, &whole, &(), &Registry::standard(), pose).expect("renders");
    let exposed = exposed.picture.pixels;
    let whole = picture(&whole);
    for (i, pixel) in whole.iter().enumerate() {
        // Means in single precision.
        let parts = (3.0 * first[i] + 13.0 * second[i]) / 16.0;
        for found in [parts, exposed[i]] {
            assert!((found - *pixel).abs().max_element() < 1e-6, "{i}: {found} instead of {pixel}");
        }
    }
    let differ = whole.iter().any(|p| (*p - Vec3::splat(0.5)).abs().max_element() > 0.05);
    assert!(differ, "a texture that shows");
}
