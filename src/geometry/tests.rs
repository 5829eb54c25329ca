//! Ray queries against double precision, and the promises of the room: watertight, scale free, deterministic.

use super::lanes::{Native, Portable};
use super::shapes::{Random, cuboid, merge, place, soup, sphere};
use super::{Aabb, MeshGeometry, MeshHit, Ray, offset_origin};
use glam::Vec3;

/// Möller & Trumbore in double precision: (t, u, v) of any crossing of the plane.
fn exact(triangle: &[Vec3; 3], ray: &Ray) -> Option<(f64, f64, f64)> {
    let [a, b, c] = triangle.map(|v| v.as_dvec3());
    let (e1, e2, d) = (b - a, c - a, ray.direction.as_dvec3());
    let p = d.cross(e2);
    let det = e1.dot(p);
    let s = ray.origin.as_dvec3() - a;
    let q = s.cross(e1);
    (det != 0.0).then(|| (e2.dot(q) / det, s.dot(p) / det, d.dot(q) / det))
}

#[test]
fn hits_agree_with_double_precision() {
    for (seed, scale, shift) in [(1, 1.0, 0.0), (2, 1.0e-6, 0.0), (3, 1.0e6, 0.0), (4, 1.0, 20.0)] {
        let shift = Vec3::splat(shift);
        let (positions, triangles) = place(soup(600, 0.3, seed), scale, shift);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let mut random = Random(seed);
        let (mut found, mut all) = (0, Vec::new());
        for _ in 0..4000 {
            let ray = Ray::new(random.cube() * scale + shift, random.direction());
            let crossings: Vec<_> = (0..600)
                .filter_map(|i| {
                    exact(&mesh.triangle(i), &ray).map(|(t, u, v)| (i, t, u, v, u.min(v).min(1.0 - u - v)))
                })
                .filter(|c| c.1 > 0.0)
                .collect();
            let closest = crossings.iter().filter(|c| c.4 > 0.0).min_by(|a, b| a.1.total_cmp(&b.1));
            // Cases that single precision may decide otherwise: near an edge (needles: relative to their width).
            let unsure = |bound: f64| crossings.iter().any(|c| c.4.abs() < 2.0e-3 && c.1 < bound);
            let hit = mesh.intersect(&ray);
            assert_eq!(mesh.occluded(&ray), hit.is_some());
            mesh.intersect_all(&ray, &mut all);
            assert_eq!(all.first().map(|h| h.t), hit.map(|h| h.t));
            assert!(all.windows(2).all(|w| w[0].t <= w[1].t));
            if unsure(f64::INFINITY) {
                continue;
            }
            assert_eq!(all.len(), crossings.iter().filter(|c| c.4 > 0.0).count());
            match (hit, closest) {
                (Some(hit), Some(&(triangle, t, u, v, _))) => {
                    found += 1;
                    assert_eq!(hit.triangle, triangle);
                    assert!((f64::from(hit.t) - t).abs() < 2.0e-3 * t, "t = {} or {t}", hit.t);
                    let p = mesh.point(triangle, hit.u, hit.v).0.as_dvec3();
                    let [a, b, c] = mesh.triangle(triangle).map(|v| v.as_dvec3());
                    let q = a + u * (b - a) + v * (c - a);
                    let place = f64::from(shift.x) + f64::from(scale);
                    assert!(p.distance(q) < 1.0e-3 * place, "{p} or {q}");
                }
                (None, None) => {}
                other => panic!("{other:?}"),
            }
        }
        assert!(found > 400, "only {found} rays hit");
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let shapes =
        [(1.0, Vec3::ZERO), (1.0e-6, Vec3::ZERO), (1.0e6, Vec3::ZERO), (1.0, Vec3::new(30.0, -7.0, 100.0))];
    let mut leaks = 0;
    for (scale, shift) in shapes {
        let (positions, triangles) = place(sphere(4, 0.3, 5), scale, shift);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let mut random = Random(6);
        for i in 0..2_500_000_u32 {
            let origin = random.cube() * (0.3 * scale) + shift;
            let direction = match i % 8 {
                0 => (positions[random.below(positions.len())] - origin).normalize(),
                1 => {
                    let [a, b, _] = mesh.triangle(random.below(triangles.len()) as u32);
                    (a + (b - a) * random.unit() - origin).normalize()
                }
                2 => [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z][random.below(6)],
                _ => random.direction(),
            };
            leaks += u32::from(mesh.intersect(&Ray::new(origin, direction)).is_none());
        }
    }
    assert_eq!(leaks, 0);
}

#[test]
fn rays_along_the_symmetries_of_a_box_hit_it() {
    for scale in [1.0e-6, 1.0, 1.0e6] {
        let (positions, triangles) = cuboid(Vec3::splat(-scale), Vec3::splat(scale));
        let mesh = MeshGeometry::build(&positions, &triangles);
        for code in 0..27 {
            let d = Vec3::new((code % 3) as f32, (code / 3 % 3) as f32, (code / 9) as f32) - 1.0;
            if d != Vec3::ZERO {
                let inside = mesh.intersect(&Ray::new(Vec3::ZERO, d.normalize()));
                let t = inside.map_or(f32::NAN, |h| h.t);
                assert!((t / (d.length() * scale) - 1.0).abs() < 1.0e-6, "from inside along {d}: {inside:?}");
                let outside = mesh.intersect(&Ray::new(-4.0 * scale * d, d.normalize()));
                assert!(outside.is_some(), "from outside along {d}");
            }
        }
    }
}

#[test]
fn both_kinds_of_lanes_give_the_same_bits() {
    let (positions, triangles) = merge(soup(3000, 0.2, 8), sphere(3, 0.2, 9));
    let mesh = MeshGeometry::build(&positions, &triangles);
    let mut random = Random(10);
    let (mut a, mut b): (Vec<MeshHit>, Vec<MeshHit>) = Default::default();
    for i in 0..20_000 {
        let mut direction = random.direction();
        if i % 5 == 0 {
            direction = Vec3::new(0.0, direction.x.signum(), -0.0);
        }
        let t_max = if i % 3 == 0 { 0.2 * random.unit() } else { f32::INFINITY };
        let ray = Ray { origin: random.cube(), direction, t_max };
        assert_eq!(mesh.intersect_with::<Native>(&ray), mesh.intersect_with::<Portable>(&ray));
        assert_eq!(mesh.occluded_with::<Native>(&ray), mesh.occluded_with::<Portable>(&ray));
        mesh.intersect_all_with::<Native>(&ray, &mut a);
        mesh.intersect_all_with::<Portable>(&ray, &mut b);
        assert_eq!(a, b);
        let p = 1.5 * ray.origin;
        assert_eq!(mesh.nearest_with::<Native>(p, t_max), mesh.nearest_with::<Portable>(p, t_max));
    }
}

#[test]
fn a_ray_that_leaves_a_triangle_does_not_find_it_again() {
    let mut random = Random(11);
    for round in 0..20 {
        let size = 10.0_f32.powi(round % 4 - 2);
        let shift = if round % 2 == 0 { Vec3::ZERO } else { 50.0 * random.cube() };
        let (positions, triangles) = place(soup(100, size, 12 + round as u64), 1.0, shift);
        let mesh = MeshGeometry::build(&positions, &triangles);
        for i in 0..50_000 {
            let id = random.below(100) as u32;
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let (p, error) = mesh.point(id, u, v);
            let n = mesh.geometric_normal(id);
            let mut direction = random.direction();
            if i % 4 == 0 {
                // Grazing.
                direction = (direction - direction.dot(n) * n + random.cube() * 1.0e-3).normalize();
            }
            let ray = Ray::new(offset_origin(p, error, n, direction), direction);
            let again = mesh.intersect(&ray).is_some_and(|h| h.triangle == id);
            assert!(!again, "left {:?} at {p} along {direction}", mesh.triangle(id));
        }
    }
}

#[test]
fn nearest_points_agree_with_brute_force() {
    let (positions, triangles) = soup(400, 0.3, 14);
    let mesh = MeshGeometry::build(&positions, &triangles);
    let mut random = Random(15);
    for _ in 0..2000 {
        let p = 2.0 * random.cube();
        let brute = (0..400)
            .map(|i| {
                let corners = mesh.triangle(i);
                let (u, v) = super::triangle_block::nearest_barycentrics(&corners, p);
                mesh.point(i, u, v).0.distance(p)
            })
            .fold(f32::INFINITY, f32::min);
        let found = mesh.nearest(p, f32::INFINITY).unwrap();
        assert!((found.distance - brute).abs() <= 4.0e-6 * (brute + 1.0), "{found:?}, not {brute}");
        assert!(mesh.nearest(p, 0.99 * brute).is_none());
        assert!(mesh.nearest(p, 1.01 * brute).is_some());
    }
}

#[test]
fn the_nearest_barycentrics_are_a_minimum() {
    let mut random = Random(16);
    for _ in 0..2000 {
        let corners = [random.cube(), random.cube(), random.cube()];
        let p = 2.0 * random.cube();
        let at = |u: f32, v: f32| corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
        let (u, v) = super::triangle_block::nearest_barycentrics(&corners, p);
        assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.000_001);
        let (mut a, mut b) = (random.unit(), random.unit());
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        assert!(p.distance(at(u, v)) <= p.distance(at(a, b)) + 1.0e-6);
    }
}

