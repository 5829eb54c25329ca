//! Light that is scattered once (Jensen et al. 2001, §3; Habel et al. 2013).
//!
//! [`SingleScattering`] is the exact radial profile of a half space with a smooth boundary. [`Connection`] is the term
//! along a refracted view ray on any surface: at the distance s_o′ below the exit the light comes in straight from
//! ωi, and refraction at its entry, which nobody knows without a search, is approximated by the shorter way
//! s_i′ = s_i |ωi·n_i|/√(1 − (1 − |ωi·n_i|²)/η²).
//!
//! As printed the term takes the radiance per steradian outside; light refracted into the medium is per steradian
//! inside and leaves it 1/η² dimmer. [`Contribution::physical_factor`] corrects both.

use super::{Coefficients, RadialProfile, fresnel, phase, quadrature};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Exact single scattering of a normally incident pencil beam on a half space: light that meets one particle and leaves
/// without being reflected at the boundary on its way.
///
/// From depth t the surface at r is seen along the cosine t/d, d = √(r² + t²):
/// ss(r) = ∫ σs e^{−σt(t+d)} p(−t/d) T(t/d) (t/d)/d² dt. In the sine s of the exit angle outside, with µ = √(1 − s²/η²),
/// ss(r) = σs/(ηr) ∫₀¹ e^{−σt η r(1+µ)/s} p(−µ) T ds. It grows as 1/r towards the beam.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleScattering {
    coefficients: Coefficients,
    /// (1 + µ)/s and p(−µ) T ds at the nodes of the quadrature over s.
    nodes: Vec<[f64; 2]>,
}

impl SingleScattering {
    /// The profile of one channel.
    pub fn new(c: &Coefficients) -> Self {
        let Coefficients { g, eta, .. } = *c;
        // Light from a medium of lower index leaves at sines up to η only.
        let largest = eta.min(1.0);
        let node = |&[x, rest, weight]: &[f64; 3]| {
            let (sin, cos) = ((FRAC_PI_2 * x).sin(), (FRAC_PI_2 * rest).sin());
            let s = largest * sin;
            let inside = if eta < 1.0 { eta * cos } else { ((eta - s) * (eta + s)).sqrt() };
            let outside = if eta < 1.0 { ((1.0 - s) * (1.0 + s)).sqrt() } else { cos };
            let mu = inside / eta;
            let transmittance = 1.0 - fresnel::reflectance(mu, outside / eta, 1.0 / eta);
            let ds = FRAC_PI_2 * largest * cos * weight;
            [(1.0 + mu) / s, phase::henyey_greenstein(g, -mu) * transmittance * ds]
        };
        Self { coefficients: *c, nodes: quadrature::nodes().iter().map(node).collect() }
    }

    /// The integrand over the depth `t` > 0 in m: what unit length of the beam sends to unit area at distance `r`
    /// (m), 1/m³.
    pub fn integrand(&self, t: f64, r: f64) -> f64 {
        let c = &self.coefficients;
        let d = r.hypot(t);
        let mu = t / d;
        c.sigma_s
            * (-c.sigma_t() * (t + d)).exp()
            * phase::henyey_greenstein(c.g, -mu)
            * fresnel::transmittance(mu, 1.0 / c.eta)
            * mu
            / (d * d)
    }

    /// The depth t_c = r√(η² − 1) in m above which light to distance `r` is totally reflected.
    pub fn critical_depth(&self, r: f64) -> f64 {
        let eta = self.coefficients.eta;
        r * ((eta - 1.0) * (eta + 1.0)).max(0.0).sqrt()
    }
}

impl RadialProfile for SingleScattering {
    fn eval(&self, r: f64) -> f64 {
        let c = &self.coefficients;
        let reach = c.sigma_t() * c.eta * r;
        let sum: f64 = self.nodes.iter().map(|[rate, weight]| weight * (-reach * rate).exp()).sum();
        c.sigma_s / (c.eta * r) * sum
    }

    fn total(&self) -> f64 {
        let c = &self.coefficients;
        let sum: f64 = self.nodes.iter().map(|[rate, weight]| weight / rate).sum();
        TAU * c.albedo() / (c.eta * c.eta) * sum
    }
}

/// s_i′ in m: length inside of the refracted way to the light, for the straight way `s_i` in m to a surface met at the
/// cosine `cos_i` = |ωi·n_i| by light from outside (Jensen et al. 2001, §3).
pub fn refracted_distance(s_i: f64, cos_i: f64, eta: f64) -> f64 {
    s_i * cos_i / (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt()
}

/// One connection from a point on the refracted view ray to the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Unit normal where the light enters.
    pub n_i: DVec3,
    /// Unit normal where it leaves.
    pub n_o: DVec3,
    /// Unit direction outside towards the light, n_i·wi > 0.
    pub wi: DVec3,
    /// Unit direction outside towards the camera, n_o·wo > 0.
    pub wo: DVec3,
    /// Straight distance from the scattering event to the surface along `wi`, m.
    pub s_i: f64,
    /// Distance from the exit to the scattering event along the refracted view ray, m.
    pub s_o: f64,
}

/// What a [`Connection`] carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// s_i′, m.
    pub s_i_refracted: f64,
    /// e^{−σt(s_i′ + s_o′)}.
    pub attenuation: f64,
    /// σs F p e^{−σt s_i′} e^{−σt s_o′}, 1/(m sr): outgoing radiance per unit incident radiance, solid angle of the
    /// light outside and length of the view ray, as printed (eq. 6).
    pub integrand: f64,
    /// Combined extinction σt(1 + G), G = |n_i·wo′|/|n_i·wi′|, 1/m: `integrand` falls as e^{−σtc s_o′} in a
    /// half space.
    pub combined_extinction: f64,
    /// (|ωi·n_i|/|ωi′·n_i|)/η²: turns the printed `integrand` into the radiance that physics gives.
    pub physical_factor: f64,
}

impl Connection {
    /// `None` where one of the directions is below its surface or does not cross it.
    pub fn evaluate(&self, c: &Coefficients) -> Option<Contribution> {
        let (cos_i, cos_o) = (self.n_i.dot(self.wi), self.n_o.dot(self.wo));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return None;
        }
        let before = fresnel::refract(self.wi, self.n_i, c.eta)?;
        let after = -fresnel::refract(self.wo, self.n_o, c.eta)?;
        let crossing = fresnel::transmittance(cos_i, c.eta) * fresnel::transmittance(cos_o, c.eta);
        let s_i_refracted = refracted_distance(self.s_i, cos_i, c.eta);
        let attenuation = (-c.sigma_t() * (s_i_refracted + self.s_o)).exp();
        let cos_refracted = self.n_i.dot(before).abs();
        let phase = phase::henyey_greenstein(c.g, before.dot(after));
        Some(Contribution {
            s_i_refracted,
            attenuation,
            integrand: c.sigma_s * crossing * phase * attenuation,
            combined_extinction: c.sigma_t() * (1.0 + self.n_i.dot(after).abs() / cos_refracted),
            physical_factor: cos_i / (cos_refracted * c.eta * c.eta),
        })
    }
}
