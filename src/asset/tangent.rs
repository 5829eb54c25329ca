//! Tangents where a normal map needs them and the file has none: MikkTSpace, as glTF 2.0 §3.7.2.1 asks.
//!
//! MikkTSpace gives a tangent to each corner of a triangle. Corners that share a vertex but not a tangent (at seams of
//! the texture) get a vertex each.
//!
//! Its welding compares all different corners at one place with each other. A mesh that crowds so many there that this
//! would take more than some seconds gets plain averages of its triangles' tangents instead (Lengyel 2001).

use std::collections::{HashMap, HashSet};

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::mesh::flatten;
use super::primitive::Primitive;

/// Comparisons of corners that are worth waiting for; each takes some 20 ns.
const MOST_COMPARISONS: u64 = 100_000_000;

struct Corners<'p> {
    primitive: &'p Primitive,
    uvs: &'p [Vec2],
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }
    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)].to_array()
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)].to_array()
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)].to_array()
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[3 * face + corner] = space.map(|s| Vec4::from(s.tangent_encoded()));
    }
}

/// Makes sure that a primitive with a normal map on texture coordinate set `uv_set` has tangents, and normals for them
/// to be perpendicular to.
pub(crate) fn complete(primitive: &mut Primitive, uv_set: usize) {
    if primitive.normals.is_empty() {
        primitive.tangents.clear();
        flatten(primitive);
    }
    if !primitive.tangents.is_empty() {
        return;
    }
    let mut corners = vec![None; 3 * primitive.triangles.len()];
    if let Some(uvs) = primitive.uvs.get(uv_set) {
        if comparisons(primitive, uvs) <= MOST_COMPARISONS {
            let mut geometry = Corners { primitive, uvs, tangents: corners };
            // Its error type has no values.
            let _ = generate_tangents(&mut geometry);
            corners = geometry.tangents;
        } else {
            corners = averages(primitive, uvs);
        }
    }
    split(primitive, &corners);
}

/// How many pairs of corners MikkTSpace may compare: at each place, all corners with all different ones.
fn comparisons(primitive: &Primitive, uvs: &[Vec2]) -> u64 {
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    let mut corners = vec![0_u64; primitive.positions.len()];
    primitive.triangles.iter().flatten().for_each(|&i| corners[i as usize] += 1);
    let used = (0..corners.len()).filter(|&i| corners[i] > 0);
    let mut places: Vec<([u32; 3], u32)> = used.map(|i| (bits(primitive.positions[i]), i as u32)).collect();
    places.par_sort_unstable();
    let mut different = HashSet::new();
    let mut pairs = |place: &[([u32; 3], u32)]| {
        let all: u64 = place.iter().map(|&(_, i)| corners[i as usize]).sum();
        if place.len() == 1 {
            return all;
        }
        different.clear();
        different.extend(place.iter().map(|&(_, i)| {
            let ([x, y, z], uv) = (bits(primitive.normals[i as usize]), uvs[i as usize]);
            [x, y, z, uv.x.to_bits(), uv.y.to_bits()]
        }));
        all * different.len() as u64
    };
    places.chunk_by(|a, b| a.0 == b.0).map(&mut pairs).sum()
}

/// The directions in which u and v grow over a triangle, as long as the triangle is large; `None` if u does not grow.
fn gradients([a, b, c]: [Vec3; 3], [s, t, r]: [Vec2; 3]) -> Option<(Vec3, Vec3)> {
    let (e, f, g, h) = (b - a, c - a, t - s, r - s);
    let sign = g.perp_dot(h).signum();
    let (u, v) = ((e * h.y - f * g.y) * sign, (f * g.x - e * h.x) * sign);
    (u.is_finite() && v.is_finite() && u != Vec3::ZERO).then_some((u, v))
}

/// A tangent for each corner: the average over the triangles of its vertex, made perpendicular to the normal.
fn averages(primitive: &Primitive, uvs: &[Vec2]) -> Vec<Option<Vec4>> {
    let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); primitive.positions.len()];
    for triangle in &primitive.triangles {
        let corners = triangle.map(|i| i as usize);
        let (p, t) = (corners.map(|i| primitive.positions[i]), corners.map(|i| uvs[i]));
        let Some((u, v)) = gradients(p, t) else { continue };
        for i in corners {
            sums[i].0 += u;
            sums[i].1 += v;
        }
    }
    let tangent = |&i: &u32| {
        let (normal, (u, v)) = (primitive.normals[i as usize], sums[i as usize]);
        let tangent = u.reject_from_normalized(normal).try_normalize()?;
        let sign = if normal.cross(tangent).dot(v) < 0.0 { -1.0 } else { 1.0 };
        Some(tangent.extend(sign))
    };
    primitive.triangles.iter().flatten().map(tangent).collect()
}

