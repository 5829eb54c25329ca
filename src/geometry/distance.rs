//! How far is the boundary at least?
//!
//! Space is cut into cells. For the centre c of its cell each holds two facts about the mesh:
//!
//! - the distance d from c to the mesh. Distance is a Lipschitz function with constant 1, so the mesh is at least
//!   `d - |p - c|` away from any point p;
//! - a plane: every triangle that reaches into the ball of radius ρ about c lies where `n · (x - c) >= δ`, with
//!   `|n| <= 1`. So the mesh is at least `min(δ - n · (p - c), ρ - |p - c|)` away: as good as the distance itself where the
//!   surface is nearly flat, and cells need not be small.
//!
//! A walk whose next step is shorter than the bound stays inside and needs no ray query, nor does one whose step begins
//! and ends in the ball and before the plane.
//!
//! Cells are filled when they are first asked for: most of the volume is never visited. What a cell holds is a function
//! of the cell alone, so it does not matter which thread fills it, or whether two do. Cells are stored in bricks of 4³,
//! since walks stay in a neighbourhood; one search serves a brick that is deep inside.

use super::mesh::MeshGeometry;
use super::offset::ROUNDING;
use glam::{UVec3, Vec3, Vec3A};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Cells along the longest axis, by default.
pub(super) const RESOLUTION: u32 = 64;
/// ρ, in cells: more than the half diagonal of a cell, and so little that curved surfaces are nearly flat there.
const BALL: f32 = 1.25;
/// A brick is deep where its centre is at least this many cells away from the mesh: then its cells, whose centres are at
/// most 2.6 cells from there, are farther away than ρ.
const DEEP: f32 = 6.0;
/// Units of a stored distance in the longest edge of the box.
const DISTANCE_UNITS: f32 = 4_000_000.0;
/// Largest δ that is stored, in cells.
const FARTHEST_PLANE: f32 = 4.0;
/// Part of a distance that the search may miss; it ends early where many triangles are about equally far.
const SEARCH_SLACK: f32 = 0.01;

/// A conservative lower bound of the distance to a mesh, as a function of position.
#[derive(Debug)]
pub struct DistanceBound {
    min: Vec3A,
    cell: f32,
    inverse_cell: f32,
    /// Lengths of the units of d and of δ.
    distance_unit: f32,
    plane_unit: f32,
    /// Largest index on each axis.
    last: Vec3A,
    /// Bricks on x, and on x times y.
    bricks: [u32; 2],
    rounding: f32,
    /// [`Cell::pack`]; zero where nobody has asked yet.
    pub(super) cells: Box<[AtomicU64]>,
    /// Lower bounds of the distance from the bricks' centres, as bits of floats; zero where nobody has asked yet.
    brick_distances: Box<[AtomicU32]>,
}

/// What is known about the surroundings of a cell's centre, in units.
#[derive(Clone, Copy, Debug)]
struct Cell {
    distance: u32,
    normal: [i8; 3],
    plane: i16,
}

/// No plane.
const NOWHERE: i16 = i16::MIN;

impl Cell {
    /// One word that is never zero.
    fn pack(self) -> u64 {
        let [x, y, z] = self.normal.map(|n| u64::from(n as u8));
        let plane = u64::from(self.plane as u16);
        u64::from(self.distance + 1) << 40 | plane << 24 | z << 16 | y << 8 | x
    }

    /// Not longer than 1.
    #[inline]
    fn normal(&self) -> Vec3A {
        let [x, y, z] = self.normal.map(|n| f32::from(n) * (1.0 / 127.0));
        Vec3A::new(x, y, z)
    }

    #[inline]
    fn unpack(word: u64) -> Self {
        Self {
            distance: (word >> 40) as u32 - 1,
            normal: [word as i8, (word >> 8) as i8, (word >> 16) as i8],
            plane: (word >> 24) as i16,
        }
    }
}

impl DistanceBound {
    /// 64 cells along the longest axis of the mesh's box.
    pub fn new(mesh: &MeshGeometry) -> Self {
        Self::with_resolution(mesh, RESOLUTION)
    }

