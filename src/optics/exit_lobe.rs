//! How light comes in where a BSSRDF has found that it did.
//!
//! A path that a subsurface model lets out at a point goes on towards the light through a lobe of incidence. Whatever the
//! model, directions are drawn from the cosine, since lobes of BSSRDFs are smooth.

use super::{BsdfSample, fresnel, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::fmt;

/// The angular part of a BSSRDF, for light that comes in at one point. **Plug-in seam**, with
/// [`crate::subsurface::Arrival::Exit`].
pub trait ExitLobe: fmt::Debug + Send + Sync {
    /// f·cos θ_i in 1/sr for light from `wi`, a unit vector with z > 0 in the frame of
    /// [`crate::sampling::orthonormal_basis`] about the shading normal.
    fn eval(&self, wi: Vec3) -> Vec3;
}

/// The diffuse lobe in proportion to the Fresnel transmittance, (1 − F(cos θ)) cos θ/(π (1 − F̄)), which integrates to 1.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseExit {
    eta: f32,
    inv_entering: f32,
}

impl DiffuseExit {
    /// `eta` is inside over outside.
    pub fn new(eta: f32) -> Self {
        Self { eta, inv_entering: 1.0 / (1.0 - fresnel::diffuse_reflectance(eta)) }
    }
}

impl ExitLobe for DiffuseExit {
    fn eval(&self, wi: Vec3) -> Vec3 {
        let entering = (1.0 - fresnel::dielectric(wi.z, self.eta)) * self.inv_entering;
        Vec3::splat(wi.z * FRAC_1_PI * entering)
    }
}

/// f·cos θ_i and the density of [`sample`]. Directions are above the surface whichever side the path came from.
#[inline]
pub(super) fn eval_pdf(lobe: &dyn ExitLobe, wi: Vec3) -> (Vec3, f32) {
    if wi.z > 0.0 { (lobe.eval(wi), wi.z * FRAC_1_PI) } else { (Vec3::ZERO, 0.0) }
}

pub(super) fn sample(lobe: &dyn ExitLobe, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
    let wi = warp::cosine_hemisphere(u);
    let (f, pdf) = eval_pdf(lobe, wi);
    (pdf > 0.0).then(|| BsdfSample { wi, weight: f / pdf, pdf, delta: false, transmitted: wo.z < 0.0 })
}
