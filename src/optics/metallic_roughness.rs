//! The opaque and thin surfaces of glTF: the metallic-roughness BRDF of glTF 2.0 appendix B with KHR_materials_ior and
//! KHR_materials_specular, and the thin transmission of KHR_materials_transmission.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `f0`, `f90` | | dielectric reflectance at normal and grazing incidence, ((ior − 1)/(ior + 1))² and 1 times specular |
//! | `alpha` | α | roughness² |
//! | D, G | | GGX and separable Smith masking, see [`super::ggx`] |
//! | L, A, E_w | | lost share, its average, and Schlick-weighted albedo, see the reflection tables |
//!
//! [`Microfacet::Single`] is the specification to the letter, with h half-way between ω_o and ω_i, or between ω_o and
//! the mirror image of ω_i below the surface, w = (1 − ω_o·h)⁵, and S = D G / (4 |cos θ_o cos θ_i|):
//!
//! - metal: (base + (1 − base) w) S;
//! - dielectric: F S + (1 − max F)((1 − t) base/π + t base S below the surface), F = f0 + (f90 − f0) w.
//!
//! It loses energy at rough surfaces, and gains some at grazing angles, where 1 − F at the half vector is larger than
//! what the reflection left over. [`Microfacet::Multiple`] keeps S and restores the balance, reciprocally:
//!
//! - light lost by masking comes back as F_ms L(µ_o) L(µ_i)/(π A) (Kulla & Conty 2017), F_ms = F̄² Ē/(1 − F̄(1 − Ē)), with
//!   F̄ = f0 + (f90 − f0)/21 and Ē = 1 − A, the rest of it enters;
//! - the diffuse base is base (1 − E(µ_o))(1 − E(µ_i))/(π(1 − Ē_coat)) (Kelemen & Szirmay-Kalos 2001), with
//!   E = f0 (1 − L − E_w) + f90 E_w + F_ms L the albedo of everything reflected above it;
//! - thin transmission is t base ((1 − F) S + (1 − F_ms) L(µ_o) L(µ_i)/(π A)).
//!
//! So a white metal, a white dielectric and a white thin wall reflect and transmit exactly 1 in every direction, up to
//! the accuracy of the tables. Seen from behind (ω_o.z < 0) the surface is the same.

use super::anisotropic::Facets;
use super::base::{self, Spread};
use super::boundary::Microfacet;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::fresnel::{SCHLICK_AVERAGE, f0_from_eta, schlick_weight};
use super::reflection_tables::{Directional, Reflection};
use super::{BsdfSample, ggx, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Parameters of a [`Surface`], as glTF has them, textures applied.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceParameters {
    /// Linear base colour, \[0, 1\].
    pub base_color: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// α, the square of the perceptual roughness, \[0, 1\].
    pub alpha: f32,
    /// Index of refraction of the dielectric, ≥ 1 (0 means infinite, as KHR_materials_ior has it).
    pub ior: f32,
    /// Strength of the dielectric reflection, \[0, 1\].
    pub specular: f32,
    /// Colour of the dielectric reflection at normal incidence.
    pub specular_color: Vec3,
    /// Share of the dielectric's non-reflected light that passes straight through a thin wall, \[0, 1\].
    pub transmission: f32,
    /// Whether light that meets several microfacets is handed back.
    pub microfacet: Microfacet,
}

impl Default for SurfaceParameters {
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE,
            metallic: 1.0,
            alpha: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            microfacet: Microfacet::Multiple,
        }
    }
}

/// An opaque surface or thin wall at one point.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    base: Vec3,
    metallic: f32,
    alpha: f32,
    f0: Vec3,
    f90: f32,
    transmission: f32,
    multiple: bool,
    reflection: Reflection,
    /// F_ms of the metal and of the dielectric; 0 for single scattering.
    metal_again: Vec3,
    coat_again: Vec3,
    /// 1 − Ē_coat.
    base_average: f32,
}

/// Probabilities of the lobes for one direction; they add up to 1.
struct Choice {
    reflection: f32,
    diffuse: f32,
    transmission: f32,
}

/// Least probability of a lobe that exists, so that no part of the BSDF goes unsampled where the albedos are wrong.
const LEAST_CHOICE: f32 = 0.02;

