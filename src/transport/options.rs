//! What is rendered: what is seen ([`View`]), how light is followed ([`Settings`]), which samples ([`SampleRange`]).

use super::gathered::LightLayer;
use crate::film::{FilmLayer, composite};
use crate::optics::Microfacet;
use crate::scene::{CameraDescription, Footprint};

/// What is seen of a scene, and on how large a picture.
#[derive(Clone, Debug)]
pub struct View {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Who looks.
    pub camera: CameraDescription,
    /// Height (y, metres) of a horizontal plane that is seen only by the shadow that falls on it.
    pub ground: Option<f32>,
    /// Whether the background is left out, and the picture has alpha.
    pub transparent: bool,
    /// Parts of the light that the film has as layers of their own.
    pub light_layers: Vec<LightLayer>,
}

impl View {
    /// 640 × 480 pixels with the background and without a ground.
    pub fn new(camera: CameraDescription) -> Self {
        Self { width: 640, height: 480, camera, ground: None, transparent: false, light_layers: Vec::new() }
    }

    /// The layers of a film for it.
    pub(super) fn layers(&self) -> Vec<FilmLayer> {
        let light = self.light_layers.iter().map(LightLayer::on_film);
        light.chain(composite::layers(self.transparent, self.ground.is_some())).collect()
    }
}

/// How light is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Name of the subsurface model.
    pub subsurface: String,
    /// Seed: another seed, another noise.
    pub seed: u32,
    /// Most events of a path between the camera and the light that it finds: reflections, refractions and scatterings. What
    /// is passed straight does not count.
    pub max_depth: u32,
    /// Whether rough surfaces scatter more than once.
    pub microfacet: Microfacet,
    /// Whether paths below a surface are also aimed at lights beyond it; off, the same picture is noisier.
    pub aim: bool,
    /// How wide a part of a pixel colour textures are averaged over, in pixels ([`Footprint`]); 0 looks them up at points.
    pub texture_filter: f32,
}

impl Default for Settings {
    /// The random walk, with nothing cut off.
    fn default() -> Self {
        Self {
            subsurface: "random-walk".to_owned(),
            seed: 0,
            max_depth: 100_000,
            microfacet: Microfacet::Multiple,
            aim: true,
            texture_filter: Footprint::DEFAULT_FILTER,
        }
    }
}

/// Which samples of each pixel: a picture is a function of their numbers, and parts of it that were rendered apart add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    /// Number of the first.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// A picture to render in one go.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// What is seen.
    pub view: View,
    /// How light is followed.
    pub settings: Settings,
    /// Which samples.
    pub samples: SampleRange,
    /// Threads, 0 for those of the thread pool that is there: by default as many as the machine has.
    pub threads: usize,
}

impl RenderOptions {
    /// 640 × 480 pixels of 64 samples with the random walk, all threads and nothing cut off.
    pub fn new(camera: CameraDescription) -> Self {
        Self {
            view: View::new(camera),
            settings: Settings::default(),
            samples: SampleRange { first: 0, count: 64 },
            threads: 0,
        }
    }

    /// These options, changed.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// The threads that will render: as many as asked for, else as the machine has.
    pub fn thread_count(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        }
    }
}
