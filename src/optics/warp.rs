//! Small maps of uniform numbers that the lobes share.

use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Largest `f32` below 1.
const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A rescaled uniform number brought back into \[0, 1) after rounding.
#[inline]
pub(super) fn clamp_unit(u: f32) -> f32 {
    u.clamp(0.0, ONE_MINUS_EPSILON)
}

/// A direction about +z with density cos θ/π (Malley's method).
#[inline]
pub(super) fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let r = u.x.sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(r * cos, r * sin, (1.0 - u.x).max(0.0).sqrt())
}

/// A direction about +z with density 1/2π.
#[inline]
pub(super) fn uniform_hemisphere(u: Vec2) -> Vec3 {
    let r = ((1.0 - u.x) * (1.0 + u.x)).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(r * cos, r * sin, u.x)
}

/// Normals of layers are taken to be at least so far above the horizon of directions.
const LEAST_COSINE: f32 = 1e-3;

/// A direction in the frame of a layer that has one of its own, above its horizon.
#[inline]
pub(super) fn tilted(w: Vec3, to_layer: Option<&Mat3>) -> Vec3 {
    let w = to_layer.map_or(w, |m| *m * w);
    if w.z >= LEAST_COSINE { w } else { Vec3::new(w.x, w.y, LEAST_COSINE).normalize() }
}

/// One more uniform number in \[0, 1) out of three that are already spent: a hash of their bits (the finaliser of
/// MurmurHash3). Used for the azimuth of light that lost its direction, after a rejection that depends on `u`.
#[inline]
pub(super) fn scramble(u: Vec2, u_lobe: f32) -> f32 {
    let mut x = u64::from(u.x.to_bits()) << 32 | u64::from(u.y.to_bits());
    x ^= u64::from(u_lobe.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x ^= x >> 33;
    x = x.wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    x ^= x >> 33;
    x = x.wrapping_mul(0xC4CE_B9FE_1A85_EC53);
    x ^= x >> 33;
    (x >> 40) as f32 * (1.0 / 16_777_216.0)
}

/// Which of some probabilities (that add up to 1) `u` falls into, and `u` rescaled within it.
#[inline]
pub(super) fn choose<const N: usize>(probabilities: &[f32; N], u: f32) -> (usize, f32) {
    let mut left = u;
    let mut last = 0;
    for (k, &p) in probabilities.iter().enumerate().filter(|(_, p)| **p > 0.0) {
        last = k;
        if left < p {
            return (k, clamp_unit(left / p));
        }
        left -= p;
    }
    (last, ONE_MINUS_EPSILON)
}