    /// The given number of cells (clamped to 1–512) along the longest axis.
    pub fn with_resolution(mesh: &MeshGeometry, resolution: u32) -> Self {
        let bounds = mesh.bounds();
        let extent = if bounds.extent().max_element() > 0.0 { bounds.extent() } else { Vec3::ZERO };
        let longest = extent.max_element();
        let resolution = resolution.clamp(1, 512);
        // A cell without size stands for a mesh without size.
        let cell = longest / resolution as f32;
        let size = (extent / cell).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(512));
        let bricks = (size + 3) / 4;
        let largest = if longest > 0.0 { bounds.min.abs().max(bounds.max.abs()).max_element() } else { 0.0 };
        Self {
            min: if longest > 0.0 { bounds.min.into() } else { Vec3A::ZERO },
            cell,
            inverse_cell: if longest > 0.0 { 1.0 / cell } else { 0.0 },
            distance_unit: longest / DISTANCE_UNITS,
            plane_unit: FARTHEST_PLANE * cell / f32::from(i16::MAX),
            last: (size - 1).as_vec3a(),
            bricks: [bricks.x, bricks.x * bricks.y],
            rounding: ROUNDING * (largest + longest),
            // Memory that the system hands out page by page when it is touched.
            cells: bytemuck::zeroed_slice_box(64 * (bricks.x * bricks.y * bricks.z) as usize),
            brick_distances: bytemuck::zeroed_slice_box((bricks.x * bricks.y * bricks.z) as usize),
        }
    }

    /// A number in \[0, distance from `p` to the mesh\], in units of the mesh's space. Zero far outside of the mesh's box.
    ///
    /// `mesh` is the one given to [`Self::new`].
    #[inline]
    pub fn bound(&self, mesh: &MeshGeometry, p: Vec3) -> f32 {
        let (cell, from_middle) = self.look_up(mesh, p);
        let away = from_middle.length();
        let along = cell.normal().dot(from_middle);
        let by_distance = cell.distance as f32 * self.distance_unit - away;
        let by_plane = (f32::from(cell.plane) * self.plane_unit - along).min(BALL * self.cell - away);
        by_distance.max(by_plane).max(0.0)
    }

    /// [`Self::bound`] at `p`, and whether a way that leads from there by `step` cannot meet the mesh: it stays before
    /// the plane.
    // Asked at each event of a walk; left to itself the compiler sometimes makes a call of it, which costs 1 % of a picture.
    #[inline(always)]
    pub fn bound_ahead(&self, mesh: &MeshGeometry, p: Vec3, step: Vec3) -> (f32, bool) {
        let (cell, from_middle) = self.look_up(mesh, p);
        let away = from_middle.length();
        let normal = cell.normal();
        let by_distance = cell.distance as f32 * self.distance_unit - away;
        let before = f32::from(cell.plane) * self.plane_unit - normal.dot(from_middle);
        let by_plane = before.min(BALL * self.cell - away);
        let ahead = from_middle + Vec3A::from(step);
        let stays = by_plane > 0.0
            && normal.dot(Vec3A::from(step)) < before
            && ahead.length_squared() < BALL * BALL * self.cell * self.cell;
        (by_distance.max(by_plane).max(0.0), stays)
    }

    /// About the outward unit normal of the mesh where it is nearest to `p`; within a cell of the mesh.
    pub fn normal(&self, mesh: &MeshGeometry, p: Vec3) -> Option<Vec3> {
        Vec3::from(self.look_up(mesh, p).0.normal()).try_normalize()
    }

    /// The cell of a point, and the point relative to the cell's centre.
    #[inline]
    fn look_up(&self, mesh: &MeshGeometry, p: Vec3) -> (Cell, Vec3A) {
        let (at, index, q) = self.place(p);
        let word = match self.cells[at].load(Ordering::Relaxed) {
            0 => self.fill(mesh, at, index),
            known => known,
        };
        (Cell::unpack(word), (q - (index + 0.5)) * self.cell)
    }

    /// Asks for the memory of the cell of a point that will be looked at soon.
    #[inline]
    pub fn prefetch(&self, p: Vec3) {
        let (at, _, _) = self.place(p);
        #[cfg(all(target_arch = "x86_64", target_feature = "sse"))]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            // SAFETY: a prefetch has no effect on what a program computes, wherever it points.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(self.cells.as_ptr().wrapping_add(at).cast()) };
        }
        #[cfg(not(all(target_arch = "x86_64", target_feature = "sse")))]
        let _ = at;
    }

    /// The cell of a point: where it is stored, its index on each axis, and the point in units of cells.
    #[inline]
    fn place(&self, p: Vec3) -> (usize, Vec3A, Vec3A) {
        // Adding 2²³ rounds, and leaves a whole number in the low bits. At the face between two cells it does not matter
        // which one is chosen. `max` turns NaN into the first cell.
        const WHOLE: f32 = 8_388_608.0;
        let q = (Vec3A::from(p) - self.min) * self.inverse_cell;
        let shifted = (q - 0.5).max(Vec3A::ZERO).min(self.last) + WHOLE;
        let [x, y, z] = shifted.to_array().map(|i| i.to_bits() & 0x007f_ffff);
        let brick = (x >> 2) + (y >> 2) * self.bricks[0] + (z >> 2) * self.bricks[1];
        let at = (brick << 6 | (z & 3) << 4 | (y & 3) << 2 | x & 3) as usize;
        (at, shifted - WHOLE, q)
    }

    #[cold]
    #[inline(never)]
    fn fill(&self, mesh: &MeshGeometry, at: usize, index: Vec3A) -> u64 {
        let center = self.min + self.cell * (index + 0.5);
        let brick_center = self.min + (4.0 * self.cell) * ((0.25 * index).floor() + 0.5);
        let (brick, apart) =
            (self.brick_distance(mesh, at >> 6, brick_center.into()), center.distance(brick_center));
        let center = Vec3::from(center);
        let lower = if brick >= DEEP * self.cell {
            brick - apart
        } else {
            let reach = 1.001 * ((brick + 2.0 * self.rounding) * (1.0 + 2.0 * SEARCH_SLACK) + apart);
            mesh.distance_at_least(center, reach, SEARCH_SLACK)
        };
        let lower = (lower - self.rounding) * (1.0 - ROUNDING);
        let units = lower / self.distance_unit - 1.0;
        let distance = units.clamp(0.0, 2.0 * DISTANCE_UNITS) as u32;
        let mut cell = Cell { distance, normal: [0; 3], plane: NOWHERE };
        if lower < BALL * self.cell {
            (cell.normal, cell.plane) = self.plane(mesh, center);
        }
        let word = cell.pack();
        self.cells[at].store(word, Ordering::Relaxed);
        word
    }

    /// At most the distance from a brick's centre, and at most [`SEARCH_SLACK`] less.
    fn brick_distance(&self, mesh: &MeshGeometry, brick: usize, center: Vec3) -> f32 {
        let known = f32::from_bits(self.brick_distances[brick].load(Ordering::Relaxed));
        if known > 0.0 {
            return known;
        }
        let lower = mesh.distance_at_least(center, f32::INFINITY, SEARCH_SLACK);
        let lower = (lower - self.rounding).max(f32::MIN_POSITIVE);
        self.brick_distances[brick].store(lower.to_bits(), Ordering::Relaxed);
        lower
    }

    /// The normal and δ of a plane behind which the mesh lies, seen from inside.
    fn plane(&self, mesh: &MeshGeometry, center: Vec3) -> ([i8; 3], i16) {
        let radius = BALL * self.cell;
        let Some(nearest) = mesh.nearest(center, 1.1 * radius) else { return ([0; 3], NOWHERE) };
        let outward = mesh.geometric_normal(nearest.triangle);
        let (q, _) = mesh.point(nearest.triangle, nearest.u, nearest.v);
        let towards = q - center;
        // At an edge the direction to the nearest point is better than the normal of either side.
        let normal = if towards.length() > 0.1 * self.cell {
            towards.normalize() * towards.dot(outward).signum()
        } else {
            outward
        };
        // Rounded towards zero, so that it is not longer than 1.
        let stored = (normal * 127.0).to_array().map(|n| n as i8);
        let normal = Vec3::from_array(stored.map(|n| f32::from(n) * (1.0 / 127.0)));
        // The nearest triangle reaches into the ball, or none does.
        let start = mesh.triangle(nearest.triangle).map(|corner| normal.dot(corner - center));
        let start = start.into_iter().fold(f32::INFINITY, f32::min);
        let least = mesh.least_along(normal, (center, radius + self.rounding), start) - 2.0 * self.rounding;
        let units = (least / self.plane_unit).floor() - 1.0;
        let farthest = f32::from(i16::MAX);
        (stored, if units < -farthest { NOWHERE } else { units.min(farthest) as i16 })
    }

    /// A distance within which the mesh lies from any point of the grid whose [`DistanceBound::bound`] is `bound`.
    #[inline]
    pub fn reach(&self, bound: f32) -> f32 {
        // A brick's centre is at most 2.6 and √3/2 cells away; the way there counts twice.
        1.05 * bound + 7.2 * self.cell
    }

    /// Bytes of address space; what is not asked for is never touched.
    pub fn memory(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.cells) + size_of_val(&*self.brick_distances)
    }
}

