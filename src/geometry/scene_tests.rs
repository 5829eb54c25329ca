//! Instances against the same triangles in world space, similarities, and slabs of every size.

use super::shapes::{Random, cuboid, merge, place, sphere};
use super::{GeometryError, Hit, MeshGeometry, Ray, SceneGeometry, Similarity, offset_origin};
use glam::{Affine3A, DVec3, Mat3, Mat3A, Quat, Vec3};

#[test]
fn slabs_of_every_thickness_keep_what_is_inside() {
    for thickness in [1.0e-6_f32, 1.0e-3, 1.0, 1.0e3] {
        for turn in [
            Quat::IDENTITY,
            Quat::from_rotation_x(0.7),
            Quat::from_rotation_z(1.1) * Quat::from_rotation_y(2.0),
        ] {
            // Ten times as wide as thick, one face through the origin.
            let wide = 5.0 * thickness;
            let (positions, triangles) =
                cuboid(Vec3::new(-wide, 0.0, -wide), Vec3::new(wide, thickness, wide));
            let place = Affine3A::from_rotation_translation(turn, Vec3::new(0.1, -0.2, 0.3) * thickness);
            let scene = SceneGeometry::build(vec![(positions, triangles)], &[(0, place)]).unwrap();
            let mut random = Random(13);
            for _ in 0..20_000 {
                let local = Vec3::new(2.0 * random.unit() - 1.0, 0.5, 2.0 * random.unit() - 1.0) * thickness;
                let ray = Ray::new(place.transform_point3(local), random.direction());
                let hit = scene.intersect(&ray).expect("the slab is closed");
                let s = scene.surface(&hit);
                // Back in: must leave through another face, after a distance of the slab's order.
                let mut back = random.direction();
                if back.dot(s.geometric_normal) > 0.0 {
                    back = -back;
                }
                let inside = Ray::new(offset_origin(s.position, s.error, s.geometric_normal, back), back);
                let out = scene.intersect(&inside).expect("the ray goes in");
                let other = scene.surface(&out).geometric_normal;
                assert!(other.dot(s.geometric_normal) < 0.5, "the same face is found again at {}", out.t);
                // On: nothing is there.
                let leave = Ray::new(offset_origin(s.position, s.error, s.geometric_normal, -back), -back);
                assert!(!scene.occluded(&leave), "outside there is nothing");
                // The offset is far below any length of the slab.
                assert!(inside.origin.distance(s.position) < 1.0e-4 * thickness);
            }
        }
    }
}

#[test]
fn transforms_are_sorted_into_similar_affine_and_singular() {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.5);
    let similar =
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.37), turn, Vec3::new(1.0, 2.0, 3.0));
    let mirrored = Affine3A::from_scale_rotation_translation(Vec3::new(-2.0, 2.0, 2.0), turn, Vec3::ONE);
    let stretched = Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 1.001, 1.0), turn, Vec3::ONE);
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let broken = Affine3A::from_mat3(Mat3::from_diagonal(Vec3::new(1.0, f32::NAN, 1.0)));
    let similarity = Similarity::from_affine(&similar).unwrap();
    assert!((similarity.scale - 0.37).abs() < 1.0e-7 && !similarity.mirrors());
    assert!(Similarity::from_affine(&mirrored).unwrap().mirrors());
    assert!(Similarity::from_affine(&stretched).is_none());
    let mesh = sphere(1, 0.0, 1);
    let build =
        |transform| SceneGeometry::build(vec![mesh.clone()], &[(0, Affine3A::IDENTITY), (0, transform)]);
    assert_eq!(build(similar).unwrap().geometry_count(), 1);
    assert_eq!(build(mirrored).unwrap().geometry_count(), 1);
    assert_eq!(build(stretched).unwrap().geometry_count(), 2);
    for bad in [flat, broken] {
        assert_eq!(build(bad).err(), Some(GeometryError::SingularTransform { instance: 1 }));
    }
    let none = SceneGeometry::build(Vec::new(), &[(3, Affine3A::IDENTITY)]).err();
    assert_eq!(none, Some(GeometryError::NoSuchMesh { instance: 0, mesh: 3, count: 0 }));
    let empty = SceneGeometry::build(Vec::new(), &[]).unwrap();
    assert!(empty.bounds().is_empty() && empty.intersect(&Ray::new(Vec3::ZERO, Vec3::X)).is_none());
}

