//! What a path remembers between events.

use super::direct::Shaded;
use super::gathered::Seen;
use super::media::MediumStack;
use super::place::InPlace;
use crate::geometry::offset_origin;
use crate::light::Anchor;
use crate::scene::{Footprint, Surface};
use crate::subsurface::{Aimed, PathHead, Start};
use glam::Vec3;

/// The last vertex that chose a direction, for weighing what the direction finds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub point: Vec3,
    /// For the probability of choosing lights.
    pub anchor: Anchor,
    /// Solid-angle density of the direction.
    pub pdf: f32,
    /// Whether lights were also sampled there (otherwise what is hit by chance counts in full).
    pub connected: bool,
    /// How many were.
    pub lights: f32,
    /// As [`PathHead::aimed`], for light found directly from here.
    pub aimed: Aimed,
}

impl Vertex {
    /// A point from which no lights were sampled.
    pub fn unconnected(point: Vec3) -> Self {
        Self {
            point,
            anchor: Shaded::NOWHERE,
            pdf: 1.0,
            connected: false,
            lights: 1.0,
            aimed: Aimed::default(),
        }
    }
}

/// The state of a path between events.
#[derive(Clone)]
pub(super) struct Path {
    pub head: PathHead,
    pub stack: MediumStack,
    /// Where it is in one place with several surfaces, and has not left it.
    pub place: Option<Box<InPlace>>,
    pub vertex: Vertex,
    /// Reflections, refractions and scatterings. What is passed straight is none.
    pub events: u32,
    /// Surfaces that were passed straight.
    pub passes: u32,
    pub bounces: u32,
    /// Total reflections in a row at boundaries with shading normals.
    pub total_reflections: u32,
    /// The wavelength that the path keeps once a dispersive boundary has refracted it, nanometres.
    pub wavelength: Option<f32>,
    /// The camera still sees straight through what was met.
    pub direct_view: bool,
    /// How far its neighbours are apart.
    pub footprint: Footprint,
    /// What the camera saw first, for layers of light.
    pub seen: Seen,
}

impl Path {
    /// Goes straight on through a surface that is not there.
    pub fn pass(&mut self, surface: &Surface) {
        self.passes += 1;
        self.leave_surface(surface);
        self.step_in_place(true);
    }

    #[inline]
    pub fn leave_surface(&mut self, surface: &Surface) {
        self.head.position =
            offset_origin(surface.position, surface.error, surface.geometric_normal, self.head.direction);
        self.head.start = Some(Start::of(surface));
    }
}
