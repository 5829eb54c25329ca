//! A compensation lobe: the share of light that single scattering loses, tabulated over the cosine of the direction,
//! and the diffuse-like density that hands it back.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `loss` | L(µ) = 1 − E(µ) | lost share of light that arrives at cosine µ |
//! | `total` | A = ∫₀¹ 2µ L(µ) dµ | its hemispherical average |
//! | density | L(µ) / (π A) | times µ it integrates to 1 over the hemisphere |
//!
//! L is interpolated linearly between warped nodes, which crowd at grazing directions and at the critical angle with
//! the scale of the roughness. So µ L(µ) is a quadratic with non-negative Bernstein coefficients in each cell: its
//! integral is exact and it is sampled exactly as a mixture of the densities of Beta(1,3), Beta(2,2) and Beta(3,1).

/// Cells between µ = 0 and 1.
pub(super) const CELLS: usize = 72;

/// Places nodes in µ: clusters at 0 and at the critical angle with the scale of the roughness, and at 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Warp {
    grazing_scale: f32,
    critical_scale: f32,
    critical: f32,
    /// Shares of the nodes at 0, everywhere, at the critical angle and at 1, with their normalisation.
    shares: [f32; 4],
    critical_start: f32,
}

/// Share of the nodes spread uniformly, so that no region starves.
const UNIFORM_SHARE: f32 = 0.1;
/// Share of the nodes at the critical angle in the limit of large roughness; where the surface is nearly smooth the
/// loss there is of the order of α^1.5.
const CRITICAL_SHARE: f32 = 0.35;
const CRITICAL_ALPHA: f32 = 0.05;
/// Share of the nodes at normal incidence for α = 1, where the loss has a root-like end.
const NORMAL_SHARE: f32 = 0.2;

impl Warp {
    /// Nodes for roughness `alpha` and relative index `eta` (beyond over this side; 1 where nothing is refracted).
    pub(super) fn new(alpha: f32, eta: f32) -> Self {
        let critical_share = if eta < 1.0 { CRITICAL_SHARE * alpha / (alpha + CRITICAL_ALPHA) } else { 0.0 };
        let critical = ((1.0 - eta) * (1.0 + eta)).max(0.0).sqrt();
        let start = step(-critical / alpha);
        let range = step((1.0 - critical) / alpha) - start;
        let normal_share = NORMAL_SHARE * alpha;
        let grazing_share = 1.0 - UNIFORM_SHARE - critical_share - normal_share;
        let contrast = (1.0 - eta.min(1.0 / eta)).abs();
        let grazing_scale = if contrast > 0.0 { (alpha * alpha.min(contrast)).sqrt() } else { alpha };
        Self {
            grazing_scale,
            critical_scale: alpha,
            critical,
            shares: [
                grazing_share * (1.0 + grazing_scale),
                UNIFORM_SHARE,
                critical_share / range,
                normal_share,
            ],
            critical_start: start,
        }
    }

    /// Position of `mu` among the nodes, 0 to 1, increasing.
    #[inline]
    pub(super) fn position(&self, mu: f32) -> f32 {
        self.shares[0] * mu / (mu + self.grazing_scale)
            + self.shares[1] * mu
            + self.shares[2] * (step((mu - self.critical) / self.critical_scale) - self.critical_start)
            + self.shares[3] * (1.0 - (1.0 - mu).max(0.0).sqrt())
    }

    fn node(&self, i: usize) -> f32 {
        let target = i as f32 / CELLS as f32;
        let (mut low, mut high) = (0.0f32, 1.0f32);
        for _ in 0..40 {
            let mid = 0.5 * (low + high);
            if self.position(mid) < target {
                low = mid;
            } else {
                high = mid;
            }
        }
        match i {
            0 => 0.0,
            CELLS => 1.0,
            _ => 0.5 * (low + high),
        }
    }
}

/// The tabulated lobe of one roughness and one side.
#[derive(Clone, Debug)]
pub(super) struct Lobe {
    warp: Warp,
    mu: [f32; CELLS + 1],
    loss: [f32; CELLS + 1],
    /// ∫₀^µ 2µ L dµ at the nodes.
    cumulative: [f32; CELLS + 1],
}

impl Lobe {
    /// Tabulates `loss`, a function of the cosine with values in \[0, 1\].
    pub(super) fn new(warp: Warp, mut loss: impl FnMut(f32) -> f32) -> Self {
        let mu: [f32; CELLS + 1] = std::array::from_fn(|i| warp.node(i));
        let loss = mu.map(|mu| loss(mu).clamp(0.0, 1.0));
        let mut cumulative = [0.0; CELLS + 1];
        for i in 0..CELLS {
            let b = bernstein(mu[i], mu[i + 1], loss[i], loss[i + 1]);
            cumulative[i + 1] = cumulative[i] + 2.0 * (mu[i + 1] - mu[i]) * (b[0] + b[1] + b[2]) / 3.0;
        }
        Self { warp, mu, loss, cumulative }
    }

