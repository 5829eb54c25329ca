//! Diffuse microfacets: EON, the energy-preserving Oren–Nayar model of Portsmouth, Kutz & Hill 2024 ("EON: A practical
//! energy-preserving rough diffuse BRDF"), alone or below a dielectric's coat.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `roughness` | r | 0 Lambertian, 1 facets of all slopes |
//! | `flat` | A = 1/(1 + (1/2 − 2/(3π)) r) | Fujii's first coefficient, the second is r A |
//! | s, t | s = ω_o·ω_i − µ_o µ_i | t = max(µ_o, µ_i) where s > 0, else 1 |
//! | `albedo` | E(µ) | what white facets reflect after one scattering event |
//!
//! One event is A (1 + r s/t)/π, and what is missing to 1 comes back as (1 − E(µ_o))(1 − E(µ_i))/(π(1 − Ē)), coloured
//! ρ² Ē/(1 − ρ(1 − Ē)).
//!
//! A coat lets in the share S(µ) = 1 − E_coat(µ). Where the Lambertian lobe is S_o S_i/S̄ (Kelemen & Szirmay-Kalos 2001),
//! one event is S_o S_i/S̄ · A (1 + r s/t)/π. Facets send more of it to the horizon, where the coat throws back more, than
//! Lambert's law, so the share b(µ_o) of what came in gets out. The rest, Q = S (1 − b), returns as Q_o Q_i/(π Q̄): a white
//! surface lets out all that it lets in, from every direction. Without a coat this is EON, without roughness Kelemen's.

use super::reflectance::NODES;
use super::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// (1/2 − 2/(3π)), by which roughness dims the flat part.
const DIMMED: f32 = 0.287_793_4;

/// The lobes of one point, white.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughDiffuse {
    roughness: f32,
    flat: f32,
    /// 2 µ w E_coat(µ) at the nodes of the quadrature.
    held: [f32; NODES.len()],
    /// S̄.
    entering: f32,
    /// Q̄ = ∫ 2µ Q dµ.
    rest: f32,
    /// Share of what came in that gets out after one event.
    kept: f32,
}

/// Coefficients of the linear transform that bends a cosine lobe to the model's (listing 2 of the paper).
struct Bent {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
}

impl Bent {
    fn new(mu: f32, r: f32) -> Self {
        Self {
            a: 1.0 + r * (0.303_392 + mu * (-0.518_982 + 0.111_709 * mu) + r * (-0.276_266 + 0.335_918 * mu)),
            b: r * (-1.164_07 + 1.158_59 * mu + r * (0.150_815 - 0.150_105 * mu)) / (mu.powi(3) - 1.435_45),
            c: 1.0 + r * (0.200_13 + mu * (-0.506_373 + 0.261_777 * mu)),
            d: r * (0.540_852 + mu * (-1.016_25 + 0.475_392 * mu)) / (-1.074_3 + mu * (0.072_562_8 + mu)),
        }
    }

    fn determinant(&self) -> f32 {
        self.c * (self.a - self.b * self.d)
    }

    /// The part of the unit disk from which the transform leads above the surface.
    fn clipped(&self) -> f32 {
        0.5 * (1.0 + 1.0 / (self.d * self.d + 1.0).sqrt())
    }
}

impl RoughDiffuse {
    /// Facets of a roughness in \[0, 1\] below a coat that throws back `held`, a function of the cosine, and lets in the
    /// share `entering` of diffuse light.
    pub(super) fn new(roughness: f32, entering: f32, held: impl Fn(f32) -> f32) -> Self {
        let roughness = roughness.clamp(0.0, 1.0);
        let flat = 1.0 / (1.0 + DIMMED * roughness);
        let share = NODES.map(|(mu, _)| held(mu).clamp(0.0, 1.0));
        let mut lobes = Self {
            roughness,
            flat,
            held: std::array::from_fn(|k| 2.0 * NODES[k].0 * NODES[k].1 * share[k]),
            entering: entering.max(1e-6),
            rest: 0.0,
            kept: 1.0,
        };
        lobes.rest = NODES
            .iter()
            .zip(share)
            .map(|(&(mu, w), share)| 2.0 * mu * w * lobes.missing(mu, 1.0 - share))
            .sum();
        lobes.kept = (1.0 - lobes.rest / lobes.entering).clamp(0.0, 1.0);
        lobes
    }

