//! Tangents where a normal map needs them and the file has none: MikkTSpace, as glTF 2.0 §3.7.2.1 asks.
//!
//! MikkTSpace gives a tangent to each corner of a triangle. Corners that share a vertex but not a tangent (at seams of
//! the texture) get a vertex each.
//!
//! MikkTSpace has v grow upwards, glTF downwards. The bitangent of glTF points up in the picture, as the green of
//! normal maps does, so its sign is the opposite of MikkTSpace's.
//!
//! Texture coordinates are those at which the map is read: where KHR_texture_transform turns or mirrors the picture, the
//! vectors in it turn with it. Tangents that a file gives are left alone: they are the space that the map is in, whatever
//! its coordinates.
//!
//! Nearly all vertices of a mesh are in the middle, or at an open end, of one fan of triangles; what MikkTSpace gives to
//! those is a closed form ([`super::fans`]). The others, at mirrored textures and where surfaces touch, are left to the
//! library, with the triangles around them: what a corner gets depends on the triangles at its place alone. Only triangles
//! without texture area hand on what they got elsewhere; a primitive that has any is left to the library as a whole.
//!
//! The library compares all different corners at one place with each other. A mesh that crowds so many there that this
//! would take more than some seconds gets plain averages of its triangles' tangents instead (Lengyel 2001).

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Mat2, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::fans::Fans;
use super::mesh::flatten;
use super::primitive::Primitive;

/// Comparisons of corners that are worth waiting for; each takes some 20 ns.
const MOST_COMPARISONS: u64 = 100_000_000;

/// Some triangles of a primitive, by their indices, and the tangents of their corners.
struct Corners<'p> {
    primitive: &'p Primitive,
    uvs: &'p [Vec2],
    triangles: &'p [u32],
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[self.triangles[face] as usize][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
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
        self.tangents[3 * face + corner] =
            space.map(|s| Vec4::from(s.tangent_encoded()) * Vec4::new(1.0, 1.0, 1.0, -1.0));
    }
}

/// Makes sure that a primitive with a normal map on texture coordinate set `uv_set`, which it reads through `transform`, has
/// tangents, and normals for them to be perpendicular to.
pub(crate) fn complete(primitive: &mut Primitive, uv_set: usize, transform: Mat2) {
    if primitive.normals.is_empty() {
        primitive.tangents.clear();
        flatten(primitive);
    }
    if !primitive.tangents.is_empty() {
        return;
    }
    let Some(uvs) = primitive.uvs.get(uv_set) else { return split(primitive, |_, _| None) };
    let uvs = &turned(uvs, transform);
    let (fans, hard) = match Fans::new(primitive, uvs) {
        Some(fans) => {
            let hard = fans.others(primitive);
            (fans.tangents, hard)
        }
        None => (Vec::new(), (0..primitive.triangles.len() as u32).collect()),
    };
    let corners = if comparisons(primitive, uvs, &hard) <= MOST_COMPARISONS {
        mikktspace(primitive, uvs, &hard)
    } else {
        averages(primitive, uvs, &hard)
    };
    split(primitive, |corner, vertex| match fans.get(vertex) {
        Some(Some(tangent)) => Some(*tangent),
        _ => {
            let place = hard.binary_search(&((corner / 3) as u32)).ok()?;
            corners[3 * place + corner % 3]
        }
    });
}

/// Texture coordinates as the picture on the surface has them. Lengths do not matter, so what only scales, or leaves no
/// picture, changes nothing.
fn turned(uvs: &[Vec2], transform: Mat2) -> Cow<'_, [Vec2]> {
    let [u, v] = [transform.x_axis, transform.y_axis];
    let only_scales = u.y == 0.0 && v.x == 0.0 && u.x > 0.0 && v.y > 0.0;
    if only_scales || transform.determinant() == 0.0 || !transform.is_finite() {
        return Cow::Borrowed(uvs);
    }
    Cow::Owned(uvs.par_iter().map(|&uv| transform * uv).collect())
}

/// The tangents that the library gives to the corners of those triangles.
fn mikktspace(primitive: &Primitive, uvs: &[Vec2], triangles: &[u32]) -> Vec<Option<Vec4>> {
    let mut corners = Corners { primitive, uvs, triangles, tangents: vec![None; 3 * triangles.len()] };
    // Its error type has no values.
    let _ = generate_tangents(&mut corners);
    corners.tangents
}

