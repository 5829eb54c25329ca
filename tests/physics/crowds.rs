//! Many bodies in one: more than a list of what is inside of a body holds, so that the scene is asked.

use crate::lab::*;
use glam::{Affine3A, Vec3};
use nephrite::scene::*;

/// Bodies on a side of the lattice: 100 are more than are listed.
const SIDE: usize = 10;
/// Distance between the middles of two, and their edge.
const STEP: f32 = 0.25;
const EDGE: f32 = 0.2;

/// A box with a layer of cubes in it.
fn jar(around: MaterialDescription, inside: MaterialDescription) -> Scene {
    let mut scene =
        single(cuboid(Vec3::new(3.0, 3.0, 1.0)), around, EnvironmentDescription::Constant(Vec3::ONE));
    scene.materials.push(inside);
    let mut cube = cuboid(Vec3::splat(EDGE));
    cube.triangle_materials.fill(1);
    scene.meshes.push(cube);
    for i in 0..SIDE * SIDE {
        let middle = |k: usize| STEP * (k as f32 - 0.5 * (SIDE - 1) as f32);
        let at = Vec3::new(middle(i % SIDE), middle(i / SIDE), 0.1);
        scene.instances.push(place(1, Affine3A::from_translation(at)));
    }
    let scene = Scene::build(scene).expect("builds");
    assert!(matches!(scene.objects[0].intruders, Intruders::Many));
    assert!(matches!(scene.objects[1].intruders, Intruders::Few(_)));
    scene
}

/// Beer's law, through the cubes over their part of the picture, and beside them over the rest.
#[test]
fn each_body_of_a_crowd_absorbs_what_is_in_it() {
    let clear = |sigma_a: Vec3| subsurface(sigma_a, Vec3::ZERO, 0.0, 1.0, 0.0);
    let [around, inside] = [Vec3::new(0.2, 0.5, 1.0), Vec3::new(6.0, 3.0, 0.0)];
    let scene = jar(clear(around), clear(inside));
    // Eight cells of the lattice, edge to edge.
    let camera = ortho(Vec3::NEG_Z, 4.0, 4.0 * STEP);
    let covered = f64::from(EDGE / STEP).powi(2);
    let expected = [0, 1, 2].map(|c| {
        let (a, b) = (f64::from(around[c]), f64::from(inside[c]));
        let edge = f64::from(EDGE);
        covered * (-a * (1.0 - edge) - b * edge).exp() + (1.0 - covered) * (-a).exp()
    });
    let [found, ..] = measure_pictures(&scene, &options(camera, 32, 16), 24);
    found.assert_matches(expected, [0.0; 3], "a crowd that absorbs");
}

/// In uniform light bodies that absorb nothing cannot be seen, whatever they do to it.
#[test]
fn a_crowd_without_loss_cannot_be_seen() {
    let white = |sigma_s: f32, ior: f32| subsurface(Vec3::ZERO, Vec3::splat(sigma_s), 0.0, ior, 0.0);
    let scene = jar(white(1.0, 1.2), white(4.0, 1.4));
    let found = measure(&scene, &options(ortho(Vec3::new(0.3, 0.2, -1.0).normalize(), 4.0, 0.8), 24, 48));
    found.assert_matches([1.0; 3], [0.0; 3], "a crowd without loss");
}
