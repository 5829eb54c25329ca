//! `directional-dipole`: Frisvad, Hachisuka & Kjeldsen 2014, "Directional dipole model for subsurface scattering":
//! S = F_t(ω_o) (S_d + S_δ) F_t(ω_i).
//!
//! S_d ([`diffusion::DirectionalDipole`]) depends on both points, both normals and the direction of the refracted light, so
//! there is no radial profile to sample and no fixed lobe of incidence. Radii come from its profile under normal
//! incidence, one crossing of the line is kept by S_d of light along its normal, and the path goes on through the lobe
//! F_t(ω_i) S_d(x_i, ω_i; x_o) cos θ_i. Single scattering is in S_d.
//!
//! S_δ is the light that crosses the object without being scattered, e^{−σt s}: with the probability of a weight of its own
//! the path goes straight on to the boundary instead.

use super::exit_search::{Candidate, ExitSearch};
use super::tables::{PerMedium, Tables, coefficients_at};
use super::{
    Arrival, Connector, Exit, Flight, PathHead, Propagator, RandomWalk, SubsurfaceModel, TexturedMedium,
};
use crate::geometry::{Hit, Ray};
use crate::optics::diffusion::{self, Moments, directional};
use crate::optics::{ExitLobe, fresnel};
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::{Scene, Surface};
use glam::{DVec3, Mat3, Vec3};
use std::f32::consts::PI;

/// Mean free paths of the clearest channel after which light that is not scattered no longer counts: e^{−20} = 2·10⁻⁹.
const OPAQUE: f32 = 20.0;
/// Share of the radial profile in what a crossing is kept by: S_d is zero for some directions and not for others.
const DEFENSIVE: f32 = 0.2;

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
        Box::new(Directional {
            tables: Tables::new(scene, Box::new(profile)),
            moments: PerMedium::new(scene),
            fallback: RandomWalk.prepare(scene),
        })
    }
}

struct Directional {
    tables: Tables,
    /// Of η and of 1/η.
    moments: PerMedium<[Moments; 2]>,
    fallback: Box<dyn Propagator>,
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

impl Propagator for Directional {
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        let Some(hit) = flight.entry(head) else {
            return self.fallback.propagate(flight, head, sampler, connector);
        };
        let tables = self.tables.of(flight);
        let scattered = (head.throughput * tables.total()).element_sum();
        if let Some((hit, transmittance)) = unscattered(flight, head, sampler) {
            let straight = (head.throughput * transmittance).element_sum();
            let probability = straight / (straight + scattered);
            if sampler.rng().f32() < probability {
                head.position += head.direction * hit.t;
                head.throughput *= transmittance / probability;
                return Arrival::Surface(hit);
            }
            head.throughput /= 1.0 - probability;
        }
        head.events += 1;
        self.search(flight, head, &hit, sampler).map_or(Arrival::Ended, |exit| Arrival::Exit(Box::new(exit)))
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
        let eta = f64::from(flight.eta);
        let [inside, outside] =
            *self.moments.get(flight, || [Moments::exact(eta), Moments::exact(1.0 / eta)]);
        let towards = |position: Vec3| Towards {
            channels: coefficients_at(flight, position)
                .map(|c| diffusion::DirectionalDipole::with_moments(&c, inside, outside)),
            exit: directional::Exit { x: (from.position - position).as_dvec3(), n: from.normal.as_dvec3() },
        };
        let exitance = 4.0 * PI * outside.c_phi() as f32;
        let along_normal = |c: &Candidate| {
            let n = c.normal.as_dvec3();
            let radial = self.tables.reflectance(flight, tables, c);
            exitance * towards(c.position).s_d(n, n) + DEFENSIVE * radial
        };
        let found = search.find(head.throughput, sampler, along_normal)?;
        let surface = Surface::new(scene, &found.candidate.hit);
        let (x, y) = orthonormal_basis(surface.normal);
        let tint = scene.base_color(&surface).truncate();
        // The weight under normal incidence; what the lobe says of a direction is relative to it.
        let weight = found.reflectance * found.inverse_pdf;
        head.throughput *= weight * tint;
        let eta = flight.eta;
        let lobe = Lobe {
            towards: towards(found.candidate.position),
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

/// Where the path leaves the object if it is not scattered, and the share of it that is not.
fn unscattered(flight: &Flight<'_>, head: &PathHead, sampler: &mut Sampler) -> Option<(Hit, Vec3)> {
    let geometry = &flight.scene.geometry;
    let sigma_t = flight.medium.sigma_t;
    let clearest = if flight.is_textured() { 0.0 } else { sigma_t.min_element() };
    let ray = Ray { origin: head.position, direction: head.direction, t_max: OPAQUE / clearest };
    let hit = if flight.object.isolated {
        geometry.intersect_instance(flight.enclosure.instance, &ray)
    } else {
        geometry.intersect(&ray)
    }?;
    let transmittance = if flight.is_textured() {
        let mut medium = TexturedMedium::new(flight.scene, flight.enclosure);
        medium.transmittance(ray.origin, ray.direction, hit.t, sampler.rng())
    } else {
        (-sigma_t * hit.t).exp()
    };
    (transmittance.max_element() > 0.0).then_some((hit, transmittance))
}
