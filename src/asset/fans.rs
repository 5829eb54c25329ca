//! Tangents of vertices whose triangles form one fan, as MikkTSpace has them.
//!
//! MikkTSpace (Mikkelsen 2008) first makes corners one that agree in position, normal and texture coordinates. Around each
//! such vertex it groups triangles that are joined by edges and have the same orientation in the texture, and gives the
//! corners of a group the tangent
//!
//! ```text
//! t = normalize(Σ_f φ_f normalize(t_f − (t_f·n) n)),    t_f ∝ ±((v_3 − v_1) e_2 − (v_2 − v_1) e_3)
//! ```
//!
//! with n the normal, φ_f the angle of the triangle at the vertex measured in the tangent plane, e_2 and e_3 its edges and v
//! its texture coordinates. Where all triangles of a vertex are one group there is nothing to search for.

use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::primitive::Primitive;

/// Most triangles of a fan; whether more are one fan would take long to tell.
const MOST: usize = 64;

/// Tangents of the vertices that are each in one fan.
pub(super) struct Fans {
    /// The tangent of each vertex, with the sign of the bitangent of glTF ([`super::tangent`]); `None` where its
    /// triangles are not one fan.
    pub tangents: Vec<Option<Vec4>>,
}

/// The unit direction of u on a triangle, and whether the texture is not mirrored there; `None` without texture area
/// (equations 18 and 19 of MikkTSpace's reference).
fn direction(primitive: &Primitive, uvs: &[Vec2], triangle: &[u32; 3]) -> Option<(Vec3, bool)> {
    let [a, b, c] = triangle.map(|i| primitive.positions[i as usize]);
    let [s, t, r] = triangle.map(|i| uvs[i as usize]);
    let (e, f, g, h) = (b - a, c - a, t - s, r - s);
    let area = g.perp_dot(h);
    let (u, v) = (e * h.y - f * g.y, f * g.x - e * h.x);
    let some = |x: f32| x > f32::MIN_POSITIVE && x.is_finite();
    let (length, other) = (u.length(), v.length());
    let found = some(area.abs()) && some(length / area.abs()) && some(other / area.abs());
    found.then(|| (u * (area.signum() / length), area > 0.0))
}

/// Vertices that agree in all that counts have the number of the first of them.
fn welded(primitive: &Primitive, uvs: &[Vec2]) -> Vec<u32> {
    // Zero of either sign is the same.
    let key = |i: usize| {
        let (p, n, t) = (primitive.positions[i] + 0.0, primitive.normals[i] + 0.0, uvs[i] + 0.0);
        [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y].map(f32::to_bits)
    };
    let hasher = BuildHasherDefault::<DefaultHasher>::default();
    let hash = |i: usize| (hasher.hash_one(key(i)), i as u32);
    let mut order: Vec<(u64, u32)> = (0..primitive.positions.len()).into_par_iter().map(hash).collect();
    order.par_sort_unstable();
    let mut first: Vec<u32> = (0..primitive.positions.len() as u32).collect();
    for same in order.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
        for (k, &(_, i)) in same.iter().enumerate() {
            let equal = same[..k].iter().find(|&&(_, j)| key(j as usize) == key(i as usize));
            first[i as usize] = equal.map_or(i, |&(_, j)| first[j as usize]);
        }
    }
    first
}

