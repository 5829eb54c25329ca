//! What reaches into the bounds of an object, and may be inside of it.

use super::Scene;
use crate::geometry::{Aabb, BoxTree, ROUNDING, SurfacePoint, TOUCHING};
use std::sync::Arc;

/// Intruders that are listed, at most: so many are asked one by one in about the time that the scene takes.
const MOST_LISTED: usize = 64;
/// Instances with boxes in those of an object that are looked at to find its intruders, at most.
const MOST_LOOKED_AT: usize = 1024;

/// What reaches into the bounds of an object.
#[derive(Clone, Debug)]
pub enum Intruders {
    /// These instances, in order.
    Few(Arc<[Intruder]>),
    /// So many that they are not listed: lists of all would grow with the square of a heap.
    Many,
}

impl Default for Intruders {
    fn default() -> Self {
        Self::Few(Arc::default())
    }
}

impl Intruders {
    /// Whether nothing reaches in.
    pub fn is_empty(&self) -> bool {
        matches!(self, Self::Few(list) if list.is_empty())
    }
}

/// An instance that reaches into the bounds of another.
#[derive(Clone, Copy, Debug)]
pub struct Intruder {
    /// The instance.
    pub instance: u32,
    /// World box around those of its triangles that reach in.
    pub bounds: Aabb,
}

impl Scene {
    /// The other instances of which a triangle reaches into `bounds`, or touches them up to rounding.
    pub(super) fn intruders(&self, instance: u32, bounds: &Aabb, all: &BoxTree) -> Intruders {
        let bounds = &touched(bounds);
        let Some(others) = all.at_most(MOST_LOOKED_AT, bounds, |other| other != instance) else {
            return Intruders::Many;
        };
        let part = |other| Intruder { instance: other, bounds: self.geometry.part_within(other, bounds) };
        let parts = others.into_iter().map(part).filter(|i| !i.bounds.is_empty());
        let listed: Vec<_> = parts.take(MOST_LISTED + 1).collect();
        if listed.len() > MOST_LISTED {
            return Intruders::Many;
        }
        Intruders::Few(listed.into_iter().map(|i| Intruder { bounds: touched(&i.bounds), ..i }).collect())
    }

    /// Visits what reaches into the bounds of an instance and may be around points near another one, as long as `visit` says to go
    /// on.
    pub fn visit_intruders(&self, instance: u32, near: &SurfacePoint, mut visit: impl FnMut(u32) -> bool) {
        match &self.objects[instance as usize].intruders {
            Intruders::Few(list) => _ = list.iter().all(|i| visit(i.instance)),
            Intruders::Many => {
                let bounds = self.geometry.bounds();
                let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
                // Beyond what `beside` moves points by.
                let room = 2.0 * (TOUCHING * near.error.max_element() + ROUNDING * reach);
                let place = Aabb { min: near.position - room, max: near.position + room };
                self.geometry.visit_instances(&place, |other| other == instance || visit(other));
            }
        }
    }
}

/// A box with room for what only touches it, up to rounding.
fn touched(bounds: &Aabb) -> Aabb {
    let room = ROUNDING * bounds.min.abs().max(bounds.max.abs()).max_element();
    Aabb { min: bounds.min - room, max: bounds.max + room }
}
