//! `better-dipole`: d'Eon 2012, "A better dipole": Grosjean's diffusion coefficient, exact Fresnel moments, exitance from
//! flux and fluence. The profile is what leaves the surface, so the exit lobe is normalised. Single scattering is not in
//! it and not added (docs/models.md, §6).

use super::radial::{Formula, Radial};
use super::{Propagator, SubsurfaceModel};
use crate::optics::diffusion::{self, Coefficients, RadialProfile};
use crate::scene::Scene;

/// The better dipole.
#[derive(Clone, Copy, Debug)]
pub struct BetterDipole;

impl SubsurfaceModel for BetterDipole {
    fn name(&self) -> &str {
        "better-dipole"
    }

    fn summary(&self) -> &str {
        "dipole of Grosjean's diffusion with exact Fresnel moments (d'Eon 2012)"
    }

    fn closed_form(&self, c: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        Radial::closed_form(self, c)
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        Radial::prepare(*self, scene)
    }
}

impl Formula for BetterDipole {
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile> {
        Box::new(diffusion::BetterDipole::new(c))
    }
}
