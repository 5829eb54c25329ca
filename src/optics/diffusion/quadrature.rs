//! Quadrature for integrands that are analytic inside their range and misbehave at its ends.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// ∫₀¹ f by the tanh–sinh rule (Takahasi & Mori 1974). `f` takes x and 1 − x, each accurate near its own zero.
pub(super) fn unit_interval(f: impl Fn(f64, f64) -> f64) -> f64 {
    nodes().iter().map(|&[x, rest, weight]| weight * f(x, rest)).sum()
}

/// The nodes x and 1 − x and the weights of [`unit_interval`].
pub(super) fn nodes() -> &'static [[f64; 3]] {
    &TANH_SINH
}

/// For step 1/12; the outermost weights are below 1e-15.
static TANH_SINH: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    const STEPS: i32 = 39;
    const STEP: f64 = 1.0 / 12.0;
    (-STEPS..=STEPS)
        .map(|i| {
            let t = STEP * f64::from(i);
            let e = PI * t.sinh();
            let (x, rest) = (1.0 / (1.0 + (-e).exp()), 1.0 / (1.0 + e.exp()));
            [x, rest, STEP * PI * t.cosh() * x * rest]
        })
        .collect()
});

/// ∫ f(x) dx over x in (0, ∞) by the trapezoid rule in ln x, from e^`from` to e^`to` in steps of about `step`; outside
/// that range x f(x) must be negligible.
pub(super) fn logarithmic(from: f64, to: f64, step: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = ((to - from) / step).ceil();
    let step = (to - from) / steps;
    let (mut x, ratio) = (from.exp(), step.exp());
    let mut sum = 0.0;
    for _ in 0..=steps as usize {
        sum += x * f(x);
        x *= ratio;
    }
    sum * step
}
