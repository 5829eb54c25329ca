//! Choosing lights: estimates against closed forms, densities against sampling.

use std::f32::consts::PI;
use std::sync::Arc;

use super::*;
use crate::light::emitter::{EmissionField, EmissiveRadiance};
use crate::sampling::{SmallRng, SphericalTriangle, statistics::Estimate, warp};
use crate::scene::PunctualKind;

pub const DARK: EnvironmentDescription = EnvironmentDescription::Constant(Vec3::ZERO);

pub fn triangle(
    instance: u32,
    index: u32,
    vertices: [Vec3; 3],
    radiance: f32,
    double_sided: bool,
) -> EmissiveTriangle {
    let cross = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
    let sides = if double_sided { 2.0 } else { 1.0 };
    EmissiveTriangle {
        instance,
        triangle: index,
        vertices,
        geometric_normal: cross.normalize_or(Vec3::Y),
        double_sided,
        power: Vec3::splat(radiance * 0.5 * cross.length() * PI * sides),
        radiance: EmissiveRadiance::Constant(Vec3::splat(radiance)),
    }
}

/// A square of half size `s` at height `h`, shining down.
pub fn quad(instance: u32, s: f32, h: f32, radiance: f32) -> Vec<EmissiveTriangle> {
    let [a, b, c, d] = [[-s, -s], [s, -s], [s, s], [-s, s]].map(|[x, z]| Vec3::new(x, h, z));
    vec![triangle(instance, 0, [a, b, c], radiance, false), triangle(instance, 1, [a, c, d], radiance, false)]
}

/// A latitude–longitude sphere of `n × 2n` facets shining outwards, with slightly different radiances.
pub fn ball(center: Vec3, radius: f32, n: usize) -> Vec<EmissiveTriangle> {
    let at = |i: usize, j: usize| {
        let (theta, phi) = (PI * i as f32 / n as f32, PI * j as f32 / n as f32);
        center + radius * Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        for v in [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]] {
            let cross = (v[1] - v[0]).cross(v[2] - v[0]);
            if cross.length() > 1e-6 {
                triangles.push(triangle(4, triangles.len() as u32 * 3, v, 1.0 + (j % 3) as f32, false));
            }
        }
    }
    triangles
}

/// Irradiance of an unoccluded triangle wholly above the horizon (Lambert's formula), zero from behind.
pub fn irradiance_of(t: &EmissiveTriangle, point: Vec3, normal: Vec3) -> f64 {
    let EmissiveRadiance::Constant(radiance) = t.radiance else { panic!("constant emitters only") };
    let side = t.geometric_normal.dot(point - t.vertices[0]);
    if side <= 0.0 && !t.double_sided {
        return 0.0;
    }
    let v = t.vertices.map(|v| (v.as_dvec3() - point.as_dvec3()).normalize());
    let n = normal.as_dvec3();
    let sum: f64 = (0..3)
        .map(|i| {
            let (a, b) = (v[i], v[(i + 1) % 3]);
            let cross = a.cross(b);
            cross.length().atan2(a.dot(b)) * cross.normalize().dot(n)
        })
        .sum();
    0.5 * sum.abs() * f64::from(radiance.x)
}

pub fn point_light(position: Vec3, intensity: f32) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(intensity),
        position,
        direction: Vec3::NEG_Y,
        range: None,
        kind: PunctualKind::Point,
    }
}

pub fn sun(irradiance: f32) -> PunctualLight {
    let direction = Vec3::new(0.6, -0.8, 0.0);
    PunctualLight { direction, kind: PunctualKind::Directional, ..point_light(Vec3::ZERO, irradiance) }
}

