//! The near and far planes of cameras: what is seen straight ends at them, what is seen by reflection or as a shadow does
//! not, and media around the near plane are known.

use crate::lab::*;
use glam::{Affine3A, Vec2, Vec3, Vec4};
use nephrite::scene::*;
use nephrite::transport::render;

fn unlit(color: Vec3) -> MaterialDescription {
    MaterialDescription {
        base_color: color.extend(1.0),
        unlit: true,
        double_sided: true,
        ..MaterialDescription::default()
    }
}

/// A camera at z = 5 that looks along −z.
fn camera(projection: Projection, near: f32, far: f32) -> CameraDescription {
    CameraDescription {
        name: String::new(),
        transform: Affine3A::from_translation(5.0 * Vec3::Z),
        projection,
        clip: Clip { near, far },
        lens: None,
    }
}

const LENSES: [Projection; 2] = [
    Projection::Orthographic { ymag: 1.0, aspect: None },
    Projection::Perspective { yfov: 0.8, aspect: None },
];

/// The pixels of a picture of 16 × 16.
fn picture(scene: &Scene, camera: CameraDescription, spp: u32) -> Vec<Vec3> {
    let rendered = render(scene, &options(camera, 16, spp), &()).expect("renders");
    assert_eq!(rendered.stats.leaked_paths, 0);
    rendered.picture.pixels
}

#[track_caller]
fn all_are(pixels: &[Vec3], expected: Vec3) {
    assert!(pixels.iter().all(|p| (*p - expected).abs().max_element() < 1e-5), "{pixels:?}");
}

#[test]
fn walls_before_the_near_plane_and_beyond_the_far_plane_are_not_seen() {
    let sky = Vec3::splat(0.25);
    let mut scene = SceneDescription {
        environment: EnvironmentDescription::Constant(sky),
        ..SceneDescription::default()
    };
    // Red, 3 m before the camera, in the middle of green, 4 m, in front of blue, 5 m: each hides what is behind it.
    let colors = [Vec3::X, Vec3::Y, Vec3::Z];
    for (color, z) in colors.into_iter().zip([2.0, 1.0, 0.0]) {
        add_panel(&mut scene, z * Vec3::Z, Vec3::Z, 30.0, unlit(color));
    }
    let scene = Scene::build(scene).expect("builds");
    let never = f32::INFINITY;
    for lens in LENSES {
        // Planes are perpendicular to the view, so the corners of a perspective picture are cut at the same depth.
        let seen = [
            (0.0, never, Vec3::X),
            (2.99, never, Vec3::X),
            (3.01, never, Vec3::Y),
            (3.99, never, Vec3::Y),
            (4.01, never, Vec3::Z),
            (5.01, never, sky),
            (0.01, 2.99, sky),
            (0.01, 3.01, Vec3::X),
            (3.5, 3.9, sky),
            (3.5, 4.1, Vec3::Y),
        ];
        for (near, far, expected) in seen {
            all_are(&picture(&scene, camera(lens, near, far), 1), expected);
        }
    }
    // Parallel rays may start behind the eye.
    let behind = CameraDescription { transform: Affine3A::IDENTITY, ..camera(LENSES[0], -1.5, never) };
    all_are(&picture(&scene, behind, 1), Vec3::Y);
}

#[test]
fn what_is_clipped_is_still_reflected_and_still_casts_shadows() {
    let never = f32::INFINITY;
    let mirror = MaterialDescription {
        base_color: Vec4::ONE,
        metallic: 1.0,
        roughness: 0.0,
        ..MaterialDescription::default()
    };
    // A mirror at z = 0; green all over it at z = 3, before the near plane. What the mirror shows is 8 m away.
    let mut scene = SceneDescription::default();
    add_panel(&mut scene, Vec3::ZERO, Vec3::Z, 30.0, mirror);
    add_panel(&mut scene, 3.0 * Vec3::Z, Vec3::Z, 30.0, unlit(Vec3::Y));
    let scene = Scene::build(scene).expect("builds");
    for lens in LENSES {
        all_are(&picture(&scene, camera(lens, 4.0, 6.0), 4), Vec3::Y);
        all_are(&picture(&scene, camera(lens, 4.0, never), 4), Vec3::Y);
    }
    // A matte floor below a black lid under a sun.
    let matte = MaterialDescription { metallic: 0.0, roughness: 1.0, ..MaterialDescription::default() };
    let mut scene = SceneDescription::default();
    scene.lights.push(PunctualLight {
        name: String::new(),
        intensity: Vec3::ONE,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        range: None,
        kind: PunctualKind::Directional,
    });
    add_panel(&mut scene, Vec3::ZERO, Vec3::Z, 30.0, matte);
    add_panel(&mut scene, 3.0 * Vec3::Z, Vec3::Z, 40.0, unlit(Vec3::ZERO));
    let scene = Scene::build(scene).expect("builds");
    all_are(&picture(&scene, camera(LENSES[0], 4.0, never), 4), Vec3::ZERO);
}

