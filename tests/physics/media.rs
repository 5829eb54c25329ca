//! Media where geometry is unusual: nested, overlapping, textured, mirrored, inside out, open, around the camera.

use crate::lab::*;
use glam::{Affine3A, Vec3, Vec4};
use nephrite::scene::*;
use nephrite::transport::render;

const SIGMA_A: Vec3 = Vec3::new(5.0, 20.0, 40.0);
const SIGMA_S: Vec3 = Vec3::new(200.0, 150.0, 80.0);

pub fn view() -> CameraDescription {
    ortho(Vec3::new(-0.3, -0.5, -0.8), 0.2, 0.022)
}

/// Pictures of two scenes that must be the same but for noise.
fn assert_same_pictures(a: SceneDescription, b: SceneDescription, spp: u32, what: &str) {
    let [a, b] = [a, b].map(|s| Scene::build(s).expect("builds"));
    let (mut first, mut second) = (options(view(), 32, spp), options(view(), 32, spp));
    (first.settings.seed, second.settings.seed) = (100, 200);
    let first = measure_pictures(&a, &first, 24);
    let second = measure_pictures(&b, &second, 24);
    for (part, (a, b)) in first.iter().zip(&second).enumerate() {
        let part = ["whole", "upper left", "upper right", "lower left", "lower right"][part];
        a.assert_same(b, &format!("{what}, {part}"));
    }
}

fn ball(mesh: MeshDescription, ior: f32, roughness: f32) -> SceneDescription {
    single(mesh, subsurface(SIGMA_A, SIGMA_S, 0.4, ior, roughness), sky_above(1.0))
}

#[test]
fn a_sphere_inside_of_its_own_medium_cannot_be_seen() {
    for ior in [1.0, 1.4] {
        let alone = ball(icosphere(0.02, 3, false), ior, 0.0);
        let mut nested = alone.clone();
        let mut inner = icosphere(0.01, 2, false);
        inner.triangle_materials.fill(1);
        nested.materials.push(alone.materials[0].clone());
        nested.meshes.push(inner);
        nested.instances.push(place(1, Affine3A::from_translation(Vec3::new(0.004, 0.0, -0.003))));
        assert_same_pictures(nested, alone, 32, &format!("nested, ior {ior}"));
    }
}

#[test]
fn textures_multiply_coefficients() {
    let alone = ball(with_uvs(icosphere(0.02, 3, false)), 1.4, 0.0);
    for (value, factor) in [(1.0, 1.0), (0.5, 2.0)] {
        let mut textured = alone.clone();
        let texture = add_texture(&mut textured, 2, &[Vec3::splat(value); 4]);
        let medium = textured.materials[0].medium.as_mut().expect("a medium");
        medium.sigma_a *= factor;
        medium.sigma_s *= factor;
        medium.absorption_texture = Some(texture);
        medium.scattering_texture = Some(texture);
        assert_same_pictures(textured, alone.clone(), 32, &format!("constant texture {value}"));
    }
}

#[test]
fn inside_out_meshes_are_turned() {
    for smooth in [false, true] {
        let right = ball(icosphere(0.02, 2, smooth), 1.4, 0.0);
        let mut reversed = right.clone();
        reversed.meshes[0].triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert_same_pictures(reversed.clone(), right.clone(), 32, &format!("reversed, smooth {smooth}"));
        if smooth {
            reversed.meshes[0].normals.iter_mut().for_each(|n| *n = -*n);
            assert_same_pictures(reversed, right, 32, "reversed with its normals");
        }
    }
}

#[test]
fn mirrored_and_stretched_instances_are_the_shapes_they_make() {
    // The icosahedron has the coordinate planes for mirrors.
    let right = ball(icosphere(0.02, 2, true), 1.4, 0.0);
    let mut mirrored = right.clone();
    mirrored.instances = vec![place(0, Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)))];
    assert_same_pictures(mirrored, right.clone(), 32, "mirrored");

    let scale = Vec3::new(0.5, 1.0, -0.8);
    let mut stretched = right.clone();
    stretched.instances = vec![place(0, Affine3A::from_scale(scale))];
    let mut made = right;
    made.meshes[0].positions.iter_mut().for_each(|p| *p *= scale.abs());
    made.meshes[0].normals.iter_mut().for_each(|n| *n = (*n / scale.abs()).normalize());
    assert_same_pictures(stretched, made, 32, "stretched");
}

/// Absorption only, and no boundary: what is seen through it is e^−τ, without noise.
fn absorbing(sigma_a: Vec3, priority: i32) -> MaterialDescription {
    let mut material = subsurface(sigma_a, Vec3::ZERO, 0.0, 1.0, 0.0);
    material.medium.as_mut().expect("a medium").priority = priority;
    material
}