/// z of the estimated irradiance at a point against the truth; checks every sample on the way.
pub fn irradiance_z(
    lights: &Lights,
    point: Vec3,
    normal: Vec3,
    given: Option<Vec3>,
    truth: f64,
    n: u32,
) -> f64 {
    let mut rng = SmallRng::new(9);
    let mut estimate = Estimate::default();
    for _ in 0..n {
        let sample = lights.sample(point, given, rng.f32(), rng.vec2());
        estimate.add(sample.map_or(0.0, |s| {
            assert!((s.direction.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0 && s.pdf.is_finite());
            let pdf = lights.density_at(&Anchor::at(point, given), &s.point, point);
            assert!((pdf - s.pdf).abs() < 2e-3 * s.pdf, "{pdf} {s:?}");
            f64::from(s.radiance.x * normal.dot(s.direction).max(0.0) / s.pdf)
        }));
    }
    let z = estimate.z(truth);
    println!("{} ± {} for {truth}: z = {z}", estimate.mean(), estimate.standard_error());
    z
}

#[test]
fn quads_far_and_near_give_their_irradiance() {
    for (s, h) in [(0.5, 100.0), (0.5, 3.0), (0.5, 1.0), (1.0, 0.3), (1.0, 0.01), (5.0, 0.001)] {
        let emitters = quad(0, s, h, 2.0);
        let point = Vec3::new(0.1, 0.0, -0.2);
        for normal in [Vec3::Y, Vec3::new(0.0, 0.8, 0.6)] {
            // Only points whose horizon the quad does not cross have the simple closed form.
            let above = emitters.iter().flat_map(|t| t.vertices).all(|v| normal.dot(v - point) > 0.0);
            if !above {
                continue;
            }
            let truth: f64 = emitters.iter().map(|t| irradiance_of(t, point, normal)).sum();
            let lights = Lights::build(emitters.clone(), &[], &DARK);
            for given in [Some(normal), None] {
                let z = irradiance_z(&lights, point, normal, given, truth, 60_000);
                assert!(z.abs() < 4.0, "half size {s}, height {h}, {given:?}: z = {z}");
            }
        }
    }
}

#[test]
fn emission_is_from_the_front_or_from_both_sides() {
    let below = Vec3::new(0.0, -1.0, 0.0);
    let mut up = triangle(0, 0, [Vec3::ZERO, Vec3::Z, Vec3::X], 1.0, false);
    assert!(up.geometric_normal.y > 0.0);
    let one = Lights::build(vec![up.clone()], &[], &DARK);
    assert!(one.sample(below, None, 0.3, Vec2::splat(0.4)).is_none());
    assert_eq!(one.emitter_pdf(EmitterId(0), below, None, Vec3::new(0.2, 0.0, 0.2)), 0.0);
    up.double_sided = true;
    let truth = irradiance_of(&up, below, Vec3::Y);
    let both = Lights::build(vec![up.clone()], &[], &DARK);
    let z = irradiance_z(&both, below, Vec3::Y, Some(Vec3::Y), truth, 40_000);
    assert!(z.abs() < 4.0, "z = {z}");
    // A mirrored instance: the winding says up, the normal says down.
    up.double_sided = false;
    up.geometric_normal = Vec3::NEG_Y;
    let mirrored = Lights::build(vec![up], &[], &DARK);
    assert!(mirrored.sample(below, None, 0.3, Vec2::splat(0.4)).is_some());
    assert!(mirrored.sample(-below, None, 0.3, Vec2::splat(0.4)).is_none());
    // Surfaces that look away from a light do not choose it.
    assert!(mirrored.sample(below, Some(Vec3::NEG_Y), 0.3, Vec2::splat(0.4)).is_none());
}

#[test]
fn many_emitters_give_the_sum_of_theirs() {
    let emitters = ball(Vec3::new(0.0, 2.0, 0.0), 0.7, 10);
    assert!(emitters.len() > FEW);
    for point in [Vec3::ZERO, Vec3::new(3.0, 0.5, 0.0), Vec3::new(0.0, 1.2, 0.0)] {
        let normal = (Vec3::new(0.0, 2.0, 0.0) - point).normalize();
        let truth: f64 = emitters.iter().map(|t| irradiance_of(t, point, normal)).sum();
        let lights = Lights::build(emitters.clone(), &[], &DARK);
        for given in [Some(normal), None] {
            let z = irradiance_z(&lights, point, normal, given, truth, 300_000);
            assert!(z.abs() < 4.0, "{point}: z = {z}");
        }
    }
}

#[test]
fn mixed_lights_add_up() {
    let environment = EnvironmentDescription::Constant(Vec3::splat(0.25));
    let punctual = [point_light(Vec3::new(0.0, 2.0, 0.0), 4.0), sun(0.5)];
    let (point, normal) = (Vec3::ZERO, Vec3::Y);
    let emitters = quad(3, 0.5, 1.5, 2.0);
    let quad_part: f64 = emitters.iter().map(|t| irradiance_of(t, point, normal)).sum();
    let truth = 0.25 * std::f64::consts::PI + 4.0 / 4.0 + 0.5 * 0.8 + quad_part;
    for many in [false, true] {
        let mut punctual = punctual.to_vec();
        let mut truth = truth;
        if many {
            for i in 0..20 {
                punctual.push(point_light(Vec3::new(0.0, 4.0, i as f32), 1.0));
                let d2 = 16.0 + f64::from(i * i);
                truth += 4.0 / d2.powf(1.5);
            }
        }
        let lights = Lights::build(emitters.clone(), &punctual, &environment);
        assert!(lights.has_delta() && lights.has_emitters() && !lights.is_empty());
        for given in [Some(normal), None] {
            let z = irradiance_z(&lights, point, normal, given, truth, 400_000);
            assert!(z.abs() < 4.0, "many {many}, {given:?}: z = {z}");
        }
    }
}

#[test]
fn hundreds_of_punctual_lights_give_the_sum_of_theirs() {
    let mut rng = SmallRng::new(11);
    let mut lights: Vec<PunctualLight> = (0..300)
        .map(|i| {
            let position = Vec3::new(rng.f32() - 0.5, 0.3 + rng.f32(), rng.f32() - 0.5) * 6.0;
            let kind = match i % 3 {
                0 => PunctualKind::Spot { inner: 0.2, outer: 0.3 + rng.f32() },
                _ => PunctualKind::Point,
            };
            let range = (i % 5 == 0).then(|| 2.0 + 4.0 * rng.f32());
            let direction = (warp::uniform_sphere(rng.vec2()) - Vec3::Y).normalize();
            PunctualLight { kind, range, direction, ..point_light(position, 0.2 + rng.f32()) }
        })
        .collect();
    for suns in [0, 2, 40] {
        for i in 0..suns {
            let direction = Vec3::new(0.6 * (i as f32).sin(), -0.8, 0.6 * (i as f32).cos());
            lights.push(PunctualLight { direction, ..sun(0.01 + 0.02 * i as f32) });
        }
        let all = Lights::build(Vec::new(), &lights, &DARK);
        for (point, normal) in [(Vec3::ZERO, Vec3::Y), (Vec3::new(2.0, 1.5, 0.5), Vec3::new(0.6, 0.0, 0.8))] {
            let truth: f64 = lights
                .iter()
                .filter_map(|l| punctual::irradiance(l, point))
                .map(|p| f64::from(p.irradiance.x * normal.dot(p.direction).max(0.0)))
                .sum();
            for given in [Some(normal), None] {
                let z = irradiance_z(&all, point, normal, given, truth, 150_000);
                assert!(z.abs() < 4.0, "{suns} suns, {point}, {given:?}: z = {z}");
            }
        }
    }
}

#[test]
fn pdf_of_all_lights_integrates_to_one() {
    // Uniform directions: the environment's pdf everywhere, plus that of each emitter that the ray meets.
    let environment = EnvironmentDescription::Constant(Vec3::splat(0.5));
    let emitters = quad(0, 1.0, 0.8, 2.0);
    let lights = Lights::build(emitters.clone(), &[], &environment);
    let point = Vec3::new(0.3, 0.0, 0.2);
    for normal in [None, Some(Vec3::Y), Some(Vec3::new(0.6, 0.8, 0.0))] {
        let mut rng = SmallRng::new(4);
        let mut total = Estimate::default();
        for _ in 0..400_000 {
            let d = warp::uniform_sphere(rng.vec2());
            let mut pdf = lights.environment_pdf(point, normal, d);
            for (i, t) in emitters.iter().enumerate() {
                let [a, b, c] = t.vertices.map(|v| v - point);
                let sides = [a.cross(b).dot(d), b.cross(c).dot(d), c.cross(a).dot(d)];
                let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
                if inside && d.dot(a + b + c) > 0.0 {
                    let position = point + d * (0.8 / d.y);
                    pdf += lights.emitter_pdf(EmitterId(i as u32), point, normal, position);
                }
            }
            total.add(f64::from(pdf * warp::SPHERE));
        }
        assert!(total.z(1.0).abs() < 4.0, "{normal:?}: z = {}", total.z(1.0));
    }
}

#[test]
fn textured_emission_is_looked_up_where_the_sample_is() {
    struct Ramp;
    impl EmissionField for Ramp {
        fn radiance(&self, instance: u32, triangle: u32, b: Vec2, cos: f32) -> Vec3 {
            assert_eq!((instance, triangle), (2, 5));
            assert!(cos > 0.0 && cos <= 1.0 + 1e-6, "{cos}");
            Vec3::new(b.x, b.y, 1.0 - b.x - b.y)
        }
    }
    let vertices = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(2.0, 0.3, -1.0), Vec3::new(0.0, 0.0, 1.5)];
    let mut emitter = triangle(2, 5, vertices, 1.0 / 3.0, true);
    emitter.radiance = EmissiveRadiance::Textured(Arc::new(Ramp));
    let lights = Lights::build(vec![emitter], &[], &DARK);
    for (point, tolerance) in [(Vec3::new(0.1, 1.0, 0.0), 1e-4), (Vec3::new(0.0, 80.0, 0.0), 1e-3)] {
        let mut rng = SmallRng::new(2);
        for _ in 0..2000 {
            let s = lights.sample(point, None, rng.f32(), rng.vec2()).unwrap();
            let position = point + s.distance * s.direction;
            let b = s.radiance;
            let expected = b.z * vertices[0] + b.x * vertices[1] + b.y * vertices[2];
            assert!((position - expected).length() < tolerance, "{position} {expected}");
        }
    }
}

