//! Subsurface models: where does light that left an object come in?
//!
//! **Plug-in seam.** A model is one file with one [`SubsurfaceModel`], and one line in [`Registry::standard`]; a model
//! from another crate goes through [`Registry::register`]. The path tracer asks a model one question, once per
//! flight below a surface: *this path is inside this object at this point, going this way: where does it arrive
//! next?* ([`Propagator::propagate`]). The random walk answers with the boundary point it meets from inside; a BSSRDF
//! answers with an exit point and a diffuse lobe. Emission, light sampling, nesting and whole scenes are the path
//! tracer's business, so every model works everywhere.
//!
//! Throughput carries radiance from the camera: the boundary has already divided it by η² on the way in. A model that
//! answers [`Arrival::Exit`] multiplies by η² to bring it out again.

mod accelerated_walk;
mod aim;
mod aiming;
mod better_dipole;
mod brdf_approximation;
mod dipole;
mod directional_dipole;
mod draws;
mod exit_search;
mod from_boundary;
mod guide;
mod intruders;
mod last_event;
mod light_biased;
mod normalized_diffusion;
mod photon_beam_diffusion;
mod radial;
mod random_walk;
mod single_scattering;
mod spectral;
mod sphere_jumps;
mod steps;
mod tables;
mod textured;

pub use accelerated_walk::AcceleratedWalk;
pub use aim::{Aim, Aimed, NearBoundary};
pub use better_dipole::BetterDipole;
pub use brdf_approximation::BrdfApproximation;
pub use dipole::Dipole;
pub use directional_dipole::DirectionalDipole;
pub use exit_search::{Candidate, ExitSearch, Found, Radii};
pub use light_biased::LightBiased;
pub use normalized_diffusion::NormalizedDiffusion;
pub use photon_beam_diffusion::PhotonBeamDiffusion;
pub use radial::{Formula, Radial};
pub use random_walk::RandomWalk;
pub use single_scattering::SingleScattering;
pub use textured::TexturedMedium;

use crate::geometry::{Aabb, Hit};
use crate::light::LightSample;
use crate::optics::diffusion::{Coefficients, Cosines, RadialProfile, ScaleFit};
use crate::optics::{ExitLobe, HenyeyGreenstein, Medium};
use crate::sampling::Sampler;
use crate::scene::{MediumDescription, Object, Scene, Surface};
use crate::transport::Enclosure;
use glam::Vec3;
use std::sync::Arc;

/// Whether somebody asked to stop. A walk may take minutes; one that sees this ends anywhere, and what it brings home is
/// thrown away.
#[derive(Clone, Copy)]
pub struct Stop<'a>(pub Option<&'a (dyn Fn() -> bool + Sync)>);

/// Events after which a walk that has no longer steps asks whether to stop.
pub(crate) const BETWEEN_QUESTIONS: u32 = 64;

impl Stop<'_> {
    /// Nobody asks.
    pub const NEVER: Self = Self(None);

    /// Whether to stop.
    #[inline]
    pub fn asked(&self) -> bool {
        self.0.is_some_and(|asked| asked())
    }
}

/// A flight below a surface: which object, which medium.
pub struct Flight<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The object around the path and the material through which it was entered.
    pub enclosure: Enclosure,
    /// The object's properties.
    pub object: &'a Object,
    /// What fills it (before textures).
    pub medium: &'a Medium,
    /// Index of the medium over that of what surrounds the object.
    pub eta: f32,
    /// Scattering events the path may still have, and one more, which ends it: light is not looked for there.
    pub budget: u32,
    /// How events in the medium can be connected to lights.
    pub connection: Connection,
    /// Asked now and then by what may take long.
    pub stop: Stop<'a>,
}

