//! `directional-dipole`: Frisvad, Hachisuka & Kjeldsen 2014, "Directional dipole model for subsurface scattering":
//! S = F_t(ω_o) (S_d + S_δ) F_t(ω_i).
//!
//! S_d ([`diffusion::DirectionalDipole`]) depends on both points, both normals and the direction of the refracted light, so
//! there is no radial profile to sample and no fixed lobe of incidence. Points are searched for as if it had its profile on
//! a plane under normal incidence, and the path goes on through the lobe F_t(ω_i) S_d(x_i, ω_i; x_o) cos θ_i. Single
//! scattering is in S_d.
//!
//! S_δ is the light that crosses the object without being scattered, e^{−σt s}: with the probability of a weight of its own
//! the path goes straight on to the boundary instead.

use super::exit_search::{Candidate, ExitSearch};
use super::from_boundary::{FromBoundary, or_walk};
use super::tables::{PerMedium, Tables, coefficients_at};
use super::{Arrival, Connector, Exit, Flight, PathHead, Propagator, SubsurfaceModel, TexturedMedium};
use crate::geometry::{Hit, Ray};
use crate::optics::diffusion::{self, Moments, directional};
use crate::optics::{ExitLobe, fresnel};
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::{Scene, Surface};
use glam::{DVec3, Mat3, Vec3};
use std::f32::consts::PI;

/// How much more light that goes straight through is looked at than there is of it: it may come from a light itself.
const PREFER_STRAIGHT: f32 = 4.0;
/// Less than this share of light goes straight through unnoticed.
const LEAST_STRAIGHT: f32 = 1e-12;
/// Least cosine to the normal of light that decides what crossing is kept.
const LOWEST_LIGHT: f32 = 0.1;

/// The directional dipole.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalDipole;

impl SubsurfaceModel for DirectionalDipole {
    fn name(&self) -> &str {
        "directional-dipole"
    }

    fn summary(&self) -> &str {
        "dipole of ray sources between any two points (Frisvad et al. 2014)"
    }

    /// For light along the normal, which is not quite what is rendered: the model does not look the same both ways, and
    /// paths enter where light leaves.
    fn closed_form(&self, c: &diffusion::Coefficients) -> Option<Box<dyn diffusion::RadialProfile>> {
        Some(Box::new(diffusion::DirectionalDipole::new(c)))
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        let profile = |c: &diffusion::Coefficients| -> Box<dyn diffusion::RadialProfile> {
            Box::new(diffusion::DirectionalDipole::new(c))
        };
        let formulas = PerMedium::new(scene);
        or_walk(Directional { tables: Tables::new(scene, Box::new(profile)), formulas }, scene)
    }
}

struct Directional {
    tables: Tables,
    formulas: PerMedium<Formulas>,
}

/// What does not depend on positions.
struct Formulas {
    /// Of η and of 1/η.
    moments: [Moments; 2],
    untextured: [diffusion::DirectionalDipole; 3],
}

impl Formulas {
    fn new(flight: &Flight<'_>) -> Self {
        let eta = f64::from(flight.eta);
        let moments = [Moments::exact(eta), Moments::exact(1.0 / eta)];
        Self { moments, untextured: of_channels(&flight.coefficients(), moments) }
    }

    /// The formulas for light that comes in at a position.
    fn at(&self, flight: &Flight<'_>, position: Vec3) -> [diffusion::DirectionalDipole; 3] {
        if flight.is_textured() {
            of_channels(&coefficients_at(flight, position), self.moments)
        } else {
            self.untextured
        }
    }
}

fn of_channels(
    c: &[diffusion::Coefficients; 3],
    [inside, outside]: [Moments; 2],
) -> [diffusion::DirectionalDipole; 3] {
    [0, 1, 2].map(|i| diffusion::DirectionalDipole::with_moments(&c[i], inside, outside))
}

/// S_d towards one x_o.
#[derive(Clone, Debug)]
struct Towards {
    channels: [diffusion::DirectionalDipole; 3],
    /// x_o, relative to x_i.
    exit: directional::Exit,
}

impl Towards {
    fn s_d(&self, normal: DVec3, wi: DVec3) -> Vec3 {
        let entry = directional::Entry { x: DVec3::ZERO, n: normal, w: wi };
        Vec3::from_array([0, 1, 2].map(|i| self.channels[i].s_d(&entry, &self.exit) as f32))
    }
}

/// F_t(ω_i) S_d cos θ_i, over what the crossing was kept by.
#[derive(Debug)]
struct Lobe {
    towards: Towards,
    frame: Mat3,
    eta: f32,
    scale: Vec3,
}

