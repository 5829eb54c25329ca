//! Henyey–Greenstein in double precision (Henyey & Greenstein 1941). `cos` is between the directions of propagation
//! before and after, 1 is straight on; `g` the mean cosine, in (−1, 1). Sampling as in [`crate::optics::phase`].

use std::f64::consts::PI;

/// (1 − g²)/(4π(1 + g² − 2g cos)^{3/2}), per steradian.
pub fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    let d = spread(g, cos);
    (1.0 - g) * (1.0 + g) / (4.0 * PI * d * d.sqrt())
}

/// The probability in \[0, 1\] that the cosine of the deflection is at most `cos`.
///
/// (1 − g²)/(2g) (1/√(1 + g² − 2g cos) − 1/(1 + g)), with the difference taken apart so that g = 0 needs no case.
pub fn henyey_greenstein_cdf(g: f64, cos: f64) -> f64 {
    let root = spread(g, cos).sqrt();
    (1.0 - g) * (1.0 + cos) / (root * (1.0 + g + root))
}

/// The cosine in \[−1, 1\] whose [`henyey_greenstein_cdf`] is `xi` in \[0, 1\].
pub fn henyey_greenstein_inverse(g: f64, xi: f64) -> f64 {
    let d = (1.0 - g) + 2.0 * g * xi;
    let plus = (1.0 + g) * (1.0 + g) * xi * (1.0 - g * (1.0 - xi)) * 2.0 / (d * d);
    let minus = (1.0 - g) * (1.0 - g) * (1.0 - xi) * (1.0 + g * xi) * 2.0 / (d * d);
    if minus < plus { 1.0 - minus } else { plus - 1.0 }
}

/// 1 + g² − 2g cos as a sum of non-negative terms.
fn spread(g: f64, cos: f64) -> f64 {
    if g >= 0.0 {
        (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos)
    } else {
        (1.0 + g) * (1.0 + g) - 2.0 * g * (1.0 + cos)
    }
}
