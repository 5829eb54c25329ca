//! The exit-point search: its density is that of its samples, on any mesh, and it integrates profiles exactly.

use crate::lab::*;
use glam::{Affine3A, Quat, Vec3};
use nephrite::geometry::Hit;
use nephrite::optics::diffusion::{BetterDipole, Coefficients, RadialProfile, TabulatedProfile};
use nephrite::sampling::{Sampler, SmallRng};
use nephrite::scene::*;
use nephrite::subsurface::{ExitSearch, Radii};

/// A transport mean free path of a millimetre.
const MEDIUM: Coefficients = Coefficients { sigma_a: 50.0, sigma_s: 950.0, g: 0.0, eta: 1.4 };
const LINES: u32 = 400_000;

fn scene_of(meshes: Vec<MeshDescription>) -> Scene {
    let material = subsurface(Vec3::splat(50.0), Vec3::splat(950.0), 0.0, 1.4, 0.0);
    let mut description = single(meshes[0].clone(), material, EnvironmentDescription::default());
    description.instances = (0..meshes.len()).map(|i| place(i, Affine3A::IDENTITY)).collect();
    description.meshes = meshes;
    Scene::build(description).expect("builds")
}

/// Counts how often each triangle of instance 0 is hit by lines about a point of `from`, and compares with the integral
/// of the density over the triangle. A line meets a triangle at most once, so the counts are sums of binomials: |z| < 5 in
/// each of at most 1300 triangles (confidence 0.9992 in all).
fn density_is_that_of_the_lines(scene: &Scene, from: u32, what: &str) {
    let table = TabulatedProfile::new(&BetterDipole::new(&MEDIUM)).expect("scatters");
    let radii = Radii::new([(&table, 1.0)].into_iter()).expect("weights");
    let mesh = scene.geometry.mesh_of(0);
    let at = scene.geometry.surface(&Hit::at(0, from, 0.3, 0.25));
    let search = ExitSearch::new(scene, 0, at.position, at.geometric_normal, &radii);
    let mut counts = vec![0u32; mesh.triangle_count()];
    let mut rng = SmallRng::new(9);
    for _ in 0..LINES {
        let (u_part, u) = (rng.f32(), rng.vec2());
        search.visit(u_part, u, &mut rng, |c| {
            assert_eq!(c.hit.instance, 0);
            counts[c.hit.triangle as usize] += 1;
        });
    }
    let (mut worst, mut tested) = (0.0f64, 0);
    for (triangle, &count) in counts.iter().enumerate() {
        let normal = mesh.geometric_normal(triangle as u32);
        let expected = f64::from(LINES)
            * integral(mesh.triangle(triangle as u32), 6, &|p| {
                f64::from(search.pdf(scene.geometry.transform(0).point(p), normal))
            });
        // The quadrature is not exact near the point, where the density peaks.
        let near = (0..3).any(|k| mesh.triangle(triangle as u32)[k].distance(at.position) < 4e-4);
        if expected < 25.0 || near || triangle as u32 == from {
            continue;
        }
        tested += 1;
        let z = (f64::from(count) - expected) / expected.sqrt();
        worst = worst.max(z.abs());
        assert!(z.abs() < 5.0, "{what}: triangle {triangle} has {count} for {expected}");
    }
    println!("{what}: {tested} triangles, largest |z| {worst:.2}");
    assert!(tested >= 20, "{what}: only {tested} triangles have enough lines");
}

