//! Which triangles use which edges: vertices that are one, triangles that count, and their edges in order.
//!
//! Vertices are numbered by the first corner that has them, corner c being the one of number c mod 3 of triangle c / 3.

use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// One triangle's use of an edge: `(lower vertex, upper vertex, triangle << 1 | runs upwards)`.
pub(super) type EdgeUse = (u32, u32, u32);

/// Vertices numbered by the first corner that has them.
pub(super) fn first_corners(merged: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let largest = merged.par_iter().flatten().max().map_or(0, |&vertex| vertex as usize);
    let corners = merged.as_flattened();
    let numbers: Vec<u32> = if largest < 4 * corners.len() {
        let mut first = vec![u32::MAX; largest + 1];
        let number = |(&vertex, corner): (&u32, u32)| {
            let first = &mut first[vertex as usize];
            *first = corner.min(*first);
            *first
        };
        corners.iter().zip(0_u32..).map(number).collect()
    } else {
        let mut first = HashMap::new();
        corners.iter().zip(0_u32..).map(|(&vertex, corner)| *first.entry(vertex).or_insert(corner)).collect()
    };
    numbers.as_chunks::<3>().0.to_vec()
}

/// Vertex numbers of each triangle after merging equal positions; three equal numbers for dropped triangles.
pub(super) fn merged_vertices(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    // Adding zero makes −0 and 0 the same bits.
    let key = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
    let mut order: Vec<([u32; 3], u32)> =
        positions.par_iter().enumerate().map(|(i, &p)| (key(p), i as u32)).collect();
    order.par_sort_unstable();
    let mut equal = vec![0; positions.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        for &(_, i) in same {
            equal[i as usize] = same[0].1;
        }
    }
    let merged: Vec<_> = triangles.par_iter().map(|t| t.map(|i| equal[i as usize])).collect();
    first_corners(&merged)
}

/// False for triangles with equal corners and for repetitions.
pub(super) fn distinct_triangles(vertices: &[[u32; 3]]) -> Vec<bool> {
    let lowest_first = |&[a, b, c]: &[u32; 3]| {
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    };
    let triangles: Vec<([u32; 3], u32)> =
        vertices.par_iter().enumerate().map(|(i, v)| (lowest_first(v), i as u32)).collect();
    let sorted = sorted_by_vertex(&triangles, vertices.len(), |t| t.0[0]);
    let mut used = vec![false; vertices.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        let [a, b, c] = same[0].0;
        used[same[0].1 as usize] = a != b && b != c && c != a;
    }
    used
}

/// All uses of edges by the triangles that are `used`, in the order of edges.
pub(super) fn edge_uses(vertices: &[[u32; 3]], used: &[bool], reversed: bool) -> Vec<EdgeUse> {
    let edges: Vec<EdgeUse> = (0..vertices.len())
        .into_par_iter()
        .filter(|&t| used[t])
        .flat_map_iter(|t| {
            let v = vertices[t];
            (0..3).map(move |i| {
                let (a, b) = (v[i], v[(i + 1) % 3]);
                (a.min(b), a.max(b), (t as u32) << 1 | u32::from((a < b) != reversed))
            })
        })
        .collect();
    sorted_by_vertex(&edges, vertices.len(), |edge| edge.0)
}

/// Sorts what begins with a vertex: counts how often each one occurs, and sorts what little belongs to one.
fn sorted_by_vertex<T: Copy + Ord + Send>(
    items: &[T],
    triangles: usize,
    vertex: impl Fn(&T) -> u32 + Sync,
) -> Vec<T> {
    let Some(&any) = items.first() else { return Vec::new() };
    let mut places = vec![0_u32; 3 * triangles + 1];
    for item in items {
        places[vertex(item) as usize + 1] += 1;
    }
    for i in 1..places.len() {
        places[i] += places[i - 1];
    }
    let mut sorted = vec![any; items.len()];
    for item in items {
        let place = &mut places[vertex(item) as usize];
        sorted[*place as usize] = *item;
        *place += 1;
    }
    let groups = sorted.par_chunk_by_mut(|a, b| vertex(a) == vertex(b));
    groups.for_each(|group| group.sort_unstable());
    sorted
}

/// Whether as many triangles run along an edge in one direction as in the other.
pub(super) fn is_balanced(edge: &[EdgeUse]) -> bool {
    2 * edge.iter().filter(|use_| use_.2 & 1 == 1).count() == edge.len()
}

/// Whether two uses are of one edge.
pub(super) fn same_edge(a: &EdgeUse, b: &EdgeUse) -> bool {
    (a.0, a.1) == (b.0, b.1)
}
