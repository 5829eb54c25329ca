//! The picture is a function of scene, options and seed, bit for bit.

use crate::lab::*;
use glam::{Affine3A, Vec3, Vec4};
use nephrite::scene::*;
use nephrite::transport::render;

/// A textured medium behind a rough boundary, a homogeneous one, a floor, an environment map and a lamp.
fn scene() -> Scene {
    let map = (0..32).map(|i| Vec3::new(0.2, 0.3, 0.5) * (1 + (i * 7) % 5) as f32).collect();
    let environment =
        EnvironmentDescription::Map { width: 8, height: 4, pixels: map, scale: Vec3::ONE, rotation: 0.7 };
    let textured = subsurface(Vec3::splat(20.0), Vec3::new(400.0, 300.0, 200.0), 0.4, 1.4, 0.4);
    let mut scene = single(with_uvs(icosphere(0.02, 2, true)), textured, environment);
    let texels: Vec<Vec3> = (0..16).map(|i| Vec3::splat(((i * 5) % 16) as f32 / 15.0)).collect();
    let texture = add_texture(&mut scene, 4, &texels);
    let medium = scene.materials[0].medium.as_mut().expect("a medium");
    medium.scattering_texture = Some(texture);
    medium.absorption_texture = Some(texture);
    scene.materials.push(subsurface(Vec3::splat(5.0), Vec3::new(900.0, 500.0, 100.0), 0.0, 1.5, 0.0));
    scene.materials.push(MaterialDescription { metallic: 0.3, roughness: 0.5, ..Default::default() });
    scene.materials.push(MaterialDescription {
        base_color: Vec4::ZERO,
        emission: Vec3::splat(30.0),
        double_sided: true,
        ..Default::default()
    });
    let sizes = [Vec3::splat(0.02), Vec3::new(0.3, 0.01, 0.3), Vec3::new(0.03, 0.001, 0.03)];
    let places = [Vec3::new(0.035, 0.0, 0.0), Vec3::new(0.0, -0.03, 0.0), Vec3::new(0.0, 0.06, 0.0)];
    for (i, (size, at)) in sizes.into_iter().zip(places).enumerate() {
        let mut mesh = cuboid(size);
        mesh.triangle_materials.fill(i as u32 + 1);
        scene.meshes.push(mesh);
        scene.instances.push(place(i + 1, Affine3A::from_translation(at)));
    }
    Scene::build(scene).expect("builds")
}

#[test]
fn pictures_do_not_depend_on_threads_and_repeat() {
    let scene = scene();
    let picture = |threads, seed| {
        // Neither a multiple of the tile nor of a pass.
        let options = options(ortho(Vec3::new(-0.3, -0.5, -0.8), 0.3, 0.05), 1, 7).with(|o| {
            o.view.width = 53;
            o.view.height = 37;
            o.threads = threads;
            o.settings.seed = seed;
        });
        let picture = render(&scene, &options, &()).expect("renders").picture;
        picture.pixels.iter().flat_map(|p| p.to_array()).map(f32::to_bits).collect::<Vec<u32>>()
    };
    let one = picture(1, 5);
    assert!(one == picture(1, 5), "two runs differ");
    assert!(one == picture(2, 5), "two threads make another picture");
    assert!(one == picture(4, 5), "four threads make another picture");
    let other = picture(2, 6);
    let equal = one.iter().zip(&other).filter(|(a, b)| a == b).count();
    assert!(equal < one.len() / 10, "{equal} of {} numbers are the same for another seed", one.len());
}

#[test]
fn compiling_a_scene_again_gives_the_same_picture() {
    let options = options(ortho(Vec3::new(-0.3, -0.5, -0.8), 0.3, 0.05), 24, 3);
    let pictures = [(), ()].map(|()| render(&scene(), &options, &()).expect("renders").picture.pixels);
    assert_eq!(pictures[0], pictures[1]);
}