#[test]
fn hostile_meshes_do_no_harm() {
    let nan = f32::NAN;
    let ray = Ray::new(Vec3::new(0.1, 0.1, -1.0), Vec3::Z);
    let ask = |positions: &[Vec3], triangles: &[[u32; 3]]| {
        let mesh = MeshGeometry::build(positions, triangles);
        let mut hits = Vec::new();
        mesh.intersect_all(&ray, &mut hits);
        mesh.nearest(Vec3::ZERO, f32::INFINITY);
        mesh.contains(Vec3::splat(0.1));
        assert_eq!(mesh.occluded(&ray), mesh.intersect(&ray).is_some());
        (mesh.dropped(), hits.len())
    };
    let corner = [Vec3::ZERO, Vec3::X, Vec3::Y];
    assert_eq!(ask(&[], &[]), (0, 0));
    assert_eq!(ask(&[], &[[0, 1, 2]]), (1, 0));
    assert_eq!(ask(&corner, &[]), (0, 0));
    assert_eq!(ask(&corner, &[[0, 1, 2]]), (0, 1));
    assert_eq!(ask(&corner, &[[0, 1, 2], [0, 1, 3], [0, 0, 1], [2, 2, 2]]), (1, 1));
    assert_eq!(ask(&[Vec3::ZERO, Vec3::new(nan, 0.0, 0.0), Vec3::Y], &[[0, 1, 2]]), (1, 0));
    assert_eq!(ask(&[Vec3::ZERO, Vec3::new(0.0, f32::INFINITY, 0.0), Vec3::Y], &[[0, 1, 2]]), (1, 0));
    assert_eq!(ask(&[Vec3::ZERO, Vec3::X * 1.0e30, Vec3::Y], &[[0, 1, 2]]), (1, 0));
    ask(&[Vec3::ZERO, Vec3::X * 1.0e18, Vec3::Y * 1.0e18], &[[0, 1, 2]]);
    ask(&[Vec3::ZERO, Vec3::X * 1.0e-38, Vec3::Y * 1.0e-40], &[[0, 1, 2]]);
    // A thousand equal triangles, and sizes that grow by a factor: deep trees.
    assert_eq!(ask(&corner, &vec![[0, 1, 2]; 1000]), (0, 1000));
    let towers: Vec<Vec3> = (0..600).flat_map(|i| corner.map(|p| p * 1.13_f32.powi(i - 300))).collect();
    let triangles: Vec<[u32; 3]> = (0..600).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    ask(&towers, &triangles);
    // Points on a line.
    ask(&[Vec3::ZERO, Vec3::X, 2.0 * Vec3::X], &[[0, 1, 2]]);
    // Rays that are not what they should be.
    let (positions, triangles) = sphere(2, 0.0, 1);
    let mesh = MeshGeometry::build(&positions, &triangles);
    for bad in [Vec3::ZERO, Vec3::splat(nan), Vec3::splat(f32::INFINITY), Vec3::splat(1.0e-30)] {
        mesh.intersect(&Ray::new(Vec3::ZERO, bad));
        mesh.intersect(&Ray::new(bad, Vec3::X));
        mesh.occluded(&Ray { origin: bad, direction: bad, t_max: nan });
        mesh.nearest(bad, nan);
    }
    assert!(mesh.intersect(&Ray { t_max: -1.0, ..ray }).is_none());
}

