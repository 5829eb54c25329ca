//! Jumps of a walk across spheres: many scattering events at once, deep inside of an object.
//!
//! At an event far from the boundary all that matters is how the light leaves a sphere about it. Where scattering is
//! isotropic it leaves anywhere on the sphere alike; what is left of each channel is tabulated ([`Sphere`]), and so is
//! the angle to the normal under which it leaves. Compare the shells of Moon, Walter & Marschner 2008 and Müller et al.
//! 2016.
//!
//! Where scattering is not isotropic the walk jumps as one of isotropic scattering σs* does that absorbs as much and in
//! which light decays over the same length ([`equivalent`]). After an event it takes one free flight of that medium,
//! which carries it as far as the memory of its direction does on average, is weighed for all channels like any flight,
//! and ends in an event. The sphere is about that. A flight that comes too near to the boundary is cut there, and the
//! walk goes on step by step.
//!
//! Two things are approximated:
//!
//! - the angle is that of light without absorption, and from 16 mean free paths on that of a sphere of 16. It is
//!   forgotten after one free flight;
//! - media that scatter forward are not their equivalents, near a source or a boundary, and the less the more is absorbed.
//!   So walks jump only through spheres of [`NOT_SIMILAR`] radii more, and not at all where a channel absorbs more
//!   than [`MOST_ABSORBED`].

use super::guide::{Plain, Steering};
use super::spectral::Coefficients;
use super::steps::uniform_direction;
use crate::optics::diffusion::sphere::{Sphere, equivalent};
use crate::sampling::{SmallRng, fast_math, orthonormal_basis};
use glam::{Mat3, Vec3, Vec3A};
use std::sync::OnceLock;

/// Least radius in the longest transport mean free path.
const LEAST: f32 = 2.0;
/// Radii that are skipped where scattering is not isotropic: similarity needs more room.
const NOT_SIMILAR: usize = 2;
/// Most that is lost in an event of the equivalent medium where scattering is not isotropic.
const MOST_ABSORBED: f64 = 0.01;
/// Radii to a doubling.
const STEPS: f32 = 2.0;
/// Most radii.
const MOST: usize = 24;
/// Radii with angles of their own.
const ANGLES: usize = 7;
/// Angles of each.
const SAMPLES: usize = 8192;

/// The spheres of one medium.
pub(super) struct SphereJumps {
    /// Radii, rising by a factor of 2^{1/[`STEPS`]} from [`LEAST`] on, in the units of the walk.
    radii: Vec<f32>,
    /// T of each radius.
    through: Vec<Vec3A>,
    /// Radii that have been skipped.
    skipped: usize,
    /// The equivalent medium, where scattering is not isotropic.
    flights: Option<Coefficients>,
    /// Room that a jump needs.
    room: f32,
}

impl SphereJumps {
    /// For coefficients in the units of the walk, in an object of the given size; `None` where a channel is clear or absorbs
    /// too much, or no sphere fits.
    pub fn new(sigma_a: Vec3, sigma_s: Vec3, g: f32, size: f32) -> Option<Self> {
        let sigma_t = sigma_a + sigma_s;
        if !(g >= 0.0 && sigma_t.min_element() > 0.0 && sigma_t.is_finite()) {
            return None;
        }
        let media = [0, 1, 2].map(|i| equivalent(f64::from(sigma_s[i] / sigma_t[i]), f64::from(g)));
        let extinction = sigma_t * Vec3::from_array(media.map(|m| m.1 as f32));
        let longest = extinction.min_element().recip();
        if !longest.is_finite() || g > 0.0 && media.iter().any(|m| m.0 < 1.0 - MOST_ABSORBED) {
            return None;
        }
        let skipped = if g > 0.0 { NOT_SIMILAR } else { 0 };
        let flight = if g > 0.0 { longest } else { 0.0 };
        let radii: Vec<f32> = (skipped..MOST)
            .map(|i| LEAST * longest * (i as f32 / STEPS).exp2())
            .take_while(|radius| radius + flight < 0.5 * size)
            .collect();
        let room = radii.first()? + flight;
        let spheres = media.map(|m| Sphere::new(m.0));
        let left = |radius: f32, i: usize| {
            spheres[i].transmittance(f64::from(radius) * f64::from(extinction[i])) as f32
        };
        let through = radii.iter().map(|&r| Vec3A::new(left(r, 0), left(r, 1), left(r, 2))).collect();
        let scattering = extinction - sigma_a;
        let flights = (g > 0.0).then(|| Coefficients::of_one_event(sigma_a, scattering, 0.0));
        Some(Self { radii, through, skipped, flights, room })
    }
}

