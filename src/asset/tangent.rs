//! Tangents where a normal map needs them and the file has none: MikkTSpace, as glTF 2.0 §3.7.2.1 asks.
//!
//! MikkTSpace gives a tangent to each corner of a triangle. Corners that share a vertex but not a tangent (at seams of
//! the texture) get a vertex each.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use super::mesh::flatten;
use super::primitive::Primitive;

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
    let missing = Vec::new();
    let uvs = match primitive.uvs.get(uv_set) {
        Some(uvs) => uvs,
        None => &missing,
    };
    let mut corners = vec![None; 3 * primitive.triangles.len()];
    if !uvs.is_empty() {
        let mut geometry = Corners { primitive, uvs, tangents: corners };
        // Its error type has no values.
        let _ = generate_tangents(&mut geometry);
        corners = geometry.tangents;
    }
    split(primitive, &corners);
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
