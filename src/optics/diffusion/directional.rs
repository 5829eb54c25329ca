//! The directional dipole (Frisvad, Hachisuka, Kjeldsen, "Directional Dipole Model for Subsurface Scattering",
//! ACM TOG 34(1), 2014).
//!
//! The source is a ray of light that starts at the point of entry and is scattered forward along the refracted
//! direction; its mirror image in a plane through entry and exit is subtracted. The model needs no half space: it is a
//! function of two points, their normals and the direction of incidence.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `x` | x = x_o − x_i | m |
//! | `w12` | ω₁₂ | refracted direction of propagation of the incident light |
//! | `n_star` | n_i* | modified normal: that of the plane through both points, closest to n_i |
//! | `d_e` | d_e = 2.131 D/√α′ | distance of the extrapolated boundary, m |
//! | `d_r`, `d_v` | d_r, d_v | corrected distance to the real source, distance to the virtual one, m |
//! | `mu0` | µ₀ = −n_o·ω₁₂ | whether the exit is lit from the front |
//!
//! S′_d(x, ω, d) = 1/(16π² C_φ(1/η)) e^{−σtr d}/d³ \[ C_φ(d²/D + 3(1 + σtr d) x·ω) − C_E(3D(1 + σtr d) ω·n_o −
//! ((1 + σtr d) + 3D(3(1 + σtr d) + (σtr d)²)/d² x·ω) x·n_o) \], and
//! S_d = S′_d(x, ω₁₂, d_r) − S′_d(x_o − x_v, ω_v, d_v), clamped at 0, with x_v = x_i + 2A d_e n_i* and ω_v the mirrored
//! direction. Only d is corrected near the source, not the vector x: d_r² = r² + Dµ₀(Dµ₀ − 2d_e cos β) where µ₀ > 0 and
//! r² + 1/(3σt)², with the unreduced σt, elsewhere.
//!
//! The full BSSRDF is T₁₂ S_d T₂₁ plus the unscattered light. Single scattering is part of S_d. S_d is not reciprocal
//! ([`DirectionalDipole::reciprocal`] averages, §6.3). On a half space it reflects 20 to 40 % too much, more at low
//! albedo: that is the model.

use super::{Coefficients, Moments, RadialProfile, fresnel};
use glam::DVec3;
use std::f64::consts::PI;

/// Light entering at one surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Position x_i, m.
    pub x: DVec3,
    /// Unit normal n_i, outwards.
    pub n: DVec3,
    /// Unit direction ωi outside towards the light, n·w ≥ 0.
    pub w: DVec3,
}

/// The point where light is observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// Position x_o, m.
    pub x: DVec3,
    /// Unit normal n_o, outwards.
    pub n: DVec3,
}

/// S_d taken apart, 1/(m² sr); lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// The contribution of the real ray source, never negative on a front-lit plane.
    pub real: f64,
    /// The contribution of the mirrored source, to be subtracted.
    pub image: f64,
    /// Modified normal n_i*.
    pub n_star: DVec3,
    /// Refracted direction of propagation ω₁₂.
    pub w12: DVec3,
    /// Direction of the mirrored source ω_v.
    pub w_v: DVec3,
    /// Position of the mirrored source x_v.
    pub x_v: DVec3,
    /// µ₀ = −n_o·ω₁₂.
    pub mu0: f64,
    /// cos β in \[−1, 0\].
    pub cos_beta: f64,
    /// Corrected distance to the real source.
    pub d_r: f64,
    /// Distance to the mirrored source.
    pub d_v: f64,
}

impl Evaluation {
    /// S_d ≥ 0, 1/(m² sr).
    pub fn clamped(&self) -> f64 {
        (self.real - self.image).max(0.0)
    }
}

/// The directional dipole of one channel, ready to evaluate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalDipole {
    eta: f64,
    scatters: bool,
    d: f64,
    sigma_tr: f64,
    c_phi: f64,
    c_e: f64,
    c_phi_outside: f64,
    d_e: f64,
    a: f64,
    /// 1/(3σt)², the least squared distance to a source that lies behind the exit.
    back_lit: f64,
}

/// Cross products shorter than this times |x| are rounding: x is along the normal.
const PARALLEL: f64 = 1e-12;

impl DirectionalDipole {
    /// With exact Fresnel moments.
    pub fn new(c: &Coefficients) -> Self {
        Self::with_moments(c, Moments::exact(c.eta), Moments::exact(1.0 / c.eta))
    }

    /// As published, with the polynomial fits of the moments.
    pub fn with_fits(c: &Coefficients) -> Self {
        Self::with_moments(c, Moments::fit(c.eta), Moments::fit(1.0 / c.eta))
    }