/// How many pairs of corners of those triangles MikkTSpace may compare: at each place, all corners with all different ones.
fn comparisons(primitive: &Primitive, uvs: &[Vec2], triangles: &[u32]) -> u64 {
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    let mut corners = vec![0_u64; if triangles.is_empty() { 0 } else { primitive.positions.len() }];
    let used = triangles.iter().flat_map(|&t| primitive.triangles[t as usize]);
    used.for_each(|i| corners[i as usize] += 1);
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

/// A tangent for each corner of those triangles: the average over all triangles of its vertex, made perpendicular to the
/// normal.
fn averages(primitive: &Primitive, uvs: &[Vec2], triangles: &[u32]) -> Vec<Option<Vec4>> {
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
        let sign = if normal.cross(tangent).dot(v) < 0.0 { 1.0 } else { -1.0 };
        Some(tangent.extend(sign))
    };
    triangles.iter().flat_map(|&t| &primitive.triangles[t as usize]).map(tangent).collect()
}

/// Any unit tangent at a normal, for where the texture coordinates say nothing.
fn arbitrary(normal: Vec3) -> Vec4 {
    normal.any_orthonormal_vector().extend(1.0)
}

/// Writes the tangents of corners, given by their number and their vertex, to vertices, adding vertices where corners
/// disagree.
fn split(primitive: &mut Primitive, tangent_of: impl Fn(usize, usize) -> Option<Vec4>) {
    let mut first: Vec<Option<Vec4>> = vec![None; primitive.positions.len()];
    let mut others: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let Primitive { positions, normals, uvs, colors, triangles, .. } = primitive;
    for (corner, index) in triangles.iter_mut().flatten().enumerate() {
        let vertex = *index as usize;
        let usable =
            tangent_of(corner, vertex).filter(|t| t.is_finite() && t.truncate().length_squared() > 0.0);
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

    const ALL: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

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
            let expected = u.extend(0.0).extend(if mirrored { 1.0 } else { -1.0 });
            for tangent in averages(&primitive, &primitive.uvs[0], &ALL) {
                let tangent = tangent.expect("a tangent");
                assert!((tangent - expected).length() < 1e-5, "{tangent} is not {expected}");
            }
            complete(&mut primitive, 0, Mat2::IDENTITY);
            assert_eq!(primitive.tangents.len(), primitive.positions.len());
            for tangent in &primitive.tangents {
                assert!((*tangent - expected).length() < 1e-5, "{tangent} is not {expected}");
            }
        }
    }

    /// A square that shows a picture upright: v is 0 at its upper edge. Green of a normal map is up (glTF 2.0 §3.9.3).
    #[test]
    fn the_bitangent_of_an_upright_picture_points_up() {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let mut square = Primitive {
            positions: corners.iter().map(|c| c.extend(0.0)).collect(),
            normals: vec![Vec3::Z; 4],
            uvs: vec![corners.iter().map(|c| Vec2::new(c.x, 1.0 - c.y)).collect()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Primitive::default()
        };
        let averaged = averages(&square, &square.uvs[0], &[0, 1]);
        let library = mikktspace(&square, &square.uvs[0], &[0, 1]);
        complete(&mut square, 0, Mat2::IDENTITY);
        for tangent in averaged.into_iter().chain(library).flatten().chain(square.tangents) {
            let up = Vec3::Z.cross(tangent.truncate()) * tangent.w;
            assert!(
                (tangent.truncate() - Vec3::X).length() < 1e-6 && (up - Vec3::Y).length() < 1e-6,
                "{tangent}"
            );
        }
    }

    #[test]
    fn crowds_are_counted() {
        let mut primitive = fan(Vec2::X, false);
        // The hub has 8 equal corners, each of the 8 vertices of the rim has 2.
        assert_eq!(comparisons(&primitive, &primitive.uvs[0], &ALL), 8 + 8 * 2);
        super::super::mesh::unshare(&mut primitive);
        let uvs: Vec<Vec2> = (0..24).map(|i| Vec2::splat(i as f32)).collect();
        assert_eq!(comparisons(&primitive, &uvs, &ALL), 8 * 8 + 8 * 2 * 2);
    }

    #[test]
    fn no_texture_coordinates_still_give_unit_tangents() {
        let mut primitive = fan(Vec2::X, false);
        primitive.uvs.clear();
        complete(&mut primitive, 3, Mat2::IDENTITY);
        for (tangent, normal) in primitive.tangents.iter().zip(&primitive.normals) {
            assert!(tangent.truncate().is_normalized() && tangent.truncate().dot(*normal).abs() < 1e-6);
        }
    }

    /// A bumpy sheet whose texture is mirrored beyond x = 0, with a seam, a sharp edge, a rift, a place where it is pinched,
    /// and vertices that are stored twice.
    fn sheet() -> Primitive {
        const N: u32 = 12;
        let mut p = Primitive { uvs: vec![Vec::new()], ..Primitive::default() };
        for i in 0..=N {
            for j in 0..=N {
                let (x, y) = (i as f32 / 6.0 - 1.0, j as f32 / 6.0 - 1.0);
                p.positions.push(Vec3::new(x, y, 0.2 * (3.0 * x).sin() * (2.0 * y).cos()));
                p.normals.push(Vec3::new(0.3 * y, -0.2 * x, 1.0).normalize());
                p.uvs[0].push(Vec2::new(x.abs() + 0.1 * y, y + 0.05 * x * x));
            }
        }
        let at = |i: u32, j: u32| i * (N + 1) + j;
        for i in 0..N {
            for j in 0..N {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                p.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        // From the row of a seam on, triangles have vertices of their own: with other texture coordinates, with other
        // normals, or with the same of both.
        let rows = [(3, Vec2::ONE, 0.0), (6, Vec2::ZERO, 1.0), (9, Vec2::ZERO, 0.0)];
        for (row, shift, bend) in rows {
            let first = p.positions.len() as u32;
            for j in 0..=N {
                let old = at(row, j) as usize;
                p.positions.push(p.positions[old]);
                p.normals.push((p.normals[old] + bend * Vec3::X).normalize());
                let uv = p.uvs[0][old] + shift;
                p.uvs[0].push(uv);
            }
            for triangle in &mut p.triangles[(2 * N * row) as usize..(2 * N * (row + 1)) as usize] {
                for v in triangle.iter_mut().filter(|v| (at(row, 0)..=at(row, N)).contains(v)) {
                    *v += first - at(row, 0);
                }
            }
        }
        // Two fans that touch at one vertex, and one triangle on its back.
        p.triangles.retain(|t| *t != [at(1, 7), at(2, 7), at(2, 8)] && *t != [at(2, 8), at(3, 9), at(2, 9)]);
        p.triangles[40].swap(0, 1);
        p
    }

    #[test]
    fn fans_and_the_rest_are_what_the_library_makes_of_the_whole() {
        let p = sheet();
        let all: Vec<u32> = (0..p.triangles.len() as u32).collect();
        let whole = mikktspace(&p, &p.uvs[0], &all);
        let fans = Fans::new(&p, &p.uvs[0]).expect("all triangles have texture area");
        let hard = fans.others(&p);
        let rest = mikktspace(&p, &p.uvs[0], &hard);
        let (mut by_fan, mut by_rest) = (0, 0);
        for (corner, &vertex) in p.triangles.iter().flatten().enumerate() {
            let expected = whole[corner].expect("a tangent");
            let found = match fans.tangents[vertex as usize] {
                Some(tangent) => {
                    by_fan += 1;
                    tangent
                }
                None => {
                    by_rest += 1;
                    let place = hard.binary_search(&((corner / 3) as u32)).expect("it is among the others");
                    rest[3 * place + corner % 3].expect("a tangent")
                }
            };
            // Sums of six terms in another order.
            assert!((found - expected).length() < 1e-5, "corner {corner}: {found} for {expected}");
        }
        assert!(by_fan > 600 && by_rest > 20, "{by_fan} by fan, {by_rest} by the library");
    }

    #[test]
    fn a_triangle_without_texture_area_leaves_all_to_the_library() {
        let mut p = sheet();
        assert!(Fans::new(&p, &p.uvs[0]).is_some());
        let [a, b, _] = p.triangles[5].map(|i| i as usize);
        p.uvs[0][a] = p.uvs[0][b];
        assert!(Fans::new(&p, &p.uvs[0]).is_none());
        let all: Vec<u32> = (0..p.triangles.len() as u32).collect();
        let whole = mikktspace(&p, &p.uvs[0], &all);
        let before = p.triangles.clone();
        complete(&mut p, 0, Mat2::IDENTITY);
        for (corner, &vertex) in p.triangles.iter().flatten().enumerate() {
            assert_eq!(
                Some(p.tangents[vertex as usize]),
                whole[corner],
                "corner {corner} of {}",
                before.len()
            );
        }
    }
}
