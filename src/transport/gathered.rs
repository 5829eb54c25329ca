//! The light that a path finds, and which light it is.
//!
//! Everything that adds light to a path does it here, with a tag: what the camera saw first, how many events there were,
//! what shines. The sum is the pixel; layers of a film take the parts of it that they hold ([`LightLayer`]). The tag is
//! only made where there are layers.

use super::state::Path;
use crate::film::{Averaging, FilmLayer};
use glam::Vec3;
use std::sync::Arc;

/// What happened first to a path on its way from the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstEvent {
    /// Nothing: the camera sees the light itself, or through what is passed straight.
    #[default]
    None,
    /// It was scattered by a surface, or reflected by the boundary of a medium.
    Surface,
    /// It went through the boundary of a medium.
    Refraction,
    /// It was scattered in the medium that the camera is in.
    Medium,
}

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// The environment.
    Environment,
    /// A light without size; the number is its index among those with intensity.
    Punctual(u32),
    /// A surface of an instance: emission, or a base colour that is unlit.
    Surface(u32),
}

/// Which light it is that a path has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightTag {
    /// What happened first.
    pub first: FirstEvent,
    /// The instance where that was; `None` where nothing happened.
    pub object: Option<u32>,
    /// Reflections, refractions and scatterings between the camera and the light.
    pub events: u32,
    /// Those of them that were in media.
    pub scatterings: u32,
    /// What shines.
    pub light: LightSource,
}

/// A part of the light, as a layer of the film: the sum over layers that share out all tags is the picture. The background
/// behind a ground that catches shadows, and one that is transparent, are in none.
#[derive(Clone)]
pub struct LightLayer {
    /// Name of the layer.
    pub name: String,
    /// Whether it holds light of that kind.
    pub holds: Arc<dyn Fn(&LightTag) -> bool + Send + Sync>,
}

impl LightLayer {
    /// A layer with the light for which `holds` is true.
    pub fn new(name: &str, holds: impl Fn(&LightTag) -> bool + Send + Sync + 'static) -> Self {
        Self { name: name.to_owned(), holds: Arc::new(holds) }
    }

    pub(super) fn on_film(&self) -> FilmLayer {
        FilmLayer::new(&self.name, &["R", "G", "B"], Averaging::Samples)
    }
}

impl std::fmt::Debug for LightLayer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LightLayer").field("name", &self.name).finish_non_exhaustive()
    }
}

/// What tags of all light that a path finds from now on have in common.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub first: FirstEvent,
    /// Where it was; meaningless without.
    pub object: u32,
    /// Scatterings in media.
    pub scatterings: u32,
}

impl Seen {
    /// Notes the first event, if it is that.
    #[inline]
    pub fn note(&mut self, first: FirstEvent, object: u32) {
        if self.first == FirstEvent::None {
            (self.first, self.object) = (first, object);
        }
    }

    /// The tag of light found after so many events.
    pub fn tag(&self, events: u32, light: LightSource) -> LightTag {
        let object = (self.first != FirstEvent::None).then_some(self.object);
        LightTag { first: self.first, object, events, scatterings: self.scatterings, light }
    }
}

impl Path {
    /// The tag of light that is found now.
    pub fn tag(&self, light: LightSource) -> LightTag {
        self.seen.tag(self.events, light)
    }
}

/// The light of a path so far.
pub(super) struct Gathered<'a> {
    pub sum: Vec3,
    layers: &'a [LightLayer],
    /// Of each layer.
    pub parts: Vec<Vec3>,
}

impl<'a> Gathered<'a> {
    pub fn new(layers: &'a [LightLayer]) -> Self {
        Self { sum: Vec3::ZERO, layers, parts: vec![Vec3::ZERO; layers.len()] }
    }

    /// Nothing yet, for the same layers.
    #[inline]
    pub fn anew(&self) -> Self {
        Self::new(self.layers)
    }

    /// Whether tags are asked for.
    #[inline]
    pub fn has_layers(&self) -> bool {
        !self.layers.is_empty()
    }

    /// Adds light.
    #[inline]
    pub fn add(&mut self, light: Vec3, tag: impl FnOnce() -> LightTag) {
        self.sum += light;
        self.note_part(|| (light, tag()));
    }

    /// Out of the way of paths without layers, with all that a tag needs.
    #[cold]
    #[inline(never)]
    fn sort(&mut self, part: impl FnOnce() -> (Vec3, LightTag)) {
        let (light, tag) = part();
        for (layer, part) in self.layers.iter().zip(&mut self.parts) {
            if (layer.holds)(&tag) {
                *part += light;
            }
        }
    }

    /// Adds light that [`Self::note_part`] was told the parts of.
    #[inline]
    pub fn add_noted(&mut self, light: Vec3) {
        self.sum += light;
    }

    /// Adds a part of light to the layers that hold it.
    #[inline]
    pub fn note_part(&mut self, part: impl FnOnce() -> (Vec3, LightTag)) {
        if self.has_layers() {
            self.sort(part);
        }
    }

    /// Adds the `n`th part of what others gathered.
    pub fn add_share(&mut self, other: &Gathered<'_>, n: f32) {
        self.sum += other.sum / n;
        self.parts.iter_mut().zip(&other.parts).for_each(|(part, more)| *part += *more / n);
    }
}