fn assert_transmits(scene: SceneDescription, camera: CameraDescription, expected: Vec3, what: &str) {
    let scene = Scene::build(scene).expect("builds");
    let mean = measure(&scene, &options(camera, 8, 4)).mean;
    for c in 0..3 {
        let expected = f64::from(expected[c]);
        assert!((mean[c] / expected - 1.0).abs() < 1e-4, "{what} [{c}]: {} is not {expected}", mean[c]);
    }
}

#[test]
fn an_overlap_belongs_to_the_higher_priority() {
    let (a, b) = (Vec3::new(1.0, 2.0, 0.5), Vec3::new(0.3, 0.1, 3.0));
    for (priorities, in_a, in_b) in [([0, 1], 0.5, 1.5), ([3, -2], 1.5, 0.5), ([-5, -4], 0.5, 1.5)] {
        for order in [1.0, -1.0] {
            // A fills x from −1 to 0.5, B from −0.5 to 1.
            let mut scene = single(
                cuboid(Vec3::new(1.5, 1.0, 1.0)),
                absorbing(a, priorities[0]),
                EnvironmentDescription::Constant(Vec3::ONE),
            );
            let mut other = scene.meshes[0].clone();
            other.triangle_materials.fill(1);
            scene.meshes.push(other);
            scene.materials.push(absorbing(b, priorities[1]));
            scene.instances = vec![
                place(0, Affine3A::from_translation(Vec3::new(-0.25, 0.0, 0.0))),
                place(1, Affine3A::from_translation(Vec3::new(0.25, 0.0, 0.0))),
            ];
            let expected = (-(a * in_a + b * in_b)).exp();
            assert_transmits(
                scene,
                ortho(Vec3::X * order, 3.0, 0.1),
                expected,
                &format!("priorities {priorities:?} along {order}"),
            );
        }
    }
}

/// A rectangle that shines along +z at that z.
fn emitter(z: f32, half: f32, radiance: f32) -> (MeshDescription, MaterialDescription) {
    let mesh = MeshDescription {
        positions: [[-half, -half], [half, -half], [half, half], [-half, half]]
            .map(|[x, y]| Vec3::new(x, y, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![1; 2],
        ..Default::default()
    };
    let material = MaterialDescription {
        base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
        emission: Vec3::splat(radiance),
        ..Default::default()
    };
    (mesh, material)
}

#[test]
fn a_camera_inside_of_a_medium_sees_what_the_medium_leaves() {
    let sigma = Vec3::new(0.5, 1.0, 2.0);
    // A box around the camera at the origin; the emitter is in it at 0.7, or outside of its wall at 1.
    for (distance, inside) in [(0.7f32, 0.7f32), (1.6, 1.0)] {
        let mut scene = single(
            cuboid(Vec3::splat(2.0)),
            absorbing(sigma, 0),
            EnvironmentDescription::Constant(Vec3::ZERO),
        );
        let (mesh, material) = emitter(-distance, 0.9, 3.0);
        scene.meshes.push(mesh);
        scene.materials.push(material);
        scene.instances.push(place(1, Affine3A::IDENTITY));
        let camera = CameraDescription {
            name: String::new(),
            transform: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov: 1e-3, aspect: None },
            clip: nephrite::scene::Clip::NONE,
            lens: None,
        };
        assert_transmits(scene, camera, 3.0 * (-sigma * inside).exp(), &format!("emitter at {distance}"));
    }
}

#[test]
fn a_camera_inside_of_a_scattering_medium_sees_the_furnace() {
    // Radiance over the square of the index is what stays the same along a ray.
    for ior in [1.0f32, 1.5] {
        let environment = EnvironmentDescription::Constant(Vec3::ONE);
        let material = subsurface(Vec3::ZERO, Vec3::splat(100.0), 0.2, ior, 0.0);
        let scene = Scene::build(single(icosphere(0.02, 3, false), material, environment)).expect("builds");
        let camera = ortho(Vec3::new(0.1, 0.2, 1.0), 0.005, 0.001);
        let estimate = measure(&scene, &options(camera, 16, 64));
        let expected = f64::from(ior * ior);
        estimate.assert_matches([expected; 3], [1e-4; 3], &format!("camera inside, ior {ior}"));
    }
}

#[test]
fn alpha_blend_lets_the_rest_through() {
    let (mesh, material) = emitter(-1.0, 1.0, 2.0);
    let veil = MaterialDescription {
        base_color: Vec4::new(0.0, 0.0, 0.0, 0.3),
        metallic: 0.0,
        specular: 0.0,
        alpha_mode: AlphaMode::Blend,
        ..Default::default()
    };
    let mut scene = single(emitter(0.0, 1.0, 0.0).0, veil, EnvironmentDescription::Constant(Vec3::ZERO));
    scene.meshes[0].triangle_materials.fill(0);
    scene.materials.push(material);
    scene.meshes.push(mesh);
    scene.instances.push(place(1, Affine3A::IDENTITY));
    let scene = Scene::build(scene).expect("builds");
    let estimate = measure(&scene, &options(ortho(Vec3::NEG_Z, 1.0, 0.1), 64, 64));
    estimate.assert_matches([1.4; 3], [1e-6; 3], "seen through the veil");
}

#[test]
fn alpha_blend_lets_the_rest_of_a_shadow_ray_through() {
    let floor = MaterialDescription { metallic: 0.0, specular: 0.0, ..Default::default() };
    let veil = MaterialDescription {
        base_color: Vec4::new(0.0, 0.0, 0.0, 0.3),
        metallic: 0.0,
        specular: 0.0,
        alpha_mode: AlphaMode::Blend,
        ..Default::default()
    };
    let plane = |z| emitter(z, 1.0, 0.0).0;
    let mut scene = single(plane(0.0), floor, EnvironmentDescription::Constant(Vec3::ZERO));
    scene.meshes[0].triangle_materials.fill(0);
    scene.meshes.push(plane(0.5));
    scene.materials.push(veil);
    scene.instances.push(place(1, Affine3A::IDENTITY));
    scene.lights.push(PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(2.0),
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        range: None,
        kind: PunctualKind::Directional,
    });
    // The camera is between the floor and the veil.
    assert_transmits(
        scene,
        ortho(Vec3::NEG_Z, 0.2, 0.1),
        Vec3::splat(0.7 * 2.0 / std::f32::consts::PI),
        "shadow",
    );
}

