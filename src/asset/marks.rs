//! Points and lines (glTF 2.0 §3.7.2.1, modes 0 to 3) as something that has a surface: small spheres and thin tubes.
//!
//! glTF leaves their size to the viewer. Here it is a fixed fraction of the primitive's own extent, so that it does not
//! depend on units. Spheres are icosahedra, tubes have six sides and a sphere at each end, and all are shaded smoothly.
//! Material, colours and texture coordinates are those of the vertices.

use glam::Vec3;

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::primitive::Primitive;

/// Radius of a point, relative to the diagonal of the bounding box.
const POINT_RADIUS: f32 = 1.0 / 100.0;
/// Radius of a line, likewise.
const LINE_RADIUS: f32 = 1.0 / 200.0;
/// Sides of a tube.
const SIDES: u32 = 6;

/// What the indices of points and lines mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marks {
    /// Mode 0.
    Points,
    /// Mode 1: two indices a line.
    Lines,
    /// Mode 2: each index continues the line, and the last one is joined to the first.
    Loop,
    /// Mode 3: each index continues the line.
    Strip,
}

impl Marks {
    /// The marks of a `mode`.
    pub fn from_mode(mode: usize) -> Option<Self> {
        [Self::Points, Self::Lines, Self::Loop, Self::Strip].get(mode).copied()
    }

    /// The lines of a sequence of indices; what is left over at the end is left out.
    pub fn segments(self, indices: &[u32]) -> Vec<[u32; 2]> {
        let mut segments: Vec<[u32; 2]> = match self {
            Self::Points => Vec::new(),
            Self::Lines => indices.as_chunks::<2>().0.to_vec(),
            Self::Loop | Self::Strip => indices.windows(2).map(|w| [w[0], w[1]]).collect(),
        };
        if self == Self::Loop
            && let (Some(&first), Some(&last), true) = (indices.first(), indices.last(), indices.len() > 2)
        {
            segments.push([last, first]);
        }
        segments
    }

    /// Whether a sequence of `count` indices is complete.
    pub fn is_whole(self, count: usize) -> bool {
        match self {
            Self::Points => true,
            Self::Lines => count.is_multiple_of(2),
            Self::Loop | Self::Strip => count >= 2,
        }
    }
}

impl Loader<'_> {
    /// Gives the points or lines of a primitive, which has been posed, a surface.
    pub(crate) fn marks(&mut self, primitive: &mut Primitive, json: &Json<'_>) -> Result<(), AssetError> {
        let Some((marks, indices)) = primitive.marks.take() else { return Ok(()) };
        let segments = marks.segments(&indices);
        let mut points = match marks {
            Marks::Points => indices,
            _ => segments.iter().flatten().copied().collect(),
        };
        points.sort_unstable();
        points.dedup();
        let vertices = points.len() as u64 * 12 + segments.len() as u64 * u64::from(2 * SIDES);
        let triangles = points.len() as u64 * 20 + segments.len() as u64 * u64::from(2 * SIDES);
        let (most_vertices, most_triangles) = self.room();
        let what = if marks == Marks::Points { "spheres for points" } else { "tubes for lines" };
        let pointer = json.pointer();
        Self::within(vertices, most_vertices, pointer, &format!("the {what}, in vertices,"), "vertices")?;
        Self::within(triangles, most_triangles, pointer, &format!("the {what}, in triangles,"), "triangles")?;

        let usable = points.iter().map(|&i| primitive.positions[i as usize]).filter(|p| p.is_finite());
        let (low, high) =
            usable.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let fraction = if marks == Marks::Points { POINT_RADIUS } else { LINE_RADIUS };
        let radius = (high - low).length() * fraction;
        if !(radius > 0.0 && radius.is_finite()) {
            let message = "points and lines without any extent have no size and are left out";
            self.note(pointer, message);
            primitive.triangles.clear();
            return Ok(());
        }
        self.note(
            pointer,
            format!("points and lines have no surface; {what} are shown, of radius {radius:.3e}"),
        );
        let mut shape = Shape::new(primitive, radius);
        points.iter().for_each(|&i| shape.sphere(i));
        segments.iter().for_each(|&s| shape.tube(s));
        *primitive = shape.out;
        Ok(())
    }
}

/// The vertices and edges of a regular icosahedron come from the golden ratio.
fn icosahedron() -> ([Vec3; 12], [[u32; 3]; 20]) {
    let golden = f32::midpoint(1.0, 5.0_f32.sqrt());
    let corner = |i: usize| {
        let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
        match i / 4 {
            0 => Vec3::new(0.0, a, b),
            1 => Vec3::new(a, b, 0.0),
            _ => Vec3::new(b, 0.0, a),
        }
    };
    let corners: [Vec3; 12] = std::array::from_fn(|i| corner(i).normalize());
    // Neighbours are the closest of all.
    let near = |a: usize, b: usize| corners[a].dot(corners[b]) > 0.4;
    let mut triangles = [[0; 3]; 20];
    let mut next = 0;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) && next < triangles.len() {
                    let outwards = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
                    let [b, c] = if outwards { [b, c] } else { [c, b] };
                    triangles[next] = [a as u32, b as u32, c as u32];
                    next += 1;
                }
            }
        }
    }
    (corners, triangles)
}

