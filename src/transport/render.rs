//! Sharing the pixels of a picture among threads.
//!
//! The image is cut into tiles, the samples into passes of growing size. A tile sums each pixel's samples in order, in
//! double precision, so that the result does not depend on who rendered which tile when. A cancelled render keeps
//! every tile it finished.

use super::media::{Enclosure, MediumStack};
use super::path::PathTracer;
use super::state::Counters;
use crate::film::Film;
use crate::optics::Microfacet;
use crate::sampling::Sampler;
use crate::scene::{Camera, CameraDescription, Scene};
use crate::subsurface::{Propagator, Registry};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Edge of a tile in pixels.
const TILE: u32 = 16;
/// Most samples a pixel in one pass.
const LARGEST_PASS: u32 = 16;

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
    /// Threads, 0 for all.
    pub threads: usize,
    /// The view.
    pub camera: CameraDescription,
    /// Name of the subsurface model.
    pub subsurface: String,
    /// Most events (surfaces met and scatterings) of a path.
    pub max_depth: u32,
    /// Whether rough surfaces scatter more than once.
    pub microfacet: Microfacet,
    /// Whether paths below a surface are also aimed at lights beyond it; off, the same picture is noisier.
    pub aim: bool,
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
    /// Whether to stop; what is finished is kept.
    fn cancelled(&self) -> bool;
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
    /// Paths that left a medium without crossing its boundary (open meshes).
    pub leaked_paths: u64,
    /// Samples that were not finite and count as black.
    pub invalid_samples: u64,
}

impl std::ops::AddAssign for RenderStats {
    fn add_assign(&mut self, more: Self) {
        self.rays += more.rays;
        self.scattering_events += more.scattering_events;
        self.truncated_paths += more.truncated_paths;
        self.leaked_paths += more.leaked_paths;
        self.invalid_samples += more.invalid_samples;
    }
}

/// A finished picture.
#[derive(Debug)]
pub struct Rendered {
    /// Mean radiance of every pixel.
    pub film: Film,
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
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|e| RenderError::Threads { threads: options.threads, reason: e.to_string() })?;
    Ok(pool.install(|| {
        let propagator = model.prepare(scene);
        Job { scene, options, control, model: propagator.as_ref() }.run()
    }))
}

struct Job<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    control: &'a dyn RenderControl,
    model: &'a dyn Propagator,
}

impl Job<'_> {
    fn run(&self) -> Rendered {
        let &RenderOptions { width, height, spp, .. } = self.options;
        let camera = Camera::new(&self.options.camera, width, height);
        let surrounding = surrounding(self.scene, camera.origin());
        let mut tiles = tiles(width, height);
        let total = u64::from(width) * u64::from(height) * u64::from(spp);
        let done = AtomicU64::new(0);
        let mut first = 0;
        while first < spp && !self.control.cancelled() {
            let last = (first + first.clamp(1, LARGEST_PASS)).min(spp);
            tiles.par_iter_mut().for_each(|tile| {
                if self.control.cancelled() {
                    return;
                }
                self.render_tile(tile, first..last, &camera, surrounding);
                let samples = tile.sums.len() as u64 * u64::from(last - first);
                let so_far = done.fetch_add(samples, Ordering::Relaxed) + samples;
                self.control.advance(so_far, total);
            });
            first = last;
        }
        self.assemble(&tiles)
    }

    fn render_tile(
        &self,
        tile: &mut Tile,
        samples: std::ops::Range<u32>,
        camera: &Camera,
        surrounding: MediumStack,
    ) {
        let tracer = PathTracer {
            scene: self.scene,
            options: self.options,
            model: self.model,
            camera,
            surrounding,
            counters: Cell::new(tile.counters),
        };
        let positions = (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y)));
        for ((x, y), sum) in positions.zip(&mut tile.sums) {
            let (x, y) = (tile.x + x, tile.y + y);
            for sample in samples.clone() {
                let index = self.options.first_sample.wrapping_add(sample);
                let mut sampler = Sampler::new(y * self.options.width + x, index, self.options.seed);
                *sum += tracer.sample_pixel(x, y, &mut sampler).as_dvec3();
            }
        }
        tile.samples = samples.end;
        tile.counters = tracer.counters.get();
    }

    fn assemble(&self, tiles: &[Tile]) -> Rendered {
        let mut film = Film::new(self.options.width, self.options.height);
        let mut stats = RenderStats::default();
        for tile in tiles {
            for (i, sum) in tile.sums.iter().enumerate() {
                let (x, y) = (tile.x + i as u32 % tile.width, tile.y + i as u32 / tile.width);
                let mean = *sum / f64::from(tile.samples.max(1));
                film.pixels[(y * self.options.width + x) as usize] = mean.as_vec3();
            }
            stats.rays += tile.counters.rays;
            stats.scattering_events += tile.counters.events;
            stats.truncated_paths += tile.counters.truncated;
            stats.leaked_paths += tile.counters.leaks;
            stats.invalid_samples += tile.counters.invalid;
        }
        Rendered { film, spp: tiles.iter().map(|t| t.samples).min().unwrap_or(0), stats }
    }
}

fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in (0..height).step_by(TILE as usize) {
        for x in (0..width).step_by(TILE as usize) {
            let (w, h) = (TILE.min(width - x), TILE.min(height - y));
            let sums = vec![DVec3::ZERO; (w * h) as usize];
            let counters = Counters::default();
            tiles.push(Tile { x, y, width: w, height: h, sums, samples: 0, counters });
        }
    }
    tiles
}

/// The closed media around a point.
fn surrounding(scene: &Scene, point: Vec3) -> MediumStack {
    let mut stack = MediumStack::default();
    for (i, object) in scene.objects.iter().enumerate() {
        let instance = i as u32;
        if !(object.has_medium && object.closed) {
            continue;
        }
        let local = scene.geometry.transform(instance).inverse_point(point);
        if scene.geometry.mesh_of(instance).contains(local) {
            let materials = &scene.mesh(instance).triangle_materials;
            if let Some(&material) = materials.iter().find(|&&m| scene.medium(m).is_some()) {
                stack.enter(Enclosure { instance, material, rank: object.rank });
            }
        }
    }
    stack
}
