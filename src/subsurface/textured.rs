//! The random walk where coefficients come from textures: delta tracking against the factors.
//!
//! σ at an interior point is that of its nearest boundary point, so the medium is a function of position, the same for
//! every path. Textures multiply the factors and are at most 1, so the factors bound them: tentative collisions are
//! drawn from one majorant M = max_k σt_k, and each is real or null.
//!
//! **Spectral weights** (null-scattering path integral, Miller, Georgiev & Jarosz 2019). At a tentative collision let
//! σn = M − σt ≥ 0 for each channel. It is real with probability P = Σβσs / Σβ(σs + σn), and then
//! β ← β σs/(M P); otherwise β ← β σn/(M (1−P)). Either way Σβ' = Σβ(σs + σn)/M ≤ Σβ. (Counting null collisions of the
//! clearer channels as scattering would gain energy; the coloured furnace shows it.)
//!
//! The nearest boundary point of the last event bounds the next search: it is at most the distance travelled farther.

use super::random_walk::{scatter, survival};
use super::{Arrival, Connection, Connector, Flight, PathHead};
use crate::geometry::Ray;
use crate::sampling::{Sampler, SmallRng};
use crate::scene::{Scene, Surface};
use crate::transport::Enclosure;
use glam::{Vec2, Vec3};

/// The coefficients of one object as a function of position.
pub struct TexturedMedium<'a> {
    scene: &'a Scene,
    enclosure: Enclosure,
    /// Where the last look-up was, in local space, and how far its boundary point.
    last: Option<(Vec3, f32)>,
}

impl<'a> TexturedMedium<'a> {
    /// Coefficients of the medium of `enclosure`.
    pub fn new(scene: &'a Scene, enclosure: Enclosure) -> Self {
        Self { scene, enclosure, last: None }
    }

    /// (σa, σs) at a world position, 1/m.
    pub fn coefficients(&mut self, position: Vec3) -> (Vec3, Vec3) {
        let Some(medium) = &self.scene.material(self.enclosure.material).medium else {
            return (Vec3::ZERO, Vec3::ZERO);
        };
        let instance = self.enclosure.instance;
        let mesh = self.scene.geometry.mesh_of(instance);
        let p = self.scene.geometry.transform(instance).inverse_point(position);
        // A little slack, so that rounding cannot exclude the very point that gave the bound.
        let reach = self.last.map_or(f32::INFINITY, |(q, r)| (r + p.distance(q)) * (1.0 + 1e-4));
        let nearest = mesh.nearest(p, reach).or_else(|| mesh.nearest(p, f32::INFINITY));
        let Some(nearest) = nearest else { return (medium.sigma_a, medium.sigma_s) };
        self.last = Some((p, nearest.distance));
        let point = Surface {
            position,
            error: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            normal: Vec3::Z,
            instance,
            triangle: nearest.triangle,
            barycentric: Vec2::new(nearest.u, nearest.v),
            material: self.enclosure.material,
        };
        let factor = |texture: &Option<_>| match texture {
            Some(t) => point.texture(self.scene, t).truncate().clamp(Vec3::ZERO, Vec3::ONE),
            None => Vec3::ONE,
        };
        (
            medium.sigma_a * factor(&medium.absorption_texture),
            medium.sigma_s * factor(&medium.scattering_texture),
            footprint: 0.0,
        )
    }

    /// An unbiased estimate of the transmittance over a segment that stays in the medium (ratio tracking).
    pub fn transmittance(&mut self, origin: Vec3, direction: Vec3, length: f32, rng: &mut SmallRng) -> Vec3 {
        let Some(medium) = &self.scene.material(self.enclosure.material).medium else { return Vec3::ONE };
        let majorant = (medium.sigma_a + medium.sigma_s).max_element();
        if majorant <= 0.0 {
            return Vec3::ONE;
        }
        let (mut t, mut transmittance) = (0.0, Vec3::ONE);
        loop {
            t -= rng.open01().ln() / majorant;
            if t >= length {
                return transmittance;
            }
            let (sigma_a, sigma_s) = self.coefficients(origin + direction * t);
            transmittance *= Vec3::ONE - (sigma_a + sigma_s) / majorant;
            transmittance *= survival(transmittance.max_element(), rng);
            if transmittance.max_element() <= 0.0 {
                return Vec3::ZERO;
            }
        }
    }
}

/// Follows a path through a textured medium.
pub(super) fn propagate(
    flight: &Flight<'_>,
    head: &mut PathHead,
    sampler: &mut Sampler,
    connector: &mut dyn Connector,
) -> Arrival {
    let medium = flight.medium;
    let majorant = medium.sigma_t.max_element();
    let radiance_scale = medium.ior * medium.ior;
    let mut textured = TexturedMedium::new(flight.scene, flight.enclosure);
    let alone = flight.object.isolated;
    let straight = flight.connection == Connection::Straight;
    loop {
        let t = if majorant > 0.0 { -sampler.rng().open01().ln() / majorant } else { f32::INFINITY };
        let ray = Ray { origin: head.position, direction: head.direction, t_max: t };
        let geometry = &flight.scene.geometry;
        let hit = if alone {
            geometry.intersect_instance(flight.enclosure.instance, &ray)
        } else {
            geometry.intersect(&ray)
        };
        if let Some(hit) = hit {
            head.position += head.direction * hit.t;
            return Arrival::Surface(hit);
        }
        if t == f32::INFINITY {
            return Arrival::Escaped;
        }
        head.position += head.direction * t;
        let (sigma_a, sigma_s) = textured.coefficients(head.position);
        let sigma_n = (Vec3::splat(majorant) - sigma_a - sigma_s).max(Vec3::ZERO);
        let scattered = (head.throughput * sigma_s).element_sum();
        let total = scattered + (head.throughput * sigma_n).element_sum();
        if total <= 0.0 {
            return Arrival::Ended;
        }
        let real = scattered / total;
        if sampler.rng().f32() < real {
            head.throughput *= sigma_s / (majorant * real);
            if !scatter(head, medium.phase(), sampler, straight.then_some(&mut *connector)) {
                return Arrival::Ended;
            }
        } else {
            head.throughput *= sigma_n / (majorant * (1.0 - real));
            head.events += 1;
        }
        head.throughput *= survival(head.throughput.max_element() * radiance_scale, sampler.rng());
        if head.events >= flight.budget || head.throughput.max_element() <= 0.0 {
            return Arrival::Ended;
        }
    }
}
