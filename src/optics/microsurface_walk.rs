//! A random walk on a Smith microsurface (Heitz et al. 2016), the reference that the compensated boundary is held
//! against. Heights are uniform in \[−1, 1\]; the answer does not depend on that choice.
use super::{fresnel, ggx};
use glam::Vec3;

use super::test_support::Rng;

/// Smith's Λ for a direction above (≥ 0) or below (≤ −1) the horizon.
fn lambda(w: Vec3, alpha: f32) -> f32 {
    let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z).max(1e-30);
    let s = (1.0 + alpha * alpha * tan2).sqrt();
    if w.z > 0.0 { 0.5 * (s - 1.0) } else { 0.5 * (-1.0 - s) }
}

fn cdf(h: f32) -> f32 {
    (0.5 * (h + 1.0)).clamp(0.0, 1.0)
}

/// Height of the next meeting with the microsurface for a ray at height `h` along `w`; `None` where it leaves.
fn next_height(w: Vec3, h: f32, alpha: f32, u: f32) -> Option<f32> {
    if w.z > 0.9999 {
        return None;
    }
    if w.z < -0.9999 {
        return Some(2.0 * u * cdf(h) - 1.0);
    }
    if w.z.abs() < 1e-4 {
        return Some(h);
    }
    let l = lambda(w, alpha);
    let escape = if w.z > 0.0 { cdf(h).powf(l) } else { 0.0 };
    if u > 1.0 - escape {
        return None;
    }
    Some((2.0 * cdf(h) / (1.0 - u).powf(1.0 / l) - 1.0).clamp(-1.0, 1.0))
}

/// Where a walk ends.
pub struct Walk {
    /// Direction in which the light leaves.
    pub direction: Vec3,
}

/// Follows light that arrives from `wo` (pointing away from the surface, either side) until it leaves.
pub fn walk(wo: Vec3, alpha: f32, eta: f32, rng: &mut Rng) -> Walk {
    let mut outside = wo.z > 0.0;
    let mut w = -wo;
    let mut h = if outside { 1.0 } else { -1.0 };
    let mut events = 0;
    loop {
        let next = if outside {
            next_height(w, h, alpha, rng.next())
        } else {
            next_height(-w, -h, alpha, rng.next()).map(|h| -h)
        };
        let Some(height) = next else { break };
        h = height;
        events += 1;
        if events > 10_000 {
            break;
        }
        let view = if outside { -w } else { w };
        let m_up = ggx::sample_visible(view, alpha, rng.vec2());
        let m = if outside { m_up } else { -m_up };
        let n_ratio = if outside { eta } else { 1.0 / eta };
        let c = (-w).dot(m).max(0.0);
        if rng.next() < fresnel::dielectric(c, n_ratio) {
            w += 2.0 * c * m;
        } else {
            w = fresnel::refract(-w, m, n_ratio).unwrap_or(w);
            outside = !outside;
        }
        w = w.normalize();
    }
    Walk { direction: w }
}
