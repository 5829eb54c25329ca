//! How far is the boundary at least?
//!
//! A uniform grid stores the distance d from each cell's centre c to the mesh, rounded down. Distance is a Lipschitz
//! function with constant 1, so `d(p) >= d(c) - |p - c|` at any p, inside the cell or not. A walk whose next step is
//! shorter than the bound stays inside and needs no ray query.

use super::mesh::MeshGeometry;
use glam::{UVec3, Vec3};
use rayon::prelude::*;

/// Cells along the longest axis, by default.
const RESOLUTION: u32 = 96;
/// Part of a distance that the search may miss; it ends early where many triangles are about equally far.
const SEARCH_SLACK: f32 = 0.01;
/// Rounding of coordinates and distances, relative to the largest coordinate.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// A conservative lower bound of the distance to a mesh, as a function of position.
#[derive(Clone, Debug)]
pub struct DistanceBound {
    min: Vec3,
    cell: f32,
    inverse_cell: f32,
    last: Vec3,
    stride: UVec3,
    /// Bounds at cell centres, x fastest.
    distances: Vec<f32>,
}

impl DistanceBound {
    /// Builds with 96 cells along the longest axis of the mesh's box. Deterministic.
    pub fn build(mesh: &MeshGeometry) -> Self {
        Self::with_resolution(mesh, RESOLUTION)
    }

    /// Builds with the given number of cells (clamped to 1–512) along the longest axis.
    pub fn with_resolution(mesh: &MeshGeometry, resolution: u32) -> Self {
        let bounds = mesh.bounds();
        let extent = bounds.extent();
        let longest = extent.max_element();
        if longest <= 0.0 {
            return Self::nothing();
        }
        let cell = longest / resolution.clamp(1, 512) as f32;
        let size = (extent / cell).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(512));
        let center = |x: u32, y: u32, z: u32| bounds.min + cell * (UVec3::new(x, y, z).as_vec3() + 0.5);
        let rounding = ROUNDING * (bounds.min.abs().max(bounds.max.abs()).max_element() + longest);
        let slice = |z: u32| {
            let mut out = vec![0.0; (size.x * size.y) as usize];
            // An upper bound of the distance at the cell before; neighbours lie side by side on the way.
            let mut above = f32::INFINITY;
            for y in 0..size.y {
                for step in 0..size.x {
                    let x = if y % 2 == 0 { step } else { size.x - 1 - step };
                    let reach = above + 1.001 * cell;
                    let (lower, upper) = mesh.distance_range(center(x, y, z), reach, SEARCH_SLACK);
                    above = upper;
                    out[(y * size.x + x) as usize] = (lower - rounding).max(0.0);
                }
            }
            out
        };
        let distances: Vec<Vec<f32>> = (0..size.z).into_par_iter().map(slice).collect();
        Self {
            min: bounds.min,
            cell,
            inverse_cell: 1.0 / cell,
            last: (size - 1).as_vec3(),
            stride: UVec3::new(1, size.x, size.x * size.y),
            distances: distances.concat(),
        }
    }

    fn nothing() -> Self {
        Self {
            min: Vec3::ZERO,
            cell: 0.0,
            inverse_cell: 0.0,
            last: Vec3::ZERO,
            stride: UVec3::ZERO,
            distances: vec![0.0],
        }
    }

    /// A number in \[0, distance to the mesh\], in units of the mesh's space. Zero far outside of the mesh's box.
    #[inline]
    pub fn bound(&self, p: Vec3) -> f32 {
        // `max` turns NaN into the first cell.
        let index = ((p - self.min) * self.inverse_cell).floor().max(Vec3::ZERO).min(self.last);
        let center = self.min + self.cell * (index + 0.5);
        let at = index.as_uvec3() * self.stride;
        let distance = self.distances[(at.x + at.y + at.z) as usize];
        (distance - p.distance(center)).max(0.0)
    }

    /// A distance within which the mesh lies from any point of the grid whose [`DistanceBound::bound`] is `bound`.
    #[inline]
    pub fn reach(&self, bound: f32) -> f32 {
        // The distance is at most that of the centre and the way to it, at most √3/2 of a cell, twice.
        1.05 * bound + 2.0 * self.cell
    }

    /// Bytes of memory.
    pub fn memory(&self) -> usize {
        size_of::<Self>() + size_of_val(self.distances.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::{Random, cuboid, place, soup, sphere};
    use super::*;

    #[test]
    fn bounds_are_below_the_distance_and_close_to_it() {
        let shapes = [
            (sphere(4, 0.0, 1), 0.9),
            (sphere(4, 0.3, 2), 0.7),
            (cuboid(Vec3::splat(-1.0), Vec3::new(1.0, 0.2, 0.5)), 0.8),
            (soup(50, 0.5, 3), 0.5),
        ];
        for (shape, worth) in shapes {
            for (scale, shift) in
                [(1.0, Vec3::ZERO), (1.0e-6, Vec3::ZERO), (1.0e6, Vec3::ZERO), (1.0, 9.0 * Vec3::ONE)]
            {
                let (positions, triangles) = place(shape.clone(), scale, shift);
                let mesh = MeshGeometry::build(&positions, &triangles);
                let bound = DistanceBound::build(&mesh);
                let mut random = Random(4);
                let (mut sum, mut all) = (0.0, 0.0);
                for _ in 0..3000 {
                    let p = 1.1 * scale * random.cube() + shift;
                    let truth = mesh.nearest(p, f32::INFINITY).map_or(f32::NAN, |n| n.distance);
                    let b = bound.bound(p);
                    assert!(b >= 0.0 && b <= truth, "{b} is above {truth} at {p}");
                    if mesh.bounds().contains(p) {
                        sum += b;
                        all += truth;
                    }
                }
                assert!(sum > worth * all, "{} of the distance", sum / all);
            }
        }
    }

    #[test]
    fn odd_meshes_and_points_give_zero() {
        let nothing = DistanceBound::build(&MeshGeometry::build(&[], &[]));
        assert_eq!(nothing.bound(Vec3::ONE), 0.0);
        let (positions, triangles) = sphere(2, 0.0, 1);
        let bound = DistanceBound::with_resolution(&MeshGeometry::build(&positions, &triangles), 9);
        assert_eq!(bound.bound(Vec3::splat(100.0)), 0.0);
        assert_eq!(bound.bound(Vec3::splat(f32::NAN)), 0.0);
        assert!(bound.memory() < 9 * 9 * 9 * 4 + 200);
        let point = MeshGeometry::build(&[Vec3::ONE, Vec3::ONE, Vec3::ONE], &[[0, 1, 2]]);
        assert_eq!(DistanceBound::build(&point).bound(Vec3::ONE), 0.0);
    }
}
