//! The searchlight: R(r) of any subsurface model, measured. A pencil beam meets a half space at normal incidence; how
//! much light comes out at which distance?
//!
//! The real [`Propagator`] of a model walks in a real scene: a box so large that it is a half space for the medium. By
//! reciprocity paths run backwards, from the camera's side: they enter along the inward normal at the middle of the upper
//! face, and radiance 1 shines on the box from everywhere. What a path brings home is binned by the distance r from
//! where it entered. Summed over all r that is the reflectance, and R(r) is its density per area: as in
//! [`crate::optics::diffusion`], for unit power that has crossed the surface on the way in.
//!
//! - A walk that meets the face from inside is reflected or refracted by Fresnel's equations and counts where it
//!   comes out.
//! - A BSSRDF counts at its exit, times what its lobe integrates to.
//! - Single scattering asks for a light; it is given a direction, uniform over the sphere.
//!
//! Lengths are scaled so that the transport mean free path 1/σt′ is 1.
//!
//! Paths are dealt to [`BATCHES`] batches with numbers of their own; standard errors are those of the batches' mean, and
//! nothing depends on the number of threads.

mod half_space;

use super::control::{RenderControl, RenderError};
use super::media::Enclosure;
use super::threads::Workers;
use crate::film::Film;
use crate::geometry::{Hit, offset_origin};
use crate::light::{LightPoint, LightSample};
use crate::optics::diffusion::Coefficients;
use crate::optics::{HenyeyGreenstein, Medium, fresnel};
use crate::sampling::Sampler;
use crate::scene::{Scene, SceneError, Surface};
use crate::subsurface::{
    Aim, Aimed, Arrival, Connection, Connector, Exit, Flight, PathHead, Propagator, Start, Stop,
    SubsurfaceModel,
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};
use std::sync::atomic::{AtomicU64, Ordering};

/// Independent batches of paths.
pub const BATCHES: u32 = 64;
/// Fewest batches that say something about their spread; fewer are left after an early interruption.
const FEWEST_BATCHES: usize = 8;
/// Paths between two questions whether to stop.
const BETWEEN_QUESTIONS: u32 = 256;

/// Nearer than this to the beam, in transport mean free paths, light has come out where it entered.
const NOWHERE_ELSE: f32 = 1e-5;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Searchlight {
    /// The medium and its boundary, which is smooth.
    pub coefficients: Coefficients,
    /// Ascending radii between the bins, in transport mean free paths.
    pub edges: Vec<f64>,
    /// Paths; rounded up to a multiple of [`BATCHES`].
    pub paths: u64,
    /// Seed: another seed, another noise.
    pub seed: u32,
    /// Threads, 0 for all.
    pub threads: usize,
}

/// A share of the light that crossed the surface, and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Radii between the bins, in transport mean free paths.
    pub edges: Vec<f64>,
    /// Light inside the first edge, between each pair, and outside the last.
    pub shares: Vec<Share>,
    /// All of it.
    pub total: Share,
    /// Paths that were followed.
    pub paths: u64,
}

/// Why there is no profile.
#[derive(Debug, thiserror::Error)]
pub enum SearchlightError {
    /// Neither absorption nor scattering, or numbers that are none.
    #[error("a medium that does not scatter has no profile")]
    NothingScattered,
    /// The model lets light out where it came in.
    #[error("light leaves where it came in")]
    LeavesWhereItEntered,
    /// The model asks for the closest light, and there is none.
    #[error("it depends on the lights of a scene")]
    NeedsLights,
    /// Stopped before there was enough.
    #[error("interrupted")]
    Interrupted,
    /// The box could not be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The operating system gave no threads.
    #[error(transparent)]
    Threads(#[from] RenderError),
}

impl Histogram {
    /// R in the bin between edges i and i + 1, as 1 over the area of a square of one transport mean free path.
    pub fn reflectance(&self, i: usize) -> Share {
        let area = std::f64::consts::PI * (self.edges[i + 1].powi(2) - self.edges[i].powi(2));
        let Share { value, standard_error } = self.shares[i + 1];
        Share { value: value / area, standard_error: standard_error / area }
    }
}

/// Measures the profile of `model`.
///
/// # Errors
/// See [`SearchlightError`].
pub fn measure(
    model: &dyn SubsurfaceModel,
    light: &Searchlight,
    control: &dyn RenderControl,
) -> Result<Histogram, SearchlightError> {
    let c = &light.coefficients;
    let measurable = c.transport_mean_free_path().is_finite() && c.sigma_t().is_finite() && c.eta.is_finite();
    if !(c.scatters() && measurable) {
        return Err(SearchlightError::NothingScattered);
    }
    let (description, face) = half_space::build(c);
    let scene = Scene::build(description)?;
    let medium = scene.medium(0).ok_or(SearchlightError::NothingScattered)?;
    Workers::new(light.threads)?.install(|| {
        let propagator = model.prepare(&scene);
        let asked = || control.cancelled();
        let stop = Stop(Some(&asked));
        Bench { scene: &scene, medium, face, propagator: propagator.as_ref(), light, stop }.run(control)
    })
}

/// What a path brings home, by radius.
struct Tally<'a> {
    edges: &'a [f64],
    shares: Vec<f64>,
    /// Light that came out where it entered.
    at_beam: f64,
    needs_lights: bool,
}

