//! The models below surfaces where media nest and meshes have parts of other materials.

use crate::lab::*;
use crate::media::view;
use glam::{Affine3A, Vec3};
use nephrite::scene::*;
use nephrite::transport::render;

const MODELS: [&str; 9] = [
    "dipole",
    "dipole-diffuse",
    "single-scattering",
    "better-dipole",
    "directional-dipole",
    "photon-beam-diffusion",
    "normalized-diffusion",
    "brdf-approximation",
    "light-biased",
];

/// Milk inside of glass: light is totally reflected on its way into the milk.
#[test]
fn models_work_inside_of_denser_media() {
    let mut scene = single(
        icosphere(0.02, 3, false),
        subsurface(Vec3::ZERO, Vec3::ZERO, 0.0, 1.5, 0.0),
        EnvironmentDescription::Constant(Vec3::ONE),
    );
    let mut milk = icosphere(0.015, 3, false);
    milk.triangle_materials.fill(1);
    scene.materials.push(subsurface(Vec3::ZERO, Vec3::splat(5000.0), 0.0, 1.33, 0.0));
    scene.meshes.push(milk);
    scene.instances.push(place(1, Affine3A::IDENTITY));
    let scene = Scene::build(scene).expect("builds");
    for model in MODELS {
        let options = options(view(), 24, 32).with(|o| o.settings.subsurface = model.into());
        let rendered = render(&scene, &options, &()).expect("renders");
        assert_eq!(rendered.stats.invalid_samples, 0, "{model}");
    }
}

/// A body whose lower half is metal, and a light below it: nothing comes in there, by any model.
#[test]
fn models_let_no_light_in_through_opaque_parts() {
    let mut mesh = icosphere(0.02, 4, false);
    for (material, triangle) in mesh.triangle_materials.iter_mut().zip(&mesh.triangles) {
        *material = u32::from(triangle.iter().any(|&v| mesh.positions[v as usize].y < 0.006));
    }
    let mut scene = single(
        mesh,
        subsurface(Vec3::ZERO, Vec3::splat(1000.0), 0.0, 1.4, 0.0),
        EnvironmentDescription::Constant(Vec3::ZERO),
    );
    scene.materials.push(MaterialDescription { metallic: 1.0, ..Default::default() });
    scene.lights = vec![PunctualLight {
        name: String::new(),
        intensity: Vec3::ONE,
        position: Vec3::new(0.0, -0.06, 0.0),
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    }];
    let scene = Scene::build(scene).expect("builds");
    let above = ortho(Vec3::NEG_Y, 0.2, 0.012);
    for model in MODELS {
        let options = options(above.clone(), 16, 32).with(|o| o.settings.subsurface = model.into());
        let picture = render(&scene, &options, &()).expect("renders").picture;
        assert!(picture.pixels.iter().all(|p| *p == Vec3::ZERO), "{model}: light came in");
    }
}

/// Two overlapping balls in one mesh: exits inside of the other one are none, so nothing glows.
#[test]
fn boundaries_inside_of_the_same_mesh_are_no_exits() {
    let (mut mesh, other) = (icosphere(0.015, 3, false), icosphere(0.012, 3, false));
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions.iter().map(|p| *p + Vec3::new(0.012, 0.0, 0.0)));
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    let material = || subsurface(Vec3::ZERO, Vec3::splat(3000.0), 0.0, 1.4, 0.0);
    let white = || EnvironmentDescription::Constant(Vec3::ONE);
    let mean = |mesh: &MeshDescription, model: &str| {
        let scene = Scene::build(single(mesh.clone(), material(), white())).expect("builds");
        let options = options(view(), 48, 64).with(|o| o.settings.subsurface = model.into());
        measure(&scene, &options).mean[1]
    };
    for model in ["better-dipole", "normalized-diffusion"] {
        let (both, one) = (mean(&mesh, model), mean(&icosphere(0.015, 3, false), model));
        println!("{model}: {both:.4}, one ball {one:.4}");
        // The bodies differ in shape, to which these models are not quite indifferent. Hidden exits made it 1.08.
        assert!((both - one).abs() < 0.01, "{model}: {both} for {one}");
    }
}
