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
use crate::geometry::TOUCHING;
use crate::scene::{Intruders, Surface};
use glam::Vec3;

/// The boundaries of media in one place, crossed in one direction.
///
/// Filled in where it is: it is large, and moving it would cost more than finding it.
#[derive(Clone, Debug)]
pub(super) struct Interface {
    /// The objects on the side of arrival, where the path had lost count of them.
    pub corrected: Option<Box<MediumStack>>,
    /// What leads to the other side.
    pub crossing: Crossing,
    /// `None`: the same medium is on both sides.
    pub contrast: Option<Contrast>,
}

impl Interface {
    /// That of no boundary.
    pub const NONE: Self = Self { corrected: None, crossing: Crossing::Nothing, contrast: None };
}

/// What crossing boundaries does to the stack of a path. Where there is one it is kept as what changes: stacks are
/// large, and most paths that meet a boundary do not cross it at once.
#[derive(Clone, Debug)]
pub(super) enum Crossing {
    /// There is no boundary.
    Nothing,
    /// This object now winds so often about the path.
    One(Enclosure, i32),
    /// These are the objects on the other side.
    Several(Box<MediumStack>),
}

impl Crossing {
    /// Takes a path, which has arrived with `stack`, to the other side.
    #[inline]
    pub fn apply(&self, stack: &mut MediumStack) {
        match self {
            Self::Nothing => {}
            Self::One(enclosure, winding) => stack.set(*enclosure, *winding),
            Self::Several(beyond) => *stack = **beyond,
        }
    }
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
    /// What `boundaries`, all those of media in one place, are to a path with this stack that travels in `direction`. The
    /// interface is to be [`Interface::NONE`] before.
    #[inline(always)]
    pub(super) fn find_interface(
        &self,
        interface: &mut Interface,
        stack: &MediumStack,
        boundaries: &[Surface],
        direction: &Vec3,
    ) {
        let single = match boundaries {
            [surface] => {
                let entering = direction.dot(surface.geometric_normal) < 0.0;
                self.single(interface, stack, surface, entering)
            }
            _ => false,
        };
        if !single {
            *interface = self.several(stack, boundaries, *direction);
        }
    }

    /// One boundary that the stack agrees with: mostly there is no more to ask. False: it does not agree.
    #[inline(always)]
    fn single(
        &self,
        interface: &mut Interface,
        stack: &MediumStack,
        surface: &Surface,
        entering: bool,
    ) -> bool {
        let Some(enclosure) = self.enclosure_of(surface) else { return false };
        if stack.winding(enclosure.instance) != i32::from(!entering) {
            return false;
        }
        let top = stack.current();
        let (fills, outside) = if entering {
            (top.is_none_or(|top| top.rank < enclosure.rank).then_some(enclosure), top)
        } else {
            (top.filter(|top| top.instance == enclosure.instance), stack.below())
        };
        let goes_on = |e: Enclosure| {
            outside.is_some_and(|o| o.material == e.material && self.scene.transmits_all(surface))
        };
        if let Some(enclosure) = fills
            && !goes_on(enclosure)
        {
            let eta = self.ior_of(Some(enclosure)) / self.ior_of(outside);
            interface.contrast = Some(Contrast { boundary: 0, enclosure, entering, outside, eta });
        }
        interface.crossing = Crossing::One(enclosure, i32::from(entering));
        true
    }

    #[cold]
    fn several(&self, stack: &MediumStack, boundaries: &[Surface], direction: Vec3) -> Interface {
        let mut beyond = *stack;
        let mut corrected: Option<Box<MediumStack>> = None;
        // Boundaries come in the order of instances.
        for own in boundaries.chunk_by(|a, b| a.instance == b.instance) {
            let Some(enclosure) = self.enclosure_of(&own[0]) else { continue };
            let instance = enclosure.instance;
            let change_at = |s: &Surface| if direction.dot(s.geometric_normal) < 0.0 { 1 } else { -1 };
            let changes = own.iter().map(change_at);
            let object = &self.scene.objects[instance as usize];
            let simple = !object.in_parts && !object.wound_both_ways;
            let mut known = stack.winding(instance);
            if changes
                .clone()
                .all(|change| (change < 0 && known <= 0) || (change > 0 && known > 0 && !object.in_parts))
            {
                known = self.winding_before(&own[0], direction, change_at(&own[0]), known);
                corrected.get_or_insert_with(|| Box::new(*stack)).set(enclosure, known);
            }
            let beyond_it = known + changes.sum::<i32>();
            // Next to an edge both of its triangles may have been met, but a single solid is entered once.
            let several = own.len() > 1;
            beyond.set(enclosure, if simple && several { beyond_it.clamp(0, 1) } else { beyond_it });
        }
        let contrast = self.contrast(corrected.as_deref().unwrap_or(stack), &beyond, boundaries);
        Interface { corrected, crossing: Crossing::Several(Box::new(beyond)), contrast }
    }

    /// How often the object of a boundary winds about the path just before it comes there, asked anew.
    #[cold]
    fn winding_before(&self, surface: &Surface, direction: Vec3, change: i32, known: i32) -> i32 {
        let geometry = &self.scene.geometry;
        let instance = surface.instance;
        if !self.scene.objects[instance as usize].closed {
            return if change < 0 { 1 } else { known };
        }
        let point = geometry.beside(&surface.point(), -direction, instance);
        let transform = geometry.transform(instance);
        let found = geometry.mesh_of(instance).winding_number(transform.inverse_point(point));
        // What is left by a back was entered by a front, unless parts are wound both ways. Next to an edge the answer may be
        // that of the other side of it.
        if change < 0 && !self.scene.objects[instance as usize].wound_both_ways {
            found.max(1)
        } else {
            found
        }
    }

    #[inline]
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
    pub(super) fn moved(&self, path: &mut Path, change: impl FnOnce(&mut MediumStack)) {
        let before = self.ior_in(&path.stack);
        change(&mut path.stack);
        let ratio = before / self.ior_in(&path.stack);
        if ratio != 1.0 {
            path.head.throughput *= ratio * ratio;
        }
    }

    /// Finds out what is around an exit from an object that others overlap or touch; the way from there begins beyond their
    /// boundaries in the same place. Returns what the weight of radiance changes by, as in [`Self::moved`].
    pub(super) fn look_around(&self, stack: &mut MediumStack, left: Enclosure, exit: &mut Surface) -> f32 {
        let object = &self.scene.objects[left.instance as usize];
        if !object.overlapped {
            return 1.0;
        }
        let before = self.ior_in(stack);
        let point = exit.point();
        exit.error *= TOUCHING;
        let known = *stack;
        let mut look = |instance: u32| {
            let other = &self.scene.objects[instance as usize];
            if other.has_medium && other.closed {
                let outside = self.scene.geometry.beside(&point, point.geometric_normal, instance);
                set_winding(self.scene, stack, instance, outside);
            }
            true
        };
        if matches!(object.intruders, Intruders::Many) {
            // Those that are not near the exit are not visited.
            known.instances().filter(|&i| i != left.instance).for_each(|i| _ = look(i));
        }
        self.scene.visit_intruders(left.instance, &point, look);
        (before / self.ior_in(stack)).powi(2)
    }
}
