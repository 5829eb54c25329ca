//! Angular moments of the Fresnel reflectance, and the boundary coefficients of diffusion built from them.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `c1`, `c2` | C₁, C₂ | C_i = ∫₀¹ R(µ) µ^i dµ, for light inside the medium |
//! | `eta` | η | index of the medium over that outside; above 1 the moments include total internal reflection |
//! | [`Moments::c_phi`] | C_φ = (1 − 2C₁)/4 | share of the fluence that leaves |
//! | [`Moments::c_e`] | C_E = (1 − 3C₂)/2 | share of the flux that leaves |
//! | [`Moments::a`] | A = (1 + 3C₂)/(1 − 2C₁) | reflection at the extrapolated boundary |
//!
//! Definitions and fits: d'Eon & Irving 2011 (A also (1 − C_E)/(2C_φ), Frisvad et al. 2014).

use super::fresnel;
use super::quadrature;

/// First and second angular moment of the internal Fresnel reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// C₁ = ∫R µ dµ in \[0, ½\].
    pub c1: f64,
    /// C₂ = ∫R µ² dµ in \[0, ⅓\].
    pub c2: f64,
}

impl Moments {
    /// An index-matched boundary.
    pub const MATCHED: Self = Self { c1: 0.0, c2: 0.0 };

    /// The integrals, by quadrature, within 1e-13; `eta` > 0 is the index of the medium over that outside.
    pub fn exact(eta: f64) -> Self {
        if eta == 1.0 {
            return Self::MATCHED;
        }
        let beyond = 1.0 / eta;
        if eta < 1.0 {
            let moment = |i| quadrature::unit_interval(|mu, _| fresnel::dielectric(mu, beyond) * mu.powi(i));
            return Self { c1: moment(1), c2: moment(2) };
        }
        // Below the critical cosine R is 1; above it the cosine outside, c, is the variable in which R is smooth:
        // µ dµ = c dc/η².
        let critical = ((eta - 1.0) * (eta + 1.0)).sqrt() * beyond;
        let moment = |i: i32| {
            let partial = quadrature::unit_interval(|c, _| {
                let mu = critical.hypot(c * beyond);
                fresnel::reflectance(mu, c * beyond, beyond) * c * mu.powi(i - 1)
            });
            critical.powi(i + 1) / f64::from(i + 1) + partial * beyond * beyond
        };
        Self { c1: moment(1), c2: moment(2) }
    }

    /// The polynomial fits of d'Eon & Irving 2011, within 2e-3 for `eta` in \[0.5, 2\]; exactly zero at 1, where the
    /// polynomials are not.
    pub fn fit(eta: f64) -> Self {
        if eta == 1.0 {
            return Self::MATCHED;
        }
        let v = 1.0 / eta;
        if eta < 1.0 {
            Self {
                c1: horner(eta, [0.919317, -3.4793, 6.75335, -7.80989, 4.98554, -1.36881]) / 2.0,
                c2: horner(eta, [0.828421, -2.62051, 3.36231, -1.95284, 0.236494, 0.145787]) / 3.0,
            }
        } else {
            let c2 = horner(eta, [-1641.1, 1213.67, -568.556, 164.798, -27.0181, 1.91826])
                + horner(v, [0.0, 1376.53, -656.175, 135.926, 0.0, 0.0]);
            Self {
                c1: horner(eta, [-9.23372, 22.2272, -20.9292, 10.2291, -2.54396, 0.254913]) / 2.0,
                c2: c2 / 3.0,
            }
        }
    }

    /// [`Moments::fit`] already divided by 2 and 3 and rounded to five decimals, as Pharr, Jakob & Humphreys 2016
    /// print it: what figures made with that book's renderer contain.
    pub fn fit_rounded(eta: f64) -> Self {
        if eta == 1.0 {
            return Self::MATCHED;
        }
        let v = 1.0 / eta;
        if eta < 1.0 {
            Self {
                c1: horner(eta, [0.45966, -1.73965, 3.37668, -3.904945, 2.49277, -0.68441]),
                c2: horner(eta, [0.27614, -0.87350, 1.12077, -0.65095, 0.07883, 0.04860]),
            }
        } else {
            Self {
                c1: horner(eta, [-4.61686, 11.1136, -10.4646, 5.11455, -1.27198, 0.12746]),
                c2: horner(eta, [-547.033, 404.557, -189.519, 54.9327, -9.00603, 0.63942])
                    + horner(v, [0.0, 458.843, -218.725, 45.3087, 0.0, 0.0]),
            }
        }
    }

    /// C_φ = (1 − 2C₁)/4 in \[0, ¼\].
    pub fn c_phi(&self) -> f64 {
        0.25 * (1.0 - 2.0 * self.c1)
    }

    /// C_E = (1 − 3C₂)/2 in \[0, ½\].
    pub fn c_e(&self) -> f64 {
        0.5 * (1.0 - 3.0 * self.c2)
    }

    /// A = (1 + 3C₂)/(1 − 2C₁) ≥ 1.
    pub fn a(&self) -> f64 {
        (1.0 + 3.0 * self.c2) / (1.0 - 2.0 * self.c1)
    }
}

fn horner(x: f64, coefficients: [f64; 6]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}
