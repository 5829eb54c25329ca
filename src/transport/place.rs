//! A path in a place where several surfaces coincide ([`crate::geometry::SceneGeometry::place`]).
//!
//! They are met one after the other, as if thin gaps were between them, from the top down:
//!
//! - The later in the document lies on top, from whichever side one looks: a label that was modelled after its wall
//!   covers it. All boundaries of media are one member of this order, at the place of the last of them
//!   ([`super::interface`]). From inside of what they bound they come first, so that a body which stands on a floor has
//!   air below it, as if a little above.
//! - Faces that are culled are not there where something else is: of two single-sided faces of opposite winding, the
//!   one that shows its front is met.
//! - Where a sheet does not cover the place (alpha), it is taken out, and the path goes on to the next. Light that
//!   comes back from below passes the same hole, so the members are composited as *over* has it. Boundaries of media
//!   stay, as the path crosses them wherever it passes; that there is a hole in them is remembered.
//! - Where a member sends the path on through it, the next one below is met, and where it sends it back, the one above.
//! - Shadow rays that start at a member pass the others on their side of it. No direction leads to a lamp that is one of
//!   them, so it is not sampled, and what a path finds there once it was scattered in the place counts in full.

use super::gathered::Gathered;
use super::media::MediumStack;
use super::path::PathTracer;
use super::state::Path;
use crate::geometry::{Hit, offset_origin};
use crate::sampling::Sampler;
use crate::scene::{Scene, Surface};
use crate::subsurface::Start;
use glam::Vec3;
use std::rc::Rc;

/// What is met as one: a sheet, or all boundaries of media of the place.
pub(super) type Member = Vec<Surface>;

/// Surfaces in one place.
#[derive(Debug)]
struct Place {
    /// Top first.
    members: Vec<Member>,
    /// Which of them is the boundaries of media.
    boundary: Option<u32>,
    position: Vec3,
    /// Bounds of how far any of the members is from the position, on each axis.
    error: Vec3,
    /// Unit normal on the side that the path came from.
    up: Vec3,
}

/// A path in a place.
#[derive(Clone, Debug)]
pub(super) struct InPlace {
    place: Rc<Place>,
    /// Members that are still there, the lowest first.
    left: Vec<u32>,
    /// Which of them is met next.
    at: usize,
    /// There is a hole in the boundary.
    open: bool,
    /// Whether the path was turned here.
    scattered: bool,
}

impl InPlace {
    /// What a ray in a unit direction meets in the place of a crowded hit; `None` where it is alone after all.
    pub fn new(
        scene: &Scene,
        hit: &Hit,
        direction: Vec3,
        (stack, direct_view): (&MediumStack, bool),
    ) -> Option<Self> {
        let found = scene.geometry.place(hit, direction);
        if found.len() < 2 {
            return None;
        }
        let mut surfaces: Vec<Surface> = found.iter().map(|(hit, _)| Surface::new(scene, hit)).collect();
        let reach = |s: &Surface, n: Vec3, p: Vec3| (s.position - p).dot(n).abs() + n.abs().dot(s.error);
        let first = Surface::new(scene, hit);
        let n = first.geometric_normal;
        let own = n.abs().dot(first.error);
        let farthest = surfaces.iter().map(|s| reach(s, n, first.position)).fold(own, f32::max);
        let stretch = if own > 0.0 { farthest / own } else { 1.0 };
        let place_error = first.error * stretch + (farthest - own * stretch).max(0.0) * n.abs();

        surfaces.retain(|s| {
            let front = direction.dot(s.geometric_normal) < 0.0;
            !scene.material(s.material).is_absent(front, direct_view)
        });
        let is_culled = |s: &Surface| {
            let material = scene.material(s.material);
            let back = direction.dot(s.geometric_normal) >= 0.0;
            back && !material.double_sided && !material.is_see_through() && scene.medium(s.material).is_none()
        };
        let others = surfaces.iter().any(|s| scene.medium(s.material).is_none() && !is_culled(s));
        if others || direct_view {
            surfaces.retain(|s| !is_culled(s));
        }
        // A triangle that is there twice is one boundary.
        let bounds = |s: &Surface| scene.medium(s.material).is_some();
        let mut last = None;
        surfaces.retain(|s| {
            if bounds(s) && last == Some(s.instance) && scene.is_repetition(s) {
                return false;
            }
            last = if bounds(s) { Some(s.instance) } else { last };
            true
        });
        let mut members: Vec<Member> = Vec::new();
        let mut boundary = None;
        for surface in surfaces.into_iter().rev() {
            if !bounds(&surface) {
                members.push(vec![surface]);
                continue;
            }
            let at = *boundary.get_or_insert_with(|| {
                members.push(Vec::new());
                members.len() - 1
            });
            members[at].push(surface);
        }
        if let Some(at) = &mut boundary
            && members[*at].iter().all(|s| stack.winding(s.instance) != 0)
        {
            members[..=*at].rotate_right(1);
            *at = 0;
        }
        let left: Vec<u32> = (0..members.len() as u32).rev().collect();
        let at = left.len().wrapping_sub(1);
        let up = if n.dot(direction) < 0.0 { n } else { -n };
        let boundary = boundary.map(|at| at as u32);
        let place = Place { members, boundary, position: first.position, error: place_error, up };
        Some(Self { place: Rc::new(place), left, at, open: false, scattered: false })
    }