/// A primitive that grows by spheres and tubes around the vertices of another.
struct Shape<'p> {
    source: &'p Primitive,
    radius: f32,
    ball: ([Vec3; 12], [[u32; 3]; 20]),
    out: Primitive,
}

impl<'p> Shape<'p> {
    fn new(source: &'p Primitive, radius: f32) -> Self {
        let out = Primitive {
            material: source.material,
            uvs: vec![Vec::new(); source.uvs.len()],
            ..Primitive::default()
        };
        Self { source, radius, ball: icosahedron(), out }
    }

    /// Adds a vertex that lies off vertex `of` in the direction of `normal`.
    fn vertex(&mut self, of: u32, normal: Vec3) {
        let of = of as usize;
        self.out.positions.push(self.source.positions[of] + normal * self.radius);
        self.out.normals.push(normal);
        for (set, from) in self.out.uvs.iter_mut().zip(&self.source.uvs) {
            set.push(from[of]);
        }
        self.out.colors.extend(self.source.colors.get(of).copied());
    }

    fn sphere(&mut self, at: u32) {
        let first = self.out.positions.len() as u32;
        let (corners, triangles) = self.ball;
        corners.into_iter().for_each(|normal| self.vertex(at, normal));
        self.out.triangles.extend(triangles.map(|t| t.map(|i| i + first)));
    }

    fn tube(&mut self, [a, b]: [u32; 2]) {
        let along = self.source.positions[b as usize] - self.source.positions[a as usize];
        let Some(along) = along.try_normalize() else { return };
        let (x, y) = along.any_orthonormal_pair();
        let first = self.out.positions.len() as u32;
        for side in 0..SIDES {
            let (sin, cos) = (side as f32 * std::f32::consts::TAU / SIDES as f32).sin_cos();
            let normal = x * cos + y * sin;
            self.vertex(a, normal);
            self.vertex(b, normal);
        }
        for side in 0..SIDES {
            let [i, j] = [2 * side, 2 * ((side + 1) % SIDES)].map(|k| k + first);
            self.out.triangles.extend([[i, j, j + 1], [i, j + 1, i + 1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Builder, told};
    use super::*;
    use crate::asset::Severity;
    use crate::geometry::{MeshGeometry, Topology};
    use serde_json::json;

    #[test]
    fn indices_make_lines() {
        let indices = [4, 5, 6, 7, 8];
        assert_eq!(Marks::Lines.segments(&indices), [[4, 5], [6, 7]]);
        assert_eq!(Marks::Strip.segments(&indices[..3]), [[4, 5], [5, 6]]);
        assert_eq!(Marks::Loop.segments(&indices[..3]), [[4, 5], [5, 6], [6, 4]]);
        assert_eq!(Marks::Loop.segments(&indices[..2]), [[4, 5]]);
        assert!(Marks::Points.segments(&indices).is_empty());
    }

    #[test]
    fn a_sphere_is_a_closed_icosahedron_that_faces_outwards() {
        let (corners, triangles) = icosahedron();
        let topology = Topology::analyse(&MeshGeometry::build(&corners, &triangles));
        assert!(topology.is_closed() && topology.components.len() == 1);
        // A regular icosahedron of edge a has the volume 5/12 (3 + √5) a³; in the unit sphere a = 1/sin 72°.
        assert!((topology.components[0].signed_volume - 2.536_150_7).abs() < 1e-5);
    }

    #[test]
    fn points_and_lines_are_seen_in_the_colours_of_their_vertices() {
        for (mode, triangles) in [(0, 3 * 20), (1, 20), (2, 3 * 20 + 3 * 12), (3, 3 * 20 + 2 * 12)] {
            let mut b = Builder::triangle();
            let colors = b.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            let primitive = &mut b.json["meshes"][0]["primitives"][0];
            primitive["mode"] = json!(mode);
            primitive["attributes"]["COLOR_0"] = json!(colors);
            let loaded = b.loaded();
            let mesh = &loaded.scene.meshes[0];
            let a_line = if mode == 1 { 20 + 12 } else { 0 };
            assert_eq!(mesh.triangles.len(), triangles + a_line, "mode {mode}");
            assert!(told(&loaded, Severity::Note, "/meshes/0/primitives/0"));
            for (p, c) in mesh.positions.iter().zip(&mesh.colors) {
                let vertex = [Vec3::ZERO, Vec3::X, Vec3::Y]
                    [c.truncate().to_array().iter().position(|&x| x == 1.0).expect("a colour")];
                let diagonal = if mode == 1 { 1.0 } else { 2_f32.sqrt() };
                let distance = p.distance(vertex) / diagonal;
                let radius = if mode == 0 { POINT_RADIUS } else { LINE_RADIUS };
                assert!((distance - radius).abs() < 1e-6, "{distance}");
            }
        }
    }

    #[test]
    fn a_single_point_has_no_size() {
        let mut b = Builder::triangle();
        b.json["meshes"][0]["primitives"][0]["mode"] = json!(0);
        b.json["accessors"][0]["count"] = json!(1);
        assert!(b.loaded().scene.meshes.is_empty());
    }
}
