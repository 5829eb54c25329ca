//! Sharing the pixels of a picture among threads.
//!
//! The image is cut into tiles, the samples into passes of growing size. A tile sums each pixel's samples in order, in
//! double precision, so that the result does not depend on who rendered which tile when. A cancelled render keeps
//! every tile it finished.

use super::path::PathTracer;
use super::pixel::{Composite, Coverage, into_picture};
use super::state::Counters;
use super::surroundings::Surroundings;
use super::threads::on_threads;
use crate::film::Picture;
use crate::optics::Microfacet;
use crate::sampling::Sampler;
use crate::scene::{Camera, CameraDescription, Footprint, Scene};
use crate::subsurface::{Propagator, Registry, Stop};
use glam::DVec3;
use rayon::prelude::*;
use std::cell::Cell;
use std::sync::{OnceLock, atomic::AtomicU64, atomic::Ordering};
use std::time::{Duration, Instant};

/// Samples after which a tile asks whether to stop; long ones ask by themselves.
const SAMPLES_BETWEEN_QUESTIONS: u32 = 16;
/// Edge of a tile in pixels.
const TILE: u32 = 16;
/// Most samples a pixel in one pass.
const LARGEST_PASS: u32 = 16;
/// How much longer the first pass may go on once somebody asked to stop: without it there is no picture at all.
const GRACE: Duration = Duration::from_millis(300);

/// What to render.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel.
    pub spp: u32,
    /// Index of the first of them; renders of different samples are parts of one picture.
    pub first_sample: u32,
    /// Seed: another seed, another noise.
    pub seed: u32,
    /// Threads, 0 for those of the thread pool that is there: by default as many as the machine has.
    pub threads: usize,
    /// The view.
    pub camera: CameraDescription,
    /// Name of the subsurface model.
    pub subsurface: String,
    /// Most events of a path between the camera and the light that it finds: reflections, refractions and scatterings. What
    /// is passed straight does not count.
    pub max_depth: u32,
    /// Whether rough surfaces scatter more than once.
    pub microfacet: Microfacet,
    /// Whether paths below a surface are also aimed at lights beyond it; off, the same picture is noisier.
    pub aim: bool,
    /// How wide a part of a pixel colour textures are averaged over, in pixels ([`crate::scene::Footprint`]); 0 looks them
    /// up at points.
    pub texture_filter: f32,
    /// Height (y, metres) of a horizontal plane that is seen only by the shadow that falls on it.
    pub ground: Option<f32>,
    /// Whether the background is left out, and the picture has alpha.
    pub transparent: bool,
}

impl RenderOptions {
    /// 640 × 480 pixels of 64 samples with the random walk, all threads and nothing cut off.
    pub fn new(camera: CameraDescription) -> Self {
        Self {
            width: 640,
            height: 480,
            spp: 64,
            first_sample: 0,
            seed: 0,
            threads: 0,
            camera,
            subsurface: "random-walk".to_owned(),
            max_depth: 100_000,
            microfacet: Microfacet::Multiple,
            aim: true,
            texture_filter: Footprint::DEFAULT_FILTER,
            ground: None,
            transparent: false,
        }
    }

    /// The threads that will render: as many as asked for, else as the machine has.
    pub fn thread_count(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        }
    }
}

/// Progress and cancellation, from whoever waits.
pub trait RenderControl: Sync {
    /// Called now and then with the samples done so far and in all.
    fn advance(&self, samples_done: u64, samples_total: u64);
    /// Whether to stop; what is finished is kept, and the first pass gets 0.3 s more. Asked often; it stays so.
    fn cancelled(&self) -> bool;
    /// Called between passes, while nothing is rendered; `picture` makes the picture so far, whose pixels all have the
    /// same number of samples.
    fn between_passes(&self, _picture: &dyn Fn() -> Rendered) {}
}

