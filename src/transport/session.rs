//! A film that is being exposed: samples are added to it in passes, for as long as somebody wants more of them.
//!
//! The picture is cut into tiles, and each is a job of its own that an idle thread can take, since tiles differ by far in
//! what they cost. A tile takes its pixels off the film, adds samples to each in the order of their numbers, and puts them
//! back when all of them are done. So the film does not depend on who rendered which tile when, nor on how samples were
//! shared out over passes; a pass that was cancelled leaves complete tiles behind, and the others as they were.
//!
//! The threads and what the subsurface model has prepared last as long as the session. Another scene or another view does
//! not clear the film: an open shutter is a session whose scene changes. Whoever wants a new picture calls
//! [`Session::clear`].

use super::control::{RenderControl, RenderError, RenderStats};
use super::options::{Settings, View};
use super::path::PathTracer;
use super::surroundings::Surroundings;
use super::threads::Workers;
use crate::film::{Film, FilmLayer, MergeError, Window, composite};
use crate::sampling::Sampler;
use crate::scene::{Camera, Scene};
use crate::subsurface::{Propagator, Registry, Stop, SubsurfaceModel};
use rayon::prelude::*;
use std::cell::Cell;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Samples after which a tile asks whether to stop; long ones ask by themselves.
const SAMPLES_BETWEEN_QUESTIONS: u32 = 16;
/// Edge of a tile in pixels.
const TILE: u32 = 16;

/// Which pixels a pass is about, and how many samples each of them gets.
#[derive(Clone, Debug)]
pub enum Plan {
    /// So many for all of them.
    Everywhere(u32),
    /// So many for those of a window; what lies beyond the picture is nothing.
    Within(Window, u32),
    /// So many for each of them, row by row.
    Each(Vec<u32>),
}

impl Plan {
    fn samples(&self, x: u32, y: u32, width: u32) -> u32 {
        match self {
            Self::Everywhere(n) => *n,
            Self::Within(w, n) => {
                let within = |v: u32, first: u32, count: u32| v >= first && v - first < count;
                if within(x, w.x, w.width) && within(y, w.y, w.height) { *n } else { 0 }
            }
            Self::Each(counts) => counts.get((y * width + x) as usize).copied().unwrap_or(0),
        }
    }
}

/// A scene that is looked at, and the film with what was seen. `S` is a reference to a [`Scene`] or an [`Arc`] of one.
pub struct Session<S> {
    scene: S,
    view: View,
    settings: Settings,
    /// Number of the first sample of each pixel.
    first_sample: u32,
    film: Film,
    stats: RenderStats,
    workers: Workers,
    model: Arc<dyn SubsurfaceModel>,
    prepared: Box<dyn Propagator>,
}

impl<S: Deref<Target = Scene> + Sync> Session<S> {
    /// A session with an unexposed film; `threads` as in [`RenderOptions`](super::RenderOptions).
    ///
    /// # Errors
    /// Unknown models, empty images, no memory, no threads.
    pub fn new(
        scene: S,
        view: View,
        settings: Settings,
        threads: usize,
        models: &Registry,
    ) -> Result<Self, RenderError> {
        let View { width, height, .. } = view;
        if width == 0 || height == 0 {
            return Err(RenderError::Empty { width, height, spp: 1 });
        }
        let model = models.get(&settings.subsurface).ok_or_else(|| RenderError::UnknownModel {
            name: settings.subsurface.clone(),
            known: models.iter().map(|m| m.name().to_owned()).collect(),
        })?;
        let layers = view.layers();
        check_memory(width, height, &layers)?;
        let workers = Workers::new(threads)?;
        let prepared = workers.install(|| model.prepare(&scene));
        let film = Film::new(width, height, layers);
        let stats = RenderStats::default();
        Ok(Self { scene, view, settings, first_sample: 0, film, stats, workers, model, prepared })
    }

    /// Sets the number of the first sample of each pixel, 0 unless it is called: sessions with other samples make parts of
    /// one picture.
    #[must_use]
    pub fn starting_at(mut self, first_sample: u32) -> Self {
        self.first_sample = first_sample;
        self
    }

    /// Goes on with a film that was exposed before, from the same first sample on.
    ///
    /// # Errors
    /// A film of another size or with other layers.
    pub fn resume(&mut self, film: Film) -> Result<(), MergeError> {
        Film::new(self.view.width, self.view.height, self.view.layers()).merge(&film)?;
        self.film = film;
        Ok(())
    }

    /// What is on the film.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// The film itself; the session is over.
    pub fn into_film(self) -> Film {
        self.film
    }

    /// Work done and trouble met by all passes.
    pub fn stats(&self) -> RenderStats {
        self.stats
    }

    /// The scene that is looked at.
    pub fn scene(&self) -> &S {
        &self.scene
    }

    /// What is seen of it.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// How light is followed.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Looks at another scene from now on. What is on the film stays.
    pub fn set_scene(&mut self, scene: S) {
        let keeps = self.scene.has_same_bodies(&scene);
        self.scene = scene;
        if !keeps {
            self.prepared = self.workers.install(|| self.model.prepare(&self.scene));
        }
    }

    /// Looks from elsewhere from now on. What is on the film stays, unless the picture has another size or needs other
    /// layers: then it is a new one.
    ///
    /// # Errors
    /// Empty images, no memory; then everything is as it was.
    pub fn set_view(&mut self, view: View) -> Result<(), RenderError> {
        let (width, height, layers) = (view.width, view.height, view.layers());
        if width == 0 || height == 0 {
            return Err(RenderError::Empty { width, height, spp: 1 });
        }
        if (width, height) != (self.film.width(), self.film.height()) || layers != self.film.layers() {
            check_memory(width, height, &layers)?;
            self.film = Film::new(width, height, layers);
        }
        self.view = view;
        Ok(())
    }

