//! The media around the eye: a path has to know them before it meets the first boundary.
//!
//! All rays of a perspective camera start at one point. Those of an orthographic one start all over the view plane, some
//! inside of an object and some beside it, so there the question is asked for each ray, of the objects that the plane may
//! cut.

use super::media::{Enclosure, MediumStack};
use crate::geometry::Aabb;
use crate::scene::{Camera, Scene};
use glam::{Vec2, Vec3};

/// The media around the starts of camera rays.
pub(super) enum Surroundings {
    /// The same for all rays.
    Same(MediumStack),
    /// Instances that may be around some of them.
    Candidates(Vec<u32>),
}

impl Surroundings {
    /// Of a camera with a picture of `size` pixels.
    pub fn new(scene: &Scene, camera: &Camera, size: Vec2) -> Self {
        let closed = (0..scene.objects.len() as u32).filter(|&i| {
            let object = &scene.objects[i as usize];
            object.has_medium && object.closed
        });
        if !camera.is_orthographic() {
            return Self::Same(around(scene, closed, camera.origin()));
        }
        let corners = [Vec2::ZERO, Vec2::new(size.x, 0.0), Vec2::new(0.0, size.y), size];
        let plane = Aabb::from_points(&corners.map(|c| camera.ray(c).origin));
        let near = closed.filter(|&i| {
            let bounds = scene.geometry.transform(i).bounds(&scene.geometry.mesh_of(i).bounds());
            bounds.min.cmple(plane.max).all() && bounds.max.cmpge(plane.min).all()
        });
        let near: Vec<u32> = near.collect();
        if near.is_empty() { Self::Same(MediumStack::default()) } else { Self::Candidates(near) }
    }

    /// For a ray that starts at `origin`.
    #[inline]
    pub fn at(&self, scene: &Scene, origin: Vec3) -> MediumStack {
        match self {
            Self::Same(stack) => *stack,
            Self::Candidates(instances) => around(scene, instances.iter().copied(), origin),
        }
    }
}

/// Those of the instances that a point is inside of.
fn around(scene: &Scene, instances: impl Iterator<Item = u32>, point: Vec3) -> MediumStack {
    let mut stack = MediumStack::default();
    for instance in instances {
        set_winding(scene, &mut stack, instance, point);
    }
    stack
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