#[cfg(test)]
mod tests {
    use super::super::ray::Ray;
    use super::super::shapes::{Random, cuboid, place, soup, sphere};
    use super::*;

    #[test]
    fn bounds_are_below_the_distance_and_close_to_it() {
        let shapes = [
            (sphere(4, 0.0, 1), [0.75, 0.6]),
            (sphere(4, 0.3, 2), [0.65, 0.3]),
            (cuboid(Vec3::splat(-1.0), Vec3::new(1.0, 0.2, 0.5)), [0.6, 0.8]),
            (soup(50, 0.5, 3), [0.4, 0.0]),
        ];
        // How much of the distance the bound is worth: everywhere (deep bricks share a search), and inside within a cell of
        // the mesh.
        for (shape, worth) in shapes {
            for (scale, shift) in
                [(1.0, Vec3::ZERO), (1.0e-6, Vec3::ZERO), (1.0e6, Vec3::ZERO), (1.0, 9.0 * Vec3::ONE)]
            {
                let (positions, triangles) = place(shape.clone(), scale, shift);
                let mesh = MeshGeometry::build(&positions, &triangles);
                let bound = DistanceBound::new(&mesh);
                let mut random = Random(4);
                let (mut sum, mut all) = ([0.0; 2], [0.0; 2]);
                for _ in 0..3000 {
                    let p = 1.1 * scale * random.cube() + shift;
                    let truth = mesh.nearest(p, f32::INFINITY).map_or(f32::NAN, |n| n.distance);
                    let b = bound.bound(&mesh, p);
                    assert!(b >= 0.0 && b <= truth, "{b} is above {truth} at {p}");
                    if mesh.bounds().contains(p) {
                        assert!(truth <= bound.reach(b), "{truth} is out of reach at {p}");
                        let near = usize::from(truth < bound.cell && mesh.contains(p));
                        for i in 0..=near {
                            sum[i] += b;
                            all[i] += truth;
                        }
                    }
                }
                for i in 0..2 {
                    assert!(sum[i] >= worth[i] * all[i], "{i}: {} of the distance", sum[i] / all[i]);
                }
            }
        }
    }

