//! The media around the starts of camera rays: a path has to know them before it meets the first boundary.
//!
//! Rays start at the near plane of the camera: at one point where there is neither that nor a lens, else each at a point of
//! its own, some inside of an object and some beside it. An object that no surface of comes as near to the centre of those points as the
//! farthest of them is around all or none of them; of the others the question is asked for each ray.

use super::media::{Enclosure, MediumStack};
use crate::geometry::Aabb;
use crate::scene::{Camera, Scene};
use glam::Vec3;

/// Room for roundings, as a factor.
const MARGIN: f32 = 1.001;

/// The media around the starts of camera rays.
pub(super) struct Surroundings {
    /// What is around all of them.
    around: MediumStack,
    /// Instances that may be around some of them.
    undecided: Vec<u32>,
}

impl Surroundings {
    /// Of a camera.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let corners = camera.starts();
        let starts = Aabb::from_points(&corners);
        let mut found = Self { around: MediumStack::default(), undecided: Vec::new() };
        for i in 0..scene.objects.len() as u32 {
            let object = &scene.objects[i as usize];
            let may_be_around = || scene.geometry.instance_bounds(i).overlaps(&starts);
            if !(object.has_medium && object.closed && may_be_around()) {
                continue;
            }
            if surface_is_near(scene, i, &corners) {
                found.undecided.push(i);
            } else {
                set_winding(scene, &mut found.around, i, corners[0]);
            }
        }
        found
    }

    /// For a ray that starts at `origin`.
    #[inline]
    pub fn at(&self, scene: &Scene, origin: Vec3) -> MediumStack {
        let mut stack = self.around;
        for &instance in &self.undecided {
            set_winding(scene, &mut stack, instance, origin);
        }
        stack
    }
}

/// Whether a surface of an instance may lie between some of the points of a rectangle; never if they are one.
fn surface_is_near(scene: &Scene, instance: u32, corners: &[Vec3; 4]) -> bool {
    let transform = scene.geometry.transform(instance);
    let corners = corners.map(|c| transform.inverse_point(c));
    let center = 0.25 * corners.iter().sum::<Vec3>();
    let radius = corners.iter().map(|c| c.distance(center)).fold(0.0, f32::max);
    corners.iter().any(|c| *c != corners[0])
        && scene.geometry.mesh_of(instance).nearest(center, radius * MARGIN).is_some()
}

/// Finds out how often an instance winds about a point.
pub(super) fn set_winding(scene: &Scene, stack: &mut MediumStack, instance: u32, point: Vec3) {
    let materials = &scene.mesh(instance).triangle_materials;
    let Some(&material) = materials.iter().find(|&&m| scene.medium(m).is_some()) else { return };
    let local = scene.geometry.transform(instance).inverse_point(point);
    let winding = scene.geometry.mesh_of(instance).winding_number(local);
    let rank = scene.objects[instance as usize].rank;
    stack.set(Enclosure { instance, material, rank }, winding);
}