impl Fans {
    /// The fans of a primitive with normals; `None` where a triangle has no texture area.
    pub fn new(primitive: &Primitive, uvs: &[Vec2]) -> Option<Self> {
        let directions: Option<Vec<(Vec3, bool)>> =
            primitive.triangles.par_iter().map(|t| direction(primitive, uvs, t)).collect();
        let directions = directions?;
        let first = welded(primitive, uvs);
        let mut starts = vec![0_u32; first.len() + 1];
        let corners = || primitive.triangles.iter().flatten().map(|&i| first[i as usize] as usize);
        corners().for_each(|vertex| starts[vertex + 1] += 1);
        for vertex in 0..first.len() {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut around = vec![0_u32; 3 * primitive.triangles.len()];
        for (corner, vertex) in corners().enumerate() {
            around[next[vertex] as usize] = corner as u32;
            next[vertex] += 1;
        }
        let tangent = |vertex: usize| {
            let corners = &around[starts[vertex] as usize..starts[vertex + 1] as usize];
            tangent(primitive, &first, &directions, vertex, corners)
        };
        let own: Vec<Option<Vec4>> = (0..first.len()).into_par_iter().map(tangent).collect();
        let tangents = first.iter().map(|&vertex| own[vertex as usize]).collect();
        Some(Self { tangents })
    }

    /// The triangles, by number in ascending order, that have a place in common with a vertex that is used but in no fan.
    pub fn others(&self, primitive: &Primitive) -> Vec<u32> {
        let key = |i: u32| (primitive.positions[i as usize] + 0.0).to_array().map(f32::to_bits);
        let alone = |i: &&u32| self.tangents[**i as usize].is_none();
        let places: std::collections::HashSet<[u32; 3]> =
            primitive.triangles.iter().flatten().filter(alone).map(|&i| key(i)).collect();
        if places.is_empty() {
            return Vec::new();
        }
        let touches = |t: &u32| primitive.triangles[*t as usize].iter().any(|&i| places.contains(&key(i)));
        (0..primitive.triangles.len() as u32).into_par_iter().filter(touches).collect()
    }
}

/// The tangent of a vertex with these corners; `None` where their triangles are not one fan.
fn tangent(
    primitive: &Primitive,
    first: &[u32],
    directions: &[(Vec3, bool)],
    vertex: usize,
    corners: &[u32],
) -> Option<Vec4> {
    let start = *corners.first()?;
    let preserves = directions[start as usize / 3].1;
    let same = corners.iter().all(|&c| directions[c as usize / 3].1 == preserves);
    if !same || !is_one_fan(primitive, first, corners) {
        return None;
    }
    let normal = primitive.normals[vertex];
    let flat = |v: Vec3| (v - normal * normal.dot(v)).try_normalize();
    let mut sum = Vec3::ZERO;
    for &corner in corners {
        let (triangle, k) = (corner as usize / 3, corner as usize % 3);
        let [here, next, last] = [k, (k + 1) % 3, (k + 2) % 3]
            .map(|k| primitive.positions[primitive.triangles[triangle][k] as usize]);
        let (a, b) = (flat(next - here).unwrap_or_default(), flat(last - here).unwrap_or_default());
        let angle = a.dot(b).clamp(-1.0, 1.0).acos();
        sum += flat(directions[triangle].0).unwrap_or_default() * angle;
    }
    let tangent = sum.try_normalize()?;
    Some(tangent.extend(if preserves { -1.0 } else { 1.0 }))
}

/// Whether the triangles of these corners hang together by the edges at their common vertex, two at an edge at most.
fn is_one_fan(primitive: &Primitive, first: &[u32], corners: &[u32]) -> bool {
    if corners.len() > MOST {
        return false;
    }
    let mut rim = [(0, 0); MOST];
    for (place, &corner) in rim.iter_mut().zip(corners) {
        let (triangle, k) = (primitive.triangles[corner as usize / 3], corner as usize % 3);
        let [next, last] = [triangle[(k + 1) % 3], triangle[(k + 2) % 3]].map(|i| first[i as usize]);
        *place = (next, last);
    }
    let rim = &mut rim[..corners.len()];
    // The chain grows at both ends until nothing fits.
    let (mut begin, mut end) = rim[0];
    let mut used = 1;
    while used < rim.len() {
        let Some(k) = (used..rim.len()).find(|&k| rim[k].0 == end || rim[k].1 == begin) else { return false };
        let (next, last) = rim[k];
        if next == end {
            end = last;
        } else {
            begin = next;
        }
        rim.swap(used, k);
        used += 1;
    }
    let twice =
        |f: fn(&(u32, u32)) -> u32| (1..rim.len()).any(|i| rim[..i].iter().any(|r| f(r) == f(&rim[i])));
    !twice(|r| r.0) && !twice(|r| r.1)
}
