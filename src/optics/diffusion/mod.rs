//! Closed forms of the analytic subsurface models, in double precision and one colour channel at a time.
//!
//! | file | model | source |
//! | --- | --- | --- |
//! | [`classical`] | dipole of isotropic sources | Jensen, Marschner, Levoy, Hanrahan 2001 |
//! | [`better`] | dipole of Grosjean's diffusion, exitance by flux and fluence | d'Eon 2012 |
//! | [`photon_beam`] | dipoles strung along the refracted beam | Habel, Christensen, Jarosz 2013 |
//! | [`directional`] | dipole of ray sources, between any two surface points | Frisvad, Hachisuka, Kjeldsen 2014 |
//! | [`normalized`] | two exponentials of known integral | Christensen & Burley 2015 |
//! | [`brdf`] | the limit of uniform light | Jensen et al. 2001, Hanrahan & Krueger 1993 |
//! | [`single`] | one scattering event: along the view ray, and the exact radial profile | Jensen et al. 2001 |
//!
//! [`discrete_ordinates`] has the colour of a half space behind a boundary for any anisotropy, [`sphere`] how much
//! light leaves a sphere from its middle.
//!
//! [`fresnel`], [`moments`] and [`phase`] are what they share, [`chandrasekhar`] and [`inversion`] relate
//! single-scattering and surface albedo, [`profile`] turns any of the radial models into a table to sample from.
//!
//! A radial profile R(r), 1/m², is the radiant exitance above a half space at distance r from a normally incident
//! pencil beam of which unit power has crossed the surface: the entry's Fresnel transmittance is left out, the exit's
//! is included. The unit of length is the inverse of that of the coefficients; metres everywhere in this crate.

pub mod better;
pub mod brdf;
pub mod chandrasekhar;
pub mod classical;
pub mod directional;
pub mod discrete_ordinates;
pub mod fresnel;
pub mod half_space;
pub mod inversion;
mod linear_algebra;
pub mod moments;
pub mod normalized;
pub mod phase;
pub mod photon_beam;
pub mod profile;
#[cfg(test)]
mod profile_tests;
mod quadrature;
pub mod single;
pub mod sphere;

pub use better::BetterDipole;
pub use brdf::{BrdfApproximation, Cosines, SingleTerm};
pub use classical::ClassicalDipole;
pub use directional::DirectionalDipole;
pub use moments::Moments;
pub use normalized::{NormalizedDiffusion, ScaleFit};
pub use photon_beam::PhotonBeam;
pub use profile::{RadialProfile, TabulatedProfile};
pub use single::SingleScattering;

use super::Medium;

/// One channel of a medium and its boundary. Derived quantities as in Jensen et al. 2001 §2 and, with Grosjean's
/// diffusion coefficient, d'Eon & Irving 2011.
///
/// | name | symbol | value, unit |
/// | --- | --- | --- |
/// | `sigma_a`, `sigma_s` | σa, σs | absorption, scattering, 1/m, ≥ 0 |
/// | `g` | g | mean cosine of Henyey–Greenstein, in (−1, 1) |
/// | `eta` | η | index of the medium over that outside, > 0 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Absorption coefficient, 1/m, ≥ 0.
    pub sigma_a: f64,
    /// Scattering coefficient, 1/m, ≥ 0.
    pub sigma_s: f64,
    /// Mean cosine of the phase function, in (−1, 1).
    pub g: f64,
    /// Index of refraction of the medium over that outside, > 0.
    pub eta: f64,
}

impl Coefficients {
    /// One channel (0, 1 or 2) of `medium`, surrounded by an index of `outside`.
    pub fn of_medium(medium: &Medium, channel: usize, outside: f32) -> Self {
        Self {
            sigma_a: f64::from(medium.sigma_a[channel]),
            sigma_s: f64::from(medium.sigma_s[channel]),
            g: f64::from(medium.g),
            eta: f64::from(medium.ior) / f64::from(outside),
        }
    }

    /// Isotropic scattering of coefficient `reduced_scattering` = σs′, 1/m.
    pub fn isotropic(sigma_a: f64, reduced_scattering: f64, eta: f64) -> Self {
        Self { sigma_a, sigma_s: reduced_scattering, g: 0.0, eta }
    }