impl Tally<'_> {
    fn record(&mut self, at: Vec3, light: f32) {
        let r = at.truncate().length();
        self.shares[self.edges.partition_point(|&edge| edge <= f64::from(r))] += f64::from(light);
        if r < NOWHERE_ELSE {
            self.at_beam += f64::from(light);
        }
    }
}

struct Bench<'a> {
    scene: &'a Scene,
    medium: &'a Medium,
    /// Triangles of the upper face.
    face: u32,
    propagator: &'a dyn Propagator,
    light: &'a Searchlight,
    stop: Stop<'a>,
}

impl Bench<'_> {
    fn run(&self, control: &dyn RenderControl) -> Result<Histogram, SearchlightError> {
        let each = self.light.paths.div_ceil(u64::from(BATCHES)).clamp(1, u64::from(u32::MAX)) as u32;
        let total = u64::from(each) * u64::from(BATCHES);
        let done = AtomicU64::new(0);
        let tallies: Vec<Option<Tally>> = (0..BATCHES)
            .into_par_iter()
            .with_max_len(1)
            .map(|batch| {
                let mut tally = self.tally();
                for path in 0..each {
                    if path % BETWEEN_QUESTIONS == 0 {
                        if control.cancelled() {
                            return None;
                        }
                        let step = u64::from(BETWEEN_QUESTIONS.min(each - path));
                        control.advance(done.fetch_add(step, Ordering::Relaxed), total);
                    }
                    self.follow(&mut Sampler::new(batch, path, self.light.seed), &mut tally);
                    if self.stop.asked() {
                        return None;
                    }
                }
                Some(tally)
            })
            .collect();
        let tallies: Vec<Tally> = tallies.into_iter().flatten().collect();
        if tallies.len() < FEWEST_BATCHES {
            return Err(SearchlightError::Interrupted);
        }
        if tallies.iter().any(|t| t.needs_lights) {
            return Err(SearchlightError::NeedsLights);
        }
        // A pixel for each bin and one for all of them; each batch is a sample.
        let bins = self.light.edges.len() + 1;
        let mut film = Film::new(bins as u32 + 1, 1, Vec::new());
        for tally in &tallies {
            let all = tally.shares.iter().sum();
            for (i, light) in tally.shares.iter().chain([&all]).enumerate() {
                film.add(i, DVec3::splat(light / f64::from(each)), &[]);
            }
        }
        let share = |i| Share { value: film.mean(i).x, standard_error: film.standard_error(i).x };
        let total = share(bins);
        let at_beam: f64 = tallies.iter().map(|t| t.at_beam / f64::from(each)).sum();
        if at_beam / tallies.len() as f64 > 0.5 * total.value {
            return Err(SearchlightError::LeavesWhereItEntered);
        }
        Ok(Histogram {
            edges: self.light.edges.clone(),
            shares: (0..bins).map(share).collect(),
            total,
            paths: tallies.len() as u64 * u64::from(each),
        })
    }

    fn tally(&self) -> Tally<'_> {
        let edges = &self.light.edges;
        Tally { edges, shares: vec![0.0; edges.len() + 1], at_beam: 0.0, needs_lights: false }
    }

    /// Follows one path from the beam until it comes out or ends.
    fn follow(&self, sampler: &mut Sampler, tally: &mut Tally) {
        let object = &self.scene.objects[0];
        let eta = self.light.coefficients.eta as f32;
        let flight = Flight {
            scene: self.scene,
            enclosure: Enclosure { instance: 0, material: 0, rank: object.rank },
            object,
            medium: self.medium,
            eta,
            budget: u32::MAX,
            connection: Connection::None,
            stop: self.stop,
        };
        // The first vertex of the first triangle is the middle of the face.
        let entry = Surface::new(self.scene, &Hit::at(0, 0, 0.0, 0.0));
        let mut head = leave(&entry, -entry.geometric_normal, Vec3::splat(1.0 / (eta * eta)));
        while !self.stop.asked() {
            let arrival = self.propagator.propagate(&flight, &mut head, sampler, &mut Everywhere { tally });
            match arrival {
                Arrival::Exit(exit) => {
                    let Exit { surface, lobe } = *exit;
                    let u = sampler.next_2d();
                    let (sin, azimuth) = (u.x.sqrt(), TAU * u.y);
                    let cos = (1.0 - u.x).sqrt();
                    let wi = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                    let light = head.throughput * lobe.eval(wi) * (PI / cos);
                    return tally.record(surface.position, light.x);
                }
                Arrival::Surface(hit) => {
                    let surface = Surface::new(self.scene, &hit);
                    let normal = surface.geometric_normal;
                    let cos = head.direction.dot(normal).abs();
                    if sampler.rng().f32() >= fresnel::dielectric(cos, 1.0 / eta) {
                        if hit.triangle < self.face {
                            tally.record(surface.position, head.throughput.x * eta * eta);
                        }
                        return;
                    }
                    let reflected = head.direction - 2.0 * head.direction.dot(normal) * normal;
                    head = leave(&surface, reflected, head.throughput);
                }
                Arrival::Escaped | Arrival::Ended => return,
            }
        }
    }
}

