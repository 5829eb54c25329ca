//! What the tests of this room share: random numbers, integration over directions, and a χ² test of a sampler.

use super::BsdfSample;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// PCG-XSH-RS 32 with a fixed stream.
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        let mut rng = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        rng.next();
        rng
    }

    pub fn next(&mut self) -> f32 {
        let x = self.0;
        self.0 = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let bits = (((x >> 22) ^ x) >> (22 + (x >> 61))) as u32;
        (bits >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    pub fn vec2(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }
}

pub fn direction(cos: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), cos)
}

/// ∫ f dω over the hemisphere above (`sign` 1) or below (−1), for f even in the azimuth about the x axis. One random
/// point in each cell of a grid: lobes of rough boundaries end abruptly where facets turn over, which regular nodes
/// would alias.
pub fn hemisphere(sign: f32, steps: usize, f: impl Fn(Vec3) -> f32) -> f32 {
    let mut rng = Rng::new(steps as u64);
    let (n, m) = (steps as f32, (steps / 2) as f32);
    let mut sum = 0.0f64;
    for i in 0..steps {
        for j in 0..steps / 2 {
            let u = rng.vec2();
            let theta = 0.5 * PI * (i as f32 + u.x) / n;
            let w = direction(theta.cos() * sign, PI * (j as f32 + u.y) / m);
            sum += f64::from(f(w) * theta.sin());
        }
    }
    (sum * f64::from(0.5 * PI / n) * f64::from(TAU / m)) as f32
}

/// Compares a histogram of samples with the integral of their density over each bin; deltas and lost samples must be
/// neither. Returns the z score of χ² (Wilson & Hilferty 1931).
pub fn chi_square(
    seed: u64,
    samples: usize,
    pdf: impl Fn(Vec3) -> f32,
    mut sample: impl FnMut(&mut Rng) -> Option<BsdfSample>,
) -> f64 {
    const COS: usize = 24;
    const PHI: usize = 16;
    const SUB: usize = 12;
    let mut rng = Rng::new(seed);
    let mut observed = vec![0.0f64; COS * PHI];
    for _ in 0..samples {
        if let Some(s) = sample(&mut rng).filter(|s| !s.delta) {
            let i = ((0.5 * (s.wi.z + 1.0)) * COS as f32) as usize;
            let phi = s.wi.y.atan2(s.wi.x) / TAU;
            let j = ((phi - phi.floor()) * PHI as f32) as usize;
            observed[i.min(COS - 1) * PHI + j.min(PHI - 1)] += 1.0;
        }
    }
    let (mut chi2, mut bins) = (0.0, 0.0);
    let mut pooled = (0.0, 0.0);
    for i in 0..COS {
        for j in 0..PHI {
            let mut expected = 0.0f64;
            for a in 0..SUB {
                for b in 0..SUB {
                    let cos = 2.0 * (i as f32 + (a as f32 + 0.5) / SUB as f32) / COS as f32 - 1.0;
                    let phi = TAU * (j as f32 + (b as f32 + 0.5) / SUB as f32) / PHI as f32;
                    expected += f64::from(pdf(direction(cos, phi)));
                }
            }
            expected *= f64::from(2.0 * TAU) / (COS * PHI * SUB * SUB) as f64 * samples as f64;
            let seen = observed[i * PHI + j];
            if expected < 8.0 {
                pooled = (pooled.0 + expected, pooled.1 + seen);
            } else {
                chi2 += (seen - expected).powi(2) / expected;
                bins += 1.0;
            }
        }
    }
    if pooled.0 >= 8.0 {
        chi2 += (pooled.1 - pooled.0).powi(2) / pooled.0;
        bins += 1.0;
    } else {
        assert!(pooled.1 < pooled.0 + 30.0, "{} samples where {} are expected", pooled.1, pooled.0);
    }
    let k = f64::max(bins - 1.0, 1.0);
    ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}
