//! `normalized-diffusion`: Christensen & Burley 2015, "Approximate reflectance profiles for efficient subsurface
//! scattering": R(r) = A (e^{−r/d} + e^{−r/3d}) / (8π d r) with d from one of three fits. A is the albedo that the surface
//! shows per transmitted light, single scattering and the reflections inside of the boundary included
//! ([`half_space::albedo`]).
//!
//! Without absorption the diffuse mean free path is infinite, and the fit by it spreads light beyond any object: where it is
//! longer than a thousand mean free paths (a reduced albedo above 1 − 3·10⁻⁷) the fit by mean free path takes its place.
//! In objects smaller than the diffuse mean free path that fit still loses light.

use super::radial::{Formula, Radial};
use super::{Propagator, SubsurfaceModel};
use crate::optics::diffusion::{
    Coefficients, NormalizedDiffusion as Profile, RadialProfile, ScaleFit, half_space,
};
use crate::scene::Scene;

/// Diffuse mean free paths longer than so many mean free paths are not followed.
const FARTHEST: f64 = 1000.0;

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
        let albedo = half_space::albedo(c.reduced_albedo(), c.eta);
        let diffuse = c.diffuse_mean_free_path();
        match self.fit {
            ScaleFit::SearchlightDmfp if diffuse < FARTHEST * c.transport_mean_free_path() => {
                Box::new(Profile::new(albedo, diffuse, ScaleFit::SearchlightDmfp))
            }
            ScaleFit::SearchlightDmfp => {
                Box::new(Profile::new(albedo, c.transport_mean_free_path(), ScaleFit::SearchlightMfp))
            }
            fit => Box::new(Profile::new(albedo, c.transport_mean_free_path(), fit)),
        }
    }
}
