//! Closed-mesh analysis on solids, sheets, shells and broken files.

use super::shapes::{Random, Triangles, cuboid, merge, place, reverse, soup, sphere};
use super::{MeshGeometry, NO_COMPONENT, Topology};
use glam::Vec3;

fn analyse(mesh: &Triangles) -> Topology {
    Topology::analyse(&MeshGeometry::build(&mesh.0, &mesh.1))
}

/// Every corner its own vertex, as a file with flat normals has it.
fn split(mesh: &Triangles) -> Triangles {
    let positions = mesh.1.iter().flatten().map(|&i| mesh.0[i as usize]).collect();
    (positions, (0..mesh.1.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Turns over what the analysis says, and expects it to be content then.
fn fixed(mut mesh: Triangles) -> Topology {
    let flips = analyse(&mesh).flips;
    for (t, _) in mesh.1.iter_mut().zip(flips).filter(|(_, flip)| *flip) {
        t.swap(1, 2);
    }
    let topology = analyse(&mesh);
    assert!(!topology.needs_flips() && topology.components.iter().all(|c| !c.inside_out));
    topology
}

/// Two tetrahedra that share an edge of positions: merged by position, four triangles meet there.
#[test]
fn solids_that_touch_are_closed() {
    let positions = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
    let first = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let second = first.map(|t: [u32; 3]| t.map(|i| if i < 2 { i } else { i + 2 }));
    let triangles = [first, second].concat();
    let mesh = MeshGeometry::build(&positions, &triangles);
    let found = Topology::analyse(&mesh);
    assert!(found.is_closed() && found.components.len() == 2);
    let apart = second.map(|t| t.map(|i| i + 100));
    let known = Topology::analyse_merged(&mesh, &[first, apart].concat());
    assert!(known.is_closed() && known.components.len() == 2);
    assert!(known.components.iter().all(|c| (c.signed_volume.abs() - 1.0 / 6.0).abs() < 1e-6));
}

#[test]
fn a_solid_is_closed_whatever_its_indices() {
    for mesh in [cuboid(Vec3::ZERO, Vec3::ONE), split(&cuboid(Vec3::ZERO, Vec3::ONE))] {
        let topology = analyse(&mesh);
        let [c] = &topology.components[..] else { panic!("{topology:?}") };
        assert!(topology.is_closed() && c.closable && !c.inside_out && !topology.needs_flips());
        assert_eq!((c.triangles, c.open_edges, c.non_manifold_edges, c.inconsistent_edges), (12, 0, 0, 0));
        assert!((c.signed_volume - 1.0).abs() < 1.0e-12 && c.leaks.is_empty());
    }
    // Zero has two signs.
    let signed = cuboid(Vec3::ZERO, Vec3::ONE);
    let mut signed = split(&signed);
    let mut random = Random(1);
    for p in &mut signed.0 {
        if random.unit() < 0.5 {
            *p = Vec3::select(p.cmpeq(Vec3::ZERO), Vec3::splat(-0.0), *p);
        }
    }
    assert!(analyse(&signed).is_closed());
}

#[test]
fn inside_out_solids_are_noticed_and_can_be_turned() {
    let mesh = reverse(sphere(2, 0.1, 2));
    let topology = analyse(&mesh);
    assert!(
        topology.is_closed()
            && topology.components[0].inside_out
            && topology.components[0].signed_volume < 0.0
    );
    assert!(topology.flips.iter().all(|&f| f));
    assert!(fixed(mesh).components[0].signed_volume > 0.0);
    // A mesh whose fronts are clockwise.
    let mesh = sphere(2, 0.1, 2);
    let reversed = Topology::analyse(&MeshGeometry::build_oriented(&mesh.0, &mesh.1, true));
    assert!(reversed.components[0].inside_out && reversed.components[0].signed_volume < 0.0);
}

#[test]
fn cavities_and_solids_in_solids_are_right_as_they_are() {
    let ball = |radius: f32| place(sphere(2, 0.0, 3), radius, Vec3::ZERO);
    let hollow = merge(ball(1.0), reverse(ball(0.5)));
    let topology = analyse(&hollow);
    assert!(topology.is_closed() && !topology.needs_flips());
    assert_eq!(topology.components[1].inside_of, Some(0));
    assert!(topology.components[1].signed_volume < 0.0 && !topology.components[1].inside_out);
    assert!(!analyse(&merge(ball(1.0), ball(0.5))).needs_flips());
    // A pearl in the cavity.
    let pearl = analyse(&merge(hollow.clone(), ball(0.2)));
    assert!(!pearl.needs_flips());
    assert_eq!(pearl.components[2].inside_of, Some(1));
    // The whole shell reversed, beside a sound solid and a reversed one.
    let beside = |x: f32, mesh| place(mesh, 1.0, Vec3::X * x);
    let all = merge(merge(beside(5.0, ball(1.0)), reverse(hollow)), beside(-5.0, reverse(ball(1.0))));
    let topology = analyse(&all);
    let out: Vec<bool> = topology.components.iter().map(|c| c.inside_out).collect();
    assert_eq!(out, [false, true, true, true]);
    fixed(all);
}

#[test]
fn open_and_tangled_meshes_say_where() {
    let mut open = cuboid(Vec3::ZERO, Vec3::ONE);
    open.1.pop();
    let topology = analyse(&open);
    let c = &topology.components[0];
    assert!(!topology.is_closed() && !c.closable && !c.inside_out);
    assert_eq!((c.open_edges, c.leaks.len()), (3, 3));
    assert!(c.leaks.iter().all(|p| p.x == 1.0), "the hole is in the face x = 1: {:?}", c.leaks);

    // Two boxes that touch along an edge.
    let touching =
        merge(cuboid(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 2.0, 1.0)));
    let topology = analyse(&touching);
    assert!(topology.is_closed() && topology.components.len() == 2);
    // A wall on a box: no telling what is inside at an edge of three triangles.
    let mut walled = cuboid(Vec3::ZERO, Vec3::ONE);
    let top = walled.0.len() as u32;
    walled.0.extend([Vec3::ZERO, Vec3::Z, Vec3::new(-1.0, -1.0, 0.0)]);
    walled.1.push([top, top + 1, top + 2]);
    let topology = analyse(&walled);
    assert_eq!(topology.components.len(), 1);
    assert_eq!((topology.components[0].non_manifold_edges, topology.components[0].open_edges), (1, 2));
    assert!(!topology.is_closed());
    // Two that touch at a corner are two solids.
    let corner = analyse(&merge(cuboid(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::ONE, 2.0 * Vec3::ONE)));
    assert!(corner.is_closed() && corner.components.len() == 2);

    let topology = analyse(&soup(100, 0.1, 4));
    assert_eq!(topology.components.len(), 100);
    assert!(topology.components.iter().all(|c| c.open_edges == 3 && !c.closed));
    assert!(!analyse(&(Vec::new(), Vec::new())).is_closed());
}

#[test]
fn triangles_that_face_the_wrong_way_are_found() {
    let mut mesh = sphere(3, 0.2, 5);
    let mut random = Random(6);
    let mut wrong = vec![false; mesh.1.len()];
    for _ in 0..300 {
        let i = random.below(mesh.1.len());
        mesh.1[i].swap(0, 2);
        wrong[i] ^= true;
    }
    let topology = analyse(&mesh);
    let c = &topology.components[0];
    assert!(c.inconsistent_edges > 0 && !c.closed && c.closable && !c.inside_out);
    assert_eq!(topology.flips, wrong);
    assert!(fixed(mesh).is_closed());
}

#[test]
fn a_closed_surface_with_one_side_has_no_orientation() {
    // The projective plane: an icosahedron whose opposite points are one.
    let (corners, all) = sphere(0, 0.0, 7);
    let opposite = |i: u32| {
        let far = |j: &u32| corners[*j as usize].distance(-corners[i as usize]) < 1.0e-3;
        (0..12).find(far).map_or(i, |j| i.min(j))
    };
    let mut random = Random(8);
    let positions = corners.iter().map(|_| random.cube()).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for t in all.iter().map(|t| t.map(opposite)) {
        if !triangles.iter().any(|o| o.iter().all(|i| t.contains(i))) {
            triangles.push(t);
        }
    }
    let topology = analyse(&(positions, triangles));
    let [c] = &topology.components[..] else { panic!("{topology:?}") };
    assert_eq!((c.triangles, c.open_edges, c.non_manifold_edges), (10, 0, 0));
    assert!(c.inconsistent_edges > 0 && !c.closed && !c.closable);
}

#[test]
fn repetitions_and_triangles_without_area_change_nothing() {
    let mut mesh = cuboid(Vec3::ZERO, Vec3::ONE);
    let first = mesh.1[0];
    mesh.1.extend([first, [first[1], first[2], first[0]], [0, 0, 1], [5, 5, 5], [0, 1, 99]]);
    let topology = analyse(&mesh);
    assert!(topology.is_closed());
    assert_eq!(topology.components[0].triangles, 12);
    assert!(topology.component_of[12..].iter().all(|&c| c == NO_COMPONENT));
    // A corner on the middle of an edge, mended by a triangle without area.
    let mut mended = cuboid(Vec3::ZERO, Vec3::ONE);
    mended.0.push(Vec3::new(0.0, 0.5, 0.0));
    let t = mended.1.iter().position(|t| t.contains(&0) && t.contains(&2)).unwrap();
    let [a, b, c] = mended.1.swap_remove(t);
    let turn = [[a, b, c], [b, c, a], [c, a, b]]
        .into_iter()
        .find(|t| [t[0], t[1]] == [0, 2] || [t[0], t[1]] == [2, 0]);
    let [a, b, c] = turn.unwrap();
    mended.1.extend([[a, 8, c], [8, b, c], [8, a, b]]);
    assert!(analyse(&mended).is_closed());
}

/// A row of blocks, each sharing a face with the next, whose triangles are equal or not.
#[test]
fn solids_that_share_faces_are_solids_of_their_own() {
    let row = |upper: Triangles| {
        let blocks = [cuboid(Vec3::ZERO, Vec3::ONE), upper, cuboid(Vec3::Z * 2.0, Vec3::new(1.0, 1.0, 3.0))];
        blocks.into_iter().reduce(merge).expect("blocks")
    };
    let block = cuboid(Vec3::Z, Vec3::new(1.0, 1.0, 2.0));
    // Turned by a quarter, so that the diagonals of its faces run the other way.
    let turn = |p: &Vec3| Vec3::new(1.0 - p.y, p.x, p.z);
    let turned = (block.0.iter().map(turn).collect(), block.1.clone());
    for mesh in [row(block.clone()), row(turned.clone()), split(&row(turned))] {
        let topology = analyse(&mesh);
        assert!(topology.is_closed() && topology.components.len() == 3, "{:?}", topology.components);
        let whole = |c: &crate::geometry::Component| (c.signed_volume - 1.0).abs() < 1e-6 && !c.inside_out;
        assert!(topology.components.iter().all(|c| whole(c) && c.inside_of.is_none()));
        // All of it inside out.
        let topology = fixed(reverse(mesh));
        assert!(topology.is_closed() && topology.components.len() == 3);
    }
}

/// What faces inwards is a cavity only if it is wholly inside; what crosses is a solid by itself.
#[test]
fn parts_that_cross_are_no_cavities() {
    let one = cuboid(Vec3::ZERO, Vec3::ONE);
    let crossing = |by: f32| reverse(place(one.clone(), 1.0, Vec3::splat(by)));
    for by in [0.05, 0.5, 0.95] {
        let topology = analyse(&merge(one.clone(), crossing(by)));
        let inside_out: Vec<bool> = topology.components.iter().map(|c| c.inside_out).collect();
        assert_eq!(inside_out, [false, true], "{by}");
        let flips: Vec<bool> = (0..24).map(|t| t >= 12).collect();
        assert_eq!(topology.flips, flips);
    }
    let cavity = reverse(place(one.clone(), 0.5, Vec3::splat(0.25)));
    let topology = analyse(&merge(one, cavity));
    assert!(!topology.needs_flips() && topology.components[1].inside_of == Some(0));
}

/// Two halves of which one is inside out have a wall of two equal triangles each: repetitions, without which nothing closes.
#[test]
fn equal_triangles_count_where_nothing_is_closed_without_them() {
    let (near, far) = (cuboid(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::Z, Vec3::new(1.0, 1.0, 2.0)));
    let mut wall = near.1[2..4].to_vec();
    wall.iter_mut().for_each(|t| t.swap(1, 2));
    // The far half's wall has the triangles of the near one's.
    let at = |far: &Triangles, p: Vec3| far.0.iter().position(|q| *q == p).expect("a corner") as u32;
    let equal = wall.iter().map(|t| t.map(|i| at(&far, near.0[i as usize])));
    let rest = far.1[2..].to_vec();
    let far: Triangles = (far.0.clone(), equal.clone().chain(rest).collect());
    assert!(analyse(&far).is_closed());
    let halves = analyse(&merge(near.clone(), reverse(far.clone())));
    assert!(halves.is_closed() && halves.components.iter().any(|c| c.repeated));
    assert!(halves.component_of.iter().all(|&c| c != NO_COMPONENT));
    // One wall between two rooms leaves an edge of three triangles.
    let mut one_wall = far;
    one_wall.1.drain(..2);
    assert!(!analyse(&merge(near, one_wall)).is_closed());
}