/// A path that sets out from the boundary.
fn leave(surface: &Surface, direction: Vec3, throughput: Vec3) -> PathHead {
    PathHead {
        position: offset_origin(surface.position, surface.error, surface.geometric_normal, direction),
        direction,
        throughput,
        events: 0,
        start: Some(Start {
            instance: surface.instance,
            triangle: surface.triangle,
            barycentric: surface.barycentric,
        }),
        aimed: Aimed::default(),
    }
}

/// Radiance 1 from everywhere.
struct Everywhere<'a, 'b> {
    tally: &'a mut Tally<'b>,
}

impl Connector for Everywhere<'_, '_> {
    fn scattered(&mut self, _: Vec3, _: Vec3, _: Vec3, _: HenyeyGreenstein, _: u32, _: &mut Sampler) {}

    fn redirected(&mut self, _: Vec3, _: f32) {}

    fn light(&mut self, _: Vec3, sampler: &mut Sampler) -> Option<LightSample> {
        let u = sampler.next_2d();
        let (z, azimuth) = (1.0 - 2.0 * u.x, TAU * u.y);
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let direction = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), z);
        Some(LightSample {
            direction,
            distance: f32::INFINITY,
            radiance: Vec3::ONE,
            pdf: 1.0 / (2.0 * TAU),
            point: LightPoint::Environment(direction),
        })
    }

    fn closest_light(&mut self, _: Vec3, _: &mut Sampler) -> Option<LightSample> {
        self.tally.needs_lights = true;
        None
    }

    fn deliver(&mut self, surface: &Surface, light: &LightSample, _: f32, throughput: Vec3, _: &mut Sampler) {
        self.tally.record(surface.position, throughput.x / light.pdf);
    }

    fn aim(&self, _: Vec3, _: Vec3, _: &mut Aim) -> bool {
        false
    }

    fn draw(&self, _: Vec3, _: &mut Aim, _: &mut Sampler) -> Option<(Vec3, f32)> {
        None
    }

    fn emerge(&mut self, _: &Hit, _: Vec3, _: Vec3, _: &Aim, _: Aimed, _: &mut Sampler) {}
}
