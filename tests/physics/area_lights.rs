//! Rectangles and disks of EXT_lights_area from glTF files: closed forms, furnaces, what they hide and who sees them.

use crate::gltf::{DOWN, floor, light};
use crate::lab::*;
use glam::{Affine3A, DVec3, Vec3};
use nephrite::scene::*;
use serde_json::{Value, json};
use std::f64::consts::PI;

const NAME: &str = "EXT_lights_area";

/// Colour and intensity of the lights.
fn lights(shape: Value) -> Value {
    let mut light = json!({"color": [1, 0.5, 0.25], "intensity": 40});
    light.as_object_mut().expect("an object").extend(shape.as_object().cloned().expect("an object"));
    json!({NAME: {"lights": [light]}})
}

const RADIANCE: [f64; 3] = [40.0, 20.0, 10.0];

/// Lambert: what a polygon of radiance 1 gives to a surface at the origin that faces +Y. Its corners are seen in order.
fn lambert(corners: &[DVec3]) -> f64 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let edge = |(a, b): (&DVec3, &DVec3)| a.angle_between(*b) * a.cross(*b).normalize().y;
    0.5 * edges.map(edge).sum::<f64>().abs()
}

/// Looks straight down at the floor, through the light from behind.
fn seen_from_above(scene: SceneDescription, irradiance: f64, what: &str) {
    let scene = Scene::build(scene).expect("builds");
    let estimate = measure(&scene, &options(ortho(Vec3::new(0.01, -1.0, 0.02), 8.0, 1e-4), 16, 96));
    estimate.assert_matches(RADIANCE.map(|l| l * irradiance * 0.5 / PI), [1e-5; 3], what);
}

#[test]
fn rectangles_light_a_floor_as_lambert_says() {
    let rectangle = lights(json!({"type": "rect", "size": 1.0, "rect": {"aspect": 2.0}}));
    // Above its middle, and beside it: the light is moved instead of the point.
    for (x, z) in [(0.0, 0.0), (0.7, -0.2), (2.0, 1.0)] {
        let scene = floor(0.5, 0.0, rectangle.clone(), &[light(NAME, [x, 1.2, z], DOWN)]);
        let corner = |a: f64, b: f64| DVec3::new(f64::from(x) + a, f64::from(1.2_f32), f64::from(z) + b);
        let corners = [corner(-1.0, -0.5), corner(-1.0, 0.5), corner(1.0, 0.5), corner(1.0, -0.5)];
        seen_from_above(scene, lambert(&corners), "rectangle");
    }
}

#[test]
fn disks_light_the_point_below_their_middle_by_the_square_of_the_sine() {
    for (size, height) in [(1.2, 1.0), (4.0, 0.5), (0.2, 1.0)] {
        let disk = lights(json!({"type": "disk", "size": size}));
        let scene = floor(0.5, 0.0, disk, &[light(NAME, [0.0, height, 0.0], DOWN)]);
        let (r, h) = (0.5 * f64::from(size as f32), f64::from(height));
        seen_from_above(scene, PI * r * r / (r * r + h * h), "disk");
    }
}

#[test]
fn a_node_scales_the_light_by_its_largest_component_and_not_its_luminance() {
    let disk = lights(json!({"type": "disk", "size": 0.5}));
    let mut node = light(NAME, [0.0, 0.5, 0.0], DOWN);
    node["scale"] = json!([0.5, 0.75, -1.5]);
    // Its −Z shows up now, which is turned by half a turn about X.
    node["rotation"] = json!([std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2]);
    let mut scene = floor(0.5, 0.0, disk, &[node]);
    assert_eq!(scene.area_lights[0].size, glam::Vec2::splat(0.75));
    seen_from_above(scene.clone(), PI * 0.375f64.powi(2) / (0.375f64.powi(2) + 0.25), "scaled");
    // The same light four times: far more of them than are weighed one by one.
    for x in [-3.0f32, 3.0, 6.0] {
        let mut light = scene.area_lights[0].clone();
        light.transform = Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)) * light.transform;
        scene.area_lights.push(light);
    }
    let far = |x: f64| {
        let ring = (0..256).map(|i| (2.0 * PI * f64::from(i) / 256.0).sin_cos());
        lambert(&ring.map(|(s, c)| DVec3::new(x + 0.375 * c, 0.5, 0.375 * s)).collect::<Vec<_>>())
    };
    seen_from_above(scene, far(0.0) + 2.0 * far(3.0) + far(6.0), "four");
}

/// A room without a way out, seen from inside of it.
fn room(albedo: f32, emission: f32) -> SceneDescription {
    let walls = MaterialDescription { emission: Vec3::splat(emission), double_sided: true, ..matte(albedo) };
    single(cuboid(Vec3::splat(2.0)), walls, EnvironmentDescription::default())
}