    /// Extinction coefficient σt = σa + σs, 1/m.
    pub fn sigma_t(&self) -> f64 {
        self.sigma_a + self.sigma_s
    }

    /// Reduced scattering coefficient σs′ = σs(1 − g), 1/m.
    pub fn reduced_scattering(&self) -> f64 {
        self.sigma_s * (1.0 - self.g)
    }

    /// Reduced extinction coefficient σt′ = σs′ + σa, 1/m.
    pub fn reduced_extinction(&self) -> f64 {
        self.reduced_scattering() + self.sigma_a
    }

    /// Single-scattering albedo α = σs/σt in \[0, 1\]; 0 where nothing happens.
    pub fn albedo(&self) -> f64 {
        share(self.sigma_s, self.sigma_t())
    }

    /// Reduced albedo α′ = σs′/σt′ in \[0, 1\]; 0 where nothing happens.
    pub fn reduced_albedo(&self) -> f64 {
        share(self.reduced_scattering(), self.reduced_extinction())
    }

    /// Mean free path 1/σt, m.
    pub fn mean_free_path(&self) -> f64 {
        1.0 / self.sigma_t()
    }

    /// Transport mean free path 1/σt′, m: the depth z_r of a dipole's real source.
    pub fn transport_mean_free_path(&self) -> f64 {
        1.0 / self.reduced_extinction()
    }

    /// Classical diffusion coefficient D = 1/(3σt′), m.
    pub fn diffusion_coefficient(&self) -> f64 {
        1.0 / (3.0 * self.reduced_extinction())
    }

    /// Grosjean's diffusion coefficient D_G = (2σa + σs′)/(3σt′²), m.
    pub fn grosjean_coefficient(&self) -> f64 {
        let t = self.reduced_extinction();
        (2.0 * self.sigma_a + self.reduced_scattering()) / (3.0 * t * t)
    }

    /// Effective transport coefficient σtr = √(σa/D) = √(3σaσt′), 1/m.
    pub fn effective_transport(&self) -> f64 {
        (3.0 * self.sigma_a * self.reduced_extinction()).sqrt()
    }

    /// √(σa/D_G), 1/m: the effective transport coefficient of Grosjean's diffusion.
    pub fn grosjean_transport(&self) -> f64 {
        (self.sigma_a / self.grosjean_coefficient()).sqrt()
    }

    /// Diffuse mean free path 1/σtr, m; infinite without absorption.
    pub fn diffuse_mean_free_path(&self) -> f64 {
        1.0 / self.effective_transport()
    }

    /// Whether light is scattered away from its direction at all; where it is not, every profile is zero.
    pub fn scatters(&self) -> bool {
        self.reduced_scattering() > 0.0
    }
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Two point sources on one normal, the real one at depth `z_r` ≥ 0 and the virtual one at depth `z_v`, usually
/// negative, seen from the surface at distance r from the normal.
#[derive(Clone, Copy)]
struct Dipole {
    /// Distance to the real source, m.
    d_r: f64,
    /// e^{−σd_r}/d_r − e^{−σd_v}/d_v, 1/m.
    fluence: f64,
    /// z(1 + σd)e^{−σd}/d³ of the real source, 1/m².
    real: f64,
    /// The same of the virtual source; the sign is that of `z_v`.
    image: f64,
}

impl Dipole {
    /// With δ = d_v − d_r = (z_v² − z_r²)/(d_v + d_r) the difference does not cancel far away.
    fn new(sigma_tr: f64, z_r: f64, z_v: f64, r: f64) -> Self {
        let (d_r, d_v) = ((r * r + z_r * z_r).sqrt(), (r * r + z_v * z_v).sqrt());
        let delta = (z_v - z_r) * (z_v + z_r) / (d_v + d_r);
        let fall = (-sigma_tr * delta).exp_m1();
        let real = (-sigma_tr * d_r).exp() / d_r;
        let image = real * (1.0 + fall) * d_r / d_v;
        let flux = |z: f64, d: f64, green: f64| z * (1.0 + sigma_tr * d) * green / (d * d);
        Self {
            d_r,
            fluence: real * (delta - d_r * fall) / d_v,
            real: flux(z_r, d_r, real),
            image: flux(z_v, d_v, image),
        }
    }
}