    /// E(µ), the paper's closed form.
    pub(super) fn albedo(&self, mu: f32) -> f32 {
        let sin = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
        let theta = mu.clamp(0.0, 1.0).acos();
        // tan θ (1 − sin³ θ), which cancels near the horizon.
        let tangent = sin * mu * (1.0 + sin + sin * sin) / (1.0 + sin);
        let g = sin * (theta - sin * mu - 2.0 / 3.0) + 2.0 / 3.0 * tangent;
        self.flat * (1.0 + self.roughness * FRAC_1_PI * g)
    }

    /// One event between two cosines, averaged over azimuths, over Lambert's law.
    fn mean(&self, o: f32, i: f32) -> f32 {
        let sines = ((1.0 - o * o) * (1.0 - i * i)).max(0.0).sqrt();
        self.flat * (1.0 + self.roughness * sines * FRAC_1_PI * (1.0 / o.max(i).max(1e-6) - 1.0))
    }

    /// Q for a cosine at which the coat lets in `share`.
    fn missing(&self, mu: f32, share: f32) -> f32 {
        let thrown: f32 = NODES.iter().zip(&self.held).map(|(&(t, _), held)| held * self.mean(mu, t)).sum();
        (share * (1.0 - (self.albedo(mu) - thrown) / self.entering)).max(0.0)
    }

    /// f·cos θ_i after one event, and after more, of directions above the surface and what the coat lets in from them.
    pub(super) fn eval(&self, o: Vec3, i: Vec3, share_o: f32, share_i: f32) -> [f32; 2] {
        let s = o.x * i.x + o.y * i.y;
        let t = if s > 0.0 { o.z.max(i.z).max(1e-6) } else { 1.0 };
        let lambert = i.z * FRAC_1_PI;
        let once = share_o * share_i / self.entering * self.flat * (1.0 + self.roughness * s / t);
        let more = if self.rest > 1e-7 {
            self.missing(o.z, share_o) * self.missing(i.z, share_i) / self.rest
        } else {
            0.0
        };
        [once * lambert, more * lambert]
    }

    /// Colour of what was scattered more than once by facets of the colour ρ.
    pub(super) fn again(&self, color: Vec3) -> Vec3 {
        color * color * self.kept / (Vec3::ONE - color * (1.0 - self.kept)).max(Vec3::splat(1e-6))
    }

    /// Share of samples that are uniform over the hemisphere, which the bent cosines do not cover well.
    fn uniform(&self, mu: f32) -> f32 {
        let p = 0.162_925 + mu * (-0.372_058 + mu * (0.538_233 - 0.290_822 * mu));
        self.roughness.powf(0.1) * p.clamp(0.0, 1.0)
    }

    /// Density of [`RoughDiffuse::sample`].
    pub(super) fn pdf(&self, o: Vec3, i: Vec3) -> f32 {
        let bent = Bent::new(o.z, self.roughness);
        let along = o.truncate().normalize_or(Vec2::X);
        let i = Vec3::new(along.dot(i.truncate()), along.perp_dot(i.truncate()), i.z);
        let Bent { a, b, c, d } = bent;
        let h = Vec3::new(c * (i.x - b * i.z), (a - b * d) * i.y, c * (a * i.z - d * i.x));
        let scale = bent.determinant() / h.length_squared();
        let cosines = scale * scale * h.z.max(0.0) * FRAC_1_PI / bent.clipped();
        let uniform = self.uniform(o.z);
        uniform / TAU + (1.0 - uniform) * cosines
    }

    /// A direction above the surface: uniform, or of a cosine lobe bent to the model's and clipped to what leads above
    /// (listing 3 of the paper); `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub(super) fn sample(&self, o: Vec3, u_lobe: f32, u: Vec2) -> Vec3 {
        if u_lobe < self.uniform(o.z) {
            return warp::uniform_hemisphere(u);
        }
        let bent = Bent::new(o.z, self.roughness);
        let (sin, cos) = (TAU * u.y).sin_cos();
        let (x, y) = (u.x.sqrt() * cos, u.x.sqrt() * sin);
        // The disk squeezed to the half ellipse and half disk over which the lobe ends above.
        let edge = (1.0 - y * y).max(0.0).sqrt();
        let x = -(edge + (x - edge) * bent.clipped());
        let h = Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
        let i = Vec3::new(bent.a * h.x + bent.b * h.z, bent.c * h.y, bent.d * h.x + h.z);
        let along = o.truncate().normalize_or(Vec2::X);
        Vec3::new(along.x * i.x - along.y * i.y, along.y * i.x + along.x * i.y, i.z).normalize_or(Vec3::Z)
    }
}

#[cfg(test)]
#[path = "rough_diffuse_tests.rs"]
mod tests;
