//! Photon beam diffusion for normal incidence (Habel, Christensen, Jarosz, "Photon Beam Diffusion", EGSR 2013).
//!
//! Instead of one source at one mean free path, the refracted beam is a line of sources at depths z = u/σt′ of power
//! density σs′ e^{−u}, each a dipole of Grosjean's diffusion:
//!
//! ms(r) = ∫₀^∞ e^{−u} κ α′² (C_φ φ(z, r) + C_E E(z, r)) du, κ = 1 − e^{−2σt′(d_r + z)},
//! φ = (e^{−σtr d_r}/d_r − e^{−σtr d_v}/d_v)/(4πD),
//! E = (z_r(1 + σtr d_r)e^{−σtr d_r}/d_r³ − z_v(1 + σtr d_v)e^{−σtr d_v}/d_v³)/(4π), z_v = −z − 4AD.
//!
//! κ is the empirical correction near the beam, where diffusion overestimates. One power of α′ is the share of the
//! extinction that scatters, the other leaves out single scattering, which is [`PhotonBeam::single`].
//!
//! As functions of ln u the integrands are analytic in a strip of half-width π/2 at every r, so the trapezoid rule in
//! ln u converges geometrically however small r is. ms diverges logarithmically at r = 0.

use super::{Coefficients, Dipole, Moments, RadialProfile, SingleScattering, quadrature};
use std::f64::consts::PI;

/// Photon beam diffusion of one channel, ready to evaluate. As a [`RadialProfile`] it is multiple scattering alone; the
/// pair `(PhotonBeam, SingleScattering)` is the whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonBeam {
    coefficients: Coefficients,
    moments: Moments,
    d: f64,
    sigma_tr: f64,
    corrected: bool,
}

/// Step in ln u: an error of 3e-7 up to eight mean free paths from the beam.
const STEP: f64 = 0.45;
/// e^{−u} is below 1e-13 beyond.
const LAST: f64 = 3.4;
/// The part of the beam nearer the surface than this exponential times min(r, 1/σt′) contributes less than 1e-7.
const NEAREST: f64 = -17.0;

impl PhotonBeam {
    /// With exact Fresnel moments.
    pub fn new(c: &Coefficients) -> Self {
        Self::with_moments(c, Moments::exact(c.eta))
    }

    /// With moments of the caller's, such as [`Moments::fit_rounded`].
    pub fn with_moments(c: &Coefficients, moments: Moments) -> Self {
        Self {
            coefficients: *c,
            moments,
            d: c.grosjean_coefficient(),
            sigma_tr: c.grosjean_transport(),
            corrected: true,
        }
    }

    /// Without the empirical correction κ: the plain integral of dipoles, too bright within a mean free path.
    pub fn uncorrected(self) -> Self {
        Self { corrected: false, ..self }
    }

    /// The integrand without e^{−u}: exitance, 1/m², at distance `r` from the beam for the part of the beam at depth
    /// `z` = u/σt′ (both m, not both 0) as if it held all power.
    pub fn source(&self, z: f64, r: f64) -> f64 {
        let z_v = -z - 4.0 * self.moments.a() * self.d;
        let Dipole { d_r, fluence, real, image } = Dipole::new(self.sigma_tr, z, z_v, r);
        let exitance = self.moments.c_phi() / self.d * fluence + self.moments.c_e() * (real - image);
        let kappa = if self.corrected {
            -(-2.0 * self.coefficients.reduced_extinction() * (d_r + z)).exp_m1()
        } else {
            1.0
        };
        let albedo = self.coefficients.reduced_albedo();
        kappa * albedo * albedo / (4.0 * PI) * exitance
    }

    /// Single scattering, 1/m², at distance `r` > 0 in m: exact for a smooth surface.
    pub fn single(&self, r: f64) -> f64 {
        SingleScattering::new(&self.coefficients).eval(r)
    }
}

impl RadialProfile for PhotonBeam {
    fn eval(&self, r: f64) -> f64 {
        if !self.coefficients.scatters() {
            return 0.0;
        }
        let t = self.coefficients.reduced_extinction();
        let from = (t * r).clamp(f64::MIN_POSITIVE, 1.0).ln() + NEAREST;
        quadrature::logarithmic(from, LAST, STEP, |u| (-u).exp() * self.source(u / t, r))
    }

    /// Quadrature over the plane, within 1e-6.
    fn total(&self) -> f64 {
        super::profile::integrate(self, self.coefficients.transport_mean_free_path())
    }
}