#[test]
fn builds_are_deterministic_and_boxes_are_exact() {
    let (positions, triangles) = sphere(5, 0.1, 20);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| MeshGeometry::build(&positions, &triangles))
    };
    let (a, b) = (build(1), build(3));
    assert_eq!(a.bounds(), Aabb::from_points(&positions));
    let mut random = Random(21);
    let (mut in_a, mut in_b) = (Vec::new(), Vec::new());
    for _ in 0..2000 {
        let ray = Ray::new(2.0 * random.cube(), random.direction());
        assert_eq!(a.intersect(&ray), b.intersect(&ray));
        a.intersect_all(&ray, &mut in_a);
        b.intersect_all(&ray, &mut in_b);
        assert_eq!(in_a, in_b);
    }
    assert!(a.same_layout(&b));
}

#[test]
fn positions_that_no_triangle_uses_are_not_kept() {
    let (mut positions, mut triangles) = sphere(2, 0.2, 26);
    triangles[7] = [0, 1, u32::MAX];
    let few = MeshGeometry::build(&positions, &triangles);
    positions.resize(100_000, Vec3::ONE);
    let many = MeshGeometry::build(&positions, &triangles);
    assert_eq!((few.dropped(), many.dropped()), (1, 1));
    assert!(many.memory() < 2 * few.memory(), "{} bytes for {}", many.memory(), few.memory());
    for i in 0..triangles.len() as u32 {
        assert_eq!(few.triangle(i), many.triangle(i));
    }
    let mut random = Random(27);
    for _ in 0..2000 {
        let ray = Ray::new(2.0 * random.cube(), random.direction());
        assert_eq!(few.intersect(&ray), many.intersect(&ray));
    }
}