/// A white floor at z = 0 seen from just above it, with `above` over it.
fn floor_below(above: MeshDescription, material: MaterialDescription, sky: f32) -> Estimate {
    floor_below_with(above, material, sky, |_| ())
}

/// The same, of a changed scene; the material is the second one.
fn floor_below_with(
    above: MeshDescription,
    material: MaterialDescription,
    sky: f32,
    change: impl FnOnce(&mut SceneDescription),
) -> Estimate {
    let floor = MaterialDescription { metallic: 0.0, specular: 0.0, ..Default::default() };
    let environment = EnvironmentDescription::Constant(Vec3::splat(sky));
    let mut scene = single(emitter(0.0, 1.0, 0.0).0, floor, environment);
    scene.meshes[0].triangle_materials.fill(0);
    scene.materials.push(material);
    scene.meshes.push(above);
    scene.instances.push(place(1, Affine3A::from_translation(Vec3::Z)));
    change(&mut scene);
    let scene = Scene::build(scene).expect("builds");
    measure(&scene, &options(ortho(Vec3::NEG_Z, 0.2, 0.01), 24, 128))
}

#[test]
fn light_through_a_tinted_boundary_without_contrast_counts_once() {
    let mut glass = absorbing(Vec3::ZERO, 0);
    glass.base_color = Vec4::new(0.5, 0.6, 0.7, 1.0);
    let mut slab = cuboid(Vec3::new(400.0, 400.0, 0.1));
    slab.triangle_materials.fill(1);
    floor_below(slab, glass, 1.0).assert_matches([0.25, 0.36, 0.49], [1e-4; 3], "tinted");
}

/// Null collisions turn nothing: what is met beyond them was sampled before them, too.
#[test]
fn light_through_a_textured_medium_counts_once() {
    let mut slab = with_uvs(cuboid(Vec3::new(40.0, 40.0, 0.5)));
    slab.triangle_materials.fill(1);
    let smoke = |factor: f32| {
        let sigma_s = Vec3::new(0.5, 1.0, 2.0);
        subsurface(factor * Vec3::new(1.0, 0.5, 0.2), factor * sigma_s, 0.0, 1.0, 0.0)
    };
    let textured = floor_below_with(slab.clone(), smoke(2.0), 1.0, |scene| {
        let texture = add_texture(scene, 2, &[Vec3::splat(0.5); 4]);
        let medium = scene.materials[1].medium.as_mut().expect("a medium");
        (medium.absorption_texture, medium.scattering_texture) = (Some(texture), Some(texture));
    });
    textured.assert_same_within(0.005, &floor_below(slab, smoke(1.0), 1.0), "textured smoke");
}

