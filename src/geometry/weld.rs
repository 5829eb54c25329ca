//! Seams: open edges of a mesh that were meant to be one, but whose ends differ by roundings.
//!
//! Programs that make solids of trimmed patches compute the border of each patch by itself, and what should be equal is
//! not. Here two open edges are one if the ends of each are within a tolerance of those of the other, and each is the
//! nearest such edge of the other. Their ends are put in the same place, so that no crack is left for rays.
//!
//! What is not open is never touched, so a closed mesh keeps every bit, and thin sheets and small details stay apart: an
//! end moves by less than an eighth of its edge, and no two corners of a triangle become one.

use super::edges::{distinct_triangles, edge_uses, merged_vertices, same_edge};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// The part of an edge that its ends may move at most: a triangle keeps its shape.
const MOST_OF_AN_EDGE: f64 = 1.0 / 8.0;
/// Width of the cells of a grid, in tolerances: a search is rarely in more than one of them.
const ROOMY: f64 = 64.0;

/// An open edge: vertices in the order in which the triangle runs, and where they are.
#[derive(Clone, Copy)]
struct Edge {
    vertices: [u32; 2],
    ends: [DVec3; 2],
    reach: f64,
}

impl Edge {
    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    fn middle(&self) -> DVec3 {
        0.5 * (self.ends[0] + self.ends[1])
    }
}

/// Puts the ends of open edges that are one within `tolerance` into one place; how many vertices were moved.
/// Deterministic.
pub fn close_seams(positions: &mut [Vec3], triangles: &[[u32; 3]], tolerance: f32) -> usize {
    let tolerance = f64::from(tolerance);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return 0;
    }
    let vertices = merged_vertices(positions, triangles);
    let used = distinct_triangles(&vertices);
    let place = |corner: u32| {
        let vertex = triangles[corner as usize / 3][corner as usize % 3];
        positions.get(vertex as usize).map_or(DVec3::NAN, |p| p.as_dvec3())
    };
    let open_edge = |edge: &[(u32, u32, u32)]| {
        let &[(low, high, direction)] = edge else { return None };
        let vertices = if direction & 1 == 1 { [low, high] } else { [high, low] };
        let ends = vertices.map(place);
        let reach = tolerance.min(MOST_OF_AN_EDGE * ends[0].distance(ends[1]));
        (reach > 0.0 && ends.iter().all(|end| end.is_finite())).then_some(Edge { vertices, ends, reach })
    };
    let uses = edge_uses(&vertices, &used, false);
    let open: Vec<Edge> = uses.chunk_by(same_edge).filter_map(open_edge).collect();
    let partners = partners(&open, tolerance);
    let mut one = HashMap::new();
    for (i, partner) in partners.iter().enumerate() {
        let Some((j, turned)) = *partner else { continue };
        if i < j && partners[j].is_some_and(|(back, _)| back == i) {
            let [a, b] = open[i].vertices;
            let [c, d] = open[j].vertices;
            let ends = if turned { [(a, d), (b, c)] } else { [(a, c), (b, d)] };
            ends.into_iter().for_each(|(a, b)| join(&mut one, a, b));
        }
    }
    move_together(positions, triangles, &vertices, &mut one)
}

/// For each edge the nearest other one, and whether it runs the other way.
fn partners(open: &[Edge], tolerance: f64) -> Vec<Option<(usize, bool)>> {
    let grid = Grid::new(open, tolerance);
    let nearest = |(i, edge): (usize, &Edge)| {
        let mut best: Option<(f64, usize, bool)> = None;
        grid.visit_near(edge, |j| {
            let other = &open[j];
            for turned in [true, false] {
                let [c, d] = if turned { [other.ends[1], other.ends[0]] } else { other.ends };
                let apart = edge.ends[0].distance(c).max(edge.ends[1].distance(d));
                let near = apart <= edge.reach.min(other.reach);
                if i != j && near && best.is_none_or(|(least, k, _)| (apart, j) < (least, k)) {
                    best = Some((apart, j, turned));
                }
            }
        });
        best.map(|(_, j, turned)| (j, turned))
    };
    open.par_iter().enumerate().map(nearest).collect()
}

/// Edges by the cells in which their middles are, in buckets by a hash of the cell: edges of other cells may be among them.
struct Grid {
    tolerance: f64,
    /// Where the edges of each bucket begin; as many buckets as a power of two.
    starts: Vec<u32>,
    edges: Vec<u32>,
}