    fn is_boundary(&self, member: u32) -> bool {
        self.place.boundary == Some(member)
    }

    /// Whether the member that is met next is known not to cover the place.
    pub fn is_open(&self) -> bool {
        self.open && self.left.get(self.at).is_some_and(|&member| self.is_boundary(member))
    }

    /// Notes that the member that is met does not cover the place.
    pub fn open(&mut self) {
        self.open |= self.left.get(self.at).is_some_and(|&member| self.is_boundary(member));
    }

    /// Whether the path was turned by another member before the one that it meets.
    pub fn has_scattered(&self) -> bool {
        self.scattered
    }

    /// Whether a triangle of an instance is in the place.
    pub fn holds(&self, (instance, triangle): (u32, u32)) -> bool {
        let mut surfaces = self.place.members.iter().flatten();
        surfaces.any(|s| (s.instance, s.triangle) == (instance, triangle))
    }

    /// All members, top first.
    pub fn members(&self) -> impl Iterator<Item = &Member> {
        self.place.members.iter()
    }

    /// The members that a ray from the one that is met passes when it leaves the place, and whether each is known not
    /// to cover it.
    pub fn towards(&self, direction: Vec3) -> impl Iterator<Item = (&Member, bool)> {
        let at = self.at.min(self.left.len());
        let (below, above) = self.left.split_at(at);
        let (below, above) = if direction.dot(self.place.up) > 0.0 {
            (&[][..], above.get(1..).unwrap_or_default())
        } else {
            (below, &[][..])
        };
        let member = |&i: &u32| (&self.place.members[i as usize], self.open && self.is_boundary(i));
        below.iter().rev().chain(above).map(member)
    }

    /// The start of a ray that leaves the place.
    pub fn origin(&self, direction: Vec3) -> Vec3 {
        offset_origin(self.place.position, self.place.error, self.place.up, direction)
    }

    /// The only surface of an instance, if there is one.
    fn surface_of(&self, instance: u32) -> Option<&Surface> {
        let mut found = self.place.members.iter().flatten().filter(|s| s.instance == instance);
        found.next().filter(|_| found.next().is_none())
    }

    /// Goes on to what a path meets next that the member has sent in `direction`, or has let pass. False: it leaves.
    fn step(&mut self, direction: Vec3, passed: bool) -> bool {
        self.scattered |= !passed;
        let upwards = direction.dot(self.place.up) > 0.0;
        let removed = passed && self.left.get(self.at).is_some_and(|&member| !self.is_boundary(member));
        if removed {
            self.left.remove(self.at);
        }
        let above = if removed { self.at } else { self.at.wrapping_add(1) };
        self.at = if upwards { above } else { self.at.wrapping_sub(1) };
        self.at < self.left.len()
    }
}

impl Path {
    /// Goes on from the member of a place that the path has met.
    #[inline]
    pub fn step_in_place(&mut self, passed: bool) {
        if self.place.is_some() {
            self.step(passed);
        }
    }

    #[cold]
    fn step(&mut self, passed: bool) {
        let Some(mut place) = self.place.take() else { return };
        let direction = self.head.direction;
        if place.step(direction, passed) {
            self.place = Some(place);
            return;
        }
        self.head.position = place.origin(direction);
        let around = self.stack.current().and_then(|e| place.surface_of(e.instance));
        self.head.start = around.map(Start::of);
    }
}

impl PathTracer<'_> {
    /// Meets the next member of the place that a path is in. False: the path ends.
    pub(super) fn meet_in_place(
        &self,
        path: &mut Path,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) -> bool {
        let Some(place) = &path.place else { return true };
        let members = Rc::clone(&place.place);
        let Some(&member) = place.left.get(place.at) else {
            // All of it was culled.
            path.passes += 1;
            path.step_in_place(true);
            return true;
        };
        self.meet(&members.members[member as usize], path, gathered, sampler)
    }
}
