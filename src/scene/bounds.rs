//! Boxes around what can be seen.
//!
//! A vertex counts only as a corner of a triangle that has an area. Files keep vertices that no triangle uses, or one
//! buffer of vertices for all meshes, and neither the camera nor the ground may move because of them.

use super::{MeshDescription, SceneDescription};
use glam::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A triangle whose height is a smaller part of its longest side has no area: it is one rounding of that side.
const THINNEST: f64 = f32::EPSILON as f64 / 2.0;
/// The square of a part that is far above the roundings of an area in single precision.
const CLEAR: f32 = 1e-6;

impl MeshDescription {
    /// Lower and upper corner of the box around all triangles that have an area; zero for a mesh without any.
    pub fn bounds(&self) -> [Vec3; 2] {
        bounds_of(&self.positions, &self.triangles).unwrap_or_default()
    }

    /// Positions of the corners of all triangles that have an area, each once.
    pub fn seen_positions(&self) -> Cow<'_, [Vec3]> {
        let mut used = Vec::new();
        used.resize_with(self.positions.len(), || AtomicBool::new(false));
        self.triangles.par_iter().with_min_len(CHUNK).for_each(|t| {
            let new = t.iter().any(|&i| used.get(i as usize).is_some_and(|used| !used.load(Relaxed)));
            if new && corners(&self.positions, t).is_some_and(has_area) {
                t.iter().for_each(|&i| used[i as usize].store(true, Relaxed));
            }
        });
        if used.iter().all(|used| used.load(Relaxed)) {
            return Cow::Borrowed(&self.positions);
        }
        let seen = self.positions.iter().zip(&used).filter(|(_, used)| used.load(Relaxed));
        Cow::Owned(seen.map(|(&p, _)| p).collect())
    }
}

/// Lower and upper corner of the box around all triangles that have an area.
pub(crate) fn bounds_of(positions: &[Vec3], triangles: &[[u32; 3]]) -> Option<[Vec3; 2]> {
    let boxes = triangles.par_chunks(CHUNK).map(|chunk| {
        let mut around = NOTHING;
        for corners in chunk.iter().filter_map(|t| corners(positions, t)) {
            let [a, b, c] = corners;
            let [low, high] = union(around, [a.min(b).min(c), a.max(b).max(c)]);
            // Most triangles add nothing, so it does not matter whether they have an area.
            if [low, high] != around && has_area(corners) {
                around = [low, high];
            }
        }
        around
    });
    boxes.reduce_with(union).filter(|[low, high]| low.cmple(*high).all())
}

/// Triangles of a piece of work.
const CHUNK: usize = 1 << 14;
const NOTHING: [Vec3; 2] = [Vec3::INFINITY, Vec3::NEG_INFINITY];

fn corners(positions: &[Vec3], triangle: &[u32; 3]) -> Option<[Vec3; 3]> {
    let [a, b, c] = triangle.map(|i| positions.get(i as usize));
    Some([*a?, *b?, *c?])
}

fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    // In single precision it is clear for all but needles.
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    if (b - a).cross(c - a).length_squared() > CLEAR * longest * longest {
        return true;
    }
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() > THINNEST * longest
}

impl SceneDescription {
    /// Lower and upper corner of the box around all instances; `None` where there is nothing to be seen.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        self.bounds_of_seen(&self.seen_meshes())
    }

    /// Center and radius of the sphere around the middle of [`Self::bounds`] that holds every triangle.
    pub fn bounding_sphere(&self) -> Option<(Vec3, f32)> {
        let seen = self.seen_meshes();
        let [low, high] = self.bounds_of_seen(&seen)?;
        let center = 0.5 * (low + high);
        Some((center, self.reduce_seen(&seen, |p| p.distance(center), f32::max)?))
    }

    /// For each mesh that has an instance its positions that are seen.
    fn seen_meshes(&self) -> Vec<Cow<'_, [Vec3]>> {
        let mut used = vec![false; self.meshes.len()];
        for instance in &self.instances {
            used.get_mut(instance.mesh).into_iter().for_each(|used| *used = true);
        }
        let meshes = self.meshes.iter().zip(&used);
        meshes.map(|(mesh, &used)| if used { mesh.seen_positions() } else { Cow::default() }).collect()
    }

    fn bounds_of_seen(&self, seen: &[Cow<'_, [Vec3]>]) -> Option<[Vec3; 2]> {
        let bounds = self.reduce_seen(seen, |p| [p; 2], union);
        bounds.filter(|[low, high]| (*high - *low).is_finite())
    }

    /// Reduces the positions that are seen, in world space.
    fn reduce_seen<T: Send>(
        &self,
        seen: &[Cow<'_, [Vec3]>],
        map: impl Fn(Vec3) -> T + Send + Sync,
        reduce: impl Fn(T, T) -> T + Send + Sync,
    ) -> Option<T> {
        let (map, reduce) = (&map, &reduce);
        let instances = self.instances.par_iter().filter_map(|i| Some((i.transform, seen.get(i.mesh)?)));
        let parts = instances.flat_map(|(transform, points)| {
            points.par_chunks(CHUNK).filter_map(move |chunk| {
                let points = chunk.iter().map(|&p| transform.transform_point3(p)).filter(|p| p.is_finite());
                points.map(map).reduce(reduce)
            })
        });
        parts.reduce_with(reduce)
    }
}

/// The box around two boxes.
pub(crate) fn union(a: [Vec3; 2], b: [Vec3; 2]) -> [Vec3; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::InstanceDescription;
    use glam::Affine3A;

    /// One triangle, a vertex that none uses, and a needle without area.
    fn scene() -> SceneDescription {
        let far = Vec3::splat(1e6);
        let mesh = MeshDescription {
            positions: vec![far, Vec3::ZERO, Vec3::X, Vec3::Y, -far, -2.0 * far],
            triangles: vec![[1, 2, 3], [1, 4, 5], [1, 1, 0]],
            triangle_materials: vec![u32::MAX; 3],
            ..Default::default()
        };
        let unseen = MeshDescription { positions: vec![far], ..Default::default() };
        let instance = |mesh, x| InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh,
            transform: Affine3A::from_translation(Vec3::X * x),
        };
        let instances = vec![instance(0, 0.0), instance(0, 3.0), instance(1, 0.0)];
        SceneDescription { meshes: vec![mesh, unseen], instances, ..Default::default() }
    }

    #[test]
    fn only_triangles_with_an_area_have_bounds() {
        let scene = scene();
        assert_eq!(scene.meshes[0].bounds(), [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]);
        assert_eq!(&*scene.meshes[0].seen_positions(), [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(scene.meshes[1].bounds(), [Vec3::ZERO; 2]);
        assert_eq!(scene.bounds(), Some([Vec3::ZERO, Vec3::new(4.0, 1.0, 0.0)]));
        let (center, radius) = scene.bounding_sphere().unwrap();
        assert_eq!(center, Vec3::new(2.0, 0.5, 0.0));
        assert!((radius - 4.25_f32.sqrt()).abs() < 1e-6);
        assert!(scene.ground_height().is_some_and(|y| (-0.001..0.0).contains(&y)));
    }

    #[test]
    fn a_long_thin_triangle_is_seen() {
        let mesh = MeshDescription {
            positions: vec![Vec3::ZERO, Vec3::X * 1e3, Vec3::new(1e3, 1e-3, 0.0)],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        assert_eq!(mesh.bounds()[1], Vec3::new(1e3, 1e-3, 0.0));
        assert!(matches!(mesh.seen_positions(), Cow::Borrowed(_)));
    }
}
