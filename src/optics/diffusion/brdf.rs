//! The limit of uniform light: Jensen's BRDF approximation (Jensen et al. 2001, §2.4 and §3.1).
//!
//! Where a surface is lit evenly over many mean free paths, the points of entry and exit no longer matter:
//! f_r = f⁽¹⁾ + F R_d/π with F = F_t(ωi) F_t(ωo), R_d the total of the classical dipole, a function of the *reduced*
//! albedo, and single scattering f⁽¹⁾ = α F p(ωi′·ωo′)/(|n·ωi′| + |n·ωo′|) of the *unreduced* one (Hanrahan & Krueger
//! 1993). The cosines are those of the refracted directions. As printed f⁽¹⁾ lacks the 1/η² by which radiance shrinks
//! as it leaves a dense medium; [`SingleTerm`] chooses.

use super::{ClassicalDipole, Coefficients, RadialProfile, fresnel, phase};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Which f⁽¹⁾.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SingleTerm {
    /// With 1/η²: exact for single scattering in a half space with a smooth boundary.
    #[default]
    Corrected,
    /// As in the paper.
    Printed,
}

/// Which cosines divide f⁽¹⁾.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cosines {
    /// Of the directions inside, as the formula means them.
    #[default]
    Refracted,
    /// Of the directions outside: a widespread misreading, brighter without bound towards grazing angles.
    Unrefracted,
}

/// The BRDF approximation of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfApproximation {
    coefficients: Coefficients,
    diffuse_reflectance: f64,
    single_term: SingleTerm,
    cosines: Cosines,
}

impl BrdfApproximation {
    /// The corrected form with refracted cosines; R_d with the published fit of F_dr.
    pub fn new(c: &Coefficients) -> Self {
        Self {
            coefficients: *c,
            diffuse_reflectance: ClassicalDipole::new(c).total(),
            single_term: SingleTerm::default(),
            cosines: Cosines::default(),
        }
    }

    /// The same with another f⁽¹⁾.
    pub fn with_single_term(self, single_term: SingleTerm) -> Self {
        Self { single_term, ..self }
    }

    /// The same with other cosines.
    pub fn with_cosines(self, cosines: Cosines) -> Self {
        Self { cosines, ..self }
    }

    /// R_d, the total of the classical dipole, in \[0, 1\].
    pub fn diffuse_reflectance(&self) -> f64 {
        self.diffuse_reflectance
    }

    /// f⁽¹⁾, 1/sr. `wi`, `wo` and `n` are unit vectors, the directions away from the surface; 0 where one of them is
    /// below it.
    pub fn single(&self, wi: DVec3, wo: DVec3, n: DVec3) -> f64 {
        let c = &self.coefficients;
        let (cos_i, cos_o) = (n.dot(wi), n.dot(wo));
        let refracted = (fresnel::refract(wi, n, c.eta), fresnel::refract(wo, n, c.eta));
        let (Some(before), Some(against)) = refracted else { return 0.0 };
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return 0.0;
        }
        let cosines = match self.cosines {
            Cosines::Refracted => n.dot(before).abs() + n.dot(against).abs(),
            Cosines::Unrefracted => cos_i + cos_o,
        };
        let compression = match self.single_term {
            SingleTerm::Corrected => c.eta * c.eta,
            SingleTerm::Printed => 1.0,
        };
        c.albedo() * self.crossing(cos_i, cos_o) * phase::henyey_greenstein(c.g, -before.dot(against))
            / (cosines * compression)
    }

    /// F R_d/π, 1/sr, for the cosines of incidence and exit outside; 0 where one of them is not above 0.
    pub fn multiple(&self, cos_i: f64, cos_o: f64) -> f64 {
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return 0.0;
        }
        self.crossing(cos_i, cos_o) * self.diffuse_reflectance * FRAC_1_PI
    }

    /// f⁽¹⁾ + F R_d/π, 1/sr; arguments as [`BrdfApproximation::single`].
    pub fn eval(&self, wi: DVec3, wo: DVec3, n: DVec3) -> f64 {
        self.single(wi, wo, n) + self.multiple(n.dot(wi), n.dot(wo))
    }

    fn crossing(&self, cos_i: f64, cos_o: f64) -> f64 {
        let eta = self.coefficients.eta;
        fresnel::transmittance(cos_i, eta) * fresnel::transmittance(cos_o, eta)
    }
}