/// A ball of clear, absorbing medium of index 1.
fn ball() -> SceneDescription {
    let medium = subsurface(Vec3::splat(2.0), Vec3::ZERO, 0.0, 1.0, 0.0);
    single(icosphere(1.0, 5, false), medium, EnvironmentDescription::Constant(Vec3::ONE))
}

/// The length of a line through the unit ball at the origin that lies at depths from `near` to `far` of a camera at z = 5.
fn inside(through: Vec3, direction: Vec3, near: f32, far: f32) -> f32 {
    let b = through.dot(direction);
    let root = (b * b - through.length_squared() + 1.0).max(0.0).sqrt();
    let at = |depth: f32| (through.z - (5.0 - depth)) / -direction.z;
    ((root - b).min(at(far)) - (-root - b).max(at(near))).max(0.0)
}

#[test]
fn media_begin_at_the_near_plane_and_end_at_the_far_plane() {
    let scene = Scene::build(ball()).expect("builds");
    let never = f32::INFINITY;
    // Planes that cut the ball, that lie in it, and around it; the last see a part smaller than the ball.
    let lenses = [
        Projection::Orthographic { ymag: 1.5, aspect: None },
        Projection::Perspective { yfov: 0.6, aspect: None },
        Projection::Orthographic { ymag: 0.2, aspect: None },
        Projection::Perspective { yfov: 0.08, aspect: None },
    ];
    let planes = [(5.0, never), (4.6, never), (4.6, 5.3), (0.1, 4.9), (5.5, 5.6), (0.1, never), (6.5, never)];
    for lens in lenses {
        for (near, far) in planes {
            let view = camera(lens, near, far);
            let rendered = render(&scene, &options(view.clone(), 60, 16), &()).expect("renders");
            assert_eq!(rendered.stats.leaked_paths, 0);
            let bound = Camera::new(&view, 60, 60);
            for (i, p) in rendered.picture.pixels.iter().enumerate() {
                let lengths = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5)].map(|(x, y)| {
                    let ray = bound.ray(Vec2::new((i % 60) as f32 + x, (i / 60) as f32 + y));
                    inside(ray.origin, ray.direction, near, far)
                });
                let (least, most) = lengths.iter().fold((never, 0_f32), |(l, m), &d| (l.min(d), m.max(d)));
                // Not at the rim, where a pixel is no number; the ball is an icosahedron, 0.1 % smaller.
                if most - least < 0.1 {
                    let (low, high) = ((-2.0 * (most + 0.005)).exp(), (-2.0 * (least - 0.005)).exp());
                    assert!(
                        (low..=high).contains(&p.x),
                        "{lens:?} {near} {far} {i}: {} is not {low} … {high}",
                        p.x
                    );
                }
            }
        }
    }
}

#[test]
fn the_ground_ends_at_the_far_plane() {
    let mut scene = ball();
    scene.instances[0].transform = Affine3A::from_translation(Vec3::new(0.0, 1.0, -90.0));
    // A lid over the ground makes its shadow black there.
    add_panel(&mut scene, Vec3::new(0.0, 0.5, 0.0), Vec3::Y, 80.0, unlit(Vec3::ZERO));
    scene.environment = EnvironmentDescription::Constant(Vec3::ONE);
    let scene = Scene::build(scene).expect("builds");
    // From 0.25 m above the ground, 45° down: the ground is met at depth 0.25 to 0.5 m.
    let view = |far| CameraDescription {
        transform: Affine3A::from_rotation_translation(
            glam::Quat::from_rotation_x(-std::f32::consts::FRAC_PI_4),
            0.25 * Vec3::Y,
        ),
        ..camera(Projection::Perspective { yfov: 0.4, aspect: None }, 0.01, far)
    };
    let mean = |far| {
        let options = options(view(far), 8, 16).with(|o| o.view.ground = Some(0.0));
        let picture = render(&scene, &options, &()).expect("renders").picture;
        picture.pixels.iter().map(|p| p.x).sum::<f32>() / 64.0
    };
    assert!((mean(0.2) - 1.0).abs() < 1e-6);
    assert!(mean(10.0) < 0.2, "{}", mean(10.0));
}