impl ExitLobe for Lobe {
    fn eval(&self, wi: Vec3) -> Vec3 {
        let entering = 1.0 - fresnel::dielectric(wi.z, self.eta);
        let direction = (self.frame * wi).as_dvec3().normalize();
        self.scale * self.towards.s_d(self.frame.z_axis.as_dvec3(), direction) * (entering * wi.z)
    }
}

impl FromBoundary for Directional {
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        hit: &Hit,
        sampler: &mut Sampler,
        _: &mut dyn Connector,
    ) -> Arrival {
        let tables = self.tables.of(flight);
        let scattered = (head.throughput * tables.total()).element_sum();
        if let Some((hit, share)) = unscattered(flight, head, sampler) {
            let straight = PREFER_STRAIGHT * (head.throughput * share).element_sum();
            let probability = straight / (straight + scattered);
            if sampler.rng().f32() < probability {
                head.position += head.direction * hit.t;
                head.throughput *= share / probability;
                return Arrival::Surface(hit);
            }
            head.throughput /= 1.0 - probability;
        }
        head.events += 1;
        self.search(flight, head, hit, sampler).map_or(Arrival::Ended, |exit| Arrival::Exit(Box::new(exit)))
    }
}

impl Directional {
    fn towards(&self, flight: &Flight<'_>, from: &Surface, entry: Vec3) -> Towards {
        Towards {
            channels: self.formulas.get(flight, || Formulas::new(flight)).at(flight, entry),
            exit: directional::Exit { x: (from.position - entry).as_dvec3(), n: from.normal.as_dvec3() },
        }
    }

    /// Keeps a crossing by the profile, which knows no directions, and by S_d for light from a likely one.
    fn search(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        hit: &Hit,
        sampler: &mut Sampler,
    ) -> Option<Exit> {
        let scene = flight.scene;
        let tables = self.tables.of(flight);
        let from = Surface::new(scene, hit);
        let radii = tables.radii(head.throughput)?;
        let search = ExitSearch::new(scene, hit.instance, from.position, from.geometric_normal, &radii);
        let found = search.find(head.throughput, sampler, |c| {
            let radial = self.tables.reflectance(flight, &tables, c);
            let towards = self.towards(flight, &from, c.position);
            let lit = PI * towards.s_d(c.normal.as_dvec3(), likely_light(scene, c).as_dvec3());
            0.5 * (radial + lit.max(Vec3::ZERO))
        })?;
        let surface = Surface::new(scene, &found.candidate.hit);
        let (x, y) = orthonormal_basis(surface.normal);
        if !flight.is_interface(&surface) {
            return None;
        }
        let tint = scene.straight_transmission(&surface);
        // The weight of the profile; what the lobe says is relative to it.
        head.throughput *= found.reflectance * tint * found.inverse_pdf;
        let eta = flight.eta;
        let lobe = Lobe {
            towards: self.towards(flight, &from, found.candidate.position),
            frame: Mat3::from_cols(x, y, surface.normal),
            eta,
            scale: Vec3::select(
                found.reflectance.cmpgt(Vec3::ZERO),
                eta * eta / found.reflectance,
                Vec3::ZERO,
            ),
        };
        Some(Exit { surface, lobe: Box::new(lobe) })
    }
}

/// The direction that light is likely to come from: that of the strongest light, or the normal.
fn likely_light(scene: &Scene, candidate: &Candidate) -> Vec3 {
    let seen = scene.beacons.iter().map(|b| b.seen_from(candidate.position));
    let above = seen.filter(|s| s.direction.dot(candidate.normal) > LOWEST_LIGHT);
    let brightest = above.max_by(|a, b| a.irradiance.total_cmp(&b.irradiance));
    brightest.map_or(candidate.normal, |s| s.direction)
}

/// Where the path leaves the object if it is not scattered, and the share of it that is not.
fn unscattered(flight: &Flight<'_>, head: &PathHead, sampler: &mut Sampler) -> Option<(Hit, Vec3)> {
    let geometry = &flight.scene.geometry;
    let ray = Ray { origin: head.position, direction: head.direction, t_max: f32::INFINITY };
    let hit = if flight.object.isolated {
        geometry.intersect_instance(flight.enclosure.instance, &ray)
    } else {
        geometry.intersect(&ray)
    }?;
    let share = if flight.is_textured() {
        let mut medium = TexturedMedium::new(flight.scene, flight.enclosure);
        medium.transmittance(ray.origin, ray.direction, hit.t, sampler.rng())
    } else {
        (-flight.medium.sigma_t * hit.t).exp()
    };
    (share.is_finite() && share.max_element() > LEAST_STRAIGHT).then_some((hit, share))
}
