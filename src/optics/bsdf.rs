//! Every way a surface scatters, as one closed set that the tracer calls without dynamic dispatch; only the lobes of
//! BSSRDFs, which are met once a flight, are open to plug-ins.

use super::boundary::DielectricBoundary;
use super::exit_lobe::{self, ExitLobe};
use super::layered::Layered;
use super::metallic_roughness::Surface;
use super::{BsdfSample, warp};
use glam::{Vec2, Vec3};

/// The scattering of one point of a surface. Local frame, directions point away from the surface, radiance is carried
/// from the camera.
#[derive(Debug)]
pub enum Bsdf {
    /// A boundary of a medium.
    Boundary(DielectricBoundary),
    /// An opaque surface or thin wall.
    Surface(Surface),
    /// Part of the surface is a boundary, the rest is opaque.
    Mixed(Mixed),
    /// Layers on a surface or boundary, or lobes of other shapes.
    Layered(Box<Layered>),
    /// Where light of a BSSRDF leaves its object.
    Exit(Box<dyn ExitLobe>),
}

impl Bsdf {
    /// A diffuse surface that reflects `color`.
    pub fn diffuse(color: Vec3) -> Self {
        Self::Surface(Surface::lambertian(color))
    }

    /// Whether every sample is a delta.
    #[inline]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Boundary(b) => b.is_delta(),
            Self::Surface(s) => s.is_delta(),
            Self::Mixed(m) => m.boundary.is_delta() && m.surface.is_delta(),
            Self::Layered(l) => l.is_delta(),
            Self::Exit(_) => false,
        }
    }

    /// f·|cos θ_i|, deltas left out.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.eval_pdf(wo, wi).0
    }

    /// Density of [`Bsdf::sample`] per steradian, deltas left out.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    /// [`Bsdf::eval`] and [`Bsdf::pdf`] at the price of one.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        match self {
            Self::Boundary(b) => b.eval_pdf(wo, wi),
            Self::Surface(s) => s.eval_pdf(wo, wi),
            Self::Mixed(m) => m.eval_pdf(wo, wi),
            Self::Layered(l) => l.eval_pdf(wo, wi),
            Self::Exit(e) => exit_lobe::eval_pdf(&**e, wi),
        }
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)². `None` ends the path.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        match self {
            Self::Boundary(b) => b.sample(wo, u_lobe, u),
            Self::Surface(s) => s.sample(wo, u_lobe, u),
            Self::Mixed(m) => m.sample(wo, u_lobe, u),
            Self::Layered(l) => l.sample(wo, u_lobe, u),
            Self::Exit(e) => exit_lobe::sample(&**e, wo, u),
        }
    }
}

/// A boundary that covers a share of the surface, with an opaque surface on the rest: partial transmission into a
/// medium. Both are energy-conserving and reciprocal, so their mean is. A thin wall is no partner for a boundary: give
/// the surface no transmission.
#[derive(Clone, Copy, Debug)]
pub struct Mixed {
    boundary: DielectricBoundary,
    surface: Surface,
    share: f32,
}

impl Mixed {
    /// `share` in \[0, 1\] is that of the boundary.
    pub fn new(boundary: DielectricBoundary, surface: Surface, share: f32) -> Self {
        Self { boundary, surface, share: share.clamp(0.0, 1.0) }
    }

    /// How a material with a medium, of the given `metallic` and `transmission`, divides: the share of the boundary,
    /// (1 − metallic) transmission, and the metallic parameter of the opaque rest.
    pub fn division(metallic: f32, transmission: f32) -> (f32, f32) {
        let share = (1.0 - metallic) * transmission;
        (share, if share < 1.0 { metallic / (1.0 - share) } else { 0.0 })
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let (f, p) = self.boundary.eval_pdf(wo, wi);
        let (g, q) = self.surface.eval_pdf(wo, wi);
        let (a, b) = (self.share, 1.0 - self.share);
        (a * f + b * g, a * p + b * q)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let a = self.share;
        let (mut sample, share) = if u_lobe < a {
            (self.boundary.sample(wo, warp::clamp_unit(u_lobe / a), u)?, a)
        } else {
            (self.surface.sample(wo, warp::clamp_unit((u_lobe - a) / (1.0 - a)), u)?, 1.0 - a)
        };
        if sample.delta {
            sample.pdf *= share;
        } else {
            let (f, pdf) = self.eval_pdf(wo, sample.wi);
            sample.weight = f / pdf;
            sample.pdf = pdf;
        }
        Some(sample)
    }
}

#[cfg(test)]
#[path = "bsdf_tests.rs"]
mod tests;
