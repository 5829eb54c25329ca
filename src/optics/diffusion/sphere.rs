//! How much of the light that an isotropic source sends out in the middle of a sphere leaves it, exactly.
//!
//! Lengths are in mean free paths, scattering is isotropic with albedo α. Without collision the fluence is e^{−r}/4πr²; let
//! u(r)/4πr be that of collided light. It solves Peierls' equation (Case & Zweifel 1967, §2.8), here for the point source
//!
//! ```text
//! u(r) = α/2 ∫₀^τ [u(t) + e^{−t}/t] [E₁(|r − t|) − E₁(r + t)] dt,   u(0) = απ²/4.                     (1)
//! ```
//!
//! Light that is scattered at r leaves without another collision with the probability P(r), and so, with a = τ − r and
//! b = τ + r, in all
//!
//! ```text
//! T = e^{−τ} + α ∫₀^τ [e^{−r} + r u(r)] P(r) dr,   P = [e^{−a} − e^{−b} + b E₂(a) − a E₂(b)] / 4r.     (2)
//! ```
//!
//! u is taken to be linear between nodes, which crowd where it is steep: with E₃″ = E₁ the integrals of (1) over the
//! pieces are second differences of E₃(|r − t|) + |r − t| and E₃(r + t). For the source the rule of Gauss is used, in
//! panels that crowd at the singular places. The error falls with the square of the step, so it is extrapolated to none
//! (Richardson).
//!
//! Some mean free paths from the middle and from the surface u is a multiple of sinh(κ(τ + z − r)): κ solves
//! 1 = α artanh(κ)/κ, and z is about 0.7104/α. The light that reaches the surface is A/sinh(κ(τ + z)) times what depends on
//! the distance from the surface alone, hence for large τ
//!
//! ```text
//! T = (c₁ + c₂ τ) / sinh(κ(τ + z)).                                                                   (3)
//! ```

use super::discrete_ordinates::gauss;
use super::linear_algebra::Matrix;
use std::f64::consts::PI;

/// Longest steps between nodes, of the two that are extrapolated.
const STEPS: [f64; 2] = [0.2, 0.1];
/// First step from the ends in longest ones, and how steps grow from there.
const FIRST_STEP: f64 = 0.1;
const GROWTH: f64 = 1.25;
/// Radii that (3) goes through; smaller spheres are solved.
const LARGE: [f64; 2] = [8.0, 12.0];
/// Hopf's constant.
const EXTRAPOLATION: f64 = 0.710_446;
/// Nodes of the rule of Gauss in a panel.
const NODES: usize = 12;
/// Euler's constant.
const GAMMA: f64 = 0.577_215_664_901_532_9;

/// Spheres of one albedo.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    albedo: f64,
    kappa: f64,
    /// c₁ and c₂ of (3), times 2 e^{κ(τ + z)} of the first of [`LARGE`].
    line: [f64; 2],
}

impl Sphere {
    /// For isotropic scattering with an albedo in \[0, 1\].
    pub fn new(albedo: f64) -> Self {
        let kappa = kappa(albedo);
        let mut sphere = Self { albedo, kappa, line: [0.0; 2] };
        if albedo < 1.0 {
            let [a, b] = LARGE.map(|tau| solved(tau, albedo) / sphere.decay(tau));
            let slope = (b - a) / (LARGE[1] - LARGE[0]);
            sphere.line = [a - slope * LARGE[0], slope];
        }
        sphere
    }

    /// T: the share of light that leaves a sphere of radius `tau` mean free paths (> 0) from an isotropic source in its
    /// middle. The error is about 1e-3 of it.
    pub fn transmittance(&self, tau: f64) -> f64 {
        if self.albedo >= 1.0 {
            1.0
        } else if tau < LARGE[0] {
            solved(tau, self.albedo)
        } else {
            ((self.line[0] + self.line[1] * tau) * self.decay(tau)).clamp(0.0, 1.0)
        }
    }

    /// 1/sinh(κ(τ + z)), up to a factor.
    fn decay(&self, tau: f64) -> f64 {
        let z = EXTRAPOLATION / self.albedo.max(f64::MIN_POSITIVE);
        let depth = self.kappa * (tau + z);
        (self.kappa * (LARGE[0] - tau)).exp() / (1.0 - (-2.0 * depth).exp())
    }
}

/// The isotropic albedo and extinction σt*, in units of the true extinction, that absorb as much and in which light decays
/// over the same length as in a medium of this albedo that scatters forward, g ≥ 0. It is σs* = (1 − g) σs where
/// little is absorbed.
pub fn equivalent(albedo: f64, g: f64) -> (f64, f64) {
    let absorption = 1.0 - albedo;
    let reduced = (1.0 - g) * albedo;
    if g == 0.0 || absorption <= 0.0 || reduced <= 0.0 {
        return (reduced / (absorption + reduced), absorption + reduced);
    }
    let decay = decay(albedo, g);
    // More scattering shortens the length.
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let extinction: f64 = absorption + middle;
        if kappa(middle / extinction) * extinction < decay {
            low = middle;
        } else {
            high = middle;
        }
    }
    let extinction = absorption + low;
    (low / extinction, extinction)
}

