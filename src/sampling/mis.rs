//! Weights of multiple importance sampling (Veach & Guibas 1995) for two techniques with one sample each.
//!
//! Both weights are 1 for an infinite `pdf`, 0 for an infinite `other`, and never NaN for densities ≥ 0.

/// `pdf / (pdf + other)`.
#[inline]
pub fn balance_heuristic(pdf: f32, other: f32) -> f32 {
    if pdf > 0.0 { 1.0 / (1.0 + other / pdf) } else { 0.0 }
}

/// `pdf² / (pdf² + other²)`, computed so that no square overflows.
#[inline]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    if pdf > 0.0 {
        let ratio = other / pdf;
        1.0 / (1.0 + ratio * ratio)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_two_techniques_sum_to_one() {
        for (a, b) in [(1.0, 2.0), (1e-30, 1e30), (3e38, 1e38), (0.5, 0.0), (1e-38, 1e-38)] {
            for weight in [balance_heuristic, power_heuristic] {
                assert!((weight(a, b) + weight(b, a) - 1.0).abs() < 1e-6, "{a} {b}");
            }
        }
        assert_eq!(balance_heuristic(0.0, 0.0), 0.0);
        assert!((balance_heuristic(1.0, 3.0) - 0.25).abs() < 1e-7);
        assert!((power_heuristic(1.0, 3.0) - 0.1).abs() < 1e-7);
        assert_eq!(power_heuristic(f32::INFINITY, 1.0), 1.0);
        assert_eq!(power_heuristic(1.0, f32::INFINITY), 0.0);
    }
}