/// Any unit tangent at a normal, for where the texture coordinates say nothing.
fn arbitrary(normal: Vec3) -> Vec4 {
    normal.any_orthonormal_vector().extend(1.0)
}

/// Writes the tangents of corners to vertices, adding vertices where corners disagree.
fn split(primitive: &mut Primitive, corners: &[Option<Vec4>]) {
    let mut first: Vec<Option<Vec4>> = vec![None; primitive.positions.len()];
    let mut others: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let Primitive { positions, normals, uvs, colors, triangles, .. } = primitive;
    for (corner, index) in corners.iter().zip(triangles.iter_mut().flatten()) {
        let vertex = *index as usize;
        let usable = corner.filter(|t| t.is_finite() && t.truncate().length_squared() > 0.0);
        let tangent = usable.unwrap_or_else(|| arbitrary(normals[vertex]));
        match first[vertex] {
            None => first[vertex] = Some(tangent),
            Some(same) if same == tangent => {}
            Some(_) => {
                *index = *others.entry((*index, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                    positions.push(positions[vertex]);
                    normals.push(normals[vertex]);
                    for set in uvs.iter_mut() {
                        set.push(set[vertex]);
                    }
                    if !colors.is_empty() {
                        colors.push(colors[vertex]);
                    }
                    first.push(Some(tangent));
                    (positions.len() - 1) as u32
                });
            }
        }
    }
    primitive.tangents =
        first.iter().zip(normals.iter()).map(|(t, &n)| t.unwrap_or_else(|| arbitrary(n))).collect();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of triangles in the plane z = 0, with u along `u` and v perpendicular to it, or mirrored.
    fn fan(u: Vec2, mirrored: bool) -> Primitive {
        let rim = (0..8).map(|i| Vec2::from_angle(i as f32 * std::f32::consts::FRAC_PI_4));
        let flat: Vec<Vec2> = std::iter::once(Vec2::ZERO).chain(rim).collect();
        let v = if mirrored { -u.perp() } else { u.perp() };
        Primitive {
            positions: flat.iter().map(|p| p.extend(0.0)).collect(),
            normals: vec![Vec3::Z; flat.len()],
            uvs: vec![flat.iter().map(|p| Vec2::new(p.dot(u), p.dot(v))).collect()],
            triangles: (0..8).map(|i| [0, 1 + i, 1 + (i + 1) % 8]).collect(),
            ..Primitive::default()
        }
    }

    #[test]
    fn both_ways_give_the_direction_of_u() {
        for (u, mirrored) in [(Vec2::X, false), (Vec2::new(0.6, 0.8), false), (Vec2::new(0.6, -0.8), true)] {
            let mut primitive = fan(u, mirrored);
            let expected = u.extend(0.0).extend(if mirrored { -1.0 } else { 1.0 });
            for tangent in averages(&primitive, &primitive.uvs[0]) {
                let tangent = tangent.expect("a tangent");
                assert!((tangent - expected).length() < 1e-5, "{tangent} is not {expected}");
            }
            complete(&mut primitive, 0);
            assert_eq!(primitive.tangents.len(), primitive.positions.len());
            for tangent in &primitive.tangents {
                assert!((*tangent - expected).length() < 1e-5, "{tangent} is not {expected}");
            }
        }
    }

    #[test]
    fn crowds_are_counted() {
        let mut primitive = fan(Vec2::X, false);
        // The hub has 8 equal corners, each of the 8 vertices of the rim has 2.
        assert_eq!(comparisons(&primitive, &primitive.uvs[0]), 8 + 8 * 2);
        super::super::mesh::unshare(&mut primitive);
        let uvs: Vec<Vec2> = (0..24).map(|i| Vec2::splat(i as f32)).collect();
        assert_eq!(comparisons(&primitive, &uvs), 8 * 8 + 8 * 2 * 2);
    }

    #[test]
    fn no_texture_coordinates_still_give_unit_tangents() {
        let mut primitive = fan(Vec2::X, false);
        primitive.uvs.clear();
        complete(&mut primitive, 3);
        for (tangent, normal) in primitive.tangents.iter().zip(&primitive.normals) {
            assert!(tangent.truncate().is_normalized() && tangent.truncate().dot(*normal).abs() < 1e-6);
        }
    }
}
