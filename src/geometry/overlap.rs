//! What reaches into a box: walks through the hierarchies that take every child which overlaps it.

use super::lines::{self, Lined};
use super::mesh::MeshGeometry;
use super::ray::Aabb;
use super::scene::SceneGeometry;
use super::wide_bvh::{Block, LEAF, NONE, Node, WideBvh};

/// Visits the leaves whose boxes overlap or touch `bounds`, in no order that means anything, as long as `visit` says to go
/// on.
pub(super) fn traverse_overlapping<B: Lined>(
    bvh: &WideBvh<B>,
    bounds: &Aabb,
    mut visit: impl FnMut(&B) -> bool,
) {
    let mut stack = Vec::new();
    if !bvh.lines.is_empty() {
        stack.push(0_u32);
    }
    while let Some(at) = stack.pop() {
        if at & LEAF != 0 {
            if !visit(lines::get(&bvh.lines, at & !LEAF)) {
                return;
            }
            continue;
        }
        let node: &Node = lines::get(&bvh.lines, at);
        // The box of an unused child is empty, which only an infinite box overlaps.
        let overlaps = |lane: usize| {
            node.planes[0][lane] <= node.planes[3][lane]
                && (0..3).all(|axis| {
                    node.planes[axis][lane] <= bounds.max[axis]
                        && node.planes[axis + 3][lane] >= bounds.min[axis]
                })
        };
        stack.extend((0..node.children.len()).filter(|&lane| overlaps(lane)).map(|lane| node.children[lane]));
    }
}

/// Numbers of the boxes of a leaf.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Numbers {
    block: Block,
    _unused: [u32; 8],
}

// SAFETY: numbers alone, one line of them.
unsafe impl Lined for Numbers {}

/// Boxes that can be asked for what overlaps them.
pub struct BoxTree {
    boxes: Vec<Aabb>,
    bvh: WideBvh<Numbers>,
}

impl BoxTree {
    /// Builds over boxes; those that are empty or not finite overlap nothing. Deterministic.
    pub fn build(boxes: Vec<Aabb>) -> Self {
        let whole = |b: &Aabb| !b.is_empty() && b.min.is_finite() && b.max.is_finite();
        let kept: Vec<u32> = (0..boxes.len() as u32).filter(|&i| whole(&boxes[i as usize])).collect();
        let there: Vec<Aabb> = kept.iter().map(|&i| boxes[i as usize]).collect();
        let leaf = |block: &Block| Numbers {
            block: block.map(|i| if i == NONE { NONE } else { kept[i as usize] }),
            _unused: [0; 8],
        };
        Self { bvh: WideBvh::build(&there, 4, |_| true, leaf), boxes }
    }

    /// Visits the number of every box that overlaps or touches `bounds`, once each, in no order that means anything.
    pub fn visit(&self, bounds: &Aabb, mut visit: impl FnMut(u32)) {
        traverse_overlapping(&self.bvh, bounds, |leaf| {
            let numbers = leaf.block.into_iter().filter(|&i| i != NONE);
            numbers.filter(|&i| self.boxes[i as usize].overlaps(bounds)).for_each(&mut visit);
            true
        });
    }

    /// The numbers of the boxes that overlap or touch `bounds` and are `wanted`, in order; `None` if there are more than
    /// `most`.
    pub fn at_most(&self, most: usize, bounds: &Aabb, wanted: impl Fn(u32) -> bool) -> Option<Vec<u32>> {
        let mut found = Vec::new();
        traverse_overlapping(&self.bvh, bounds, |leaf| {
            let numbers = leaf.block.into_iter().filter(|&i| i != NONE);
            found.extend(numbers.filter(|&i| self.boxes[i as usize].overlaps(bounds) && wanted(i)));
            found.len() <= most
        });
        found.sort_unstable();
        Some(found).filter(|found| found.len() <= most)
    }

    /// Whether a box overlaps or touches `bounds`.
    pub fn any(&self, bounds: &Aabb) -> bool {
        let mut found = false;
        traverse_overlapping(&self.bvh, bounds, |leaf| {
            let mut numbers = leaf.block.into_iter().filter(|&i| i != NONE);
            found = numbers.any(|i| self.boxes[i as usize].overlaps(bounds));
            !found
        });
        found
    }
}

impl MeshGeometry {
    /// Visits triangles that may overlap or touch a box in the space of the mesh, all that do and a few more.
    pub fn visit_overlapping(&self, bounds: &Aabb, mut visit: impl FnMut(u32)) {
        traverse_overlapping(self.bvh(), bounds, |block| {
            block.ids.into_iter().filter(|&id| id != NONE).for_each(&mut visit);
            true
        });
    }
}

