//! `brdf-approximation`: the limit of uniform light, where points of entry and exit no longer matter (Jensen et al. 2001,
//! §2.4 and §3.1): f_r = f⁽¹⁾ + F R_d/π, with f⁽¹⁾ = α F p/(η² (|n·ω_i′| + |n·ω_o′|)); see
//! [`diffusion::BrdfApproximation`] for which albedo and which cosines.
//!
//! The path leaves the object where it has entered. The boundary has chosen transmission, so F_t(ω_o) is already there,
//! and the refracted direction ω_o′ is that of the path inside, microfacets included.

use super::from_boundary::{FromBoundary, or_walk};
use super::tables::coefficients_at;
use super::{Arrival, Connector, Exit, Flight, PathHead, Propagator, SubsurfaceModel};
use crate::geometry::Hit;
use crate::optics::diffusion::{self, Cosines};
use crate::optics::{ExitLobe, HenyeyGreenstein, fresnel};
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::{Scene, Surface};
use glam::{Mat3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The BRDF approximation.
#[derive(Clone, Copy, Debug)]
pub struct BrdfApproximation {
    /// Which cosines divide single scattering.
    pub cosines: Cosines,
}

impl SubsurfaceModel for BrdfApproximation {
    fn name(&self) -> &str {
        "brdf-approximation"
    }

    fn summary(&self) -> &str {
        "light leaves where it came in: the limit of uniform light (Jensen et al. 2001)"
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        or_walk(HalfSpace { cosines: self.cosines }, scene)
    }
}

struct HalfSpace {
    cosines: Cosines,
}

impl FromBoundary for HalfSpace {
    fn arrive(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        hit: &Hit,
        _: &mut Sampler,
        _: &mut dyn Connector,
    ) -> Arrival {
        head.events += 1;
        Arrival::Exit(Box::new(leave_here(flight, head, hit, self.cosines)))
    }
}

/// Lets the path out at its point of entry.
pub(super) fn leave_here(flight: &Flight<'_>, head: &mut PathHead, hit: &Hit, cosines: Cosines) -> Exit {
    let surface = Surface::new(flight.scene, hit);
    let channels = coefficients_at(flight, surface.position);
    let (x, y) = orthonormal_basis(surface.normal);
    let lobe = Lobe {
        albedo: Vec3::from_array(channels.map(|c| c.albedo() as f32)),
        diffuse: Vec3::from_array(
            channels.map(|c| diffusion::BrdfApproximation::new(&c).diffuse_reflectance() as f32),
        ),
        phase: flight.medium.phase(),
        eta: flight.eta,
        inside: Mat3::from_cols(x, y, surface.normal).transpose() * head.direction,
        cosines,
    };
    head.throughput *= flight.scene.straight_transmission(&surface);
    Exit { surface, lobe: Box::new(lobe) }
}

/// η² f_r cos θ_i / F_t(ω_o).
#[derive(Clone, Copy, Debug)]
struct Lobe {
    albedo: Vec3,
    /// R_d.
    diffuse: Vec3,
    phase: HenyeyGreenstein,
    eta: f32,
    /// Direction of the path inside.
    inside: Vec3,
    cosines: Cosines,
}

impl ExitLobe for Lobe {
    fn eval(&self, wi: Vec3) -> Vec3 {
        let entering = 1.0 - fresnel::dielectric(wi.z, self.eta);
        if entering <= 0.0 {
            return Vec3::ZERO;
        }
        let inside = |cos: f32| (1.0 - (1.0 - cos * cos) / (self.eta * self.eta)).max(0.0).sqrt();
        let outside = |cos: f32| (1.0 - (1.0 - cos * cos) * (self.eta * self.eta)).max(0.0).sqrt();
        // Towards the light, in the medium.
        let refracted = (wi.truncate() / self.eta).extend(inside(wi.z)).normalize();
        let cosines = match self.cosines {
            Cosines::Refracted => refracted.z + self.inside.z.abs(),
            Cosines::Unrefracted => wi.z + outside(self.inside.z),
        };
        let single = self.albedo * (self.phase.eval_directions(self.inside, refracted) / cosines);
        let multiple = self.diffuse * (self.eta * self.eta * FRAC_1_PI);
        (single + multiple) * (entering * wi.z)
    }
}
