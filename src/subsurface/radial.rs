//! What the radial models share: S(x_i, ω_i; x_o, ω_o) = F_t(ω_o) R(|x_i − x_o|) F_t(ω_i) / (π C).
//!
//! The boundary has already chosen transmission (F_t(ω_o)) when a flight begins at x_o. The search finds x_i with
//! density p_A, so the throughput gains R/p_A, and the path goes on through a lobe in proportion to F_t(ω_i) cos θ_i. C
//! is 1 where a model says so (Jensen et al. 2001), so that only ∫ F_t cos θ dω/π = 1 − F̄ is kept, or 1 − F̄ where the
//! profile already is what leaves the surface. η² brings radiance out of the medium again, the base colour tints the
//! crossing.

use super::exit_search::ExitSearch;
use super::from_boundary::{FromBoundary, or_walk};
use super::tables::Tables;
use super::{Arrival, Connector, Exit, Flight, PathHead, Propagator};
use crate::geometry::Hit;
use crate::optics::diffusion::{self, Coefficients, RadialProfile};
use crate::optics::{DiffuseExit, fresnel};
use crate::sampling::Sampler;
use crate::scene::{Scene, Surface};

/// Least probability of connecting single scattering.
const LEAST_OFTEN: f32 = 0.25;

/// A radial model: its profile, and how light leaves through it. Whoever has one has a model: its
/// [`SubsurfaceModel::prepare`](super::SubsurfaceModel::prepare) is [`Radial::prepare`].
pub trait Formula: Clone + Send + Sync + 'static {
    /// The profile of one channel; it is tabulated once per medium and surrounding.
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile>;
    /// Whether C is 1 − F̄: the profile is all that leaves the surface.
    fn normalized(&self) -> bool {
        true
    }
    /// Whether single scattering is added along the refracted ray.
    fn adds_single_scattering(&self) -> bool {
        false
    }
}

/// A profile of which a share is lost at the boundary.
struct Scaled {
    profile: Box<dyn RadialProfile>,
    kept: f64,
}

impl RadialProfile for Scaled {
    fn eval(&self, r: f64) -> f64 {
        self.kept * self.profile.eval(r)
    }

    fn total(&self) -> f64 {
        self.kept * self.profile.total()
    }
}

/// A radial model, ready for one scene.
pub struct Radial<F> {
    formula: F,
    tables: Tables,
}

impl<F: Formula> Radial<F> {
    /// What a formula renders, for [`super::SubsurfaceModel::closed_form`]; `None` where single scattering is added,
    /// which has no closed form as it is connected.
    pub fn closed_form(formula: &F, c: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        if formula.adds_single_scattering() {
            return None;
        }
        let profile = formula.profile(c);
        let lost = diffusion::fresnel::diffuse_reflectance(1.0 / c.eta);
        let kept = if formula.normalized() { 1.0 } else { 1.0 - lost };
        Some(Box::new(Scaled { profile, kept }))
    }

    /// Prepares a model for a scene.
    pub fn prepare(formula: F, scene: &Scene) -> Box<dyn Propagator> {
        let profile = formula.clone();
        let tables = Tables::new(scene, Box::new(move |c| profile.profile(c)));
        or_walk(Self { formula, tables }, scene)
    }
}

impl<F: Formula> FromBoundary for Radial<F> {
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        hit: &Hit,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        let tables = self.tables.of(flight);
        if self.formula.adds_single_scattering() {
            // Beside much diffuse light there is little that is scattered once.
            let often = (1.0 - tables.total().max_element()).max(LEAST_OFTEN);
            if sampler.rng().f32() < often {
                let rare = PathHead { throughput: head.throughput / often, ..*head };
                super::single_scattering::connect(flight, &rare, sampler, connector);
            }
        }
        head.events += 1;
        let from = flight.scene.geometry.surface(hit);
        let beta = head.throughput;
        let Some(radii) = tables.radii(beta) else { return Arrival::Ended };
        let search =
            ExitSearch::new(flight.scene, hit.instance, from.position, from.geometric_normal, &radii);
        let found = search.find(beta, sampler, |c| self.tables.reflectance(flight, &tables, c));
        let Some(found) = found else { return Arrival::Ended };
        let eta = flight.eta;
        let surface = Surface::new(flight.scene, &found.candidate.hit);
        let lobe = if self.formula.normalized() { 1.0 } else { 1.0 - fresnel::diffuse_reflectance(eta) };
        if !flight.is_interface(&surface) {
            return Arrival::Ended;
        }
        let tint = flight.scene.straight_transmission(&surface);
        head.throughput *= found.reflectance * tint * (found.inverse_pdf * eta * eta * lobe);
        Arrival::Exit(Box::new(Exit { surface, lobe: Box::new(DiffuseExit::new(eta)) }))
    }
}
