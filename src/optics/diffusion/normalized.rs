//! Normalized diffusion (Christensen & Burley, "Approximate Reflectance Profiles for Efficient Subsurface Scattering",
//! Pixar Technical Memo 15-04, 2015).
//!
//! R(r) = A (e^{−r/d} + e^{−r/(3d)})/(8π d r), d = l/s (eq. 3): its integral over the plane is the surface albedo A for
//! every d. The length l and the scaling s(A) were fitted to Monte Carlo profiles of index-matched, isotropic media;
//! for η > 1 the shape is off by an L1 distance of half of the energy with the fits to the mean free path, of a fifth with
//! that to the diffuse mean free path.
//!
//! With x = e^{−r/(3d)} the distribution function is 1 − (x³ + 3x)/4, a cubic with one real root: the inverse is closed.

use super::RadialProfile;
use std::f64::consts::PI;

/// The published scalings s(A), A the surface albedo in \[0, 1\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScaleFit {
    /// 1.85 − A + 7|A − 0.8|³ for a perpendicular pencil beam; l is the mean free path (eq. 5).
    SearchlightMfp,
    /// 1.9 − A + 3.5(A − 0.8)² for ideally diffuse transmission into the surface; l is the mean free path (eq. 6).
    DiffuseMfp,
    /// 3.5 + 100(A − 0.33)⁴ for a perpendicular pencil beam; l is the diffuse mean free path (eq. 8).
    SearchlightDmfp,
}

impl ScaleFit {
    /// All three.
    pub const ALL: [Self; 3] = [Self::SearchlightMfp, Self::DiffuseMfp, Self::SearchlightDmfp];

    /// s(A), dimensionless, > 0.
    pub fn scale(self, albedo: f64) -> f64 {
        match self {
            Self::SearchlightMfp => 1.85 - albedo + 7.0 * (albedo - 0.8).abs().powi(3),
            Self::DiffuseMfp => 1.9 - albedo + 3.5 * (albedo - 0.8).powi(2),
            Self::SearchlightDmfp => 3.5 + 100.0 * (albedo - 0.33).powi(4),
        }
    }
}

/// The profile of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalizedDiffusion {
    /// Surface albedo A in \[0, 1\]: the integral of the profile.
    pub albedo: f64,
    /// Shape d = l/s in m.
    pub d: f64,
}

impl NormalizedDiffusion {
    /// Of the surface albedo `albedo` in \[0, 1\] and the length `l` in m that `fit` asks for: the (transport) mean
    /// free path or the diffuse mean free path.
    pub fn new(albedo: f64, l: f64, fit: ScaleFit) -> Self {
        Self { albedo, d: l / fit.scale(albedo) }
    }

    /// Density of the radius, 1/m: 2πr R/A, finite at 0.
    pub fn pdf_radius(&self, r: f64) -> f64 {
        let x = (-r / (3.0 * self.d)).exp();
        x * (x * x + 1.0) / (4.0 * self.d)
    }

    /// Probability in \[0, 1\] that the radius is at most `r` ≥ 0 (eq. 11).
    pub fn cdf(&self, r: f64) -> f64 {
        let y = r / (3.0 * self.d);
        -0.25 * (-3.0 * y).exp_m1() - 0.75 * (-y).exp_m1()
    }

    /// The radius in m whose [`NormalizedDiffusion::cdf`] is `xi` in \[0, 1); infinite at 1.
    ///
    /// x³ + 3x = 4(1 − ξ) = 2c by Cardano: x = w − 1/w with w³ = c + √(1 + c²), or 2 sinh(asinh(c)/3). Near ξ = 0 it
    /// is y = 1 − x that is small, and y(6 + y(−3 + y)) = 4ξ gives it back its digits by one Newton step.
    pub fn invert(&self, xi: f64) -> f64 {
        let x = 2.0 * ((2.0 * (1.0 - xi)).asinh() / 3.0).sinh();
        let mut y = 1.0 - x;
        y -= (y * (6.0 + y * (y - 3.0)) - 4.0 * xi) / (6.0 + y * (3.0 * y - 6.0));
        -3.0 * self.d * if y < 0.5 { (-y).ln_1p() } else { x.ln() }
    }
}

impl RadialProfile for NormalizedDiffusion {
    fn eval(&self, r: f64) -> f64 {
        self.albedo * self.pdf_radius(r) / (2.0 * PI * r)
    }

    fn total(&self) -> f64 {
        self.albedo
    }
}