/// Neither watches nor cancels.
impl RenderControl for () {
    fn advance(&self, _: u64, _: u64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Work done and trouble met.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderStats {
    /// Rays followed: camera rays, bounces, shadow rays, and one for each flight through a medium.
    pub rays: u64,
    /// Scattering events in media.
    pub scattering_events: u64,
    /// Paths that ended at the cap on events.
    pub truncated_paths: u64,
    /// Paths that left a medium without crossing its boundary.
    pub leaked_paths: u64,
    /// Those of them that were in an object whose mesh is closed.
    pub lost_paths: u64,
    /// Samples that were not finite and count as black.
    pub invalid_samples: u64,
}

impl std::ops::AddAssign for RenderStats {
    fn add_assign(&mut self, more: Self) {
        self.rays += more.rays;
        self.scattering_events += more.scattering_events;
        self.truncated_paths += more.truncated_paths;
        self.leaked_paths += more.leaked_paths;
        self.lost_paths += more.lost_paths;
        self.invalid_samples += more.invalid_samples;
    }
}

/// A finished picture.
#[derive(Debug)]
pub struct Rendered {
    /// Mean radiance of every pixel.
    pub picture: Picture,
    /// Samples that every pixel has (fewer than asked for after cancellation).
    pub spp: u32,
    /// What happened on the way.
    pub stats: RenderStats,
}

/// Why nothing was rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No such model.
    #[error("there is no subsurface model `{name}`; there are: {}", known.join(", "))]
    UnknownModel {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// An empty image.
    #[error("an image of {width}×{height} pixels and {spp} samples is empty")]
    Empty {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Samples a pixel.
        spp: u32,
    },
    /// There is no memory for the picture.
    #[error("there is no memory for {width}×{height} pixels, which take {:.1} GB", *bytes as f64 / 1e9)]
    Memory {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What is needed.
        bytes: u64,
    },
    /// The operating system gave no threads.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why not.
        reason: String,
    },
}

struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    sums: Vec<DVec3>,
    /// As long as `sums` where there may be something behind objects, else empty.
    coverage: Vec<Coverage>,
    samples: u32,
    counters: Counters,
}

/// Renders a picture with the models of this crate.
///
/// # Errors
/// Unknown models, empty images, no threads.
pub fn render(
    scene: &Scene,
    options: &RenderOptions,
    control: &dyn RenderControl,
) -> Result<Rendered, RenderError> {
    render_with(scene, options, control, &Registry::standard())
}

/// Renders a picture with models from a registry.
///
/// # Errors
/// Unknown models, empty images, no threads.
pub fn render_with(
    scene: &Scene,
    options: &RenderOptions,
    control: &dyn RenderControl,
    models: &Registry,
) -> Result<Rendered, RenderError> {
    let &RenderOptions { width, height, spp, .. } = options;
    if width == 0 || height == 0 || spp == 0 {
        return Err(RenderError::Empty { width, height, spp });
    }
    let model = models.get(&options.subsurface).ok_or_else(|| RenderError::UnknownModel {
        name: options.subsurface.clone(),
        known: models.iter().map(|m| m.name().to_owned()).collect(),
    })?;
    check_memory(options)?;
    let rendered = on_threads(options.threads, || {
        let propagator = model.prepare(scene);
        Job { scene, options, control, model: propagator.as_ref(), asked: OnceLock::new() }.run()
    });
    rendered.map_err(|reason| RenderError::Threads { threads: options.thread_count(), reason })
}

/// Whether there is memory for the sums and the picture, as far as the system tells before it is used.
fn check_memory(options: &RenderOptions) -> Result<(), RenderError> {
    let &RenderOptions { width, height, .. } = options;
    let pixel = size_of::<DVec3>() + size_of::<Coverage>() + 2 * size_of::<glam::Vec3>();
    let bytes = (pixel as u64).saturating_mul(u64::from(width) * u64::from(height));
    if crate::room::is_there(bytes) { Ok(()) } else { Err(RenderError::Memory { width, height, bytes }) }
}

struct Job<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    control: &'a dyn RenderControl,
    model: &'a dyn Propagator,
    /// When it was first seen that somebody wants to stop.
    asked: OnceLock<Instant>,
}