/// κ, the rate of decay deep inside in units of the extinction, for Henyey and Greenstein's phase function: the least
/// root of
///
/// ```text
/// h₀ − κ²/(h₁ − 4κ²/(h₂ − 9κ²/(h₃ − …))) = 0,   h_l = (2l + 1)(1 − α g^l)
/// ```
///
/// (Case & Zweifel 1967, §4.6: the recurrence of its moments), below which all of the nested denominators are positive.
fn decay(albedo: f64, g: f64) -> f64 {
    const MOMENTS: i32 = 400;
    let h = |l: i32| f64::from(2 * l + 1) * (1.0 - albedo * g.powi(l));
    let below = |kappa: f64| {
        let mut denominator = h(MOMENTS);
        for l in (0..MOMENTS).rev() {
            denominator = h(l) - (f64::from(l + 1) * kappa).powi(2) / denominator;
            if denominator <= 0.0 {
                return false;
            }
        }
        true
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// κ with 1 = α artanh(κ)/κ, by bisection.
fn kappa(albedo: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if albedo * middle.atanh() < middle {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// (2), extrapolated.
fn solved(tau: f64, albedo: f64) -> f64 {
    let [coarse, fine] = STEPS.map(|step| left(tau, albedo, step));
    (4.0 * fine - coarse) / 3.0
}

/// (2) with a longest step.
fn left(tau: f64, albedo: f64, step: f64) -> f64 {
    let rule = gauss(NODES);
    let nodes = nodes(tau, step);
    let collided = fluence(&nodes, albedo, &rule);
    let escape = |r: f64| {
        let (a, b) = (tau - r, tau + r);
        let [[_, near, _], [_, far, _]] = [a, b].map(exponential_integrals);
        0.25 * ((-a).exp() - (-b).exp() + b * near - a * far)
    };
    let pieces = nodes.windows(2).zip(collided.windows(2)).map(|(r, u)| {
        let piece = rule.iter().map(|[x, w]| {
            let at = r[0] + (r[1] - r[0]) * x;
            w * ((-at).exp() / at + u[0] + (u[1] - u[0]) * x) * escape(at)
        });
        (r[1] - r[0]) * piece.sum::<f64>()
    });
    (-tau).exp() + albedo * pieces.sum::<f64>()
}

/// From 0 to τ, denser near both.
fn nodes(tau: f64, longest: f64) -> Vec<f64> {
    let mut from_end = vec![0.0];
    let (mut at, mut step) = (0.0, (FIRST_STEP * longest).min(0.1 * tau));
    while at + step < 0.5 * tau {
        at += step;
        from_end.push(at);
        step = (step * GROWTH).min(longest);
    }
    let mirrored: Vec<f64> = from_end.iter().rev().map(|x| tau - x).collect();
    from_end.extend(mirrored);
    from_end
}

/// u at the nodes.
fn fluence(nodes: &[f64], albedo: f64, rule: &[[f64; 2]]) -> Vec<f64> {
    let n = nodes.len();
    let tau = nodes[n - 1];
    let half = 0.5 * albedo;
    let source =
        nodes.iter().map(|&r| half * if r == 0.0 { PI * PI / 2.0 } else { first_collision(r, tau, rule) });
    let kernel: Vec<Vec<f64>> = nodes.iter().map(|&r| hats(nodes, r)).collect();
    let matrix = Matrix::new(n, |i, j| f64::from(u8::from(i == j)) - half * kernel[i][j]);
    matrix.solve(source.collect())
}

/// ∫ h_j(t) [E₁(|r − t|) − E₁(r + t)] dt for the hat function h_j of each node.
fn hats(nodes: &[f64], r: f64) -> Vec<f64> {
    let n = nodes.len();
    // The second antiderivative of the kernel, and the slopes of its pieces.
    let value = |t: f64| {
        let apart = (r - t).abs();
        exponential_integrals(apart)[2] + apart - exponential_integrals(r + t)[2]
    };
    let values: Vec<f64> = nodes.iter().map(|&t| value(t)).collect();
    let slope = |t: f64| {
        let [_, near, _] = exponential_integrals((r - t).abs());
        let own = if t > r { 1.0 - near } else { near - 1.0 };
        own + exponential_integrals(r + t)[1]
    };
    let pieces: Vec<f64> = (1..n).map(|j| (values[j] - values[j - 1]) / (nodes[j] - nodes[j - 1])).collect();
    (0..n)
        .map(|j| match j {
            0 => pieces[0] - slope(nodes[0]),
            j if j + 1 == n => slope(nodes[j]) - pieces[j - 1],
            j => pieces[j] - pieces[j - 1],
        })
        .collect()
}

/// ∫₀^τ e^{−t}/t [E₁(|r − t|) − E₁(r + t)] dt for r > 0.
fn first_collision(r: f64, tau: f64, rule: &[[f64; 2]]) -> f64 {
    let integrand =
        |t: f64| (-t).exp() / t * (exponential_integrals((r - t).abs())[0] - exponential_integrals(r + t)[0]);
    // Panels (from, to) whose nodes crowd at `from`.
    let mut panels = vec![(0.0, 0.5 * r), (r, 0.5 * r)];
    let mut length = r.min(1.0);
    let mut at = r;
    while at < tau {
        let end = (at + length).min(tau);
        panels.push((at, end));
        (at, length) = (end, 2.0 * length);
    }
    let integral = |(from, to): (f64, f64)| {
        let panel =
            rule.iter().map(|[x, w]| w * 2.0 * x * integrand(from + (to - from) * x * x)).sum::<f64>();
        (to - from).abs() * panel
    };
    panels.into_iter().map(integral).sum()
}

/// E₁, E₂ and E₃ at x ≥ 0: series below 1, continued fraction above (Abramowitz & Stegun 5.1.11, 5.1.22, 5.1.14).
/// E₁(0) is infinite.
fn exponential_integrals(x: f64) -> [f64; 3] {
    const TERMS: usize = 20;
    const FRACTION: usize = 60;
    if x == 0.0 {
        return [f64::INFINITY, 1.0, 0.5];
    }
    let decay = (-x).exp();
    let first = if x < 1.0 {
        let mut term = -1.0;
        let sum: f64 = (1..TERMS)
            .map(|k| {
                term *= -x / k as f64;
                term / k as f64
            })
            .sum();
        sum - GAMMA - x.ln()
    } else {
        // Backwards: E₁ = e^{−x} / (x + 1/(1 + 1/(x + 2/(1 + 2/(x + …))))).
        let tail = (1..=FRACTION).rev().fold(x, |tail, k| {
            let k = k as f64;
            x + k / (1.0 + k / tail)
        });
        decay / tail
    };
    let second = decay - x * first;
    [first, second, 0.5 * (decay - x * second)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, statistics::Estimate};
    use glam::Vec3;

    /// Abramowitz & Stegun, tables 5.1 and 5.4.
    #[test]
    fn exponential_integrals_are_those_of_the_tables() {
        for (x, first, second, third) in [
            (0.5, 0.559_773_594_8, 0.326_643_9, 0.221_604_4),
            (1.0, 0.219_383_934_4, 0.148_495_5, 0.109_692_0),
            (2.0, 0.048_900_510_7, 0.037_534_3, 0.030_133_4),
        ] {
            let found = exponential_integrals(x);
            assert!((found[0] - first).abs() < 1e-9, "{x}: {found:?}");
            assert!((found[1] - second).abs() < 1e-7 && (found[2] - third).abs() < 1e-7, "{x}: {found:?}");
        }
    }

    /// Walks from the middle, whose weight is the albedo to the power of their events. 4 standard errors.
    #[test]
    fn walks_leave_as_often() {
        for (tau, albedo) in [(1.0, 0.8), (4.0, 0.5), (4.0, 0.95), (10.0, 0.99), (16.0, 0.999)] {
            let mut rng = SmallRng::new(5);
            let mut estimate = Estimate::default();
            for _ in 0..20_000 {
                let (mut p, mut weight) = (Vec3::ZERO, 1.0);
                loop {
                    let d = crate::sampling::warp::uniform_sphere(rng.vec2());
                    p -= d * rng.open01().ln();
                    if p.length() > tau as f32 {
                        break;
                    }
                    weight *= albedo;
                }
                estimate.add(weight);
            }
            let expected = Sphere::new(albedo).transmittance(tau);
            let z = (estimate.mean() - expected) / estimate.standard_error().hypot(1e-3 * expected / 4.0);
            println!("{tau} {albedo}: {} ± {}, {expected}", estimate.mean(), estimate.standard_error());
            assert!(z.abs() < 4.0, "{tau} {albedo}: {} is not {expected}", estimate.mean());
        }
    }

    /// Isotropic media are their own equivalents by either way to κ, and near 1 − α = 0 the diffusion length is that of
    /// transport theory: κ² = 3 (1 − α)(1 − gα) up to (1 − α)².
    #[test]
    fn equivalent_media_decay_alike() {
        for albedo in [0.3, 0.8, 0.99] {
            let (a, b) = (decay(albedo, 0.0), kappa(albedo));
            assert!((a - b).abs() < 2e-4, "{albedo}: {a} {b}");
        }
        for g in [0.5, 0.9] {
            let (a, b) = (decay(0.9999, g), (3.0f64 * 1e-4 * (1.0 - g * 0.9999)).sqrt());
            assert!((a / b - 1.0).abs() < 1e-3, "{g}: {a} {b}");
            let (albedo, extinction) = equivalent(0.9999, g);
            assert!(((albedo * extinction) / ((1.0 - g) * 0.9999) - 1.0).abs() < 1e-3);
        }
    }

    /// (3) against (2), beyond the radii that it goes through: twice the error that [`Sphere::transmittance`] states,
    /// since both have it.
    #[test]
    fn large_spheres_go_on_as_smaller_ones() {
        for albedo in [0.8, 0.99, 0.9995] {
            let (line, solved) = (Sphere::new(albedo).transmittance(18.0), solved(18.0, albedo));
            assert!((line / solved - 1.0).abs() < 2e-3, "{albedo}: {line} {solved}");
        }
    }
}
