//! Optics.
pub mod boundary;
pub mod boundary_tables;
pub mod fresnel;
pub mod ggx;
mod lobe;
mod loss;
#[cfg(test)]
mod microsurface_walk;
mod warp;

pub use boundary::{DielectricBoundary, Microfacet};
pub use boundary_tables::BoundaryTables;
use glam::Vec3;

/// A direction drawn from a BSDF, in the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit direction, pointing away from the surface.
    pub wi: Vec3,
    /// f·|cos θ_i| / pdf, for radiance carried from the camera.
    pub weight: Vec3,
    /// Density per steradian; for a delta, the probability of its choice.
    pub pdf: f32,
    /// Whether the direction is one of finitely many.
    pub delta: bool,
    /// Whether `wi` is on the other side of the surface than `wo`.
    pub transmitted: bool,
}

pub mod albedo;
pub mod medium;
pub mod phase;
pub use medium::Medium;
pub use phase::HenyeyGreenstein;
/// stub
pub enum Bsdf {
    /// b
    Boundary(DielectricBoundary),
    /// d
    Diffuse(Vec3),
}
impl Bsdf {
    /// s
    pub fn is_delta(&self) -> bool {
        matches!(self, Self::Boundary(b) if b.is_delta())
    }
    /// s
    pub fn diffuse(c: Vec3) -> Self {
        Self::Diffuse(c)
    }
    /// s
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        match self {
            Self::Diffuse(c) if wo.z > 0.0 && wi.z > 0.0 => *c * wi.z / std::f32::consts::PI,
            Self::Boundary(b) => b.eval(wo, wi),
            _ => Vec3::ZERO,
        }
    }
    /// s
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Diffuse(_) if wo.z > 0.0 && wi.z > 0.0 => wi.z / std::f32::consts::PI,
            Self::Boundary(b) => b.pdf(wo, wi),
            _ => 0.0,
        }
    }
    /// s
    pub fn sample(&self, wo: Vec3, ul: f32, u: glam::Vec2) -> Option<BsdfSample> {
        match self {
            Self::Diffuse(c) => {
                let wi = crate::sampling::warp::cosine_hemisphere(u);
                (wo.z > 0.0).then_some(BsdfSample {
                    wi,
                    weight: *c,
                    pdf: wi.z / std::f32::consts::PI,
                    delta: false,
                    transmitted: false,
                })
            }
            Self::Boundary(b) => b.sample(wo, ul, u),
        }
    }
}
