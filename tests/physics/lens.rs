//! Depth of field of EXT_camera_physical: the size of what is out of focus, by the formula of the thin lens.

use crate::lab::*;
use glam::{Affine3A, DVec2, Vec3};
use nephrite::asset::{LoadOptions, load_bytes};
use nephrite::scene::*;
use nephrite::transport::render;
use serde_json::json;

/// A camera at the origin that looks along −Z, from a file.
fn camera(f_stop: f32, focus: f32, near: f32) -> CameraDescription {
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
        "extensionsUsed": ["EXT_camera_physical"],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.2, "znear": near}, "extensions": {
            "EXT_camera_physical": {"focalLength": 0.5, "sensorSize": [0.1003, 0.1003], "fStop": f_stop,
                "focusDistance": focus}}}],
    });
    let bytes = document.to_string().into_bytes();
    let loaded = load_bytes(bytes, "/nowhere".as_ref(), &LoadOptions::default()).expect("loads");
    loaded.scene.cameras[0].clone()
}

/// A bright square of that half width at a distance straight ahead.
fn square(distance: f32, half: f32) -> SceneDescription {
    let mut scene = SceneDescription::default();
    let material = MaterialDescription { unlit: true, double_sided: true, ..MaterialDescription::default() };
    add_panel(&mut scene, -distance * Vec3::Z, Vec3::Z, half, material);
    scene
}

const PIXELS: u32 = 40;

/// The sum of a picture, and the mean square distance of its light from the middle, in heights of the picture.
fn spread(scene: &Scene, camera: CameraDescription, spp: u32) -> (f64, f64) {
    let picture = render(scene, &options(camera, PIXELS, spp), &()).expect("renders");
    let (mut sum, mut square) = (0.0, 0.0);
    for (i, pixel) in picture.picture.pixels.iter().enumerate() {
        let place = DVec2::new(f64::from(i as u32 % PIXELS), f64::from(i as u32 / PIXELS)) + 0.5;
        let place = place / f64::from(PIXELS) - 0.5;
        sum += f64::from(pixel.x);
        square += f64::from(pixel.x) * place.length_squared();
    }
    // A pixel is a square itself.
    (sum, square / sum - 1.0 / 6.0 / f64::from(PIXELS * PIXELS))
}

#[test]
fn the_circle_of_confusion_has_the_size_of_the_thin_lens() {
    for (f_stop, focus, distance) in [(1.0, 10.0, 20.0), (1.0, 10.0, 6.0), (0.8, 5.0, 6.5)] {
        let half = 0.02 * distance;
        let scene = Scene::build(square(distance, half)).expect("builds");
        let (light, found) = spread(&scene, camera(f_stop, focus, 0.01), 256);
        // On the sensor c = A |d − s| / d · f / (s − f), and the picture is 2 tan(yfov/2) · s f / (s − f) high.
        let (s, d, f) = (f64::from(focus), f64::from(distance), 0.5);
        let height = 2.0 * 0.1f64.tan() * s * f / (s - f);
        let confusion = f / f64::from(f_stop) * (d - s).abs() / d * f / (s - f) / height;
        let side = 2.0 * f64::from(half) / (2.0 * d * 0.1f64.tan());
        // A disk of the diameter c has the mean square c²/8, the square that it blurs side²/6.
        let expected = confusion * confusion / 8.0 + side * side / 6.0;
        assert!(confusion > 0.1, "{confusion}");
        // 400 thousand rays, of which one in twenty-five hits: half a per cent of each number.
        assert!((found / expected - 1.0).abs() < 0.04, "{focus} {distance}: {found} {expected}");
        // Light that is spread is not lost.
        let whole = side * side * f64::from(PIXELS * PIXELS);
        assert!((light / whole - 1.0).abs() < 0.03, "{light} {whole}");
    }
}

#[test]
fn what_is_in_focus_is_as_sharp_as_through_a_pinhole() {
    let scene = Scene::build(square(10.0, 0.4)).expect("builds");
    let open = camera(1.0, 10.0, 0.01);
    let pinhole = CameraDescription { lens: None, ..open.clone() };
    let stopped = camera(1e7, 3.0, 0.01);
    let picture = |camera: &CameraDescription, spp| {
        render(&scene, &options(camera.clone(), PIXELS, spp), &()).expect("renders").picture.pixels
    };
    let sharp = picture(&pinhole, 16);
    for camera in [&open, &stopped] {
        let differ = sharp.iter().zip(picture(camera, 16)).filter(|(a, b)| (**a - *b).length() > 0.3).count();
        assert_eq!(differ, 0);
    }
    // Out of focus it is another picture.
    let blurred = picture(&camera(1.0, 5.0, 0.01), 16);
    assert!(sharp.iter().zip(blurred).filter(|(a, b)| (**a - *b).length() > 0.3).count() > 50);
    // Parallel to the sensor and behind the near plane nothing is seen, through whichever part of the lens.
    let clipped = picture(&CameraDescription { clip: Clip { near: 10.1, far: 50.0 }, ..open }, 16);
    assert!(clipped.iter().all(|p| *p == Vec3::ZERO));
}

#[test]
fn a_lens_that_reaches_into_a_medium_knows_for_each_ray_where_it_starts() {
    // A white cloud in a furnace is white, also where the lens, 0.25 m wide, is partly inside of it.
    let mut scene = single(
        cuboid(Vec3::ONE),
        subsurface(Vec3::ZERO, Vec3::splat(3.0), 0.0, 1.0, 0.0),
        EnvironmentDescription::Constant(Vec3::ONE),
    );
    scene.instances[0].transform = Affine3A::from_translation(Vec3::new(0.55, 0.0, 0.0));
    let scene = Scene::build(scene).expect("builds");
    for near in [1e-4, 0.3] {
        let options = options(camera(1.0, 4.0, near), 16, 64);
        assert_eq!(render(&scene, &options, &()).expect("renders").stats.leaked_paths, 0);
        measure(&scene, &options).assert_matches([1.0; 3], [1e-5; 3], "cloud around the lens");
    }
}