#[test]
fn points_are_inside_where_they_should_be() {
    let outer = cuboid(Vec3::splat(-1.0), Vec3::splat(1.0));
    let inner = super::shapes::reverse(cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)));
    let shell = merge(outer, inner);
    let mesh = MeshGeometry::build(&shell.0, &shell.1);
    let mut random = Random(22);
    for _ in 0..20_000 {
        let p = 1.3 * random.cube();
        let reach = p.abs().max_element();
        if (reach - 1.0).abs() > 1.0e-5 && (reach - 0.5).abs() > 1.0e-5 {
            assert_eq!(mesh.contains(p), reach < 1.0 && reach > 0.5, "{p}");
        }
    }
    // On symmetry planes, where axis-parallel rays would graze.
    assert!(mesh.contains(Vec3::new(0.75, 0.0, 0.0)) && !mesh.contains(Vec3::ZERO));
}

#[test]
fn walks_that_bounce_inside_stay_inside() {
    for (scale, shift, allowed) in [(1.0, Vec3::ZERO, 0), (1.0e5, Vec3::ZERO, 0), (1.0e-3, Vec3::ONE, 200)] {
        let (positions, triangles) = place(sphere(4, 0.3, 23), scale, shift);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let mut random = Random(24);
        let (mut ray, mut leaks) = (Ray::new(shift, Vec3::X), 0);
        for _ in 0..300_000 {
            let outwards = |hit: &MeshHit| mesh.geometric_normal(hit.triangle).dot(ray.direction) > 0.0;
            let Some(hit) = mesh.intersect(&ray).filter(outwards) else {
                leaks += 1;
                ray = Ray::new(shift, random.direction());
                continue;
            };
            let n = mesh.geometric_normal(hit.triangle);
            let (p, error) = mesh.point(hit.triangle, hit.u, hit.v);
            let inwards = (random.direction() - n).normalize();
            ray = Ray::new(offset_origin(p, error, n, inwards), inwards);
        }
        // Where coordinates have few digits left (a millimetre at a metre), a point next to a sharp edge can be rounded
        // or offset to the other side of the neighbouring triangle. Nothing local can tell.
        assert!(leaks <= allowed, "{leaks} of 300000 bounces leave at scale {scale} from {shift}");
    }
}
