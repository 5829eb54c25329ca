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

use super::exit_search::ExitSearch;
use super::from_boundary::{FromBoundary, or_walk};
use super::spectral::{Coefficients, draw_flight};
use super::tables::{PerMedium, Tables, coefficients_at};
use super::{Arrival, Connector, Exit, Flight, PathHead, Propagator, SubsurfaceModel, TexturedMedium};
use crate::geometry::{Hit, Ray};
use crate::optics::diffusion::{self, Moments, directional};
use crate::optics::{ExitLobe, fresnel};
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::{Scene, Surface};
use glam::{DVec3, Mat3, Vec3};

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
            let straight = (head.throughput * share).element_sum();
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
        let found = search.find(head.throughput, sampler, |c| self.tables.reflectance(flight, &tables, c))?;
        let surface = Surface::new(scene, &found.candidate.hit);
        let (x, y) = orthonormal_basis(surface.normal);
        if !flight.is_interface(&surface) {
            return None;
        }
        let tint = scene.straight_transmission(&surface);
        // The weight of the profile; what the lobe says is relative to it.
        head.throughput *= found.reflectance * tint * found.inverse_pdf;
        let position = found.candidate.position;
        let towards = Towards {
            channels: self.formulas.get(flight, || Formulas::new(flight)).at(flight, position),
            exit: directional::Exit { x: (from.position - position).as_dvec3(), n: from.normal.as_dvec3() },
        };
        let eta = flight.eta;
        let lobe = Lobe {
            towards,
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

/// Where the path leaves the object if it is not scattered, and the share of it that is not, over the probability of
/// having looked: a free flight is drawn, and what it does not reach is not looked for.
fn unscattered(flight: &Flight<'_>, head: &PathHead, sampler: &mut Sampler) -> Option<(Hit, Vec3)> {
    let geometry = &flight.scene.geometry;
    let textured = flight.is_textured();
    let medium = flight.medium;
    let c = Coefficients::of_one_event(medium.sigma_a, medium.sigma_s, medium.g);
    let beta = head.throughput.into();
    let t_max = if textured {
        f32::INFINITY
    } else {
        draw_flight(sampler.rng()) * c.draw_mean_free_path(beta, sampler.rng())
    };
    let ray = Ray { origin: head.position, direction: head.direction, t_max };
    let hit = if flight.object.isolated {
        geometry.intersect_instance(flight.enclosure.instance, &ray)
    } else {
        geometry.intersect(&ray)
    }?;
    let share = if textured {
        let mut medium = TexturedMedium::new(flight.scene, flight.enclosure);
        medium.transmittance(ray.origin, ray.direction, hit.t, sampler.rng())
    } else {
        let carried = head.throughput.cmpgt(Vec3::ZERO);
        Vec3::select(carried, Vec3::from(c.weigh(beta, 0, hit.t)) / head.throughput, Vec3::ZERO)
    };
    (share.is_finite() && share.max_element() > 0.0).then_some((hit, share))
}
