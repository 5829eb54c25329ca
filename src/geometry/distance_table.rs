//! The distance bounds of a scene's meshes: made when they are first asked for, and with larger cells where there are many.

use super::distance::{DistanceBound, RESOLUTION};
use super::mesh::MeshGeometry;
use std::sync::OnceLock;

/// Least cells along the longest axis.
const LEAST_RESOLUTION: u32 = 8;
/// Bounds of a scene that have cells by default: they take up to 2 MB each.
const FULL: usize = 128;

/// A bound that nobody has asked for yet, or that is there.
#[derive(Debug)]
pub struct DistanceTable {
    resolution: u32,
    bound: OnceLock<DistanceBound>,
}

impl DistanceTable {
    /// One of `count` of a scene. Beyond 128 of them cells are larger, so that all together take about as much memory as those;
    /// above some 60 000 they take 5 kB each.
    pub fn one_of(count: usize) -> Self {
        let part = (FULL as f64 / count.max(FULL) as f64).cbrt();
        let resolution = ((f64::from(RESOLUTION) * part) as u32).max(LEAST_RESOLUTION);
        Self { resolution, bound: OnceLock::new() }
    }

    /// The bound, which is always asked for with the same mesh.
    #[inline]
    pub fn get(&self, mesh: &MeshGeometry) -> &DistanceBound {
        self.bound.get_or_init(|| DistanceBound::with_resolution(mesh, self.resolution))
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::cuboid;
    use super::*;
    use glam::Vec3;

    #[test]
    fn many_take_about_as_much_memory_as_some() {
        let (positions, triangles) = cuboid(Vec3::ZERO, Vec3::ONE);
        let mesh = MeshGeometry::build(&positions, &triangles);
        let bytes = |count: usize| count * size_of_val(&*DistanceTable::one_of(count).get(&mesh).cells);
        assert_eq!(bytes(FULL), FULL * bytes(1));
        // Bricks of four cells are whole: nine cells are three bricks, which have room for twelve.
        assert!([129, 1000, 20_000, 46_000].into_iter().all(|n| bytes(n) <= bytes(FULL) * 64 / 27));
    }
}
