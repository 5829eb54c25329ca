//! What a boundary of media is to a path: which medium is on either side, and whether anything is there at all.
//!
//! The boundaries that coincide in one place are crossed together. The stack before and the stack beyond tell which objects
//! fill the two sides; between them there is *one* interface, or none where one medium goes on. So two halves of a block are
//! that block, and a drink that fills its glass meets the glass without a film of air.
//!
//! | before | beyond | interface |
//! | --- | --- | --- |
//! | A | A | none: another object fills both sides |
//! | A | B of the same material | none: the medium goes on, unless the material is partly opaque |
//! | A | B | indices of A and B; the surface is that of the higher rank, of those that have a boundary there |
//!
//! **Where a path is.** Crossings change winding numbers ([`MediumStack`]), and what fills a point follows from those. Where
//! they contradict a boundary (it is left by a path that is not inside), rounding has let the path slip past an edge, or the
//! mesh is open. Then the winding number is asked for anew; an open mesh, which has none, is taken to have been entered
//! unseen.

use super::media::{Enclosure, MediumStack};
use super::path::PathTracer;
use super::state::Path;
use super::surroundings::set_winding;
use crate::geometry::offset_origin;
use crate::scene::Surface;
use crate::subsurface::TOUCHING;
use glam::Vec3;

/// The boundaries of media in one place, crossed in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// The objects on the side of arrival: those that the path knows of, unless it had lost count.
    pub before: MediumStack,
    /// The objects on the other side.
    pub beyond: MediumStack,
    /// `None`: the same medium is on both sides.
    pub contrast: Option<Contrast>,
}

/// Two media that meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contrast {
    /// Which of the boundaries is the surface.
    pub boundary: usize,
    /// The object that it belongs to, the higher one in rank.
    pub enclosure: Enclosure,
    /// Whether the path comes from outside of that object.
    pub entering: bool,
    /// What is outside of it.
    pub outside: Option<Enclosure>,
    /// Index inside over outside.
    pub eta: f32,
}

impl PathTracer<'_> {
    /// What `boundaries`, all those of media in one place, are to a path with this stack that travels in `direction`.
    pub(super) fn interface(
        &self,
        stack: &MediumStack,
        boundaries: &[Surface],
        direction: Vec3,
    ) -> Interface {
        let (mut before, mut beyond) = (*stack, *stack);
        for (i, surface) in boundaries.iter().enumerate() {
            let Some(enclosure) = self.enclosure_of(surface) else { continue };
            let instance = enclosure.instance;
            let change = if direction.dot(surface.geometric_normal) < 0.0 { 1 } else { -1 };
            let first = boundaries[..i].iter().all(|other| other.instance != instance);
            if first {
                let known = before.winding(instance);
                let may_overlap = self.scene.objects[instance as usize].in_parts;
                if (change < 0 && known <= 0) || (change > 0 && known > 0 && !may_overlap) {
                    let there = self.winding_before(surface, direction, change, known);
                    before.set(enclosure, there);
                    beyond.set(enclosure, there);
                }
            }
            beyond.wind(enclosure, change);
        }
        let contrast = self.contrast(&before, &beyond, boundaries);
        Interface { before, beyond, contrast }
    }

    /// How often the object of a boundary winds about the path just before it comes there, asked anew.
    #[cold]
    fn winding_before(&self, surface: &Surface, direction: Vec3, change: i32, known: i32) -> i32 {
        let geometry = &self.scene.geometry;
        let instance = surface.instance;
        if !self.scene.objects[instance as usize].closed {
            return if change < 0 { 1 } else { known };
        }
        let point = offset_origin(surface.position, surface.error, surface.geometric_normal, -direction);
        let transform = geometry.transform(instance);
        geometry.mesh_of(instance).winding_number(transform.inverse_point(point))
    }

    fn contrast(
        &self,
        before: &MediumStack,
        beyond: &MediumStack,
        boundaries: &[Surface],
    ) -> Option<Contrast> {
        let (here, there) = (before.current(), beyond.current());
        if here.map(|e| e.instance) == there.map(|e| e.instance) {
            return None;
        }
        let boundary_of = |e: Enclosure| boundaries.iter().position(|s| s.instance == e.instance);
        let find = |e: Option<Enclosure>| e.and_then(|e| Some((boundary_of(e)?, e)));
        let (leaving, entering) = match (find(here), find(there)) {
            (Some(a), Some(b)) if a.1.rank > b.1.rank => (Some(a), None),
            (a, None) => (a, None),
            (_, b) => (None, b),
        };
        let (boundary, enclosure) = leaving.or(entering)?;
        let goes_on = here.is_some_and(|a| there.is_some_and(|b| a.material == b.material));
        if goes_on && self.scene.transmits_all(&boundaries[boundary]) {
            return None;
        }
        let (inside, outside) = if entering.is_some() { (there, here) } else { (here, there) };
        let eta = self.ior_of(inside) / self.ior_of(outside);
        Some(Contrast { boundary, enclosure, entering: entering.is_some(), outside, eta })
    }

    /// Index of the medium of an object; 1 for none.
    pub(super) fn ior_of(&self, enclosure: Option<Enclosure>) -> f32 {
        enclosure.and_then(|e| self.scene.medium(e.material)).map_or(1.0, |m| m.ior)
    }

    /// Index of the medium that fills the point.
    pub(super) fn ior_in(&self, stack: &MediumStack) -> f32 {
        self.ior_of(stack.current())
    }

    /// Tells a path where it is. L/n² stays, so the weight of radiance changes with the index.
    pub(super) fn move_to(&self, path: &mut Path, stack: &MediumStack) {
        let ratio = self.ior_in(&path.stack) / self.ior_in(stack);
        if ratio != 1.0 {
            path.head.throughput *= ratio * ratio;
        }
        path.stack = *stack;
    }

    /// Finds out what is around an exit from an object that others overlap or touch; the way from there begins beyond their
    /// boundaries in the same place.
    pub(super) fn look_around(&self, stack: &mut MediumStack, left: Enclosure, exit: &mut Surface) {
        let object = &self.scene.objects[left.instance as usize];
        if !object.overlapped {
            return;
        }
        exit.error *= TOUCHING;
        let normal = exit.geometric_normal;
        let outside = offset_origin(exit.position, exit.error, normal, normal);
        for intruder in object.intruders.iter() {
            let other = &self.scene.objects[intruder.instance as usize];
            if other.has_medium && other.closed {
                set_winding(self.scene, stack, intruder.instance, outside);
            }
        }
    }
}
