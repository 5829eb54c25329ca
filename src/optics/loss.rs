//! Energy that single scattering loses at a rough dielectric interface, by quadrature over the visible normals.
//!
//! Light arrives at angle θ (cosine µ) and meets a facet at angle θ′ (cosine c); ψ is the azimuth of the facet's normal
//! about the direction of the light. The integral runs over (θ′, ψ) because Fresnel's equations depend on θ′ alone: all
//! that is not smooth in θ′ sits at known angles, where the integral is split (in the plane of incidence ψ = 0):
//!
//! - θ′ = θ, the peak of the density for small roughness;
//! - θ′ = π/2 − θ, where facets tilted beyond the horizon begin to cut the range of ψ;
//! - θ′ = π/4 + θ/2, where reflected light meets the horizon;
//! - the critical angle, and the angle at which light refracted out of the denser side meets the horizon.
//!
//! For each θ′ the azimuth is split where the reflected and refracted directions cross the horizon, both known in
//! closed form. Rational maps y/(1 + |y|) of the scale of the roughness flatten the peaks, a cubic one the square-root
//! ends of segments; Gauss–Legendre quadrature does the rest, to better than 1e-4 with the orders used here.

use super::fresnel::{self, Interface};
use std::f32::consts::{FRAC_PI_2, PI};

/// Segments shorter than this (of an angle or of the unit interval) contribute nothing that could be seen.
const LEAST_SEGMENT: f32 = 1e-6;
/// Keeps quotients finite; far below every length that matters.
const TINY: f32 = 1e-20;

/// Shares of the arriving light that single scattering loses.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lost {
    /// After a reflection.
    pub(super) reflected: f32,
    /// After a refraction.
    pub(super) refracted: f32,
}

/// Light that meets facets at one angle, integrated over the azimuth; shares of the arriving light.
pub(super) struct Line {
    /// Cosine of incidence on the facets.
    pub(super) cos: f32,
    /// Reflectance of the facets.
    pub(super) reflectance: f32,
    /// Share that meets such facets.
    pub(super) facing: f32,
    /// Part of it that is masked if it is reflected.
    pub(super) masked_reflected: f32,
    /// Part of it that is masked if it is refracted.
    pub(super) masked_refracted: f32,
}

/// Nodes per polar segment and over the azimuth.
pub(super) struct Quadrature<const P: usize, const A: usize> {
    polar: [(f32, f32); P],
    t: [f32; A],
    weight: [f32; A],
}

impl<const P: usize, const A: usize> Quadrature<P, A> {
    pub(super) fn new() -> Self {
        let half = |n, i| {
            let (x, w) = legendre(n, i);
            ((0.5 * (x + 1.0)) as f32, (0.5 * w) as f32)
        };
        let azimuth: [(f32, f32); A] = std::array::from_fn(|i| half(A, i));
        Self {
            polar: std::array::from_fn(|i| half(P, i)),
            t: azimuth.map(|x| x.0),
            weight: azimuth.map(|x| x.1),
        }
    }

    /// What is lost of the light that arrives at cosine `mu` from the side of relative index `eta` (beyond over this
    /// side), at roughness `alpha` and correlation `kappa`.
    pub(super) fn lost(&self, mu: f32, alpha: f32, eta: f32, kappa: f32) -> Lost {
        let mut sum = Lost::default();
        self.lines(mu, alpha, eta, kappa, |line| {
            sum.reflected += line.reflectance * line.masked_reflected;
            sum.refracted += (1.0 - line.reflectance) * line.masked_refracted;
        });
        sum
    }

    /// Calls `visit` with weighted angles of incidence, for other integrands of the same kind.
    pub(super) fn lines(&self, mu: f32, alpha: f32, eta: f32, kappa: f32, mut visit: impl FnMut(Line)) {
        let theta = mu.acos();
        let horizon = FRAC_PI_2 - theta;
        let shadow = 0.5 * (FRAC_PI_2 + theta);
        let (critical, grazing) =
            if eta < 1.0 { (eta.asin(), grazing_exit(theta, eta)) } else { (FRAC_PI_2, FRAC_PI_2) };
        let mut edges = [0.0, theta, horizon, shadow, critical, grazing, FRAC_PI_2];
        edges.sort_by(f32::total_cmp);
        let light = Light::new(mu, theta, alpha, eta, kappa);
        for pair in edges.windows(2) {
            if pair[1] - pair[0] > LEAST_SEGMENT {
                self.segment([pair[0], pair[1]], &light, &mut visit);
            }
        }
    }

