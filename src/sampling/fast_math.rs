//! Exponential and logarithm for the inner loop of random walks: branch-free, inlined, vectorisable.
//!
//! A walk takes a logarithm and three exponentials at each scattering event; calls into the system's mathematics library
//! cost as much as everything else there. Both functions are polynomials after the usual reduction of the exponent (the
//! logarithm with the coefficients of the Cephes library, S. Moshier), accurate to a few units in the last place.

use glam::Vec3;

/// e^x for x ≤ 0, each lane; below −87 it is a number under 2e-38, at −∞ zero.
///
/// Relative error below 3e-7.
#[inline(always)]
pub fn exp_negative(x: Vec3) -> Vec3 {
    Vec3::from_array(x.to_array().map(exp_lane))
}

#[inline(always)]
fn exp_lane(x: f32) -> f32 {
    const LOG2_E: f32 = std::f32::consts::LOG2_E;
    // 2^y = 2^n 2^f with f in [−½, ½].
    let y = x.max(-87.3) * LOG2_E;
    let n = y.round_ties_even();
    // The product again, in two parts, so that f keeps its accuracy where y is large.
    let f = x.max(-87.3).mul_add(LOG2_E, -n);
    let p = 1.535_336_2e-4_f32;
    let p = p.mul_add(f, 1.339_887_4e-3);
    let p = p.mul_add(f, 9.618_437e-3);
    let p = p.mul_add(f, 5.550_332_6e-2);
    let p = p.mul_add(f, 2.402_264_7e-1);
    let p = p.mul_add(f, 6.931_472e-1);
    let p = p.mul_add(f, 1.0);
    // The input is at least −87.3, so n + 127 is at least 1.
    let scale = f32::from_bits((((n as i32) + 127) << 23) as u32);
    if x == f32::NEG_INFINITY { 0.0 } else { p * scale }
}

/// The natural logarithm of a positive normal number.
///
/// Absolute error below 2e-7 around 1, relative error below 2e-7 elsewhere.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    // x = 2^e m with m in [√½, √2).
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let e = (shifted as i32 >> 23) as f32;
    let m = f32::from_bits((shifted & 0x007f_ffff) + SQRT_HALF_BITS) - 1.0;
    let z = m * m;
    let p = 7.037_683_6e-2_f32;
    let p = p.mul_add(m, -1.151_461e-1);
    let p = p.mul_add(m, 1.167_699_9e-1);
    let p = p.mul_add(m, -1.242_014_1e-1);
    let p = p.mul_add(m, 1.424_932_3e-1);
    let p = p.mul_add(m, -1.666_805_8e-1);
    let p = p.mul_add(m, 2.000_071_5e-1);
    let p = p.mul_add(m, -2.499_999_4e-1);
    let p = p.mul_add(m, 3.333_333e-1);
    let p = p * m * z;
    // ln 2 in two parts.
    let low = e.mul_add(-2.121_944_4e-4, p) - 0.5 * z;
    e.mul_add(0.693_359_4, m + low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_accurate() {
        for i in 0..200_000 {
            let x = -(i as f32) * 4e-4;
            let exact = f64::from(x).exp();
            let relative = (f64::from(exp_lane(x)) - exact).abs() / exact;
            assert!(relative < 3e-7 * (1.0 + 0.05 * f64::from(-x)), "exp({x}) is off by {relative:e}");
        }
        assert_eq!(exp_negative(Vec3::new(0.0, f32::NEG_INFINITY, -1e30)).to_array()[..2], [1.0, 0.0]);
        assert!(exp_lane(-1e30) < 2e-38);
    }

    #[test]
    fn the_logarithm_is_accurate() {
        let mut x = 1.2e-38_f32;
        while x < 3e38 {
            let exact = f64::from(x).ln();
            let error = (f64::from(ln(x)) - exact).abs();
            assert!(error < 2e-7 * exact.abs().max(1.0), "ln({x}) is off by {error:e}");
            x *= 1.003_7;
        }
        for i in 1..1 << 16 {
            let x = i as f32 / (1 << 16) as f32;
            let error = (f64::from(ln(x)) - f64::from(x).ln()).abs();
            assert!(error < 2e-7 * f64::from(x).ln().abs().max(1.0), "ln({x}) is off by {error:e}");
        }
    }
}