    /// Forgets what is on the film, and what was counted.
    pub fn clear(&mut self) {
        self.film.clear();
        self.stats = RenderStats::default();
    }

    /// Adds samples to the film, those whose numbers follow on what each pixel has. `control` is told of the samples of
    /// this pass. False if it was cancelled: then some tiles have their samples and the others do not.
    pub fn pass(&mut self, plan: &Plan, control: &dyn RenderControl) -> bool {
        let View { width, height, .. } = self.view;
        let camera = Camera::new(&self.view.camera, width, height);
        let surroundings = Surroundings::new(&self.scene, &camera);
        let shared = Mutex::new((std::mem::take(&mut self.film), RenderStats::default()));
        let exposure = Exposure {
            scene: &self.scene,
            view: &self.view,
            settings: &self.settings,
            first_sample: self.first_sample,
            model: self.prepared.as_ref(),
            camera: &camera,
            surroundings: &surroundings,
            plan,
            control,
        };
        let finished = self.workers.install(|| exposure.run(&shared));
        let (film, stats) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.film = film;
        self.stats += stats;
        finished
    }
}

/// Whether there is memory for a film and the picture of it, as far as the system tells before it is used.
fn check_memory(width: u32, height: u32, layers: &[FilmLayer]) -> Result<(), RenderError> {
    let channels = layers.iter().map(|layer| layer.channels.len()).sum();
    let pixel = Film::pixel_bytes(channels) + size_of::<glam::Vec3>() as u64;
    let bytes = pixel.saturating_mul(u64::from(width) * u64::from(height));
    if crate::room::is_there(bytes) { Ok(()) } else { Err(RenderError::Memory { width, height, bytes }) }
}

/// One pass.
struct Exposure<'a> {
    scene: &'a Scene,
    view: &'a View,
    settings: &'a Settings,
    first_sample: u32,
    model: &'a dyn Propagator,
    camera: &'a Camera,
    surroundings: &'a Surroundings,
    plan: &'a Plan,
    control: &'a dyn RenderControl,
}

impl Exposure<'_> {
    fn run(&self, shared: &Mutex<(Film, RenderStats)>) -> bool {
        let lock = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        let tiles = self.tiles();
        let total = tiles.iter().map(|(_, samples)| samples).sum();
        let done = AtomicU64::new(0);
        let finish = |(window, samples): (Window, u64)| {
            if self.control.cancelled() {
                return false;
            }
            let mut part = lock().0.part(window);
            let Some(stats) = self.expose(window, &mut part) else { return false };
            let mut shared = lock();
            shared.0.set_part(window, &part);
            shared.1 += stats;
            drop(shared);
            let so_far = done.fetch_add(samples, Ordering::Relaxed) + samples;
            self.control.advance(so_far, total);
            true
        };
        tiles.into_par_iter().with_max_len(1).map(finish).reduce(|| true, |a, b| a && b)
    }

    /// The tiles that get any samples, and how many.
    fn tiles(&self) -> Vec<(Window, u64)> {
        let &View { width, height, .. } = self.view;
        let across = (0..height).step_by(TILE as usize);
        let windows = across.flat_map(|y| {
            (0..width).step_by(TILE as usize).map(move |x| Window {
                x,
                y,
                width: TILE.min(width - x),
                height: TILE.min(height - y),
            })
        });
        let samples = |w: Window| -> u64 {
            let pixels = (w.y..w.y + w.height).flat_map(|y| (w.x..w.x + w.width).map(move |x| (x, y)));
            pixels.map(|(x, y)| u64::from(self.plan.samples(x, y, width))).sum()
        };
        windows.map(|w| (w, samples(w))).filter(|(_, samples)| *samples > 0).collect()
    }

    /// Adds samples to a part of the film; `None` if it was cancelled on the way: a path may have ended before its time.
    fn expose(&self, window: Window, part: &mut Film) -> Option<RenderStats> {
        let asked = || self.control.cancelled();
        let stop = Stop(Some(&asked));
        let tracer = PathTracer {
            scene: self.scene,
            view: self.view,
            settings: self.settings,
            model: self.model,
            camera: self.camera,
            surroundings: self.surroundings,
            counters: Cell::new(RenderStats::default()),
            stop,
        };
        let layers = (self.view.transparent, self.view.ground.is_some());
        let mut values = Vec::new();
        let mut done = 0_u32;
        for i in 0..part.counts().len() {
            let (x, y) = (window.x + i as u32 % window.width, window.y + i as u32 / window.width);
            let pixel = y.wrapping_mul(self.view.width).wrapping_add(x);
            for _ in 0..self.plan.samples(x, y, self.view.width) {
                let number = self.first_sample.wrapping_add(part.counts()[i]);
                let mut sampler = Sampler::new(pixel, number, self.settings.seed);
                let found = tracer.sample_pixel(x, y, &mut sampler);
                values.clear();
                values.extend(found.parts.iter().flat_map(|part| part.to_array()));
                composite::push_values(&mut values, layers, found.covered, found.caught.as_ref());
                part.add(i, found.radiance.as_dvec3(), &values);
                done = done.wrapping_add(1);
                if done.is_multiple_of(SAMPLES_BETWEEN_QUESTIONS) && stop.asked() {
                    return None;
                }
            }
        }
        (!stop.asked()).then(|| tracer.counters.get())
    }
}