    #[test]
    fn ways_that_stay_before_the_plane_meet_nothing() {
        for shape in [sphere(4, 0.0, 1), sphere(4, 0.3, 2), soup(50, 0.5, 3)] {
            let mesh = MeshGeometry::build(&shape.0, &shape.1);
            let bound = DistanceBound::with_resolution(&mesh, 16);
            let mut random = Random(5);
            let (mut beyond, mut staying) = (0, 0);
            for _ in 0..20_000 {
                let (p, step) = (random.cube(), 0.1 * random.cube());
                let (clear, stays) = bound.bound_ahead(&mesh, p, step);
                assert_eq!(clear, bound.bound(&mesh, p));
                if stays {
                    staying += 1;
                    beyond += u32::from(step.length() > clear);
                    let ray = Ray { origin: p, direction: step.normalize(), t_max: step.length() };
                    assert!(mesh.intersect(&ray).is_none(), "{p} {step}");
                }
            }
            assert!(beyond > 100 && staying > beyond, "{beyond} of {staying}");
        }
        let (positions, triangles) = sphere(2, 0.0, 1);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let bound = DistanceBound::new(&mesh);
        for endless in [Vec3::INFINITY, Vec3::new(f32::NAN, 0.0, 0.0)] {
            assert!(!bound.bound_ahead(&mesh, Vec3::new(0.9, 0.0, 0.0), endless).1);
        }
    }

    #[test]
    fn odd_meshes_and_points_give_zero() {
        let empty = MeshGeometry::build(&[], &[]);
        assert_eq!(DistanceBound::new(&empty).bound(&empty, Vec3::ONE), 0.0);
        let (positions, triangles) = sphere(2, 0.0, 1);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let bound = DistanceBound::with_resolution(&mesh, 8);
        assert_eq!(bound.bound(&mesh, Vec3::splat(100.0)), 0.0);
        assert_eq!(bound.bound(&mesh, Vec3::splat(f32::NAN)), 0.0);
        assert!(bound.memory() <= 8 * 8 * 8 * 8 + 400);
        let point = MeshGeometry::build(&[Vec3::ONE, Vec3::ONE, Vec3::ONE], &[[0, 1, 2]]);
        assert_eq!(DistanceBound::new(&point).bound(&point, Vec3::ONE), 0.0);
    }
}
