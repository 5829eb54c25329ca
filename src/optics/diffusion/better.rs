//! The better dipole (d'Eon, "A Better Dipole", 2012).
//!
//! Grosjean's diffusion with exact Fresnel moments: D = (2σa + σs′)/(3σt′²), σtr = √(σa/D), z_r = 1/σt′,
//! z_v = −z_r − 4AD, and an exitance that counts fluence and flux by what the boundary lets through:
//!
//! R_d(r) = α′²/(4π) \[ (C_φ/D + C_E z_r(1 + σtr d_r)/d_r²) e^{−σtr d_r}/d_r − (C_φ/D + C_E z_v(1 + σtr d_v)/d_v²)
//! e^{−σtr d_v}/d_v \].
//!
//! α′² leaves out single scattering, which is to be added ([`super::SingleScattering`]).

use super::{Coefficients, Dipole, Moments, RadialProfile};
use std::f64::consts::PI;

/// The dipole of one channel, ready to evaluate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetterDipole {
    reduced_albedo: f64,
    moments: Moments,
    d: f64,
    sigma_tr: f64,
    z_r: f64,
    z_v: f64,
}

impl BetterDipole {
    /// With exact Fresnel moments.
    pub fn new(c: &Coefficients) -> Self {
        Self::with_moments(c, Moments::exact(c.eta))
    }

    /// With moments of the caller's, such as [`Moments::fit`].
    pub fn with_moments(c: &Coefficients, moments: Moments) -> Self {
        let (d, z_r) = (c.grosjean_coefficient(), c.transport_mean_free_path());
        Self {
            reduced_albedo: c.reduced_albedo(),
            moments,
            d,
            sigma_tr: c.grosjean_transport(),
            z_r,
            z_v: -z_r - 4.0 * moments.a() * d,
        }
    }

    /// Depth of the real source, m.
    pub fn z_r(&self) -> f64 {
        self.z_r
    }

    /// Depth of the virtual source, m: negative, it is above the surface.
    pub fn z_v(&self) -> f64 {
        self.z_v
    }
}

/// Integral of the profile over the plane, in \[0, 1\], for the reduced albedo `reduced_albedo` in \[0, 1\]:
/// α′²/2 e^{−q} (C_E(1 + e^{−4At}) + (C_φ/t)(1 − e^{−4At})), q = √(3(1−α′)/(2−α′)), t = √((1−α′)(2−α′)/3)
/// (d'Eon 2012; also Hery, "Texture mapping for the better dipole", 2012).
pub fn total_reflectance(reduced_albedo: f64, moments: &Moments) -> f64 {
    let lost = (1.0 - reduced_albedo).max(0.0);
    let q = (3.0 * lost / (1.0 + lost)).sqrt();
    let t = (lost * (1.0 + lost) / 3.0).sqrt();
    let fall = -(-4.0 * moments.a() * t).exp_m1();
    let fluence = if t > 0.0 { fall / t } else { 4.0 * moments.a() };
    0.5 * reduced_albedo
        * reduced_albedo
        * (-q).exp()
        * (moments.c_e() * (2.0 - fall) + moments.c_phi() * fluence)
}

impl RadialProfile for BetterDipole {
    fn eval(&self, r: f64) -> f64 {
        if self.reduced_albedo <= 0.0 {
            return 0.0;
        }
        let Dipole { fluence, real, image, .. } = Dipole::new(self.sigma_tr, self.z_r, self.z_v, r);
        let exitance = self.moments.c_phi() / self.d * fluence + self.moments.c_e() * (real - image);
        self.reduced_albedo * self.reduced_albedo / (4.0 * PI) * exitance
    }

    fn total(&self) -> f64 {
        total_reflectance(self.reduced_albedo, &self.moments)
    }
}