impl Flight<'_> {
    /// The point of the object's boundary that the path has just come through; `None` where it begins elsewhere.
    pub fn entry(&self, head: &PathHead) -> Option<Hit> {
        let start = head.start.filter(|s| s.instance == self.enclosure.instance)?;
        Some(start.hit())
    }

    /// The coefficients of each channel, before textures.
    pub fn coefficients(&self) -> [Coefficients; 3] {
        [0, 1, 2].map(|i| Coefficients {
            eta: f64::from(self.eta),
            ..Coefficients::of_medium(self.medium, i, 1.0)
        })
    }

    /// Whether the object ends at a point of its mesh: overlapping parts of the mesh, and objects of higher rank, hide the
    /// boundaries that are inside of them.
    pub fn is_interface(&self, surface: &Surface) -> bool {
        let Object { in_parts, overlapped, rank, .. } = *self.object;
        if !(in_parts || overlapped) {
            return true;
        }
        let geometry = &self.scene.geometry;
        let holds = |instance: u32| {
            let outside = geometry.beside(&surface.point(), surface.geometric_normal, instance);
            geometry.mesh_of(instance).contains(geometry.transform(instance).inverse_point(outside))
        };
        let hides = |other: u32| {
            let object = &self.scene.objects[other as usize];
            object.has_medium && object.closed && object.rank > rank && holds(other)
        };
        let own = in_parts && holds(surface.instance);
        let foreign = || {
            let mut hidden = false;
            self.scene.visit_intruders(surface.instance, &surface.point(), |other| {
                hidden = hides(other);
                !hidden
            });
            hidden
        };
        !(own || (overlapped && foreign()))
    }

    /// The box around the medium in world space; everything where the mesh is open. A walk that is beyond it has been let out
    /// by rounding: an event right at the boundary may be on the other side of it.
    pub fn bounds(&self) -> Aabb {
        if !self.object.closed {
            return Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        }
        self.scene.geometry.instance_bounds(self.enclosure.instance)
    }

    /// Whether coefficients come from textures.
    pub fn is_textured(&self) -> bool {
        let medium = self.scene.material(self.enclosure.material).medium.as_ref();
        medium.is_some_and(MediumDescription::is_textured)
    }
}

/// How scattering events in a medium can be connected to lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connection {
    /// Not at all: light comes in where the path meets the boundary.
    None,
    /// In straight lines: lights are inside, or the boundary does not bend light.
    Straight,
    /// Through the boundary of the object, which bends light: directions can be aimed ([`Connector::aim`]).
    Boundary,
}

/// The moving end of a path, in world space.
#[derive(Clone, Copy, Debug)]
pub struct PathHead {
    /// Where it is.
    pub position: Vec3,
    /// Unit direction of travel (away from the camera).
    pub direction: Vec3,
    /// Weight of what it will find, for each channel.
    pub throughput: Vec3,
    /// Scattering events of this flight.
    pub events: u32,
    /// The surface point that the head has just left (at `position`, up to rounding): a walk in the object's own space
    /// starts there without the rounding of world space.
    pub start: Option<Start>,
    /// Where the flight ends on the boundary: how much likelier an aimed direction ([`Connector::emerge`]) was to lead here
    /// than the path itself. Light found directly beyond the boundary is weighed with it.
    pub aimed: Aimed,
}

/// A point of an instance's mesh.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The instance.
    pub instance: u32,
    /// The triangle of its mesh.
    pub triangle: u32,
    /// Barycentric coordinates of vertices 1 and 2.
    pub barycentric: glam::Vec2,
}

impl Start {
    /// The point as a hit of no ray.
    pub fn hit(&self) -> Hit {
        Hit::at(self.instance, self.triangle, self.barycentric.x, self.barycentric.y)
    }

    /// The point of a surface.
    pub fn of(surface: &Surface) -> Self {
        let &Surface { instance, triangle, barycentric, .. } = surface;
        Self { instance, triangle, barycentric }
    }
}

/// How a flight ended.
#[derive(Debug)]
pub enum Arrival {
    /// A surface was met: the object's own boundary from inside, or anything else in the medium.
    Surface(Hit),
    /// A BSSRDF: the light came in at this point of the object, with the weight already in the throughput.
    Exit(Box<Exit>),
    /// Nothing was met: the mesh is open.
    Escaped,
    /// The path ended: absorbed, or out of its budget of events.
    Ended,
}

/// Where and how a BSSRDF lets light into an object.
#[derive(Debug)]
pub struct Exit {
    /// The point of the object.
    pub surface: Surface,
    /// The lobe of incidence there, on the outside.
    pub lobe: Box<dyn ExitLobe>,
}