    #[inline]
    fn segment(&self, [from, to]: [f32; 2], light: &Light, visit: &mut impl FnMut(Line)) {
        let &Light { mu, theta, sin_theta, alpha, a2, eta, kappa, inv_masking, visible } = light;
        let warp = |angle: f32| {
            let y = (angle - theta) / alpha;
            y / (1.0 + y.abs())
        };
        let (x0, x1) = (warp(from), warp(to));
        let inv_a2 = 1.0 / a2;
        let eta2m1 = (eta - 1.0) * (eta + 1.0);
        let inv_eta = 1.0 / eta;
        for (node, weight) in self.polar {
            let (s, ds) = (node * node * (3.0 - 2.0 * node), 6.0 * node * (1.0 - node));
            let x = x0 + (x1 - x0) * s;
            let m = 1.0 - x.abs();
            let delta = alpha * x / m;
            let (sin, cos) = (theta + delta).sin_cos();
            let c = cos.max(0.0);
            let dtheta = weight * ds * (x1 - x0) * alpha / (m * m);
            let Interface { reflectance, g } = fresnel::interface(c, eta);
            let rs = (sin_theta * sin).max(TINY);
            let q0 = 2.0 * (0.5 * delta).sin().powi(2);
            let bend = eta2m1 / (c + g).max(TINY);
            let e = mu * c / rs;
            let inv_tan_max = if e < 1.0 { ((1.0 - e) / (1.0 + e)).sqrt() } else { 0.0 };
            let width = (0.5 * ((a2 + delta * delta) / rs).sqrt()).min(1.0);
            let edge = 1.0 + width * inv_tan_max;
            let position = |cos_h: f32| {
                let x = (cos_h - mu * c) / rs;
                if x.abs() >= 1.0 {
                    return 1.0;
                }
                let tan = ((1.0 - x) / (1.0 + x)).sqrt();
                (edge * tan / (width + tan)).min(1.0)
            };
            let k_r = position(mu / (2.0 * c).max(TINY));
            let k_t = if bend < 0.0 && reflectance < 1.0 { position(-mu / bend) } else { 1.0 };
            let cuts = [0.0, k_r.min(k_t), k_r.max(k_t), 1.0];
            let (mut facing, mut masked_r, mut masked_t) = ([0.0f32; A], [0.0f32; A], [0.0f32; A]);
            for cut in cuts.windows(2) {
                let length = cut[1] - cut[0];
                if length < LEAST_SEGMENT {
                    continue;
                }
                for j in 0..A {
                    let t = cut[0] + length * self.t[j];
                    let d = edge - t;
                    let wt = width * t;
                    let tan2 = wt * wt / (d * d);
                    let dpsi = length * self.weight[j] * 2.0 * width * edge / (d * d + wt * wt);
                    let q = q0 + 2.0 * rs * tan2 / (1.0 + tan2);
                    let cos_h = 1.0 - q;
                    let e = q * (2.0 - q) * inv_a2 + cos_h * cos_h;
                    let density = dpsi / (e * e);
                    let g_r = masking_of_cos((2.0 * c * cos_h - mu).clamp(0.0, 1.0), a2);
                    let g_t = masking_of_cos(((mu + bend * cos_h) * inv_eta).clamp(0.0, 1.0), a2);
                    let passed = (1.0 - kappa) * g_t + kappa * (g_t * inv_masking).min(1.0);
                    facing[j] += density;
                    masked_r[j] += density * (1.0 - g_r);
                    masked_t[j] += density * (1.0 - passed);
                }
            }
            let weight = dtheta * visible * c * sin;
            visit(Line {
                cos: c,
                reflectance,
                facing: weight * facing.iter().sum::<f32>(),
                masked_reflected: weight * masked_r.iter().sum::<f32>(),
                masked_refracted: weight * masked_t.iter().sum::<f32>(),
            });
        }
    }
}

/// What is constant for one direction of incidence.
struct Light {
    mu: f32,
    theta: f32,
    sin_theta: f32,
    alpha: f32,
    a2: f32,
    eta: f32,
    kappa: f32,
    /// 1 / G1 of the direction of incidence.
    inv_masking: f32,
    /// Constant factor of the density of visible normals, both halves of the azimuth counted.
    visible: f32,
}

impl Light {
    fn new(mu: f32, theta: f32, alpha: f32, eta: f32, kappa: f32) -> Self {
        let sin_theta = ((1.0 - mu) * (1.0 + mu)).sqrt();
        let a2 = alpha * alpha;
        let k = mu + (mu * mu + a2 * sin_theta * sin_theta).sqrt();
        let inv_masking = k / (2.0 * mu).max(TINY);
        Self { mu, theta, sin_theta, alpha, a2, eta, kappa, inv_masking, visible: 4.0 / (PI * k * a2) }
    }
}

/// Node and weight `i` of Gauss–Legendre quadrature of order `n` on [−1, 1], by Newton iteration.
pub(super) fn legendre(n: usize, i: usize) -> (f64, f64) {
    let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    let mut derivative = 1.0;
    for _ in 0..100 {
        let (mut p0, mut p1) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
        }
        derivative = n as f64 * (x * p1 - p0) / (x * x - 1.0);
        let dx = p1 / derivative;
        x -= dx;
        if dx.abs() < 1e-15 {
            break;
        }
    }
    (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
}

#[inline]
fn masking_of_cos(z: f32, a2: f32) -> f32 {
    let z2 = z * z;
    2.0 * z / (z + (z2 + a2 * (1.0 - z2)).max(1e-30).sqrt())
}

/// Angle of incidence on a facet in the plane of incidence beyond which light refracted out of the denser side stays
/// below the horizon: asin(sin θ′ / η) = π/2 − θ + θ′.
fn grazing_exit(theta: f32, eta: f32) -> f32 {
    let (mut low, mut high) = (0.0, eta.asin());
    if theta <= high {
        return FRAC_PI_2;
    }
    for _ in 0..20 {
        let mid = 0.5 * (low + high);
        if mid.sin() > eta * (theta - mid).cos() {
            high = mid;
        } else {
            low = mid;
        }
    }
    0.5 * (low + high)
}