/// ∫ f dA by the midpoints of 4^levels equal parts.
fn integral(t: [Vec3; 3], levels: u32, f: &dyn Fn(Vec3) -> f64) -> f64 {
    let n = 1 << levels.min(6);
    let area = 0.5 * f64::from((t[1] - t[0]).cross(t[2] - t[0]).length());
    let mut sum = 0.0;
    let at = |a: f32, b: f32| t[0] + (t[1] - t[0]) * (a / n as f32) + (t[2] - t[0]) * (b / n as f32);
    for i in 0..n {
        for j in 0..(n - i) {
            let (a, b) = (i as f32, j as f32);
            sum += f(at(a + 1.0 / 3.0, b + 1.0 / 3.0));
            if i + j + 1 < n {
                sum += f(at(a + 2.0 / 3.0, b + 2.0 / 3.0));
            }
        }
    }
    sum * area / f64::from(n * n)
}

#[test]
fn the_density_is_that_of_the_lines() {
    density_is_that_of_the_lines(&scene_of(vec![icosphere(0.004, 3, false)]), 100, "sphere");
    let mut edge = grid_box(Vec3::new(0.004, 0.003, 0.005), 8);
    edge.positions.iter_mut().for_each(|p| *p = Quat::from_rotation_x(0.4) * *p);
    density_is_that_of_the_lines(&scene_of(vec![edge]), 7, "box edge");
    let sheet = grid_box(Vec3::new(0.008, 0.008, 0.0004), 10);
    density_is_that_of_the_lines(&scene_of(vec![sheet]), 250, "thin sheet");
    let mut concave = icosphere(0.004, 3, false);
    concave.positions.iter_mut().for_each(|p| {
        let bump = 1.0 - 0.45 * (-8.0 * (p.normalize() - Vec3::Z).length_squared()).exp();
        *p *= bump;
    });
    density_is_that_of_the_lines(&scene_of(vec![concave]), 60, "concave mesh");
    let near = moved(icosphere(0.004, 3, false), Vec3::new(0.0085, 0.0, 0.0));
    density_is_that_of_the_lines(&scene_of(vec![icosphere(0.004, 3, false), near]), 200, "two close objects");
}

/// A box whose faces are grids of n × n squares.
fn grid_box(half: Vec3, n: u32) -> MeshDescription {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (axis, sign) in (0..3).flat_map(|a| [(a, 1.0), (a, -1.0f32)]) {
        let n_axis = Vec3::AXES[axis] * sign;
        let (x, y) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3] * sign);
        let first = positions.len() as u32;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let at = |k: u32| 2.0 * k as f32 / n as f32 - 1.0;
            positions.push((n_axis + at(i) * x + at(j) * y) * half);
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let v = |i: u32, j: u32| first + i * (n + 1) + j;
            triangles.push([v(i, j), v(i + 1, j), v(i + 1, j + 1)]);
            triangles.push([v(i, j), v(i + 1, j + 1), v(i, j + 1)]);
        }
    }
    let triangle_materials = vec![0; triangles.len()];
    MeshDescription { positions, triangles, triangle_materials, ..Default::default() }
}

#[test]
fn searches_integrate_profiles_over_meshes() {
    let profile = BetterDipole::new(&MEDIUM);
    let table = TabulatedProfile::new(&profile).expect("scatters");
    let radii = Radii::new([(&table, 1.0)].into_iter()).expect("weights");
    let mut rough = icosphere(0.004, 4, false);
    let mut rng = SmallRng::new(3);
    rough.positions.iter_mut().for_each(|p| *p *= 1.0 + 0.1 * (rng.f32() - 0.5));
    for (mesh, what) in [(icosphere(0.004, 4, false), "sphere"), (rough, "dense random mesh")] {
        let scene = scene_of(vec![mesh]);
        let geometry = scene.geometry.mesh_of(0);
        let at = scene.geometry.surface(&Hit::at(0, 37, 0.3, 0.3));
        let exact: f64 = (0..geometry.triangle_count() as u32)
            .map(|t| {
                let fine = geometry.triangle(t)[0].distance(at.position) < 1e-3;
                integral(geometry.triangle(t), if fine { 6 } else { 2 }, &|p| {
                    profile.eval(f64::from(p.distance(at.position)).max(1e-7))
                })
            })
            .sum();
        let search = ExitSearch::new(&scene, 0, at.position, at.geometric_normal, &radii);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..LINES {
            let mut value = 0.0;
            let (u_part, u) = (rng.f32(), rng.vec2());
            search.visit(u_part, u, &mut rng, |c| {
                value += profile.eval(f64::from(c.distance).max(1e-7)) / f64::from(c.pdf);
            });
            sum += value;
            squares += value * value;
        }
        let n = f64::from(LINES);
        let (mean, variance) = (sum / n, squares / n - (sum / n).powi(2));
        let se = (variance / n).sqrt();
        println!("{what}: {mean:.5} ± {se:.5}, quadrature {exact:.5}");
        assert!(se < 0.005 * exact && (mean - exact).abs() < 4.0 * se, "{what}: {mean} ± {se}, not {exact}");
    }
}

