//! Exponential and logarithm for the inner loop of random walks: branch-free, inlined, vectorisable.
//!
//! A walk takes three exponentials after every few scattering events, and logarithms where it is guided or connected to
//! light; calls into the system's mathematics library cost as much as everything else there. Both functions are
//! polynomials after the usual reduction of the exponent (the logarithm with the coefficients of the Cephes library, S.
//! Moshier), accurate to a few units in the last place.

use glam::Vec3A;

/// e^x for x ≤ 0, each lane; below −87 it is a number under 2e-38, at −∞ zero.
///
/// Relative error below 3e-7.
#[inline(always)]
pub fn exp_negative(x: Vec3A) -> Vec3A {
    // Four lanes in a loop: the compiler makes one vector of them. (It calls `map` as a function.)
    let [a, b, c] = x.to_array();
    let mut lanes = [a, b, c, c];
    for lane in &mut lanes {
        *lane = exp_lane(*lane);
    }
    Vec3A::new(lanes[0], lanes[1], lanes[2])
}

#[inline(always)]
fn exp_lane(x: f32) -> f32 {
    const LOG2_E: f32 = std::f32::consts::LOG2_E;
    // Adding it leaves a whole number in the low bits.
    const WHOLE: f32 = 12_582_912.0;
    // 2^y = 2^n 2^f with f in [−½, ½].
    let clamped = if x > -87.3 { x } else { -87.3 };
    let shifted = clamped.mul_add(LOG2_E, WHOLE);
    let n = shifted - WHOLE;
    let f = clamped.mul_add(LOG2_E, -n);
    let p = 1.535_336_2e-4_f32;
    let p = p.mul_add(f, 1.339_887_4e-3);
    let p = p.mul_add(f, 9.618_437e-3);
    let p = p.mul_add(f, 5.550_332_6e-2);
    let p = p.mul_add(f, 2.402_264_7e-1);
    let p = p.mul_add(f, 6.931_472e-1);
    let p = p.mul_add(f, 1.0);
    // The input is at least −87.3, so n + 127 is at least 1.
    let scale = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
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

/// Sine and cosine of 2πx for x in [−½, ½].
///
/// Absolute error below 3e-7.
#[inline(always)]
pub fn sin_cos_turns(x: f32) -> (f32, f32) {
    // With y = |x| − ¼, the cosine is −sin 2πy and the sine of |x| is cos 2πy: polynomials in y² (least squares at
    // Chebyshev nodes).
    let y = x.abs() - 0.25;
    let q = y * y;
    let s = 39.760_723_f32;
    let s = s.mul_add(q, -76.581_28);
    let s = s.mul_add(q, 81.602_48);
    let s = s.mul_add(q, -41.341_682);
    let s = s.mul_add(q, 6.283_185_5);
    let c = (-24.981_836_f32).mul_add(q, 60.143_95);
    let c = c.mul_add(q, -85.453_57);
    let c = c.mul_add(q, 64.939_35);
    let c = c.mul_add(q, -19.739_208);
    let c = c.mul_add(q, 1.0);
    (c.copysign(x), -s * y)
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
        assert_eq!(exp_negative(Vec3A::new(0.0, f32::NEG_INFINITY, -1e30)).to_array()[..2], [1.0, 0.0]);
        assert!(exp_lane(-1e30) < 2e-38);
    }

    #[test]
    fn the_sine_and_the_cosine_are_accurate() {
        for i in -100_000..=100_000 {
            let x = i as f32 * 5e-6;
            let (sin, cos) = sin_cos_turns(x);
            let (exact_sin, exact_cos) = (std::f64::consts::TAU * f64::from(x)).sin_cos();
            assert!((f64::from(sin) - exact_sin).abs() < 3e-7, "sin {x}: {sin} for {exact_sin}");
            assert!((f64::from(cos) - exact_cos).abs() < 3e-7, "cos {x}: {cos} for {exact_cos}");
        }
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