    /// With moments of the caller's, of η (`inside`) and of 1/η (`outside`).
    pub fn with_moments(c: &Coefficients, inside: Moments, outside: Moments) -> Self {
        let d = c.diffusion_coefficient();
        let near = 1.0 / (3.0 * c.sigma_t());
        Self {
            eta: c.eta,
            scatters: c.scatters(),
            d,
            sigma_tr: c.effective_transport(),
            c_phi: inside.c_phi(),
            c_e: inside.c_e(),
            c_phi_outside: outside.c_phi(),
            d_e: 2.131 * d / c.reduced_albedo().sqrt(),
            a: (1.0 - inside.c_e()) / (2.0 * inside.c_phi()),
            back_lit: near * near,
        }
    }

    /// Distance d_e of the extrapolated boundary, m.
    pub fn d_e(&self) -> f64 {
        self.d_e
    }

    /// Boundary coefficient A ≥ 1.
    pub fn a(&self) -> f64 {
        self.a
    }

    /// C_φ(1/η), for light that comes from outside: 4π C_φ(1/η) S_d is the exitance per unit power let in.
    pub fn c_phi_outside(&self) -> f64 {
        self.c_phi_outside
    }

    /// Both sources and the geometry behind them. `None` where the incident light does not get in or the medium does
    /// not scatter.
    pub fn evaluate(&self, entry: &Entry, exit: &Exit) -> Option<Evaluation> {
        if !self.scatters {
            return None;
        }
        let w12 = fresnel::refract(entry.w, entry.n, self.eta)?;
        let x = exit.x - entry.x;
        let r2 = x.length_squared();
        let n_star = modified_normal(entry.n, x);
        let mu0 = -exit.n.dot(w12);
        // r² − (x·ω)² = |x × ω|², which cannot turn negative.
        let cos_beta = -(x.cross(w12).length_squared() / (r2 + self.d_e * self.d_e)).sqrt();
        let d_r2 = if mu0 > 0.0 {
            let along = self.d * mu0;
            r2 + along * (along - 2.0 * self.d_e * cos_beta)
        } else {
            r2 + self.back_lit
        };
        let to_image = 2.0 * self.a * self.d_e * n_star;
        let w_v = w12 - 2.0 * w12.dot(n_star) * n_star;
        let from_image = x - to_image;
        let (d_r, d_v) = (d_r2.sqrt(), from_image.length());
        Some(Evaluation {
            real: self.source(x, w12, d_r, exit.n),
            image: self.source(from_image, w_v, d_v, exit.n),
            n_star,
            w12,
            w_v,
            x_v: entry.x + to_image,
            mu0,
            cos_beta,
            d_r,
            d_v,
        })
    }

    /// S_d ≥ 0, 1/(m² sr), without the Fresnel transmittances of entry and exit.
    pub fn s_d(&self, entry: &Entry, exit: &Exit) -> f64 {
        self.evaluate(entry, exit).map_or(0.0, |e| e.clamped())
    }

    /// The mean of [`DirectionalDipole::s_d`] and of the same with light and camera exchanged (§6.3); `wo` is the unit
    /// direction outside towards the camera.
    pub fn reciprocal(&self, entry: &Entry, exit: &Exit, wo: DVec3) -> f64 {
        let back = Entry { x: exit.x, n: exit.n, w: wo };
        0.5 * (self.s_d(entry, exit) + self.s_d(&back, &Exit { x: entry.x, n: entry.n }))
    }

    /// S′_d of a ray source along `w`, seen from `x` away at the corrected distance `d`.
    fn source(&self, x: DVec3, w: DVec3, d: f64, n_o: DVec3) -> f64 {
        let s = self.sigma_tr * d;
        let (s1, xw) = (1.0 + s, x.dot(w));
        let fluence = self.c_phi * (d * d / self.d + 3.0 * s1 * xw);
        let gradient = s1 + 3.0 * self.d * (3.0 * s1 + s * s) / (d * d) * xw;
        let flux = self.c_e * (3.0 * self.d * s1 * w.dot(n_o) - gradient * x.dot(n_o));
        (-s).exp() / (d * d * d) * (fluence - flux) / (16.0 * PI * PI * self.c_phi_outside)
    }
}

/// n_i* = x̂ × (n × x)/|n × x|: the normal of the plane that holds x and is closest to n; n itself where x is along it.
fn modified_normal(n: DVec3, x: DVec3) -> DVec3 {
    let across = n.cross(x);
    let (length, distance) = (across.length(), x.length());
    if length <= PARALLEL * distance { n } else { (x / distance).cross(across / length) }
}

/// The exitance M = 4π C_φ(1/η) S_d of a half space at normal incidence.
impl RadialProfile for DirectionalDipole {
    fn eval(&self, r: f64) -> f64 {
        let entry = Entry { x: DVec3::ZERO, n: DVec3::Z, w: DVec3::Z };
        let exit = Exit { x: DVec3::new(r, 0.0, 0.0), n: DVec3::Z };
        4.0 * PI * self.c_phi_outside * self.s_d(&entry, &exit)
    }

    /// Quadrature over the plane, within 1e-6.
    fn total(&self) -> f64 {
        if self.scatters { super::profile::integrate(self, 3.0 * self.d) } else { 0.0 }
    }
}