#[test]
fn coverage_multiplies_emission() {
    let lamp = |alpha_mode, emission| {
        let mesh = flipped(emitter(0.0, 0.5, 0.0).0);
        let material = MaterialDescription {
            base_color: Vec4::new(0.0, 0.0, 0.0, 0.5),
            emission: Vec3::splat(emission),
            alpha_mode,
            ..Default::default()
        };
        floor_below(mesh, material, 0.0)
    };
    lamp(AlphaMode::Blend, 2.0).assert_same(&lamp(AlphaMode::Opaque, 1.0), "blended emitter");
}

/// Light that crosses the boundary of a clear slab of two mean free paths twice and is scattered between at most N times: for
/// N = 0 and 1 what integrals over depth and cosine say, and all of it once any number may be.
#[test]
fn depth_counts_scatterings() {
    const TAU: f64 = 2.0;
    // ½ ∫dμ ∫dt e^−t (e^−t/μ + e^−(τ−t)/μ), by depth in closed form.
    let n = 100_000;
    let once: f64 = (0..n)
        .map(|i| {
            let inverse = f64::from(n) / (f64::from(i) + 0.5);
            let back = (1.0 - (-TAU * (1.0 + inverse)).exp()) / (1.0 + inverse);
            back + ((-TAU).exp() - (-TAU * inverse).exp()) / (inverse - 1.0)
        })
        .sum::<f64>()
        / f64::from(2 * n);
    // An index that has refractions which turn nothing, and one that has none.
    let straight = (-TAU).exp();
    let all = [(1.0001, 2), (1.0, 0)].map(|(index, refractions)| {
        [(0, straight), (1, straight + once), (1000, 1.0)].map(|(n, e)| (index, refractions + n, e))
    });
    for (index, max_depth, expected) in all.into_iter().flatten() {
        let material = subsurface(Vec3::ZERO, Vec3::ONE, 0.0, index, 0.0);
        let slab = cuboid(Vec3::new(1000.0, TAU as f32, 1000.0));
        let sky = EnvironmentDescription::Constant(Vec3::ONE);
        let scene = Scene::build(single(slab, material, sky)).expect("builds");
        let options =
            options(ortho(Vec3::NEG_Y, 5.0, 1.0), 24, 1024).with(|o| o.settings.max_depth = max_depth);
        let rendered = render(&scene, &options, &()).expect("renders");
        let pixels: Vec<_> = rendered.picture.pixels.iter().map(|p| p.as_dvec3().to_array()).collect();
        let case = format!("index {index}, {max_depth} events");
        Estimate::of(&pixels).assert_matches([expected; 3], [1e-6; 3], &case);
        assert_eq!(rendered.stats.truncated_paths > 0, expected < 1.0, "{case}: {:?}", rendered.stats);
    }
}

#[test]
fn an_open_mesh_renders() {
    for ior in [1.0, 1.5] {
        let mut scene = ball(icosphere(0.02, 2, true), ior, 0.3);
        scene.meshes[0].triangles.truncate(200);
        scene.meshes[0].triangle_materials.truncate(200);
        let scene = Scene::build(scene).expect("builds");
        let rendered = render(&scene, &options(view(), 48, 16), &()).expect("renders");
        assert_eq!(rendered.stats.invalid_samples, 0);
        assert!(rendered.picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
        assert!(
            rendered.picture.mean().iter().all(|&m| m > 0.01 && m < 2.0),
            "{:?}",
            rendered.picture.mean()
        );
    }
}

/// Light comes in through the hole of an open mesh: the same light, whether it is looked for as one radiance or as a map.
#[test]
fn open_meshes_let_light_in() {
    let mut mesh = icosphere(0.02, 3, false);
    let kept = mesh.triangles.iter().filter(|t| t.iter().any(|&v| mesh.positions[v as usize].z < 0.01));
    mesh.triangles = kept.copied().collect();
    mesh.triangle_materials.truncate(mesh.triangles.len());
    let map = EnvironmentDescription::Map {
        width: 4,
        height: 2,
        pixels: vec![Vec3::splat(0.7); 8],
        scale: Vec3::ONE,
        rotation: 0.0,
    };
    for roughness in [0.0, 0.4] {
        let material = subsurface(SIGMA_A, SIGMA_S, 0.4, 1.4, roughness);
        let of = |environment| single(mesh.clone(), material.clone(), environment);
        let constant = of(EnvironmentDescription::Constant(Vec3::splat(0.7)));
        assert_same_pictures(of(map.clone()), constant, 32, &format!("open mesh, roughness {roughness}"));
    }
}