/// Light at the scattering events of a flight.
pub trait Connector {
    /// [`Connection::Straight`]: called at each scattering event, after the throughput has been multiplied by the albedo;
    /// `incoming` is the direction of travel before the event, which is number `events` of the flight, from 1.
    fn scattered(
        &mut self,
        point: Vec3,
        incoming: Vec3,
        throughput: Vec3,
        phase: HenyeyGreenstein,
        events: u32,
        sampler: &mut Sampler,
    );
    /// [`Connection::Straight`]: called with the direction chosen and its phase-function density, so that hits by chance
    /// can be weighted.
    fn redirected(&mut self, point: Vec3, pdf: f32);
    /// Chooses a light for a point below the surface. The direction is that of a straight line.
    fn light(&mut self, point: Vec3, sampler: &mut Sampler) -> Option<LightSample>;
    /// As [`Connector::light`], but always a point of the closest light: biased.
    fn closest_light(&mut self, point: Vec3, sampler: &mut Sampler) -> Option<LightSample>;
    /// Adds the light of a sample that comes in at `surface`, a point of the object's boundary `covered` metres along the
    /// straight line to it: `throughput` × radiance / pdf, where nothing beyond is in the way. It was scattered once.
    fn deliver(
        &mut self,
        surface: &Surface,
        light: &LightSample,
        covered: f32,
        throughput: Vec3,
        sampler: &mut Sampler,
    );
    /// [`Connection::Boundary`]: prepares to aim from `point` through a boundary near by, of outward normal `normal`, at
    /// light. False: there is nothing to aim at.
    fn aim(&self, point: Vec3, normal: Vec3, aim: &mut Aim) -> bool;
    /// [`Connection::Boundary`]: draws an aimed direction of travel from `point`, and its density.
    fn draw(&self, point: Vec3, aim: &mut Aim, sampler: &mut Sampler) -> Option<(Vec3, f32)>;
    /// [`Connection::Boundary`]: a drawn direction of travel `incoming` has met the boundary from inside. `throughput`
    /// is that of the path, times phase function and transmittance, over the density of the direction; `aimed` is as in
    /// [`PathHead::aimed`]. Adds the light found directly beyond the boundary, which comes to the event of the flight that
    /// `aim` was last told of ([`Aim::set_events`]).
    fn emerge(
        &mut self,
        hit: &Hit,
        incoming: Vec3,
        throughput: Vec3,
        aim: &Aim,
        aimed: Aimed,
        sampler: &mut Sampler,
    );
}

/// A model made ready for one scene.
pub trait Propagator: Send + Sync {
    /// Follows the path from `head` to where it arrives next; `connector` is to be used as the flight's
    /// [`Connection`] says.
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival;
}

/// A subsurface model.
pub trait SubsurfaceModel: Send + Sync {
    /// Name on the command line.
    fn name(&self) -> &str;
    /// One line for `--help`.
    fn summary(&self) -> &str;
    /// R(r) of one channel of a medium where the model has it in closed form: see
    /// [`diffusion`](crate::optics::diffusion). It is what the model renders under light from everywhere;
    /// [`searchlight`](crate::transport::searchlight) measures that for any model.
    fn closed_form(&self, _: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        None
    }
    /// Tables for the media of a scene. They are kept for other scenes with the same bodies
    /// ([`Scene::has_same_bodies`]), so they must not depend on where these are.
    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator>;
}

/// The models a program offers.
pub struct Registry {
    models: Vec<Arc<dyn SubsurfaceModel>>,
}

impl Registry {
    /// All models of this crate.
    pub fn standard() -> Self {
        Self {
            models: vec![
                Arc::new(RandomWalk),
                Arc::new(AcceleratedWalk),
                Arc::new(Dipole { single: true }),
                Arc::new(Dipole { single: false }),
                Arc::new(SingleScattering),
                Arc::new(BetterDipole),
                Arc::new(DirectionalDipole),
                Arc::new(PhotonBeamDiffusion),
                Arc::new(NormalizedDiffusion { fit: ScaleFit::DiffuseMfp }),
                Arc::new(NormalizedDiffusion { fit: ScaleFit::SearchlightMfp }),
                Arc::new(NormalizedDiffusion { fit: ScaleFit::SearchlightDmfp }),
                Arc::new(BrdfApproximation { cosines: Cosines::Refracted }),
                Arc::new(LightBiased { cosines: Cosines::Refracted }),
            ],
        }
    }

    /// Adds a model; one of the same name is replaced.
    pub fn register(&mut self, model: Box<dyn SubsurfaceModel>) {
        self.models.retain(|m| m.name() != model.name());
        self.models.push(model.into());
    }

    /// The model of that name.
    pub fn get(&self, name: &str) -> Option<Arc<dyn SubsurfaceModel>> {
        self.models.iter().find(|m| m.name() == name).cloned()
    }

    /// All models, in the order of registration.
    pub fn iter(&self) -> impl Iterator<Item = &dyn SubsurfaceModel> {
        self.models.iter().map(AsRef::as_ref)
    }
}

impl Default for Registry {
    fn default() -> Self {
        Self::standard()
    }
}