    /// A = ∫₀¹ 2µ L dµ.
    #[inline]
    pub(super) fn total(&self) -> f32 {
        self.cumulative[CELLS]
    }

    /// The nodes, increasing from 0 to 1.
    pub(super) fn nodes(&self) -> &[f32; CELLS + 1] {
        &self.mu
    }

    /// L(µ) for `mu` in \[0, 1\].
    #[inline]
    pub(super) fn loss(&self, mu: f32) -> f32 {
        let (i, t) = self.locate(mu);
        self.loss[i] + t * (self.loss[i + 1] - self.loss[i])
    }

    /// The cell of `mu` and the position inside it, 0 to 1.
    #[inline]
    pub(super) fn locate(&self, mu: f32) -> (usize, f32) {
        let guess = (self.warp.position(mu) * CELLS as f32) as usize;
        let mut i = guess.min(CELLS - 1);
        if mu < self.mu[i] {
            i = i.saturating_sub(1);
        } else if mu > self.mu[i + 1] {
            i = (i + 1).min(CELLS - 1);
        }
        let (a, b) = (self.mu[i], self.mu[i + 1]);
        (i, ((mu - a) / (b - a)).clamp(0.0, 1.0))
    }

    /// A cosine with density 2µ L(µ)/A; `u` in \[0, 1).
    pub(super) fn sample(&self, u: f32) -> f32 {
        let target = u * self.total();
        let i = self.cumulative[1..CELLS].partition_point(|&c| c <= target);
        let mass = self.cumulative[i + 1] - self.cumulative[i];
        let u = if mass > 0.0 { ((target - self.cumulative[i]) / mass).clamp(0.0, 1.0) } else { 0.5 };
        let b = bernstein(self.mu[i], self.mu[i + 1], self.loss[i], self.loss[i + 1]);
        let sum = b[0] + b[1] + b[2];
        let x = u * sum;
        let s = if x < b[0] {
            1.0 - (1.0 - x / b[0]).cbrt()
        } else if x < b[0] + b[1] {
            let v = (x - b[0]) / b[1];
            0.5 - ((1.0 - 2.0 * v).clamp(-1.0, 1.0).asin() / 3.0).sin()
        } else if b[2] > 0.0 {
            ((x - b[0] - b[1]) / b[2]).clamp(0.0, 1.0).cbrt()
        } else {
            0.5
        };
        self.mu[i] + s * (self.mu[i + 1] - self.mu[i])
    }
}

/// A step of unit width and height 2 that is cheap to evaluate.
#[inline]
fn step(x: f32) -> f32 {
    x / (1.0 + x.abs())
}

/// Bernstein coefficients of µ L(µ) on a cell, both factors linear.
#[inline]
fn bernstein(mu0: f32, mu1: f32, l0: f32, l1: f32) -> [f32; 3] {
    [l0 * mu0, 0.5 * (l0 * mu1 + l1 * mu0), l1 * mu1]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobe() -> Lobe {
        Lobe::new(Warp::new(0.05, 0.7), |mu| {
            0.3 * (-mu * 6.0).exp() + 0.1 * (-((mu - 0.7) * 9.0).powi(2)).exp()
        })
    }

    #[test]
    fn nodes_increase_and_reach_the_ends() {
        for alpha in [1e-3, 0.1, 1.0] {
            for eta in [1.0, 1.5, 0.9999, 0.66, 0.4] {
                let l = Lobe::new(Warp::new(alpha, eta), |mu| 1.0 - mu);
                assert!(l.mu.windows(2).all(|w| w[0] < w[1]), "{alpha} {eta}");
                assert!((l.warp.position(1.0) - 1.0).abs() < 1e-5 && l.warp.position(0.0).abs() < 1e-5);
                assert!((l.total() - 1.0 / 3.0).abs() < 1e-5, "{}", l.total());
                assert!((l.loss(0.37) - 0.63).abs() < 1e-5);
            }
        }
    }

    /// The empirical distribution of a regular grid of `u` is the cumulative of the density.
    #[test]
    fn samples_follow_the_density() {
        let l = lobe();
        let n = 100_000;
        let mut samples: Vec<f32> = (0..n).map(|i| l.sample((i as f32 + 0.5) / n as f32)).collect();
        samples.sort_by(f32::total_cmp);
        let mut integral = 0.0f64;
        let steps = 200_000;
        let mut next = 0;
        for i in 0..steps {
            let mu = (i as f32 + 0.5) / steps as f32;
            integral += f64::from(2.0 * mu * l.loss(mu)) / f64::from(steps) / f64::from(l.total());
            while next < samples.len() && samples[next] <= mu {
                next += 1;
            }
            let empirical = next as f64 / f64::from(n);
            assert!((empirical - integral).abs() < 2e-4, "mu {mu}: {empirical} for {integral}");
        }
        assert!((integral - 1.0).abs() < 1e-4);
    }
}
