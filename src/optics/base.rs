//! What lies below layers: a plain or general surface, or a bare or treated boundary of a medium.

use super::metallic_roughness::{Surface, SurfaceParameters};
use super::substrate::Substrate;
use super::treated::TreatedBoundary;
use super::{BsdfSample, DielectricBoundary};
use glam::{Vec2, Vec3};

/// What lies below the layers.
#[derive(Clone, Copy, Debug)]
pub enum Base {
    /// A plain opaque surface or thin wall, and how it spreads light.
    Surface(Surface, Spread),
    /// Any other opaque surface or thin wall.
    Substrate(Substrate),
    /// The bare boundary of a medium, and the tint of a crossing.
    Boundary(DielectricBoundary, Vec3),
    /// A boundary with treated facets, and the tint of a crossing.
    Treated(TreatedBoundary, Vec3),
}

/// How a base spreads the light that it reflects.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Share that is Lambertian; the rest comes from facets of width `alpha`.
    pub(super) lambertian: f32,
    pub(super) alpha: f32,
    /// Mean colour.
    pub(super) color: Vec3,
}

impl Base {
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        match self {
            Self::Surface(s, ..) => s.eval_pdf(wo, wi),
            Self::Substrate(s) => s.eval_pdf(wo, wi),
            Self::Boundary(b, _) => b.eval_pdf(wo, wi),
            Self::Treated(t, _) => t.eval_pdf(wo, wi),
        }
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        match self {
            Self::Surface(s, ..) => s.sample(wo, u_lobe, u),
            Self::Substrate(s) => s.sample(wo, u_lobe, u),
            Self::Boundary(b, _) => b.sample(wo, u_lobe, u),
            Self::Treated(t, _) => t.sample(wo, u_lobe, u),
        }
    }

    pub(super) fn is_delta(&self) -> bool {
        match self {
            Self::Surface(s, ..) => s.is_delta(),
            Self::Substrate(s) => s.is_delta(),
            Self::Boundary(b, _) => b.is_delta(),
            Self::Treated(t, _) => t.is_delta(),
        }
    }

    pub(super) fn set_tangent(&mut self, tangent: Vec2) {
        match self {
            Self::Substrate(s) => s.set_tangent(tangent),
            Self::Treated(t, _) => t.set_tangent(tangent),
            Self::Surface(..) | Self::Boundary(..) => {}
        }
    }

    /// Index inside over outside and tint of a boundary.
    pub(super) fn boundary(&self) -> Option<(f32, Vec3)> {
        match self {
            Self::Boundary(b, tint) => Some((b.eta(), *tint)),
            Self::Treated(t, tint) => Some((t.eta(), *tint)),
            _ => None,
        }
    }

    /// Index inside over outside and width of the facets of a boundary.
    pub(super) fn refraction(&self) -> Option<(f32, f32)> {
        match self {
            Self::Boundary(b, _) => Some((b.eta(), b.alpha())),
            Self::Treated(t, _) => Some((t.eta(), t.alpha())),
            _ => None,
        }
    }

    pub(super) fn spread(&self) -> Spread {
        match self {
            Self::Surface(_, spread) => *spread,
            Self::Substrate(s) => s.spread(),
            _ => Spread::default(),
        }
    }
}

impl Base {
    /// A plain surface.
    pub fn surface(p: &SurfaceParameters) -> Self {
        let lambertian = (1.0 - p.metallic) * (1.0 - p.transmission);
        Self::Surface(Surface::new(p), Spread { lambertian, alpha: p.alpha, color: p.base_color })
    }
}
