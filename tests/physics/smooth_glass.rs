//! Bodies of glass with interpolated normals: they lose nothing, hold no path for long, and look like the curved bodies that
//! they stand for.

use crate::lab::*;
use glam::{Affine3A, Vec2, Vec3};
use nephrite::scene::{
    EnvironmentDescription, MaterialDescription, MeshDescription, Scene, SceneDescription,
};
use nephrite::transport::{RenderStats, render};
use std::f32::consts::{PI, TAU};

/// Rays of a smooth-shaded body for one of the same body with flat shading.
const MOST_RAYS: f64 = 1.3;
/// Events after which a path counts as held: the longest of a flat-shaded body has some hundreds.
const HELD: u32 = 5_000;
const SIDE: u32 = 32;

/// A solid of revolution about y; the profile (radius, height) runs counterclockwise, from axis to axis.
fn lathe(profile: &[Vec2], segments: u32) -> MeshDescription {
    let mut mesh = MeshDescription::default();
    let mut rows: Vec<Vec<u32>> = Vec::new();
    for p in profile {
        let start = mesh.positions.len() as u32;
        let n = if p.x == 0.0 { 1 } else { segments };
        for i in 0..n {
            let (sin, cos) = (TAU * i as f32 / segments as f32).sin_cos();
            mesh.positions.push(Vec3::new(p.x * cos, p.y, p.x * sin));
        }
        rows.push((0..segments).map(|i| start + i % n).collect());
    }
    for pair in rows.windows(2) {
        for i in 0..segments as usize {
            let j = (i + 1) % segments as usize;
            let [a, b, c, d] = [pair[0][i], pair[0][j], pair[1][i], pair[1][j]];
            if a != b {
                mesh.triangles.push([a, d, b]);
            }
            if c != d {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    mesh
}

/// Normals as modellers make them for smooth shading: those of the triangles around a vertex, weighed by angle. Edges are
/// rounded off like everything else.
fn smooth_shaded(mut mesh: MeshDescription) -> MeshDescription {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for t in &mesh.triangles {
        let p = t.map(|i| mesh.positions[i as usize]);
        let n = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
        for k in 0..3 {
            let (to, and) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            normals[t[k] as usize] += n * to.angle_between(and);
        }
    }
    mesh.normals = normals.iter().map(|n| n.normalize()).collect();
    mesh
}

fn outline(corners: &[(f32, f32)]) -> Vec<Vec2> {
    corners.iter().copied().map(Vec2::from).collect()
}

/// A tumbler of thick walls, 0.1 high, with sharp edges.
fn tumbler() -> MeshDescription {
    let profile =
        outline(&[(0.0, 0.0), (0.04, 0.0), (0.04, 0.1), (0.036, 0.1), (0.036, 0.012), (0.0, 0.012)]);
    lathe(&profile, 32)
}

/// A tumbler whose edges are arcs of `arc` pieces. Loops close to both ends of an arc keep its normals from bending those of
/// the straight walls beyond.
fn rounded_tumbler(segments: u32, arc: u32) -> MeshDescription {
    const EDGE: f32 = 0.0024;
    const LOOP: f32 = 0.0005;
    let mut profile = vec![Vec2::ZERO];
    let mut round = |x: f32, y: f32, radius: f32, from: f32, to: f32| {
        let centre = Vec2::new(x, y);
        let spoke = |degrees: f32| Vec2::from_angle(degrees.to_radians());
        let ahead = LOOP * (to - from).signum();
        profile.push(centre + radius * spoke(from) - ahead * spoke(from).perp());
        for i in 0..=arc {
            profile.push(centre + radius * spoke(from + (to - from) * i as f32 / arc as f32));
        }
        profile.push(centre + radius * spoke(to) + ahead * spoke(to).perp());
    };
    round(0.04 - 2.0 * EDGE, 2.0 * EDGE, 2.0 * EDGE, -90.0, 0.0);
    round(0.04 - EDGE, 0.1 - EDGE, EDGE, 0.0, 90.0);
    round(0.034 + EDGE, 0.1 - EDGE, EDGE, 90.0, 180.0);
    round(0.034 - 2.0 * EDGE, 0.012 + 2.0 * EDGE, 2.0 * EDGE, 0.0, -90.0);
    profile.push(Vec2::new(0.0, 0.012));
    lathe(&profile, segments)
}

fn arc(radius: f32, rows: u32, to: f32) -> impl DoubleEndedIterator<Item = Vec2> {
    (0..=rows).map(move |i| {
        let (sin, cos) = (to * i as f32 / rows as f32).sin_cos();
        Vec2::new(if sin.abs() < 1e-6 { 0.0 } else { radius * sin }, -radius * cos)
    })
}

fn bowl() -> MeshDescription {
    let profile: Vec<_> = arc(0.04, 8, 0.5 * PI).chain(arc(0.035, 8, 0.5 * PI).rev()).collect();
    lathe(&profile, 16)
}

fn globe(around: u32, rows: u32) -> MeshDescription {
    lathe(&arc(0.04, rows, PI).collect::<Vec<_>>(), around)
}

/// A thin lens with a sharp edge.
fn lens() -> MeshDescription {
    let cap = |side: f32| {
        (0..6).map(move |i| {
            let r = 0.04 * i as f32 / 6.0;
            Vec2::new(r, side * (0.008 - 5.0 * r * r))
        })
    };
    let profile: Vec<_> = cap(-1.0).chain([Vec2::new(0.04, 0.0)]).chain(cap(1.0).rev()).collect();
    lathe(&profile, 24)
}

fn bodies() -> Vec<(&'static str, MeshDescription)> {
    vec![
        ("tumbler", tumbler()),
        ("rounded tumbler", rounded_tumbler(32, 2)),
        ("bowl", bowl()),
        ("sphere of 8 × 6", globe(8, 6)),
        ("sphere of 80 triangles", icosphere(0.04, 1, false)),
        ("sphere of 1280 triangles", icosphere(0.04, 3, false)),
        ("lens", lens()),
        ("cube", cuboid(Vec3::splat(0.05))),
    ]
}

fn clear(ior: f32) -> MaterialDescription {
    subsurface(Vec3::ZERO, Vec3::ZERO, 0.0, ior, 0.0)
}

fn white() -> EnvironmentDescription {
    EnvironmentDescription::Constant(Vec3::ONE)
}

/// A camera that sees all of a scene's first mesh.
fn sight(scene: &SceneDescription) -> nephrite::scene::CameraDescription {
    let positions = &scene.meshes[0].positions;
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let mut camera = ortho(Vec3::new(-0.4, -0.35, -0.9), 0.5, 0.6 * (high - low).max_element());
    camera.transform.translation += glam::Vec3A::from(0.5 * (low + high));
    camera
}

/// What a body shows in an environment of radiance 1, and what it takes.
fn look(scene: SceneDescription, spp: u32) -> (Estimate, RenderStats) {
    let options = options(sight(&scene), SIDE, spp).with(|o| o.settings.max_depth = HELD);
    let scene = Scene::build(scene).expect("builds");
    let rendered = render(&scene, &options, &()).expect("renders");
    let pixels: Vec<_> = rendered.picture.pixels.iter().map(|p| p.as_dvec3().to_array()).collect();
    (Estimate::of(&pixels), rendered.stats)
}

/// Asserts that smooth shading costs little, and ends every path; returns what both show.
fn compare(scene: &SceneDescription, spp: u32, what: &str) -> [Estimate; 2] {
    let mut smooth = scene.clone();
    smooth.meshes = smooth.meshes.into_iter().map(smooth_shaded).collect();
    let (flat, flat_stats) = look(scene.clone(), spp);
    let (smooth, stats) = look(smooth, spp);
    let rays = stats.rays as f64 / flat_stats.rays as f64;
    println!("{what}: {rays:.3} times the rays, mean {:.5?}, flat {:.5?}", smooth.mean, flat.mean);
    assert_eq!(stats.truncated_paths, 0, "{what}");
    assert_eq!(stats.invalid_samples, 0, "{what}");
    assert_eq!((flat_stats.leaked_paths, stats.leaked_paths), (0, 0), "{what}: flat, smooth");
    assert!(rays < MOST_RAYS, "{what}: {rays} times the rays of flat shading");
    [flat, smooth]
}

#[test]
fn clear_glass_loses_nothing() {
    for (name, mesh) in bodies() {
        for ior in [1.5, 2.4] {
            let what = format!("{name}, ior {ior}");
            let [_, smooth] = compare(&single(mesh.clone(), clear(ior), white()), 32, &what);
            for mean in smooth.mean {
                // Every sample is 1 but for rounding, of a few crossings.
                assert!((mean - 1.0).abs() < 1e-5, "{what}: {mean}");
            }
        }
    }
}

#[test]
fn milky_glass_loses_nothing() {
    for (name, mesh) in bodies() {
        let material = subsurface(Vec3::ZERO, Vec3::new(18.0, 20.0, 22.0), 0.3, 1.5, 0.0);
        let [_, smooth] = compare(&single(mesh, material, white()), 64, name);
        for c in 0..3 {
            let (off, se) = ((smooth.mean[c] - 1.0).abs(), smooth.se[c]);
            assert!(off < 4.0 * se && se < 3e-4, "{name}: off by {off} ± {se}");
        }
        // Weights only move light among the channels: what those have in common has a tenth of the noise.
        let common = smooth.mean.iter().sum::<f64>() / 3.0;
        assert!((common - 1.0).abs() < 1e-4, "{name}: {common}");
    }
}

#[test]
fn frosted_glass_loses_nothing() {
    for (name, mesh) in [("tumbler", tumbler()), ("cube", cuboid(Vec3::splat(0.05)))] {
        let material = subsurface(Vec3::ZERO, Vec3::ZERO, 0.0, 1.5, 0.1f32.sqrt());
        let [_, smooth] = compare(&single(mesh, material, white()), 64, &format!("frosted {name}"));
        // Weights of the directions that facets let through are noise.
        for c in 0..3 {
            let (off, se) = ((smooth.mean[c] - 1.0).abs(), smooth.se[c]);
            assert!(off < 4.0 * se && se < 6e-4, "{name}: off by {off} ± {se}");
        }
    }
}

#[test]
fn a_drink_in_a_glass_loses_nothing() {
    let mut scene = single(tumbler(), clear(1.5), white());
    let mut water = clear(1.33);
    water.medium.as_mut().expect("a medium").priority = -1;
    scene.materials.push(water);
    // It reaches into the glass, which has priority.
    let mut drink = lathe(&outline(&[(0.0, 0.008), (0.038, 0.008), (0.038, 0.07), (0.0, 0.07)]), 32);
    drink.triangle_materials.fill(1);
    scene.meshes.push(drink);
    scene.instances.push(place(1, Affine3A::IDENTITY));
    let [_, smooth] = compare(&scene, 32, "drink");
    // Rounding, as in clear glass.
    assert!((smooth.mean[1] - 1.0).abs() < 1e-5, "{}", smooth.mean[1]);
}

/// A coarse tumbler of tinted glass with smooth shading is as bright as a fine one that needs none.
#[test]
fn tinted_tumblers_are_as_bright_as_fine_ones() {
    let material = subsurface(Vec3::new(2.0, 5.0, 10.0), Vec3::ZERO, 0.0, 1.5, 0.0);
    let coarse = single(rounded_tumbler(64, 6), material.clone(), white());
    let [_, smooth] = compare(&coarse, 128, "tinted tumbler");
    let (fine, _) = look(single(rounded_tumbler(512, 16), material, white()), 128);
    println!("fine {:.5?}", fine.mean);
    for c in 0..3 {
        // The coarse mesh is thinner, by a per cent of the eighth that its glass absorbs, and its normals are wrong at the
        // loops; the rest is four standard errors of 131072 samples whose values are between 0.5 and 1.
        assert!((smooth.mean[c] / fine.mean[c] - 1.0).abs() < 0.004, "{} {}", smooth.mean[c], fine.mean[c]);
    }
}

/// Seen along a diameter a tinted sphere shows R + (1 − R)² a / (1 − R a) at each point, a being what a chord lets through
/// and R the reflectance, the same at both of its ends.
#[test]
fn a_tinted_sphere_is_as_bright_as_the_closed_form() {
    const RADIUS: f64 = 0.04;
    const HALF: f64 = 0.028;
    const IOR: f64 = 1.5;
    let sigma = [2.0, 5.0, 10.0];
    let n = 400;
    let at = |i: usize| HALF * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
    let mut expected = [0.0; 3];
    for (x, y) in (0..n * n).map(|i| (at(i % n), at(i / n))) {
        let sin = x.hypot(y) / RADIUS;
        let cos = (1.0 - sin * sin).sqrt();
        let inside = (1.0 - (sin / IOR).powi(2)).sqrt();
        let r = f64::from(nephrite::optics::fresnel::dielectric(cos as f32, IOR as f32));
        for c in 0..3 {
            let a = (-sigma[c] * 2.0 * RADIUS * inside).exp();
            expected[c] += (r + (1.0 - r).powi(2) * a / (1.0 - r * a)) / (n * n) as f64;
        }
    }
    let material = subsurface(Vec3::from(sigma.map(|s| s as f32)), Vec3::ZERO, 0.0, IOR as f32, 0.0);
    for (levels, tolerance) in [(3, 5e-3), (5, 1e-3)] {
        let mesh = icosphere(RADIUS as f32, levels, true);
        let scene = Scene::build(single(mesh, material.clone(), white())).expect("builds");
        let estimate =
            measure(&scene, &options(ortho(Vec3::new(-0.4, -0.3, -0.9), 0.2, HALF as f32), 48, 128));
        println!("{levels}: {:.5?} ± {:.5?}, expected {expected:.5?}", estimate.mean, estimate.se);
        for (c, expected) in expected.iter().enumerate() {
            // Chords of a mesh are shorter than those of its sphere, less so with each level.
            let off = (estimate.mean[c] - expected).abs();
            assert!(off < tolerance * expected + 4.0 * estimate.se[c], "{levels} [{c}]: off by {off}");
        }
    }
}
