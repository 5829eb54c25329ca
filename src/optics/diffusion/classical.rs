//! The classical dipole (Jensen, Marschner, Levoy, Hanrahan 2001, §2.1–2.4).
//!
//! A pencil beam becomes an isotropic point source one transport mean free path below the surface; its mirror image
//! above the extrapolated boundary makes the fluence vanish there:
//!
//! R_d(r) = α′/(4π) Σ z(1 + σtr d) e^{−σtr d}/d³ over z_r = 1/σt′ and z_v = z_r(1 + 4A/3), d = √(r² + z²) (eq. 4).
//!
//! Valid for α′ near 1 and r beyond a mean free path; nearer it lacks the peak of low-order scattering, at low albedo
//! it reflects up to several times too much. The BSSRDF is S_d = F_t(ωi) R_d F_t(ωo)/π (eq. 5).

use super::{Coefficients, Dipole, RadialProfile, fresnel};
use std::f64::consts::PI;

/// The dipole of one channel, ready to evaluate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassicalDipole {
    reduced_albedo: f64,
    sigma_tr: f64,
    a: f64,
    z_r: f64,
    z_v: f64,
}

impl ClassicalDipole {
    /// As published: A from the fit of the diffuse Fresnel reflectance.
    pub fn new(c: &Coefficients) -> Self {
        Self::with_reflectance(c, fresnel::diffuse_reflectance_fit(c.eta))
    }

    /// With a diffuse Fresnel reflectance `f_dr` in \[0, 1) of the caller's, such as the exact one.
    pub fn with_reflectance(c: &Coefficients, f_dr: f64) -> Self {
        let a = fresnel::boundary_coefficient(f_dr);
        let z_r = c.transport_mean_free_path();
        Self {
            reduced_albedo: c.reduced_albedo(),
            sigma_tr: c.effective_transport(),
            a,
            z_r,
            z_v: z_r * (1.0 + 4.0 / 3.0 * a),
        }
    }

    /// Boundary coefficient A ≥ 1.
    pub fn a(&self) -> f64 {
        self.a
    }

    /// Depth of the real source, m.
    pub fn z_r(&self) -> f64 {
        self.z_r
    }

    /// Height of the virtual source, m, as a positive number.
    pub fn z_v(&self) -> f64 {
        self.z_v
    }
}

/// α′/2 (1 + e^{−4/3 A √(3(1−α′))}) e^{−√(3(1−α′))}: diffuse reflectance in \[0, 1\] of a half space of reduced albedo
/// `reduced_albedo` in \[0, 1\] and boundary coefficient `a` ≥ 1 (Jensen et al. 2001, §2.4).
pub fn total_reflectance(reduced_albedo: f64, a: f64) -> f64 {
    let root = (3.0 * (1.0 - reduced_albedo)).max(0.0).sqrt();
    0.5 * reduced_albedo * (1.0 + (-4.0 / 3.0 * a * root).exp()) * (-root).exp()
}

impl RadialProfile for ClassicalDipole {
    fn eval(&self, r: f64) -> f64 {
        if self.reduced_albedo <= 0.0 {
            return 0.0;
        }
        let Dipole { real, image, .. } = Dipole::new(self.sigma_tr, self.z_r, self.z_v, r);
        self.reduced_albedo / (4.0 * PI) * (real + image)
    }

    fn total(&self) -> f64 {
        total_reflectance(self.reduced_albedo, self.a)
    }
}