/// The whole search, one candidate kept by the light of a lamp that leaves half of the body dark, integrates three profiles
/// of very different extent at once, at the origin and where coordinates are rounded to a good part of the smallest.
#[test]
fn kept_candidates_integrate_profiles_over_meshes() {
    let media = [1.0, 5.0, 25.0].map(|density| Coefficients {
        sigma_a: 50.0 * density,
        sigma_s: 950.0 * density,
        ..MEDIUM
    });
    let tables = media.map(|c| TabulatedProfile::new(&BetterDipole::new(&c)).expect("scatters"));
    let radii = Radii::new(tables.iter().map(|t| (t, t.total()))).expect("weights");
    for away in [0.0, 30.0] {
        let material = subsurface(Vec3::splat(50.0), Vec3::splat(950.0), 0.0, 1.4, 0.0);
        let mut description = single(icosphere(0.004, 4, false), material, EnvironmentDescription::default());
        description.instances = vec![place(0, Affine3A::from_translation(Vec3::new(away, 0.0, 0.0)))];
        description.lights = vec![PunctualLight {
            name: String::new(),
            intensity: Vec3::ONE,
            position: Vec3::new(away + 0.02, 0.01, 0.0),
            direction: Vec3::NEG_Z,
            range: None,
            kind: PunctualKind::Point,
        }];
        let scene = Scene::build(description).expect("builds");
        let geometry = scene.geometry.mesh_of(0);
        let own = geometry.triangle(37);
        let middle = own[0] + 0.3 * (own[1] - own[0]) + 0.3 * (own[2] - own[0]);
        let exact = media.map(|c| {
            let profile = BetterDipole::new(&c);
            let of = |t: u32| {
                let fine = geometry.triangle(t)[0].distance(middle) < 1e-3;
                integral(geometry.triangle(t), if fine { 6 } else { 2 }, &|p| {
                    profile.eval(f64::from(p.distance(middle)).max(1e-7))
                })
            };
            (0..geometry.triangle_count() as u32).map(of).sum::<f64>()
        });
        let at = scene.geometry.surface(&Hit::at(0, 37, 0.3, 0.3));
        let search = ExitSearch::new(&scene, 0, at.position, at.geometric_normal, &radii);
        let values: Vec<[f64; 3]> = (0..LINES)
            .map(|sample| {
                let mut sampler = Sampler::new(1, sample, 5);
                let found = search.find(Vec3::ONE, &mut sampler, |c| {
                    let value = |t: &TabulatedProfile| {
                        if c.distance > c.least { t.eval(c.distance) } else { t.disk_mean(c.least) }
                    };
                    Vec3::from_array([0, 1, 2].map(|i| value(&tables[i])))
                });
                found.map_or([0.0; 3], |f| (f.reflectance * f.inverse_pdf).as_dvec3().to_array())
            })
            .collect();
        // The quadrature at the densest profile's peak, and rounding of positions 30 m away.
        Estimate::of(&values).assert_matches(exact, exact.map(|e| 2e-3 * e), &format!("{away} m away"));
    }
}