#[test]
fn instances_answer_like_the_mesh_in_world_space() {
    let mesh = sphere(3, 0.3, 17);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.5);
    let transforms = [
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), turn, Vec3::new(-2.0, 0.0, 0.0)),
        Affine3A::from_scale_rotation_translation(Vec3::new(0.4, 0.4, -0.4), turn, Vec3::ZERO),
        Affine3A::from_scale_rotation_translation(Vec3::new(0.9, -0.2, 0.5), turn, Vec3::new(2.0, 0.0, 0.0)),
        Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::Z))
            * Affine3A::from_translation(Vec3::Y * 3.0),
    ];
    let instances: Vec<_> = transforms.iter().map(|&t| (0, t)).collect();
    let scene = SceneGeometry::build(vec![mesh.clone()], &instances).unwrap();
    assert_eq!(scene.geometry_count(), 3);
    let count = mesh.1.len() as u32;
    let world = transforms.iter().fold((Vec::new(), Vec::new()), |all, t| {
        merge(all, (mesh.0.iter().map(|&p| t.transform_point3(p)).collect(), mesh.1.clone()))
    });
    let flat = MeshGeometry::build(&world.0, &world.1);
    let mut random = Random(18);
    let (mut hits, mut all) = (0, Vec::new());
    for _ in 0..20_000 {
        let ray = Ray::new(4.0 * random.cube(), random.direction());
        let (a, b) = (scene.intersect(&ray), flat.intersect(&ray));
        assert_eq!(a.is_some(), b.is_some());
        assert_eq!(scene.occluded(&ray), a.is_some());
        let (Some(a), Some(b)) = (a, b) else { continue };
        hits += 1;
        if a.instance * count + a.triangle != b.triangle {
            // Either triangle of an edge.
            assert!((a.t - b.t).abs() < 1.0e-4);
            continue;
        }
        assert!((a.t - b.t).abs() < 1.0e-4 && (a.u - b.u).abs() < 1.0e-2);
        let s = scene.surface(&a);
        let q = flat.point(b.triangle, b.u, b.v).0;
        assert!(s.position.distance(q) < 1.0e-4);
        // The front is where glTF says: the mesh's outside, also under a mirror.
        let mirrored = transforms[a.instance as usize].matrix3.determinant() < 0.0;
        let winding = flat.geometric_normal(b.triangle) * if mirrored { -1.0 } else { 1.0 };
        assert!(s.geometric_normal.dot(winding) > 0.999);
        assert!(s.geometric_normal.is_normalized());
        assert_eq!(scene.intersect_instance(a.instance, &ray), Some(a));
        all.clear();
        scene.visit_hits_of(a.instance, &ray, |hit| all.push(hit));
        let point = |hit: &Hit| (hit.t, hit.triangle, hit.u, hit.v);
        assert_eq!(all.iter().min_by(|a, b| a.t.total_cmp(&b.t)).map(point), Some(point(&a)));
        // All crossings of a closed object are pairs, apart from rays through an edge.
        assert!(all.len() % 2 == usize::from(s.geometric_normal.dot(ray.direction) > 0.0) || all.len() > 1);
    }
    assert!(hits > 1000);
}

#[test]
fn similarities_invert_within_their_error() {
    let mut random = Random(19);
    for _ in 0..20_000 {
        let scale = 10.0_f32.powf(6.0 * random.unit() - 3.0) * if random.unit() < 0.5 { -1.0 } else { 1.0 };
        let turn = Quat::from_axis_angle(random.direction(), 6.0 * random.unit());
        let shift = random.cube() * 10.0_f32.powf(6.0 * random.unit() - 3.0);
        let affine = Affine3A { matrix3: Mat3A::from_quat(turn) * scale, translation: shift.into() };
        let map = Similarity::from_affine(&affine).unwrap();
        let p = random.cube();
        let (q, error) = map.point_with_error(p, Vec3::ZERO);
        let rotation = map.rotation.as_dmat3();
        let truth = rotation * (p.as_dvec3() * f64::from(map.scale)) + shift.as_dvec3();
        assert!((q.as_dvec3() - truth).abs().cmple(error.as_dvec3()).all());
        let back: DVec3 = map.inverse_point(q).as_dvec3() - p.as_dvec3();
        let back = (rotation * back * f64::from(map.scale)).abs();
        assert!(back.cmple(error.as_dvec3()).all(), "{back} above {error}");
        let n = random.direction();
        assert!((map.inverse_direction(map.direction(n)) - n).length() < 1.0e-6);
    }
}