#[test]
fn ids_are_found_with_and_without_gaps() {
    let flat = |instance, index| triangle(instance, index, [Vec3::ZERO, Vec3::X, Vec3::Y], 1.0, false);
    let mut emitters = vec![flat(7, 9), flat(2, 4), flat(2, 5), flat(2, 6), flat(7, 2), flat(7, 3)];
    emitters.push(triangle(7, 4, [Vec3::ZERO; 3], 1.0, false));
    emitters.push(EmissiveTriangle { power: Vec3::ZERO, ..flat(8, 0) });
    let lights = Lights::build(emitters, &[], &DARK);
    assert_eq!(lights.emitter_count(), 6);
    for (instance, index) in [(2, 4), (2, 5), (2, 6), (7, 2), (7, 3), (7, 9)] {
        let found = lights.emitter(lights.emitter_id(instance, index).unwrap()).unwrap();
        assert_eq!((found.instance, found.triangle), (instance, index));
    }
    for (instance, index) in [(0, 0), (2, 3), (2, 7), (7, 4), (7, 5), (7, 10), (8, 0), (u32::MAX, 0)] {
        assert_eq!(lights.emitter_id(instance, index), None);
    }
    let none = Lights::build(vec![], &[], &DARK);
    assert!(none.is_empty() && none.emitter_id(0, 0).is_none());
    assert!(none.sample(Vec3::ZERO, None, 0.5, Vec2::splat(0.5)).is_none());
    assert_eq!(none.environment_pdf(Vec3::ZERO, None, Vec3::Y), 0.0);
}

#[test]
fn far_importance_meets_the_near_one() {
    // Both sides of the switch from the solid angle to the flat-patch estimate.
    let vertices = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 1.0)];
    let emitter = Emitter::new(triangle(0, 0, vertices, 1.0, true)).unwrap();
    let centroid = (vertices[0] + vertices[1] + vertices[2]) / 3.0;
    for direction in [Vec3::Y, Vec3::new(0.8, 0.6, 0.0)] {
        let point = centroid + direction * 6.0 * emitter.area.sqrt();
        let exact = SphericalTriangle::new(vertices, point).solid_angle;
        assert!((emitter.importance(point, None) / exact - 1.0).abs() < 0.1);
        let near = centroid + direction * 2.0;
        let exact = SphericalTriangle::new(vertices, near).solid_angle;
        assert!((emitter.importance(near, None) / exact - 1.0).abs() < 1e-5);
    }
}
