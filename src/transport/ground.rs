//! A ground that is seen only by the shadow that falls on it.
//!
//! A horizontal plane without end. A camera ray that meets it before anything else shows what is behind it, the
//! environment, times how much of the light that arrives at the plane with the scene there also arrives there without:
//!
//! ```text
//! pixel = Σ behind · E_with / E_without
//! ```
//!
//! E_with is the irradiance of a path traced as from a matte floor, light that objects throw there included; E_without
//! that of all lights if nothing were in the way. Sums run over the samples of the pixel, and the division comes last, so
//! the ratio is that of two unbiased estimates, and its bias falls with the number of samples. Both use one light sample
//! and differ only in visibility: where nothing is in the way the ratio is 1 without noise. To that end direct light is
//! found by light sampling alone.
//!
//! Nothing but the camera sees the plane: objects look as they do without it, in mirrors and in glass as well.

use super::gathered::{Gathered, Seen};
use super::path::PathTracer;
use super::state::{Path, Vertex};
use crate::film::composite::Caught;
use crate::geometry::{gamma, offset_origin};
use crate::light::Anchor;
use crate::sampling::{Sampler, warp};
use crate::scene::Footprint;
use crate::subsurface::{Aimed, Arrival, PathHead};
use glam::Vec3;
use std::f32::consts::PI;

/// Density of directions as far as weights are concerned: light that light sampling can find is not counted again when it
/// is met by chance, light that it cannot find counts in full.
const NEVER: f32 = 1e-30;

impl PathTracer<'_> {
    /// How far the ground is along the way to an arrival, if it is met there and within `reach`.
    pub(super) fn ground_distance(
        &self,
        origin: Vec3,
        direction: Vec3,
        arrival: &Arrival,
        reach: f32,
    ) -> Option<f32> {
        let height = origin.y - self.view.ground?;
        let t = height / -direction.y;
        let nearest = match arrival {
            Arrival::Surface(hit) => hit.t,
            Arrival::Escaped => reach,
            Arrival::Exit(_) | Arrival::Ended => return None,
        };
        (height > 0.0 && t > 0.0 && t < nearest).then_some(t)
    }

    /// What a camera ray that meets the ground at `point` sees.
    pub(super) fn catch(&self, path: &Path, point: Vec3, sampler: &mut Sampler) -> Caught {
        let throughput = path.head.throughput;
        let behind = throughput * self.scene.lights.environment_radiance(path.head.direction);
        let anchor = Anchor::at(point, Some(Vec3::Y));
        // The point is off along the ray by some roundings of the largest coordinate.
        let error = Vec3::splat(gamma(8) * (point - path.head.position).abs().max(point.abs()).max_element());
        let leave = |direction: Vec3| offset_origin(point, error, Vec3::Y, direction);
        let (mut with, mut without) = (Vec3::ZERO, Vec3::ZERO);
        let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
        if let Some(light) = self.scene.lights.sample_at(&anchor, u_select, u)
            && light.direction.y > 0.0
        {
            without = light.radiance * (light.direction.y / light.pdf);
            let ray = self.shadow_ray(leave(light.direction), &light);
            with = without * self.transmittance(&ray, path.stack, sampler);
        }
        let local = warp::cosine_hemisphere(sampler.next_2d());
        let direction = Vec3::new(local.x, local.z, -local.y);
        let mut reflected = Path {
            head: PathHead {
                position: leave(direction),
                direction,
                // cos/pdf
                throughput: Vec3::splat(PI),
                events: 0,
                start: None,
                aimed: Aimed::default(),
            },
            stack: path.stack,
            place: None,
            vertex: Vertex {
                point,
                anchor,
                pdf: NEVER,
                connected: true,
                lights: 1.0,
                aimed: Aimed::default(),
            },
            events: path.events + 1,
            passes: path.passes,
            bounces: 1,
            total_reflections: 0,
            wavelength: path.wavelength,
            direct_view: false,
            footprint: Footprint::default(),
            seen: Seen::default(),
        };
        if direction.y > 0.0 {
            let mut gathered = Gathered::new(&[]);
            gathered.sum = with;
            self.follow(&mut reflected, &mut gathered, sampler);
            with = gathered.sum;
        }
        if !(with.is_finite() && without.is_finite()) {
            self.count(|c| c.invalid_samples += 1);
            (with, without) = (Vec3::ZERO, Vec3::ZERO);
        }
        Caught { behind, with, without }
    }
}
