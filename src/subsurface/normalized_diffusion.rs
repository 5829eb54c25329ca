//! `normalized-diffusion`: Christensen & Burley 2015, "Approximate reflectance profiles for efficient subsurface
//! scattering": R(r) = A (e^{−r/d} + e^{−r/3d}) / (8π d r) with d from one of three fits. A is the albedo that the surface
//! shows under its boundary per transmitted light: that of the better dipole, so that the models can be compared. It leaves
//! out single scattering, so all three are too dark at low albedo (docs/models.md, §9).

use super::radial::{Formula, Radial};
use super::{Propagator, SubsurfaceModel};
use crate::optics::diffusion::{
    BetterDipole, Coefficients, NormalizedDiffusion as Profile, RadialProfile, ScaleFit,
};
use crate::scene::Scene;

/// Normalized diffusion with one of its fits.
#[derive(Clone, Copy, Debug)]
pub struct NormalizedDiffusion {
    /// How the scale depends on the albedo.
    pub fit: ScaleFit,
}

impl SubsurfaceModel for NormalizedDiffusion {
    fn name(&self) -> &str {
        match self.fit {
            ScaleFit::DiffuseMfp => "normalized-diffusion",
            ScaleFit::SearchlightMfp => "normalized-diffusion-searchlight",
            ScaleFit::SearchlightDmfp => "normalized-diffusion-dmfp",
        }
    }

    fn summary(&self) -> &str {
        match self.fit {
            ScaleFit::DiffuseMfp => {
                "two exponentials, fit for diffuse transmission (Christensen & Burley 2015)"
            }
            ScaleFit::SearchlightMfp => "the same, fit for perpendicular light by mean free path",
            ScaleFit::SearchlightDmfp => "the same, fit for perpendicular light by diffuse mean free path",
        }
    }

    fn closed_form(&self, c: &Coefficients) -> Option<Box<dyn RadialProfile>> {
        Radial::closed_form(self, c)
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        Radial::prepare(*self, scene)
    }
}

impl Formula for NormalizedDiffusion {
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile> {
        let albedo = BetterDipole::new(c).total().clamp(0.0, 1.0);
        let length = match self.fit {
            ScaleFit::SearchlightDmfp => c.diffuse_mean_free_path(),
            _ => c.transport_mean_free_path(),
        };
        Box::new(Profile::new(albedo, length, self.fit))
    }
}