/// Plain walks that jump.
pub(super) struct Jumping<'a>(pub &'a SphereJumps);

impl Steering for Jumping<'_> {
    const GUIDED: bool = false;
    type Stretch<'b>
        = Plain
    where
        Self: 'b;

    #[inline]
    fn stretch(&self, _: usize, _: Vec3, _: Vec3, _: &mut SmallRng) -> Plain {
        Plain
    }

    #[inline]
    fn room(&self) -> f32 {
        self.0.room
    }

    fn jump(
        &self,
        c: &Coefficients,
        (p, d, beta): (Vec3, Vec3, Vec3A),
        clear: f32,
        rng: &mut SmallRng,
    ) -> (Vec3, Vec3, Vec3A) {
        let jumps = self.0;
        let (mut p, mut beta, mut clear) = (p, beta, clear);
        if let Some(medium) = &jumps.flights {
            let d = c.phase.sample(d, rng.vec2()).0;
            let flight = rng.exponential() * medium.draw_channel(beta, rng).1;
            let most = clear - jumps.radii[0];
            if flight >= most {
                return (p + d * most, d, medium.weigh(beta, 0, most));
            }
            p += d * flight;
            beta = medium.weigh(beta, 1, flight);
            clear -= flight;
        }
        let i = jumps.radii.partition_point(|&radius| radius <= clear).max(1) - 1;
        let normal = uniform_direction(rng);
        let angles = angles(jumps.skipped + i);
        let cos = angles[((rng.f32() * SAMPLES as f32) as usize).min(SAMPLES - 1)];
        let (x, y) = orthonormal_basis(normal);
        let (sin_phi, cos_phi) = fast_math::sin_cos_turns(rng.f32() - 0.5);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let direction = Mat3::from_cols(x, y, normal) * Vec3::new(sin * cos_phi, sin * sin_phi, cos);
        (p + normal * jumps.radii[i], direction.normalize(), beta * jumps.through[i])
    }
}

/// Cosines to the normal under which light leaves a sphere of the `i`th radius from its middle.
fn angles(i: usize) -> &'static [f32] {
    static ANGLES_OF: [OnceLock<Vec<f32>>; ANGLES] = [const { OnceLock::new() }; ANGLES];
    let i = i.min(ANGLES - 1);
    ANGLES_OF[i].get_or_init(|| {
        let radius = LEAST * (i as f32 / STEPS).exp2();
        (0..SAMPLES as u32)
            .map(|sample| leave(radius, &mut SmallRng::for_sample(sample, i as u32, 0)))
            .collect()
    })
}

