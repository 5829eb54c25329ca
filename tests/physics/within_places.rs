//! Paths that turn within a place: what they passed on the way down they meet again on the way up.

use crate::lab::*;
use crate::places::{quad, scene_of, slab, smoke, transforms};
use glam::{Affine3A, Vec3, Vec4};
use nephrite::scene::*;

fn floor(material: MaterialDescription) -> (MeshDescription, MaterialDescription) {
    let mut floor = quad(2.0);
    floor.positions.iter_mut().for_each(|p| p.z = -0.5);
    (floor, material)
}

fn white() -> MaterialDescription {
    MaterialDescription { base_color: Vec4::ONE, metallic: 0.0, specular: 0.0, ..Default::default() }
}

/// Radiance that the middle of a floor at z = −0.5 sends up, slantwise, through what stands on it.
fn seen(
    parts: &[(MeshDescription, MaterialDescription)],
    transform: Affine3A,
    sky: f32,
    spp: u32,
) -> Estimate {
    let mut description = scene_of(parts.to_vec(), transform);
    description.environment = EnvironmentDescription::Constant(Vec3::splat(sky));
    let target = transform.transform_point3(Vec3::new(0.003, 0.005, -0.5));
    let across = transform.matrix3.determinant().abs().cbrt();
    let away = transform.transform_vector3(Vec3::new(0.2, 0.1, 1.0)).normalize();
    let mut camera = ortho(-away, 4.0 * across, 0.02 * across);
    camera.transform.translation += glam::Vec3A::from(target);
    let options = options(camera, 16, spp).with(|o| o.settings.max_depth = 100);
    measure(&Scene::build(description).unwrap(), &options)
}

/// Both orders of two parts.
fn orders(
    a: (MeshDescription, MaterialDescription),
    b: (MeshDescription, MaterialDescription),
) -> [Vec<(MeshDescription, MaterialDescription)>; 2] {
    [vec![a.clone(), b.clone()], vec![b, a]]
}

fn on_the_floor(
    low: f32,
    mut material: MaterialDescription,
    transform: Affine3A,
) -> (MeshDescription, MaterialDescription) {
    // Coefficients are per world metre.
    let scale = transform.transform_vector3(Vec3::Z).length();
    material.medium.as_mut().expect("a medium").sigma_a /= scale;
    (slab(low, 0.5), material)
}

#[test]
fn light_from_a_floor_goes_back_through_the_medium_on_it() {
    for (i, transform) in transforms().into_iter().enumerate() {
        // Index 1: the boundary is passed on the way down, and the light on the way up is in the medium all the same.
        let gap = vec![floor(white()), on_the_floor(-0.4999, smoke(1.0), transform)];
        let above = seen(&gap, transform, 1.0, 64);
        for (k, parts) in orders(floor(white()), on_the_floor(-0.5, smoke(1.0), transform)).iter().enumerate()
        {
            seen(parts, transform, 1.0, 64).assert_same(&above, &format!("transform {i}, order {k}"));
        }
    }
}

#[test]
fn light_from_a_floor_comes_back_through_the_hole_that_it_went_through() {
    // A boundary that swallows half of what meets it. A path crosses the upper side twice, and one hole on the floor twice.
    let mut black = smoke(0.0);
    (black.alpha_mode, black.base_color) = (AlphaMode::Blend, Vec4::new(0.0, 0.0, 0.0, 0.5));
    for (i, transform) in transforms().into_iter().enumerate() {
        for (k, parts) in orders(floor(white()), (slab(-0.5, 0.5), black.clone())).iter().enumerate() {
            let e = seen(parts, transform, 1.0, 256);
            assert!(e.se[0] < 0.004);
            assert!((e.mean[0] - 0.125).abs() < 4.0 * e.se[0], "transform {i}, order {k}: {:?}", e.mean);
        }
    }
}

#[test]
fn a_lamp_below_a_rough_boundary_in_its_place_is_seen_in_full() {
    // A floor that shines as the sky does: everything is white.
    let lamp = MaterialDescription { base_color: Vec4::ZERO, emission: Vec3::ONE, ..white() };
    let glass = subsurface(Vec3::ZERO, Vec3::ZERO, 0.0, 1.5, 0.5);
    for (i, transform) in transforms().into_iter().enumerate() {
        for (k, parts) in orders(floor(lamp.clone()), (slab(-0.5, 0.5), glass.clone())).iter().enumerate() {
            let e = seen(parts, transform, 1.0, 256);
            assert!(e.se[0] < 0.004, "{:?}", e.se);
            assert!((e.mean[0] - 1.0).abs() < 4.0 * e.se[0] + 1e-3, "transform {i}, order {k}: {:?}", e.mean);
        }
    }
}