impl SceneGeometry {
    /// Box of an instance, world metres.
    pub fn instance_bounds(&self, instance: u32) -> Aabb {
        self.transform(instance).bounds(&self.mesh_of(instance).bounds())
    }

    /// Visits the instances whose boxes overlap or touch a box in world space, as long as `visit` says to go on, in no order that
    /// means anything.
    pub fn visit_instances(&self, bounds: &Aabb, mut visit: impl FnMut(u32) -> bool) {
        traverse_overlapping(&self.bvh, bounds, |leaf| visit(leaf.instance));
    }

    /// The box around those triangles of an instance that may overlap or touch a box, both in world space; empty where
    /// there is none.
    pub fn part_within(&self, instance: u32, bounds: &Aabb) -> Aabb {
        let (mesh, transform) = (self.mesh_of(instance), self.transform(instance));
        let mut within = Aabb::EMPTY;
        mesh.visit_overlapping(&transform.inverse_bounds(bounds), |triangle| {
            let there = Aabb::from_points(&mesh.triangle(triangle).map(|p| transform.point(p)));
            if there.overlaps(bounds) {
                within = within.union(there);
            }
        });
        within
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::{Random, place, sphere};
    use super::*;
    use glam::{Affine3A, Quat, Vec3};

    fn some_box(random: &mut Random, size: f32) -> Aabb {
        let middle = 3.0 * random.cube();
        let half = size * random.cube().abs();
        Aabb { min: middle - half, max: middle + half }
    }

    #[test]
    fn boxes_are_found_as_by_asking_each() {
        let mut random = Random(5);
        for count in [0, 1, 7, 500] {
            let mut boxes: Vec<Aabb> = (0..count).map(|_| some_box(&mut random, 0.3)).collect();
            boxes.extend([Aabb::EMPTY; 2]);
            let tree = BoxTree::build(boxes.clone());
            for _ in 0..100 {
                let bounds = some_box(&mut random, 1.0);
                let mut found = Vec::new();
                tree.visit(&bounds, |i| found.push(i));
                found.sort_unstable();
                let overlapping = (0..boxes.len() as u32).filter(|&i| boxes[i as usize].overlaps(&bounds));
                assert_eq!(found, overlapping.collect::<Vec<_>>());
                assert_eq!(tree.any(&bounds), !found.is_empty());
            }
            let mut all = 0;
            tree.visit(&Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }, |_| all += 1);
            assert_eq!(all, count);
        }
    }

    /// Lights that a file leaves at the origin: each of 200 000 would be merged in a round of its own, for an hour.
    #[test]
    fn points_in_one_place_take_no_time() {
        let begun = std::time::Instant::now();
        for middle in [Vec3::ZERO, Vec3::ONE] {
            let tree = BoxTree::build(vec![Aabb { min: middle, max: middle }; 200_000]);
            let mut found = 0;
            tree.visit(&Aabb { min: Vec3::ZERO, max: Vec3::ONE }, |_| found += 1);
            assert_eq!(found, 200_000);
        }
        assert!(begun.elapsed().as_secs() < 60);
    }

    #[test]
    fn the_part_of_a_mesh_in_a_box_is_that_of_its_triangles() {
        let mut random = Random(6);
        let (positions, triangles) = place(sphere(3, 0.3, 7), 1.5, Vec3::ONE);
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let world =
            Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), turn, Vec3::new(2.0, -1.0, 0.5));
        let scene = SceneGeometry::build(vec![(positions, triangles)], &[(0, world)]).unwrap();
        let (mesh, transform) = (scene.mesh_of(0), scene.transform(0));
        let mut met = 0;
        for _ in 0..300 {
            let mut bounds = some_box(&mut random, 0.5);
            // About as large as the mesh, and near it.
            bounds.min = scene.bounds().center() + 0.3 * bounds.min;
            bounds.max = scene.bounds().center() + 0.3 * bounds.max;
            let found = scene.part_within(0, &bounds);
            let mut most = Aabb::EMPTY;
            for t in 0..mesh.triangle_count() as u32 {
                let corners = mesh.triangle(t).map(|p| transform.point(p));
                let there = Aabb::from_points(&corners);
                if there.overlaps(&bounds) {
                    most = most.union(there);
                }
                // Boxes may overlap where the triangle does not; where a corner is inside it surely does.
                if corners.iter().any(|p| bounds.contains(*p)) {
                    assert_eq!(found.union(there), found);
                    met += 1;
                }
            }
            assert_eq!(found.union(most), most);
        }
        assert!(met > 10);
    }
}