/// The cosine of one walk without absorption.
fn leave(radius: f32, rng: &mut SmallRng) -> f32 {
    let mut p = Vec3::ZERO;
    loop {
        let d = uniform_direction(rng);
        let next = p + d * rng.exponential();
        if next.length_squared() > radius * radius {
            // |p + d s| = radius.
            let along = p.dot(d);
            let s = -along + (along * along + radius * radius - p.length_squared()).max(0.0).sqrt();
            return ((p + d * s).dot(d) / radius).clamp(0.0, 1.0);
        }
        p = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body, extinctions, albedos, and what leaves of each channel.
    type Case = (Body, [f32; 3], [f32; 3], [(f64, f64); 3]);
    #[rustfmt::skip]
    const BODIES: [Case; 3] = [
        (Body::Ball(75.0), [1.0, 2.0, 2.0], [0.999, 0.999, 0.9999], [(0.728_544, 0.000_23), (0.359_105, 0.000_94), (0.886_520, 0.000_13)]),
        (Body::Ball(150.0), [1.0; 3], [0.9999, 0.999, 0.999], [(0.886_520, 0.000_13), (0.359_105, 0.000_94), (0.359_105, 0.000_94)]),
        (Body::Slab(120.0), [1.0; 3], [1.0, 0.9999, 0.999], [(0.126_366, 0.002_15), (0.115_809, 0.002_15), (0.058_587, 0.002_34)]),
    ];

    /// Light leaves a large sphere as it leaves a half space of Milne's problem, with a mean cosine of 0.7104 (Hopf's
    /// constant); from a small one it leaves more steeply. Standard error of a mean: 0.003; a sphere of 16 mean free
    /// paths is still curved, for which 0.01 are allowed.
    #[test]
    fn angles_come_near_to_those_of_milnes_problem() {
        let mean = |i| angles(i).iter().sum::<f32>() / SAMPLES as f32;
        assert!((mean(ANGLES - 1) - 0.7104).abs() < 0.02, "{}", mean(ANGLES - 1));
        assert!(mean(0) > mean(ANGLES - 1));
    }

    /// Out of a larger sphere step by step and with a jump first: the weight of each channel, and how far the walk has
    /// come in the direction in which it set out. 4 standard errors, and 0.5 %, which is what the accelerated walk may
    /// be off.
    #[test]
    fn jumps_lead_where_walks_lead() {
        for (g, sigma_a) in [(0.0, Vec3::new(0.001, 0.01, 0.05)), (0.6, Vec3::new(0.0005, 0.001, 0.002))] {
            let sigma_s = Vec3::ONE - sigma_a; // A mean free path of 1, and σs the albedo.
            let c = Coefficients::new(sigma_a, sigma_s, g, 1.0);
            let jumps = SphereJumps::new(sigma_a, sigma_s, g, 1000.0).expect("room");
            // Moments after the walk has left a sphere of radius R about the event: it goes on as a plain one from there.
            let radius = 2.0 * jumps.radii[0] + 4.0 * g / (1.0 - g);
            let run = |jumping: bool| {
                const N: u32 = 40_000;
                let mut rng = SmallRng::new(9);
                let (mut sum, mut squares) = ([0.0f64; 4], [0.0f64; 4]);
                for _ in 0..N {
                    let (mut p, mut d, mut beta) = (Vec3::ZERO, Vec3::Z, Vec3A::ONE);
                    if jumping {
                        (p, d, beta) = Jumping(&jumps).jump(&c, (p, d, beta), jumps.room * 1.0001, &mut rng);
                    } else {
                        d = c.phase.sample(d, rng.vec2()).0;
                    }
                    loop {
                        p -= d * rng.open01().ln();
                        if p.length() > radius {
                            break;
                        }
                        beta *= Vec3A::from(sigma_s);
                        d = c.phase.sample(d, rng.vec2()).0;
                    }
                    let values = [beta.x, beta.y, beta.z, p.z * beta.x / radius].map(f64::from);
                    for i in 0..4 {
                        sum[i] += values[i];
                        squares[i] += values[i] * values[i];
                    }
                }
                let n = f64::from(N);
                [0, 1, 2, 3].map(|i| (sum[i] / n, (squares[i] / n - (sum[i] / n).powi(2)) / n))
            };
            let (walked, jumped) = (run(false), run(true));
            for i in 0..4 {
                let error = (walked[i].1 + jumped[i].1).sqrt().hypot(0.005 * walked[i].0 / 4.0);
                let z = (walked[i].0 - jumped[i].0) / error;
                println!("g {g} moment {i}: {:?} {:?} z {z:.2}", walked[i], jumped[i]);
                assert!(z.abs() < 4.0, "g {g}, moment {i}: {:?} {:?}", walked[i], jumped[i]);
            }
        }
    }

    /// A body without a boundary that reflects.
    #[derive(Clone, Copy)]
    enum Body {
        /// About the origin, of a radius; light sets out in its middle.
        Ball(f32),
        /// From z = 0 on, of a thickness; light sets out along z and counts where it leaves on the far side.
        Slab(f32),
    }

    impl Body {
        fn clear(self, p: Vec3) -> f32 {
            match self {
                Self::Ball(radius) => radius - p.length(),
                Self::Slab(thickness) => p.z.min(thickness - p.z),
            }
        }

        /// How far it is to the boundary.
        fn ahead(self, p: Vec3, d: Vec3) -> f32 {
            match self {
                Self::Ball(radius) => {
                    let along = p.dot(d);
                    -along + (along * along + radius * radius - p.length_squared()).max(0.0).sqrt()
                }
                Self::Slab(thickness) => (if d.z > 0.0 { thickness - p.z } else { -p.z }) / d.z,
            }
        }
    }

    /// Light of each channel that gets out of a body with jumps wherever there is room: mean and standard error.
    fn out_of(body: Body, (sigma_a, sigma_s): (Vec3, Vec3), g: f32, walks: u32) -> [(f64, f64); 3] {
        let c = Coefficients::new(sigma_a, sigma_s, g, 1.0);
        let size = match body {
            Body::Ball(radius) => 2.0 * radius,
            Body::Slab(thickness) => thickness,
        };
        let jumps = SphereJumps::new(sigma_a, sigma_s, g, size).expect("room");
        let mut rng = SmallRng::new(11);
        let (mut sum, mut squares) = ([0.0f64; 3], [0.0f64; 3]);
        for _ in 0..walks {
            let d = uniform_direction(&mut rng);
            let d = if matches!(body, Body::Ball(_)) { d } else { Vec3::Z };
            let (mut p, mut d, mut beta) = (Vec3::ZERO, d, Vec3A::ONE);
            loop {
                let t = rng.exponential() * c.draw_channel(beta, &mut rng).1;
                let ahead = body.ahead(p, d);
                if t >= ahead {
                    beta = c.weigh(beta, 0, ahead);
                    if matches!(body, Body::Slab(_)) && d.z < 0.0 {
                        beta = Vec3A::ZERO;
                    }
                    break;
                }
                p += d * t;
                beta = c.weigh(beta, 1, t);
                let clear = body.clear(p);
                if clear >= jumps.room {
                    (p, d, beta) = Jumping(&jumps).jump(&c, (p, d, beta), clear, &mut rng);
                } else {
                    d = c.phase.sample(d, rng.vec2()).0;
                }
            }
            for i in 0..3 {
                sum[i] += f64::from(beta[i]);
                squares[i] += f64::from(beta[i]).powi(2);
            }
        }
        let n = f64::from(walks);
        [0, 1, 2].map(|i| (sum[i] / n, ((squares[i] / n - (sum[i] / n).powi(2)) / n).sqrt()))
    }

    /// The middle of a ball of 7.5 to 15 transport mean free paths and a slab of 12, where g = 0.9, and channels whose mean
    /// free paths and albedos differ, so that they are weighed against each other in flights and jumps. References are
    /// plain walks of another program, with their relative standard errors. Four standard errors, and the 0.5 % that the
    /// accelerated walk may be off.
    #[test]
    fn bodies_let_out_what_plain_walks_do() {
        for (body, sigma_t, albedo, expected) in BODIES {
            let (sigma_t, albedo) = (Vec3::from_array(sigma_t), Vec3::from_array(albedo));
            let found = out_of(body, (sigma_t * (Vec3::ONE - albedo), sigma_t * albedo), 0.9, 100_000);
            for i in 0..3 {
                let ((mean, se), (value, relative)) = (found[i], expected[i]);
                let off = mean / value - 1.0;
                let noise = (se / value).hypot(relative);
                println!("{sigma_t} {albedo} [{i}]: {mean} for {value}, {off:+.4} ± {noise:.4}");
                assert!(off.abs() < 0.005 + 4.0 * noise, "{sigma_t} {albedo} [{i}]: {mean} is not {value}");
            }
        }
    }

    /// Where a channel absorbs more than the equivalent medium can stand for, forward scattering is followed step by step.
    #[test]
    fn media_that_absorb_more_are_not_jumped_through() {
        let jumps = |albedo: Vec3, g| SphereJumps::new(Vec3::ONE - albedo, albedo, g, 1e4).is_some();
        assert!(jumps(Vec3::splat(0.9995), 0.9) && !jumps(Vec3::new(0.9995, 0.99, 0.9995), 0.9));
        assert!(jumps(Vec3::splat(0.5), 0.0), "isotropic media need no equivalent");
    }
}