impl Job<'_> {
    /// Whether a pass that begins with that sample has to stop.
    fn stops(&self, first: u32) -> bool {
        self.control.cancelled() && (first > 0 || self.asked.get_or_init(Instant::now).elapsed() >= GRACE)
    }

    fn run(&self) -> Rendered {
        let &RenderOptions { width, height, spp, .. } = self.options;
        let camera = Camera::new(&self.options.camera, width, height);
        let surroundings = Surroundings::new(self.scene, &camera);
        let mut tiles = tiles(width, height, self.has_coverage());
        let total = u64::from(width) * u64::from(height) * u64::from(spp);
        let done = AtomicU64::new(0);
        let mut first = 0;
        while first < spp && !self.control.cancelled() {
            let last = (first + first.clamp(1, LARGEST_PASS)).min(spp);
            // Tiles differ by far in what they cost: each is a job of its own that an idle thread can take.
            tiles.par_iter_mut().with_max_len(1).for_each(|tile| {
                if self.stops(first) {
                    return;
                }
                if !self.render_tile(tile, first..last, &camera, &surroundings) {
                    return;
                }
                let samples = tile.sums.len() as u64 * u64::from(last - first);
                let so_far = done.fetch_add(samples, Ordering::Relaxed) + samples;
                self.control.advance(so_far, total);
            });
            first = last;
            if first < spp && !self.control.cancelled() {
                self.control.between_passes(&|| self.assemble(&tiles));
            }
        }
        self.assemble(&tiles)
    }

    /// Adds samples to a tile; false if it was cancelled on the way. Then the tile is as it was before: all of its pixels
    /// have the same samples, and none of them is that of a path that ended before its time.
    fn render_tile(
        &self,
        tile: &mut Tile,
        samples: std::ops::Range<u32>,
        camera: &Camera,
        surroundings: &Surroundings,
    ) -> bool {
        let asked = || self.stops(samples.start);
        let stop = Stop(Some(&asked));
        let before = (tile.sums.clone(), tile.coverage.clone());
        let tracer = PathTracer {
            scene: self.scene,
            options: self.options,
            model: self.model,
            camera,
            surroundings,
            counters: Cell::new(tile.counters),
            stop,
        };
        let positions = (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y)));
        let mut done = 0_u32;
        'pixels: for (i, ((x, y), sum)) in positions.zip(&mut tile.sums).enumerate() {
            let (x, y) = (tile.x + x, tile.y + y);
            for sample in samples.clone() {
                let index = self.options.first_sample.wrapping_add(sample);
                let mut sampler = Sampler::new(y * self.options.width + x, index, self.options.seed);
                let found = tracer.sample_pixel(x, y, &mut sampler);
                *sum += found.radiance.as_dvec3();
                if let Some(coverage) = tile.coverage.get_mut(i) {
                    coverage.add(&found);
                }
                done = done.wrapping_add(1);
                if done.is_multiple_of(SAMPLES_BETWEEN_QUESTIONS) && stop.asked() {
                    break 'pixels;
                }
            }
        }
        if stop.asked() {
            (tile.sums, tile.coverage) = before;
            return false;
        }
        tile.samples = samples.end;
        tile.counters = tracer.counters.get();
        true
    }

    fn has_coverage(&self) -> bool {
        self.options.transparent || self.options.ground.is_some()
    }

    fn assemble(&self, tiles: &[Tile]) -> Rendered {
        let mut picture = Picture::new(self.options.width, self.options.height);
        let mut stats = RenderStats::default();
        let mut composites = Vec::new();
        if self.has_coverage() {
            composites.resize(picture.pixels.len(), Composite::default());
        }
        for tile in tiles {
            for (i, sum) in tile.sums.iter().enumerate() {
                let (x, y) = (tile.x + i as u32 % tile.width, tile.y + i as u32 / tile.width);
                let mean = *sum / f64::from(tile.samples.max(1));
                let at = (y * self.options.width + x) as usize;
                match (tile.coverage.get(i), composites.get_mut(at)) {
                    (Some(coverage), Some(composite)) => {
                        *composite = coverage.finish(mean, tile.samples, self.options.transparent);
                    }
                    _ => picture.pixels[at] = mean.as_vec3(),
                }
            }
            stats.rays += tile.counters.rays;
            stats.scattering_events += tile.counters.events;
            stats.truncated_paths += tile.counters.truncated;
            stats.leaked_paths += tile.counters.leaks;
            stats.lost_paths += tile.counters.lost;
            stats.invalid_samples += tile.counters.invalid;
        }
        if self.has_coverage() {
            let &RenderOptions { transparent, ground, .. } = self.options;
            into_picture(&mut picture, &composites, transparent, ground.is_some());
        }
        Rendered { picture, spp: tiles.iter().map(|t| t.samples).min().unwrap_or(0), stats }
    }
}

fn tiles(width: u32, height: u32, has_coverage: bool) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(TILE as usize) {
        for x in (0..width).step_by(TILE as usize) {
            let (w, h) = (TILE.min(width - x), TILE.min(height - y));
            let sums = vec![DVec3::ZERO; (w * h) as usize];
            let coverage = if has_coverage { vec![Coverage::default(); sums.len()] } else { Vec::new() };
            let counters = Counters::default();
            tiles.push(Tile { x, y, width: w, height: h, sums, coverage, samples: 0, counters });
        }
    }
    tiles
}