impl Grid {
    fn new(open: &[Edge], tolerance: f64) -> Self {
        let mut grid =
            Self { tolerance, starts: vec![0; open.len().next_power_of_two() + 1], edges: Vec::new() };
        let bucket_of = |edge: &Edge| {
            let level = grid.level(edge.length());
            grid.bucket(level, grid.cell(level, edge.middle()))
        };
        let buckets: Vec<u32> = open.par_iter().map(bucket_of).collect();
        for &bucket in &buckets {
            grid.starts[bucket as usize + 1] += 1;
        }
        for i in 1..grid.starts.len() {
            grid.starts[i] += grid.starts[i - 1];
        }
        let mut next = grid.starts.clone();
        grid.edges = vec![0; open.len()];
        for (edge, bucket) in (0..).zip(buckets) {
            let place = &mut next[bucket as usize];
            grid.edges[*place as usize] = edge;
            *place += 1;
        }
        grid
    }

    /// Cells are much larger than the tolerance, so that most searches are in one of them, but not larger than edges:
    /// those of a length have cells of their own where that counts.
    fn level(&self, length: f64) -> i32 {
        (length.min(ROOMY * self.tolerance)).log2().floor() as i32
    }

    fn cell(&self, level: i32, p: DVec3) -> [i64; 3] {
        (p / f64::from(level).exp2()).floor().to_array().map(|x| x as i64)
    }

    fn bucket(&self, level: i32, cell: [i64; 3]) -> u32 {
        let mix = |hash: u64, x: i64| (hash ^ x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        let hash = cell.into_iter().fold(mix(0, i64::from(level)), mix);
        (hash.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32 & (self.starts.len() as u32 - 2)
    }

    /// Calls `visit` with all edges that may be near, and others, perhaps more than once.
    fn visit_near(&self, edge: &Edge, mut visit: impl FnMut(usize)) {
        // Lengths of partners differ by two reaches at most.
        let lengths = [edge.length() - 2.0 * edge.reach, edge.length() + 2.0 * edge.reach];
        let [shortest, longest] = lengths.map(|length| self.level(length));
        for level in shortest..=longest {
            let [low, high] = [-edge.reach, edge.reach].map(|by| self.cell(level, edge.middle() + by));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let bucket = self.bucket(level, [x, y, z]) as usize;
                        let edges = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
                        self.edges[edges].iter().for_each(|&j| visit(j as usize));
                    }
                }
            }
        }
    }
}

/// Disjoint sets of vertices by their lowest; those that are not there are alone.
fn find(one: &mut HashMap<u32, u32>, vertex: u32) -> u32 {
    let mut root = vertex;
    while let Some(&above) = one.get(&root).filter(|above| **above != root) {
        root = above;
    }
    if root != vertex {
        one.insert(vertex, root);
    }
    root
}

fn join(one: &mut HashMap<u32, u32>, a: u32, b: u32) {
    let (a, b) = (find(one, a), find(one, b));
    if a != b {
        one.insert(a.max(b), a.min(b));
        one.insert(a.min(b), a.min(b));
    }
}

/// Moves the vertices of each set to its lowest, unless two corners of a triangle are in one set.
fn move_together(
    positions: &mut [Vec3],
    triangles: &[[u32; 3]],
    vertices: &[[u32; 3]],
    one: &mut HashMap<u32, u32>,
) -> usize {
    if one.is_empty() {
        return 0;
    }
    let mut roots = HashMap::new();
    let members: Vec<u32> = one.keys().copied().collect();
    for vertex in members {
        roots.insert(vertex, find(one, vertex));
    }
    let root = |vertex: &u32| roots.get(vertex).copied();
    let mut torn = std::collections::HashSet::new();
    for [a, b, c] in vertices {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            torn.extend(root(a).filter(|_| a != b && root(a) == root(b)));
        }
    }
    let mut moved = vec![false; positions.len()];
    for (triangle, corners) in triangles.iter().zip(vertices) {
        for (&vertex, corner) in triangle.iter().zip(corners) {
            let Some(root) = root(corner).filter(|root| !torn.contains(root)) else { continue };
            // The lowest vertex of a set is a corner; its place is never changed.
            let to = positions[triangles[root as usize / 3][root as usize % 3] as usize];
            let Some(p) = positions.get_mut(vertex as usize).filter(|p| **p != to) else { continue };
            *p = to;
            moved[vertex as usize] = true;
        }
    }
    moved.into_iter().filter(|&moved| moved).count()
}