fn disk(radiance: f32, size: f32, transform: Affine3A) -> AreaLight {
    AreaLight {
        name: String::new(),
        pointer: String::new(),
        radiance: Vec3::splat(radiance),
        shape: AreaShape::Disk,
        size: glam::Vec2::splat(size),
        transform,
    }
}

#[test]
fn a_lamp_of_the_radiance_of_a_furnace_is_not_there() {
    // All of the white comes from the lamp; then most of it from the walls, with the lamp in the middle of the room.
    let down = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let tilted = Affine3A::from_rotation_x(0.4) * Affine3A::from_translation(Vec3::new(0.1, 0.2, 0.0));
    let on_the_ceiling = Affine3A::from_translation(Vec3::Y) * down;
    for (albedo, emission, size, transform, what) in [
        (1.0, 0.0, 1.8, Affine3A::from_translation(0.8 * Vec3::Y) * down, "white room"),
        (1.0, 0.0, 1.8, on_the_ceiling, "white room with the lamp on its ceiling"),
        (0.5, 0.5, 1.2, tilted, "glowing room"),
    ] {
        let mut scene = room(albedo, emission);
        scene.area_lights.push(disk(1.0, size, transform));
        let scene = Scene::build(scene).expect("builds");
        let view = ortho(Vec3::new(0.3, -0.6, 0.5), 0.9, 0.3);
        let estimate = measure(&scene, &options(view, 16, 192));
        estimate.assert_matches([1.0; 3], [1e-4; 3], what);
    }
}

#[test]
fn a_lamp_in_a_mirror_is_seen_and_hides_what_is_behind_it_from_the_front_only() {
    let lamp = lights(json!({"type": "rect", "size": 1.0}));
    let look = |scene: &SceneDescription, direction: Vec3| {
        let scene = Scene::build(scene.clone()).expect("builds");
        measure(&scene, &options(ortho(direction, 3.0, 1e-3), 4, 16)).mean[0]
    };
    // A mirror at y = 0 shows the front of the lamp above it; the camera above looks through its back.
    let mut mirror = floor(1.0, 1.0, lamp, &[light(NAME, [0.0, 1.0, 0.0], DOWN)]);
    mirror.environment = EnvironmentDescription::Constant(Vec3::splat(3.0));
    assert!((look(&mirror, Vec3::new(0.01, -1.0, 0.0)) - 40.0).abs() < 1e-3);
    // A mirror that faces the back shows what is beyond the lamp.
    mirror.area_lights[0].transform.matrix3 *= glam::Mat3A::from_rotation_x(std::f32::consts::PI);
    assert!((look(&mirror, Vec3::new(0.01, -1.0, 0.0)) - 3.0).abs() < 1e-3);
    // Straight, the camera sees neither side.
    mirror.instances.clear();
    mirror.meshes.clear();
    for direction in [Vec3::NEG_Y, Vec3::Y] {
        mirror.area_lights[0].transform.translation = Vec3::ZERO.into();
        assert!((look(&mirror, direction) - 3.0).abs() < 1e-3);
    }
}