impl Surface {
    /// The surface with these parameters; out-of-range ones are clamped.
    pub fn new(p: &SurfaceParameters) -> Self {
        let alpha = p.alpha.clamp(0.0, 1.0);
        let reflection = Reflection::at(alpha);
        let normal = if p.ior == 0.0 { 1.0 } else { f0_from_eta(p.ior) };
        let f0 = (normal * p.specular_color).min(Vec3::ONE) * p.specular;
        let f90 = p.specular;
        let base = p.base_color.clamp(Vec3::ZERO, Vec3::ONE);
        let multiple = p.microfacet == Microfacet::Multiple;
        let mut surface = Self {
            base,
            metallic: p.metallic.clamp(0.0, 1.0),
            alpha,
            f0,
            f90,
            transmission: p.transmission.clamp(0.0, 1.0),
            multiple,
            reflection,
            metal_again: Vec3::ZERO,
            coat_again: Vec3::ZERO,
            base_average: 1.0,
        };
        if multiple {
            let kept = 1.0 - reflection.lost_average;
            let again = |f: Vec3| f * f * kept / (Vec3::ONE - f * (1.0 - kept));
            surface.metal_again = again(base + (Vec3::ONE - base) * SCHLICK_AVERAGE);
            surface.coat_again = again(f0 + (Vec3::splat(f90) - f0) * SCHLICK_AVERAGE);
        }
        let average = Directional { lost: reflection.lost_average, schlick: reflection.schlick_average };
        surface.base_average = 1.0 - surface.coat_albedo(average);
        surface
    }

    /// A diffuse surface that reflects `color`, without a coat.
    pub fn lambertian(color: Vec3) -> Self {
        Self::new(&SurfaceParameters {
            base_color: color,
            metallic: 0.0,
            alpha: 0.0,
            specular: 0.0,
            ..SurfaceParameters::default()
        })
    }

    /// Whether every sample is a delta.
    pub fn is_delta(&self) -> bool {
        let mirror_only = self.metallic >= 1.0 || self.transmission >= 1.0 || self.base == Vec3::ZERO;
        self.is_smooth() && mirror_only
    }

    #[inline]
    fn is_smooth(&self) -> bool {
        self.alpha < MIN_ROUGH_ALPHA
    }

