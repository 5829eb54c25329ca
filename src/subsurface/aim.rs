//! Directions inside a medium that lead through its boundary to light.
//!
//! A walk that meets a boundary in a random direction rarely refracts towards a lamp: for a rough boundary of GGX width
//! α only directions within about α(1 − 1/η) of the right one do. So directions are also *aimed*: choose a beacon
//! ([`crate::light::beacon`]) in the outside direction ω_o, a microfacet normal m of the boundary near by with density
//! D(m) |m·n|, and refract: ω = −refract(ω_o, m). The density of ω follows from the Jacobian of the half vector (Walter
//! et al. 2007, eq. 17), so it can be told for any direction, however found:
//!
//! ```text
//! q(ω) = Σ_k w_k D_k(h_k) |h_k·n| η² |ω·h_k| / (ω_o,k·h_k − η ω·h_k)²,   h_k ∝ η ω − ω_o,k
//! ```
//!
//! D_k is wider than the boundary's own, to cover the size of the light and the curvature of the surface.

use crate::light::beacon::{Beacon, MOST};
use crate::optics::{fresnel, ggx};
use crate::sampling::{SmallRng, orthonormal_basis};
use glam::{Mat3, Vec3};
use std::f32::consts::TAU;

/// How much wider than the boundary's own roughness the lobes are.
const WIDENING: f32 = 1.2;
/// Width that covers the bending of the surface between the nearest point and where the light comes out.
const CURVATURE: f32 = 0.06;
/// Widest lobe.
const WIDEST: f32 = 0.8;

#[derive(Clone, Copy, Debug, Default)]
struct Lobe {
    /// Towards the light, in the frame of the boundary.
    outside: Vec3,
    alpha: f32,
    /// Share of this lobe, and of all up to it.
    share: f32,
    cumulative: f32,
}

/// A mixture of aimed directions at one point.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    frame: Mat3,
    eta: f32,
    lobes: [Lobe; MOST],
    len: usize,
}

impl Default for Aim {
    fn default() -> Self {
        Self { frame: Mat3::IDENTITY, eta: 1.0, lobes: [Lobe::default(); MOST], len: 0 }
    }
}

impl Aim {
    /// Aims from a point below a boundary with the outward unit normal `normal` near by; `alpha` is its GGX width, `eta` the
    /// index inside over outside (> 1). False: there is nothing to aim at.
    pub fn set(&mut self, beacons: &[Beacon], point: Vec3, normal: Vec3, eta: f32, alpha: f32) -> bool {
        let (x, y) = orthonormal_basis(normal);
        self.frame = Mat3::from_cols(x, y, normal);
        self.eta = eta;
        self.len = 0;
        let mut total = 0.0;
        for beacon in beacons {
            let seen = beacon.seen_from(point);
            let outside = self.frame.transpose() * seen.direction;
            // Large lights shine from above the horizon though their middle is below.
            let cosine = outside.z + 0.5 * seen.radius;
            if cosine <= 0.02 {
                continue;
            }
            let size = seen.radius / (eta - 1.0);
            let width = (WIDENING * alpha).hypot(CURVATURE).hypot(size).min(WIDEST);
            let share = seen.irradiance * cosine.min(1.0);
            total += share;
            self.lobes[self.len] = Lobe { outside, alpha: width, share, cumulative: total };
            self.len += 1;
        }
        if total <= 0.0 || !total.is_finite() {
            return false;
        }
        for lobe in &mut self.lobes[..self.len] {
            lobe.share /= total;
            lobe.cumulative /= total;
        }
        true
    }

    /// A unit direction of travel and its density per steradian.
    pub fn sample(&self, rng: &mut SmallRng) -> Option<(Vec3, f32)> {
        let u = rng.f32();
        let lobes = &self.lobes[..self.len];
        let lobe = lobes.iter().find(|l| u < l.cumulative).or(lobes.last())?;
        let (u, phi) = (rng.f32(), TAU * rng.f32());
        // D(m) |m·n|: tan²θ = α² u/(1 − u).
        let tan = lobe.alpha * (u / (1.0 - u)).sqrt();
        let m = Vec3::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalize();
        if lobe.outside.dot(m) <= 0.0 {
            return None;
        }
        let direction = -fresnel::refract(lobe.outside, m, self.eta)?.normalize();
        let pdf = self.pdf_local(direction);
        (pdf > 0.0).then(|| (self.frame * direction, pdf))
    }

    /// Density of [`Aim::sample`] at a unit direction of travel.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.pdf_local(self.frame.transpose() * direction)
    }

    fn pdf_local(&self, direction: Vec3) -> f32 {
        self.lobes[..self.len].iter().map(|l| l.share * self.lobe_pdf(l, direction)).sum()
    }

    fn lobe_pdf(&self, lobe: &Lobe, direction: Vec3) -> f32 {
        let half = self.eta * direction - lobe.outside;
        let length = half.length();
        if length <= 0.0 {
            return 0.0;
        }
        let h = half / length;
        let (cos_o, cos_i) = (lobe.outside.dot(h), direction.dot(h));
        if h.z <= 0.0 || cos_o <= 0.0 || cos_i <= 0.0 {
            return 0.0;
        }
        // |ω_o·h − η ω·h| is the length of the unnormalised half vector.
        ggx::distribution(h, lobe.alpha) * h.z * self.eta * self.eta * cos_i / (length * length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Lights, beacon::beacons};
    use crate::scene::{EnvironmentDescription, PunctualKind, PunctualLight};

    fn aim() -> Aim {
        let light = |x: f32, y: f32, z: f32| PunctualLight {
            name: String::new(),
            intensity: Vec3::ONE,
            position: Vec3::new(x, y, z),
            direction: Vec3::NEG_Z,
            range: None,
            kind: PunctualKind::Point,
        };
        let punctual = [light(1.0, 0.0, 1.0), light(-2.0, 1.0, 0.5)];
        let environment = EnvironmentDescription::default();
        let lights = Lights::build(Vec::new(), &punctual, &environment, (Vec3::NEG_ONE, Vec3::ONE));
        let mut aim = Aim::default();
        assert!(aim.set(
            &beacons(&lights, &punctual),
            Vec3::ZERO,
            Vec3::new(0.1, 0.2, 0.97).normalize(),
            1.4,
            0.3
        ));
        aim
    }

    #[test]
    fn the_density_is_that_of_the_samples() {
        // E_q[g/q] over the sampler must be the integral of g where q > 0; with g = a test function both sides are
        // computed: sampling, and uniform directions. |z| < 4.
        let aim = aim();
        let g = |d: Vec3| (1.0 + d.z).powi(2);
        let mut rng = SmallRng::new(7);
        const N: usize = 400_000;
        let (mut a, mut a2, mut b, mut b2, mut hits) = (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0u32);
        for _ in 0..N {
            if let Some((d, _)) = aim.sample(&mut rng) {
                let v = f64::from(g(d));
                a += v;
                a2 += v * v;
                hits += 1;
            }
            let d = crate::sampling::warp::uniform_sphere(rng.vec2());
            let v = f64::from(g(d) * aim.pdf(d) * 4.0 * std::f32::consts::PI);
            b += v;
            b2 += v * v;
        }
        let n = N as f64;
        let (ma, mb) = (a / n, b / n);
        let variance = (a2 / n - ma * ma + b2 / n - mb * mb) / n;
        let z = (ma - mb) / variance.sqrt();
        assert!(hits > N as u32 / 2);
        assert!(z.abs() < 4.0, "{ma} against {mb}, z {z}");
    }
}
