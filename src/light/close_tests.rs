//! Lights close to what they light, and lights that are chosen at another point than the lit one.

use super::tests::*;
use super::*;
use crate::sampling::{SmallRng, statistics::Estimate};
use crate::scene::PunctualKind;
use glam::Mat3;

/// Under the middle of a panel, an edge, a corner, near an edge inside and outside, level and turned; from where it nearly
/// touches the floor to where it is far. Lambert's formula in double precision tells the irradiance.
#[test]
fn panels_at_every_gap_give_their_irradiance() {
    let places = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::new(-0.99, 0.0, 0.3), Vec3::Z * 1.1];
    for turn in [Mat3::IDENTITY, Mat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, -0.4)] {
        for place in places {
            for gap in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0] {
                // A turned panel is only as flat and level as single floats are.
                if gap < 1e-6 && turn != Mat3::IDENTITY {
                    continue;
                }
                let emitters: Vec<EmissiveTriangle> = quad(0, 0.3, 0.0, 2.0)
                    .into_iter()
                    .map(|t| {
                        let vertices = t.vertices.map(|v| turn * (v - 0.3 * place));
                        let normal = turn * t.geometric_normal;
                        EmissiveTriangle {
                            geometric_normal: normal,
                            ..triangle(0, t.triangle, vertices, 2.0, false)
                        }
                    })
                    .collect();
                let normal = turn * Vec3::Y;
                let point = -gap * normal;
                let truth: f64 = emitters.iter().map(|t| irradiance_of(t, point, normal)).sum();
                if truth <= 1e-4 {
                    continue;
                }
                let lights = Lights::build(emitters, &[], &DARK);
                for given in [Some(normal), None] {
                    let z = irradiance_z(&lights, point, normal, given, truth, 20_000);
                    assert!(z.abs() < 4.0, "{place}, gap {gap}, {given:?}: z = {z}");
                }
            }
        }
    }
}

/// Chosen at one point and seen from another, lights give what they give there, whatever the two points are: near and far
/// emitters, an environment, few and many punctual lights, few and many emitters.
#[test]
fn lights_chosen_elsewhere_give_their_irradiance() {
    let environment = EnvironmentDescription::Constant(Vec3::splat(0.25));
    let spot = |x: f32| PunctualLight {
        kind: PunctualKind::Spot { inner: 0.5, outer: 1.5 },
        ..point_light(Vec3::new(x, 2.0, 0.3), 4.0)
    };
    let places = [
        (Vec3::ZERO, Vec3::new(0.02, -0.1, 0.0)),
        (Vec3::new(0.1, 0.0, 0.0), Vec3::new(-0.3, 0.2, 0.5)),
        (Vec3::new(0.0, 0.9, 0.0), Vec3::new(0.3, 0.0, -0.2)),
        (Vec3::new(0.0, 0.93, 0.2), Vec3::new(0.0, 0.7, 0.0)),
        (Vec3::new(0.1, 0.3, 0.2), Vec3::new(0.0, 0.99, 0.0)),
    ];
    for many in [1, 40] {
        let mut emitters = quad(3, 0.5, 1.0, 2.0);
        let mut punctual = vec![sun(0.5)];
        for i in 0..many {
            let x = i as f32 / many as f32;
            punctual.push(spot(x));
            let vertices = [Vec3::new(x, 1.2, 3.0), Vec3::new(x + 0.02, 1.2, 3.0), Vec3::new(x, 1.2, 3.4)];
            emitters.push(triangle(4, i, vertices, 5.0, true));
        }
        for (here, chosen_at) in places {
            let normal = Vec3::Y;
            let of_punctual = punctual.iter().filter_map(|l| punctual::irradiance(l, here));
            let truth = 0.25 * std::f64::consts::PI
                + emitters.iter().map(|t| irradiance_of(t, here, normal)).sum::<f64>()
                + of_punctual.map(|p| f64::from(p.irradiance.x * p.direction.y.max(0.0))).sum::<f64>();
            let lights = Lights::build(emitters.clone(), &punctual, &environment);
            let anchor = Anchor::at(chosen_at, None);
            let mut rng = SmallRng::new(21);
            let mut estimate = Estimate::default();
            for _ in 0..400_000 {
                let chosen = lights.sample_at(&anchor, rng.f32(), rng.vec2());
                let seen = chosen.and_then(|l| lights.seen_from(&l, chosen_at, here));
                estimate.add(seen.map_or(0.0, |s| {
                    let pdf = lights.density_at(&anchor, &s.point, here);
                    assert!((pdf - s.pdf).abs() < 2e-3 * s.pdf, "{pdf} {s:?}");
                    let towards = lights.direction_to(&s.point, here).expect("a direction");
                    assert!(towards.distance(s.direction) < 1e-5);
                    f64::from(s.radiance.x * normal.dot(s.direction).max(0.0) / s.pdf)
                }));
            }
            let z = estimate.z(truth);
            let (mean, error) = (estimate.mean(), estimate.standard_error());
            println!("{many}, {here} from {chosen_at}: {mean} ± {error}, expected {truth}: z {z}");
            assert!(z.abs() < 4.0, "{many}, {here} from {chosen_at}: z = {z}");
        }
    }
}