    /// f·|cos θ_i|, deltas left out.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.eval_pdf(wo, wi).0
    }

    /// Density of [`Surface::sample`] at `wi`, per steradian, deltas left out.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    /// [`Surface::eval`] and [`Surface::pdf`] at the price of one.
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if wo.z == 0.0 || wi.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let o = above(wo);
        let i = above(wi);
        let at_o = self.reflection.directional(o.z);
        let choice = self.choice(o, at_o);
        self.above_eval_pdf(o, i, wo.z * wi.z < 0.0, at_o, &choice)
    }

    /// Both directions above the surface; `below` where `wi` is on the other side.
    fn above_eval_pdf(
        &self,
        o: Vec3,
        i: Vec3,
        below: bool,
        at_o: Directional,
        choice: &Choice,
    ) -> (Vec3, f32) {
        let dielectric = 1.0 - self.metallic;
        let h = (o + i).normalize_or(Vec3::Z);
        let w = schlick_weight(o.dot(h));
        let at_i = self.reflection.directional(i.z);
        let visible = if self.is_smooth() {
            0.0
        } else {
            0.5 * ggx::distribution(h, self.alpha) * ggx::masking_over_two_cos(o, self.alpha)
        };
        let single = visible * ggx::masking(i, self.alpha);
        let again = if self.multiple && self.reflection.lost_average > 0.0 {
            at_o.lost * at_i.lost * i.z * FRAC_1_PI / self.reflection.lost_average
        } else {
            0.0
        };
        let lobe_pdf = if self.multiple { single + again } else { visible };
        let fresnel = self.f0 + (Vec3::splat(self.f90) - self.f0) * w;
        let entering = 1.0 - fresnel.max_element();
        if below {
            let share = dielectric * self.transmission;
            let f = entering * single + (1.0 - self.coat_again.max_element()) * again;
            return (self.base * (share * f), choice.transmission * lobe_pdf);
        }
        let metal = self.base + (Vec3::ONE - self.base) * w;
        let mut f = self.metallic * (metal * single + self.metal_again * again)
            + dielectric * (fresnel * single + self.coat_again * again);
        let opaque = dielectric * (1.0 - self.transmission);
        let mut pdf = choice.reflection * lobe_pdf;
        if opaque > 0.0 {
            let below_coat = if self.multiple {
                (1.0 - self.coat_albedo(at_o)) * (1.0 - self.coat_albedo(at_i)) / self.base_average.max(1e-6)
            } else {
                entering
            };
            f += self.base * (opaque * below_coat * i.z * FRAC_1_PI);
            pdf += choice.diffuse * i.z * FRAC_1_PI;
        }
        (f, pdf)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let o = above(wo);
        let at_o = self.reflection.directional(o.z);
        let choice = self.choice(o, at_o);
        let (below, chosen, rest) = if u_lobe < choice.reflection {
            (false, choice.reflection, u_lobe / choice.reflection)
        } else if u_lobe < choice.reflection + choice.transmission {
            (true, choice.transmission, (u_lobe - choice.reflection) / choice.transmission)
        } else {
            let i = warp::cosine_hemisphere(u);
            return self.finish(wo, o, i, false, at_o, &choice);
        };
        if self.is_smooth() {
            return Some(self.sample_delta(wo, o, below, chosen));
        }
        let h = ggx::sample_visible(o, self.alpha, u);
        let mirrored = 2.0 * o.dot(h) * h - o;
        let passed = if mirrored.z > 0.0 { ggx::masking(mirrored, self.alpha) } else { 0.0 };
        let i = if !self.multiple || rest < passed {
            mirrored
        } else {
            let mu = self.reflection.sample_lost(warp::clamp_unit((rest - passed) / (1.0 - passed)));
            let r = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
            let (sin, cos) = (TAU * warp::scramble(u, u_lobe)).sin_cos();
            Vec3::new(r * cos, r * sin, mu)
        };
        self.finish(wo, o, i.normalize(), below, at_o, &choice)
    }

    fn finish(
        &self,
        wo: Vec3,
        o: Vec3,
        i: Vec3,
        below: bool,
        at_o: Directional,
        choice: &Choice,
    ) -> Option<BsdfSample> {
        if i.z <= 0.0 {
            return None;
        }
        let (f, pdf) = self.above_eval_pdf(o, i, below, at_o, choice);
        if !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        Some(BsdfSample { wi: placed(i, wo, below), weight: f / pdf, pdf, delta: false, transmitted: below })
    }

    fn sample_delta(&self, wo: Vec3, o: Vec3, below: bool, chosen: f32) -> BsdfSample {
        let i = Vec3::new(-o.x, -o.y, o.z);
        let w = schlick_weight(o.z);
        let fresnel = self.f0 + (Vec3::splat(self.f90) - self.f0) * w;
        let dielectric = 1.0 - self.metallic;
        let f = if below {
            self.base * (dielectric * self.transmission * (1.0 - fresnel.max_element()))
        } else {
            self.metallic * (self.base + (Vec3::ONE - self.base) * w) + dielectric * fresnel
        };
        BsdfSample {
            wi: placed(i, wo, below),
            weight: f / chosen,
            pdf: chosen,
            delta: true,
            transmitted: below,
        }
    }

    /// max over channels of E = f0 (1 − L − E_w) + f90 E_w + F_ms L.
    #[inline]
    fn coat_albedo(&self, d: Directional) -> f32 {
        let f0 = self.f0.max_element();
        let again = self.coat_again.max_element();
        f0 * (1.0 - d.lost - d.schlick) + self.f90 * d.schlick + again * d.lost
    }

    /// How light from a cosine is spread.
    pub(super) fn spread(&self, mu: f32) -> Spread {
        let entering = |mu| 1.0 - self.coat_albedo(self.reflection.directional(mu));
        let diffuse = (1.0 - self.metallic) * entering(mu) * (1.0 - self.transmission);
        Spread {
            facets: Facets::isotropic(self.alpha),
            share: 1.0,
            diffuse: diffuse.clamp(0.0, 1.0),
            grazing: base::grazing(entering(1.0), self.base_average),
        }
    }

    /// How rough it is to a coat on it: 1 where it is diffuse, the perceptual roughness where it is a metal.
    pub(super) fn seen_roughness(&self) -> f32 {
        1.0 - self.metallic * (1.0 - self.alpha.sqrt())
    }

    /// Chooses among the lobes by their albedos.
    fn choice(&self, o: Vec3, at_o: Directional) -> Choice {
        let mean = |c: Vec3| (c.x + c.y + c.z) * (1.0 / 3.0);
        let dielectric = 1.0 - self.metallic;
        let kept = 1.0 - at_o.lost - at_o.schlick;
        let base = mean(self.base);
        let coat = mean(self.f0) * kept + self.f90 * at_o.schlick + mean(self.coat_again) * at_o.lost;
        let metal = base * kept + at_o.schlick + mean(self.metal_again) * at_o.lost;
        let through = dielectric * base * (1.0 - self.coat_albedo(at_o)).max(0.0);
        debug_assert!(o.z >= 0.0, "o = {o}");
        let least = |x: f32, exists: bool| if exists { x.max(LEAST_CHOICE) } else { 0.0 };
        let reflection =
            least(self.metallic * metal + dielectric * coat, self.metallic > 0.0 || self.f90 > 0.0);
        let has_base = dielectric > 0.0 && base > 0.0;
        let diffuse = least(through * (1.0 - self.transmission), has_base && self.transmission < 1.0);
        let transmission = least(through * self.transmission, has_base && self.transmission > 0.0);
        let sum = reflection + diffuse + transmission;
        if sum <= 0.0 {
            return Choice { reflection: 1.0, diffuse: 0.0, transmission: 0.0 };
        }
        Choice { reflection: reflection / sum, diffuse: diffuse / sum, transmission: transmission / sum }
    }
}

#[inline]
fn above(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, w.z.abs())
}

/// `i`, given above the surface, on the side of `wo` or `below` on the other.
#[inline]
fn placed(i: Vec3, wo: Vec3, below: bool) -> Vec3 {
    if (wo.z > 0.0) == below { Vec3::new(i.x, i.y, -i.z) } else { i }
}

#[cfg(test)]
#[path = "metallic_roughness_tests.rs"]
mod tests;
