//! What lies below layers: a plain or general surface, or a bare or treated boundary of a medium.

use super::anisotropic::Facets;
use super::fresnel::{self, SCHLICK_AVERAGE};
use super::metallic_roughness::{Surface, SurfaceParameters};
use super::substrate::Substrate;
use super::treated::TreatedBoundary;
use super::{BsdfSample, DielectricBoundary};
use glam::{Vec2, Vec3};

/// What lies below the layers.
#[derive(Clone, Copy, Debug)]
pub enum Base {
    /// A plain opaque surface or thin wall, and its mean colour.
    Surface(Surface, Vec3),
    /// Any other opaque surface or thin wall.
    Substrate(Substrate),
    /// The bare boundary of a medium, and the tint of a crossing.
    Boundary(DielectricBoundary, Vec3),
    /// A boundary with treated facets, and the tint of a crossing.
    Treated(TreatedBoundary, Vec3),
}

/// How a base spreads the light of one direction that it reflects or lets through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// The facets that send it to where they look.
    pub(super) facets: Facets,
    /// Share of light that this concerns: what crosses a boundary is another matter.
    pub(super) share: f32,
    /// Share of it that is diffuse; the rest comes from the facets.
    pub(super) diffuse: f32,
    /// p, where the diffuse share leaves a dielectric's coat with 1 − p (1 − µ)⁵ times Lambert's law.
    pub(super) grazing: f32,
}

/// The p of [`Spread::grazing`] of what a coat lets through at normal incidence and on average.
pub(super) fn grazing(normal: f32, average: f32) -> f32 {
    ((1.0 - average / normal.max(1e-6)) / SCHLICK_AVERAGE).clamp(0.0, 1.0)
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

    /// How light of a turned direction is spread, where what layers throw back comes out again on their side.
    pub(super) fn spread(&self, w: Vec3) -> Spread {
        let reflected = |facets, share| Spread { facets, share, diffuse: 0.0, grazing: 0.0 };
        match self {
            Self::Surface(s, _) => s.spread(w.z.abs()),
            Self::Substrate(s) => s.spread(w),
            Self::Boundary(b, _) => {
                reflected(Facets::isotropic(b.alpha()), fresnel::dielectric(w.z.abs(), b.eta()))
            }
            Self::Treated(t, _) => reflected(*t.facets(), t.reflected_outside(w.z.abs())),
        }
    }

    /// Mean colour of what it sends back of a share of light.
    pub(super) fn color(&self) -> Vec3 {
        match self {
            Self::Surface(_, color) => *color,
            Self::Substrate(s) => s.color(),
            Self::Boundary(..) | Self::Treated(..) => Vec3::ONE,
        }
    }

    /// How rough it is to a coat on it: 0 as a mirror, 1 as a diffuse surface.
    pub(super) fn seen_roughness(&self) -> f32 {
        match self {
            Self::Surface(s, _) => s.seen_roughness(),
            Self::Substrate(s) => s.seen_roughness(),
            Self::Boundary(b, _) => b.alpha().sqrt(),
            Self::Treated(t, _) => t.facets().mean_width(1.0).sqrt(),
        }
    }

    /// A direction turned to the facets: x along the tangent.
    pub(super) fn turned(&self, w: Vec3) -> Vec3 {
        match self {
            Self::Substrate(s) => s.facets().turned(w),
            Self::Treated(t, _) => t.facets().turned(w),
            Self::Surface(..) | Self::Boundary(..) => w,
        }
    }

    /// Whether facets look the same from all sides.
    pub(super) fn is_isotropic(&self) -> bool {
        let same = |facets: &Facets| facets.alpha.x == facets.alpha.y;
        match self {
            Self::Substrate(s) => same(s.facets()),
            Self::Treated(t, _) => same(t.facets()),
            Self::Surface(..) | Self::Boundary(..) => true,
        }
    }

    /// A direction outside (z > 0) to which a visible facet of a rough boundary refracts light from the turned
    /// direction `o`, inside but given above, and the share that gets there.
    pub(super) fn emerging(&self, o: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        match self {
            Self::Boundary(b, _) => b.emerging(o, u),
            Self::Treated(t, _) => t.emerging(o, u),
            Self::Surface(..) | Self::Substrate(..) => None,
        }
    }

    /// Share of light from the turned direction `o` inside that a boundary hands back outside.
    pub(super) fn lost_inside(&self, o: Vec3) -> f32 {
        match self {
            Self::Boundary(b, _) => b.lost_inside(o.z),
            Self::Treated(t, _) => t.lost_inside(o),
            Self::Surface(..) | Self::Substrate(..) => 0.0,
        }
    }

    /// Where it goes: the density towards the turned direction `i` outside over that of Lambert's law.
    pub(super) fn handed_back(&self, i: Vec3) -> f32 {
        match self {
            Self::Boundary(b, _) => b.handed_back(i.z),
            Self::Treated(t, _) => t.handed_back(i),
            Self::Surface(..) | Self::Substrate(..) => 1.0,
        }
    }
}

impl Base {
    /// A plain surface.
    pub fn surface(p: &SurfaceParameters) -> Self {
        Self::Surface(Surface::new(p), p.base_color)
    }
}
