//! `photon-beam-diffusion`: Habel, Christensen & Jarosz 2013: dipoles strung along the refracted beam, and its single
//! scattering, both as a radial profile for normal incidence.

use super::radial::{Formula, Radial};
use super::{Propagator, SubsurfaceModel};
use crate::optics::diffusion::{Coefficients, PhotonBeam, RadialProfile, SingleScattering};
use crate::scene::Scene;

/// Photon beam diffusion.
#[derive(Clone, Copy, Debug)]
pub struct PhotonBeamDiffusion;

impl SubsurfaceModel for PhotonBeamDiffusion {
    fn name(&self) -> &str {
        "photon-beam-diffusion"
    }

    fn summary(&self) -> &str {
        "dipoles along the refracted beam, with single scattering (Habel et al. 2013)"
    }

    fn closed_form(&self, c: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        Radial::closed_form(self, c)
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        Radial::prepare(*self, scene)
    }
}

impl Formula for PhotonBeamDiffusion {
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile> {
        Box::new((PhotonBeam::new(c), SingleScattering::new(c)))
    }
}