#[test]
fn meshes_far_from_their_origin_get_their_digits_back() {
    let (positions, triangles) = place(sphere(3, 0.3, 25), 1.0e-3, Vec3::new(1.0, -2.0, 0.0));
    let turn = Quat::from_rotation_y(0.5);
    let maps = [
        Affine3A::IDENTITY,
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), turn, Vec3::new(1.0, 2.0, 3.0)),
        Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 1.0, 1.5), turn, Vec3::new(1.0, 2.0, 3.0)),
    ];
    for map in maps {
        let scene = SceneGeometry::build(vec![(positions.clone(), triangles.clone())], &[(0, map)]).unwrap();
        let (mesh, local) = (scene.mesh_of(0), scene.transform(0));
        assert!(mesh.bounds().min.abs().max_element() < 3.0e-3, "{:?}", mesh.bounds());
        for (i, t) in triangles.iter().enumerate() {
            for (corner, &vertex) in mesh.triangle(i as u32).iter().zip(t) {
                let truth = map.transform_point3(positions[vertex as usize]);
                assert!(local.point(*corner).distance(truth) < 2.0e-6);
            }
        }
        // The offset is small beside the mesh, where the world's would not be.
        let hit = mesh.intersect(&Ray::new(mesh.bounds().center(), Vec3::X)).unwrap();
        assert!(mesh.point(hit.triangle, hit.u, hit.v).1.max_element() < 2.0e-9);
    }
}

/// A square of two triangles in the plane z = `z`.
fn square(z: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |x: f32, y: f32| Vec3::new(x, y, z);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

#[test]
fn what_is_in_one_place_is_found_from_any_angle_and_what_is_apart_is_not() {
    // Three squares in one place by different transforms, one a little above; ten roundings are no gap, a hundred are.
    let turn = Quat::from_axis_angle(Vec3::new(1.0, -2.0, 0.5).normalize(), 1.1);
    let world = Affine3A::from_scale_rotation_translation(Vec3::splat(0.7), turn, Vec3::new(3.0, -1.0, 2.0));
    let twice = Affine3A::from_scale(Vec3::splat(2.0));
    let half = |(positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>)| {
        (positions.into_iter().map(|p| p * 0.5).collect(), triangles)
    };
    let gap = 100.0 * 3.0 / (1 << 24) as f32;
    let meshes = vec![square(0.0), half(square(0.0)), square(gap)];
    let placed = [(0, world), (1, world * twice), (2, world), (0, world)];
    let scene = SceneGeometry::build(meshes, &placed).unwrap();
    let mut random = Random(12);
    let mut flat = 0;
    for _ in 0..20_000 {
        let target = Vec3::new(random.cube().x, random.cube().y, 0.0);
        let local = random.direction();
        if local.z.abs() < 0.02 {
            continue;
        }
        flat += usize::from(local.z.abs() < 0.1);
        let direction = world.transform_vector3(local).normalize();
        let origin = world.transform_point3(target) - 5.0 * direction;
        let ray = Ray { t_max: f32::INFINITY, origin, direction };
        let Some(hit) = scene.intersect(&ray) else { continue };
        let found: Vec<u32> = scene.place(&hit, direction).iter().map(|(h, _)| h.instance).collect();
        let inside = |p: Vec3| p.abs().max_element() < 0.99;
        let above = target + local / local.z * gap;
        if hit.instance == 2 {
            assert_eq!(found, [2], "{local}");
        } else if inside(target) && inside(above) {
            assert!(hit.crowded);
            // Where the diagonal is met both triangles of a square may count.
            assert_eq!(found, [0, 1, 3], "{local}");
        }
    }
    assert!(flat > 1000);
}

#[test]
fn an_edge_between_triangles_is_met_once_wherever_it_is_hit() {
    // Two long triangles with a common edge, met close to its ends: both middles are far away in the same direction.
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let positions = [at(0.0, 0.0), at(10.0, 0.0), at(9.0, 0.1), at(9.0, -0.1)];
    let sheet = |turned: bool| {
        let second = if turned { [0, 1, 3] } else { [1, 0, 3] };
        (positions.to_vec(), vec![[0, 1, 2], second])
    };
    let met = |turned: bool, x: f32| {
        let scene = SceneGeometry::build(vec![sheet(turned)], &[(0, Affine3A::IDENTITY)]).unwrap();
        let ray = Ray { origin: Vec3::new(x, 0.0, 1.0), direction: Vec3::NEG_Z, t_max: f32::INFINITY };
        let hit = scene.intersect(&ray).expect("the edge is met");
        scene.place(&hit, ray.direction).len()
    };
    for x in [1e-3, 0.1, 5.0, 9.9] {
        assert_eq!(met(false, x), 1, "{x}");
        // One of them faces away: two crossings, of a sheet that is folded there.
        assert_eq!(met(true, x), 2, "{x}");
    }
}
