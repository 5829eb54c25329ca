//! `dipole` and `dipole-diffuse`: Jensen, Marschner, Levoy & Hanrahan 2001, "A practical model for subsurface light
//! transport": S = S_d + S^(1), with S_d = F_t(η, ω_i) R_d(|x_i − x_o|) F_t(η, ω_o) / π (eq. 5) and the single scattering
//! of [`super::single_scattering`].
//!
//! S_d transmits diffuse light a second time that R_d already counts as transmitted, so it loses F̄ of it: that is
//! how the model is printed, and how it is here.

use super::radial::{Formula, Radial};
use super::{Propagator, SubsurfaceModel};
use crate::optics::diffusion::{ClassicalDipole, Coefficients, RadialProfile};
use crate::scene::Scene;

/// The classical dipole.
#[derive(Clone, Copy, Debug)]
pub struct Dipole {
    /// Whether single scattering is added.
    pub single: bool,
}

impl SubsurfaceModel for Dipole {
    fn name(&self) -> &str {
        if self.single { "dipole" } else { "dipole-diffuse" }
    }

    fn summary(&self) -> &str {
        if self.single {
            "classical dipole and single scattering (Jensen et al. 2001)"
        } else {
            "classical dipole alone, without single scattering"
        }
    }

    fn closed_form(&self, c: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        Radial::closed_form(self, c)
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        Radial::prepare(*self, scene)
    }
}

impl Formula for Dipole {
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile> {
        Box::new(ClassicalDipole::new(c))
    }

    fn normalized(&self) -> bool {
        false
    }

    fn adds_single_scattering(&self) -> bool {
        self.single
    }
}