#[cfg(test)]
mod tests {
    use super::super::shapes::{Random, Triangles, cuboid, merge, place, sphere};
    use super::super::{MeshGeometry, Topology};
    use super::*;

    /// Every triangle with corners of its own, each off by up to `by`.
    fn shaken(mesh: &Triangles, by: f32) -> Triangles {
        let mut random = Random(3);
        let mut off = || 2.0 * random.unit() - 1.0;
        let corners = mesh.1.iter().flatten().map(|&i| mesh.0[i as usize]);
        let positions = corners.map(|p| p + by * Vec3::new(off(), off(), off())).collect();
        (positions, (0..mesh.1.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    }

    fn topology(mesh: &Triangles) -> Topology {
        Topology::analyse(&MeshGeometry::build(&mesh.0, &mesh.1))
    }

    #[test]
    fn seams_within_the_tolerance_are_closed_without_a_crack() {
        for solid in [cuboid(Vec3::ZERO, Vec3::ONE), sphere(3, 0.0, 1)] {
            let mut mesh = shaken(&solid, 1e-6);
            assert!(!topology(&mesh).is_closed());
            assert!(close_seams(&mut mesh.0, &mesh.1, 1e-5) > 0);
            let found = topology(&mesh);
            assert!(found.is_closed() && found.components.len() == 1, "{:?}", found.components);
        }
    }

    #[test]
    fn seams_beyond_the_tolerance_stay_open() {
        let mut mesh = shaken(&cuboid(Vec3::ZERO, Vec3::ONE), 1e-3);
        let before = mesh.clone();
        assert_eq!(close_seams(&mut mesh.0, &mesh.1, 1e-6), 0);
        assert_eq!(mesh, before);
        for tolerance in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(close_seams(&mut mesh.0, &mesh.1, tolerance), 0);
        }
    }

    #[test]
    fn what_is_closed_is_never_touched() {
        // A sheet that is thinner than the tolerance, and two boxes with a gap below it.
        let sheet = cuboid(Vec3::ZERO, Vec3::new(1.0, 1.0, 1e-6));
        let gap = place(cuboid(Vec3::ZERO, Vec3::ONE), 1.0, Vec3::Z * (1.0 + 3e-6));
        for mut mesh in [sheet, merge(cuboid(Vec3::ZERO, Vec3::ONE), gap)] {
            let before = mesh.clone();
            assert_eq!(close_seams(&mut mesh.0, &mesh.1, 1e-3), 0);
            assert_eq!(mesh, before);
        }
    }

    #[test]
    fn short_edges_are_not_drawn_together() {
        // A sheet of six open patches, thinner than the tolerance.
        let mut mesh = shaken(&cuboid(Vec3::ZERO, Vec3::new(1.0, 1.0, 1e-3)), 1e-6);
        close_seams(&mut mesh.0, &mesh.1, 0.1);
        let found = topology(&mesh);
        assert!(found.is_closed(), "{:?}", found.components);
        assert!((found.components[0].signed_volume - 1e-3).abs() < 1e-5);
    }

    #[test]
    fn the_order_of_triangles_does_not_matter_for_what_is_one() {
        let mut mesh = shaken(&sphere(2, 0.0, 1), 1e-6);
        let mut turned = mesh.clone();
        turned.1.reverse();
        close_seams(&mut mesh.0, &mesh.1, 1e-5);
        close_seams(&mut turned.0, &turned.1, 1e-5);
        assert!(topology(&mesh).is_closed() && topology(&turned).is_closed());
        let again = mesh.clone();
        assert_eq!(close_seams(&mut mesh.0, &mesh.1, 1e-5), 0, "what is closed stays");
        assert_eq!(mesh, again);
    }

    #[test]
    fn what_is_nowhere_is_left_alone() {
        for bad in [f32::NAN, f32::INFINITY] {
            let mut mesh = shaken(&cuboid(Vec3::ZERO, Vec3::ONE), 1e-6);
            mesh.0[0].x = bad;
            mesh.0[5].z = bad;
            close_seams(&mut mesh.0, &mesh.1, 1e-5);
            let finite = mesh.0.iter().filter(|p| p.is_finite()).count();
            assert_eq!(finite, mesh.0.len() - 2);
        }
    }
}
