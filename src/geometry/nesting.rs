//! Which solids of a mesh are in which: the closest one around each.
//!
//! A solid holds another one if all of it is inside: some of its triangles are looked for, each by the parity of crossings
//! along rays that vote. One that only crosses another is a solid by itself.
//!
//! Whatever is around a solid has a box around its box, and of those that hold it the closest one is left first along any
//! ray. So few are asked, also where many thousand lie in each other, and each by itself: rays through all of them would
//! cross the others, too.

use super::containment::{DIRECTIONS, vote};
use super::mesh::MeshGeometry;
use super::overlap::BoxTree;
use super::ray::{Aabb, MeshHit, Ray};
use super::topology::NO_COMPONENT;
use glam::Vec3;
use rayon::prelude::*;

/// Solids that are asked whether they hold another one, at most.
const MOST_ASKED: usize = 64;
/// The first part of a ray that is looked at, relative to the mesh, and how many times as long each next one is.
const FIRST_REACH: f32 = 1.0 / 1_048_576.0;
const LONGER: f32 = 16.0;

/// The solids of a mesh.
pub(super) struct Solids<'a> {
    pub mesh: &'a MeshGeometry,
    /// Of each triangle the solid, or [`NO_COMPONENT`].
    pub component_of: &'a [u32],
    /// Some triangles of each; none of those that are not to be considered.
    pub samples: &'a [Vec<u32>],
    /// Boxes around them.
    pub boxes: &'a [Aabb],
}

impl Solids<'_> {
    /// For each solid the closest one that holds it. There are no cycles: a larger box holds a smaller one, and of equal boxes
    /// a later solid an earlier one.
    pub fn parents(&self) -> Vec<Option<usize>> {
        let solid = |c: usize| !self.samples[c].is_empty();
        let count = self.samples.len();
        if (0..count).filter(|&c| solid(c)).count() < 2 {
            return vec![None; count];
        }
        let boxes = (0..count).map(|c| if solid(c) { self.boxes[c] } else { Aabb::EMPTY });
        let tree = BoxTree::build(boxes.collect());
        let asked: Vec<Vec<u32>> = (0..count)
            .into_par_iter()
            .map(|c| if solid(c) { self.candidates(c, &tree) } else { Vec::new() })
            .collect();
        let alone = self.parts(&asked);
        let holds = |k: u32, c: usize| {
            let part = alone[k as usize].as_ref();
            let mut hits = Vec::new();
            let odd = |p: Vec3, direction: Vec3, hits: &mut Vec<MeshHit>| {
                part.is_some_and(|part| {
                    part.intersect_all(&Ray::new(p, direction), hits);
                    hits.len() % 2 == 1
                })
            };
            self.samples[c].iter().all(|&s| vote(|d| odd(self.middle(s), d, &mut hits)))
        };
        let parent = |c: usize| asked[c].iter().copied().find(|&k| holds(k, c)).map(|k| k as usize);
        (0..count).into_par_iter().map(parent).collect()
    }

    /// What may hold a solid, the closest one first.
    fn candidates(&self, c: usize, tree: &BoxTree) -> Vec<u32> {
        let own = &self.boxes[c];
        let size = |k: u32| (self.boxes[k as usize].half_area(), k);
        let may_hold = |k: u32| {
            k as usize != c
                && !self.samples[k as usize].is_empty()
                && self.boxes[k as usize].union(*own) == self.boxes[k as usize]
                && size(k) > size(c as u32)
        };
        let p = self.middle(self.samples[c][0]);
        if let Some(mut few) = tree.at_most(MOST_ASKED, &Aabb { min: p, max: p }, may_hold) {
            few.sort_by(|&a, &b| size(a).partial_cmp(&size(b)).unwrap_or(a.cmp(&b)));
            return few;
        }
        let (mut found, mut hits) = (Vec::new(), Vec::new());
        let whole = self.mesh.bounds().extent().length();
        let mut reach = FIRST_REACH * whole;
        loop {
            let ray = Ray { t_max: reach, ..Ray::new(p, DIRECTIONS[0].normalize()) };
            self.mesh.intersect_all(&ray, &mut hits);
            for k in hits.iter().map(|hit| self.component_of[hit.triangle as usize]) {
                if k != NO_COMPONENT && may_hold(k) && !found.contains(&k) {
                    found.push(k);
                }
            }
            if found.len() >= MOST_ASKED || reach > whole {
                found.truncate(MOST_ASKED);
                return found;
            }
            reach *= LONGER;
        }
    }

    /// Those solids that are asked, each as a mesh of its own.
    fn parts(&self, asked: &[Vec<u32>]) -> Vec<Option<MeshGeometry>> {
        let mut wanted = vec![false; self.samples.len()];
        asked.iter().flatten().for_each(|&k| wanted[k as usize] = true);
        let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); self.samples.len()];
        for (t, &c) in (0_u32..).zip(self.component_of) {
            if c != NO_COMPONENT && wanted[c as usize] {
                triangles[c as usize].push(t);
            }
        }
        let part = |triangles: Vec<u32>| {
            let corners: Vec<Vec3> = triangles.iter().flat_map(|&t| self.mesh.triangle(t)).collect();
            let faces: Vec<[u32; 3]> =
                (0..triangles.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect();
            (!faces.is_empty()).then(|| MeshGeometry::build(&corners, &faces))
        };
        triangles.into_par_iter().map(part).collect()
    }

    /// The middle of a triangle.
    fn middle(&self, triangle: u32) -> Vec3 {
        self.mesh.point(triangle, 1.0 / 3.0, 1.0 / 3.0).0
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::sphere;
    use super::super::topology::Topology;
    use super::*;

    /// The closest solid around each of spheres, given as (middle, radius).
    fn parents(spheres: &[(Vec3, f32)]) -> Vec<Option<usize>> {
        let (unit, faces) = sphere(1, 0.0, 1);
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for &(middle, radius) in spheres {
            let first = positions.len() as u32;
            positions.extend(unit.iter().map(|p| middle + radius * *p));
            triangles.extend(faces.iter().map(|t| t.map(|i| first + i)));
        }
        let topology = Topology::analyse(&MeshGeometry::build(&positions, &triangles));
        topology.components.iter().map(|c| c.inside_of).collect()
    }

    #[test]
    fn each_solid_is_in_the_closest_one_around_it() {
        // More around each other than are asked, and beside the innermost ones.
        let shells: Vec<_> = (0..200).map(|i| (Vec3::ZERO, 1.0 + 0.1 * i as f32)).collect();
        let expected: Vec<_> = (1..=200).map(|i| Some(i).filter(|&i| i < 200)).collect();
        assert_eq!(parents(&shells), expected);
        let mut peas: Vec<_> = (0..100).map(|i| (0.2 * i as f32 * Vec3::X, 0.05)).collect();
        peas.extend((0..100).map(|i| (10.0 * Vec3::X, 30.0 + 0.1 * i as f32)));
        let found = parents(&peas);
        assert!(found[..100].iter().all(|&p| p == Some(100)), "{found:?}");
        assert_eq!(found[100..], (101..=200).map(|i| Some(i).filter(|&i| i < 200)).collect::<Vec<_>>());
    }

    #[test]
    fn one_that_only_crosses_another_is_in_none() {
        let found = parents(&[(Vec3::ZERO, 1.0), (1.2 * Vec3::X, 0.5), (0.1 * Vec3::Y, 0.3)]);
        assert_eq!(found, [None, None, Some(0)]);
    }
}