#[test]
fn another_light_is_seen_through_the_back_of_a_lamp_and_not_through_its_front() {
    let lamp = |rotation| {
        let mut lights = lights(json!({"type": "rect", "size": 1.0}));
        lights[NAME]["lights"][0]["intensity"] = json!(1e-6);
        let mut scene = floor(0.5, 0.0, lights, &[light(NAME, [0.0, 1.0, 0.0], rotation)]);
        scene.lights.push(PunctualLight {
            name: String::new(),
            intensity: Vec3::splat(8.0),
            position: 2.0 * Vec3::Y,
            direction: Vec3::NEG_Y,
            range: None,
            kind: PunctualKind::Point,
        });
        let scene = Scene::build(scene).expect("builds");
        measure(&scene, &options(ortho(Vec3::new(0.01, -1.0, 0.0), 0.5, 1e-4), 16, 96))
    };
    // Who sees its back, which faces down, sees the other light; who sees its front does not.
    let up = [std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    lamp(up).assert_matches([0.5 / PI * 8.0 / 4.0; 3], [1e-5; 3], "from behind");
    assert!(lamp(DOWN).mean[0] < 1e-5, "{}", lamp(DOWN).mean[0]);
}

/// A block of a medium of index 1 around the floor and the lamp.
fn in_medium(mut scene: SceneDescription, sigma_a: f32, sigma_s: f32) -> SceneDescription {
    scene.materials.push(subsurface(Vec3::splat(sigma_a), Vec3::splat(sigma_s), 0.0, 1.0, 0.0));
    let mut block = cuboid(Vec3::splat(6.0));
    block.triangle_materials.fill(scene.materials.len() as u32 - 1);
    scene.meshes.push(block);
    scene.instances.push(place(scene.meshes.len() - 1, Affine3A::IDENTITY));
    scene
}

#[test]
fn a_lamp_inside_of_a_medium_is_dimmed_on_the_way() {
    const SIGMA: f64 = 0.7;
    let disk = lights(json!({"type": "disk", "size": 1.0}));
    let scene = floor(0.5, 0.0, disk, &[light(NAME, [0.0, 1.0, 0.0], DOWN)]);
    // ∫ e^(−σ d) cos² / d² dA over the rings of the disk.
    let rings = 4000;
    let irradiance: f64 = (0..rings)
        .map(|i| {
            let (r, dr) = (0.5 * (f64::from(i) + 0.5) / f64::from(rings), 0.5 / f64::from(rings));
            let d = (1.0 + r * r).sqrt();
            2.0 * PI * r * dr * (-SIGMA * d).exp() / d.powi(4)
        })
        .sum();
    let scene = Scene::build(in_medium(scene, SIGMA as f32, 0.0)).expect("builds");
    let view = ortho(Vec3::new(0.01, -1.0, 0.02), 0.5, 1e-4);
    let estimate = measure(&scene, &options(view, 16, 96));
    let seen = (-SIGMA * 0.5).exp();
    estimate.assert_matches(RADIANCE.map(|l| l * irradiance * seen * 0.5 / PI), [1e-5; 3], "dimmed");
}

#[test]
fn a_lamp_inside_of_a_white_cloud_in_a_furnace_is_not_there() {
    let mut scene = SceneDescription {
        environment: EnvironmentDescription::Constant(Vec3::ONE),
        area_lights: vec![disk(1.0, 1.5, Affine3A::from_rotation_x(0.7))],
        ..Default::default()
    };
    scene = in_medium(scene, 0.0, 1.0);
    let scene = Scene::build(scene).expect("builds");
    let view = ortho(Vec3::new(0.3, -0.6, 0.5), 9.0, 2.0);
    measure(&scene, &options(view, 16, 128)).assert_matches([1.0; 3], [1e-4; 3], "cloud");
    // From inside, and through a boundary that bends light, where radiance counts n² times as much.
    let mut glassy = SceneDescription {
        environment: EnvironmentDescription::Constant(Vec3::ONE),
        area_lights: vec![disk(
            1.0,
            1.0,
            Affine3A::from_rotation_x(0.7) * Affine3A::from_translation(4.0 * Vec3::Z),
        )],
        ..Default::default()
    };
    glassy.materials = vec![subsurface(Vec3::ZERO, Vec3::splat(2.0), 0.0, 1.5, 0.0)];
    glassy.meshes = vec![cuboid(Vec3::splat(2.0))];
    glassy.instances = vec![place(0, Affine3A::IDENTITY)];
    let scene = Scene::build(glassy).expect("builds");
    let view = ortho(Vec3::new(0.3, -0.6, 0.5), 9.0, 0.5);
    measure(&scene, &options(view, 16, 128)).assert_matches([1.0; 3], [1e-4; 3], "block beside a lamp");
}

#[test]
fn the_back_of_a_lamp_between_another_and_glassy_milk_takes_no_light() {
    // Paths below a smooth boundary are aimed at the lamp, through the back of a lamp that shines away from the block.
    let block = || {
        single(
            cuboid(Vec3::splat(1.0)),
            subsurface(Vec3::splat(0.1), Vec3::splat(8.0), 0.0, 1.3, 0.0),
            EnvironmentDescription::default(),
        )
    };
    let towards = |eye: Vec3| {
        let back = eye.normalize();
        let (x, y) = back.any_orthonormal_pair();
        Affine3A::from_mat3_translation(glam::Mat3::from_cols(x, y, back), eye)
    };
    let lamp = disk(5.0, 1.0, towards(Vec3::new(0.5, 3.0, 0.4)));
    let turned = Affine3A::from_rotation_x(std::f32::consts::PI);
    let between = disk(0.5, 2.0, towards(Vec3::new(0.2, 1.5, 0.2)) * turned);
    let estimate = |lights: &[&AreaLight]| {
        let mut scene = block();
        scene.area_lights = lights.iter().map(|light| (*light).clone()).collect();
        let view = ortho(Vec3::new(0.1, -1.0, 0.2), 3.0, 0.3);
        measure(&Scene::build(scene).expect("builds"), &options(view, 12, 96))
    };
    estimate(&[&lamp, &between]).assert_same_within(0.04, &estimate(&[&lamp]), "milk");
}
