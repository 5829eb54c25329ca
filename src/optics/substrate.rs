//! The opaque or thin surface of glTF in full generality: what [`super::metallic_roughness`] has, with microfacets of two
//! widths, a thin film, and diffuse light that comes out on the other side. Plain surfaces use the plain code, which is
//! faster; where both apply they agree.
//!
//! | name | meaning |
//! | --- | --- |
//! | `metal`, `dielectric` | reflectance of the facets of the metal and of the coat of the dielectric |
//! | `diffuse` | Lambertian reflection below the coat |
//! | `through` | Lambertian transmission below the coat |
//! | `straight` | transmission by facets that a thin wall does not bend |
//!
//! Below the dielectric's coat, (1 − E(µ_o))(1 − E(µ_i))/(1 − Ē) couples the Lambertian lobes with it on both sides
//! (Kelemen & Szirmay-Kalos 2001). A diffuse boundary of a denser medium lets out only 1/η² of what it would let in, and
//! reflects the rest: radiance of equal étendue is exchanged.

use super::anisotropic::{self, Facets};
use super::base::Spread;
use super::boundary::Microfacet;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::fresnel::f0_from_eta;
use super::metallic_roughness::SurfaceParameters;
use super::reflectance::{NODES, Reflectance};
use super::reflection_tables::{Directional, Reflection};
use super::thin_film::ThinFilm;
use super::{BsdfSample, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Parameters of a [`Substrate`], as glTF has them, textures applied.
#[derive(Clone, Copy, Debug)]
pub struct SubstrateParameters {
    /// What plain surfaces have; its `alpha` does not count.
    pub plain: SurfaceParameters,
    /// Widths of the microfacets.
    pub facets: Facets,
    /// Share of a film, its index of refraction and its thickness in nanometres.
    pub film: Option<(f32, f32, f32)>,
    /// Share of the diffuse light that is transmitted diffusely, and its colour.
    pub diffuse_transmission: (f32, Vec3),
    /// Of what a thin wall transmits: the share that is scattered, its colour, and the share of that which goes on.
    pub scatter: (f32, Vec3, f32),
    /// Index of the medium below over that above, where diffuse light enters one; 1 for a thin wall.
    pub eta: f32,
}

/// What a [`Substrate`] is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ingredients {
    pub metallic: f32,
    pub metal: Reflectance,
    pub dielectric: Reflectance,
    pub facets: Facets,
    pub diffuse: Vec3,
    pub through: Vec3,
    pub straight: Vec3,
    /// Index of what is below over that of what is above, for diffuse light.
    pub eta: f32,
    pub microfacet: Microfacet,
}

/// An opaque surface or thin wall.
#[derive(Clone, Copy, Debug)]
pub struct Substrate {
    i: Ingredients,
    reflection: Reflection,
    metal_again: Vec3,
    coat_again: Vec3,
    /// 1 − Ē of the coat.
    entering: f32,
}

/// Probabilities of the lobes.
struct Choice {
    reflect: f32,
    straight: f32,
    diffuse: f32,
    through: f32,
    /// Share of light that is reflected several times, in the choice of a direction of the facets' lobes.
    again: f32,
}

const LEAST_CHOICE: f32 = 0.02;

impl Substrate {
    /// The surface with these parameters.
    pub fn new(p: &SubstrateParameters) -> Self {
        let base = p.plain.base_color.clamp(Vec3::ZERO, Vec3::ONE);
        let normal = if p.plain.ior == 0.0 { 1.0 } else { f0_from_eta(p.plain.ior) };
        let f0 = (normal * p.plain.specular_color).min(Vec3::ONE) * p.plain.specular;
        let film = |f0| p.film.map(|(_, ior, thickness)| ThinFilm::new(ior, thickness, f0));
        let share = p.film.map_or(0.0, |f| f.0);
        let (d, d_color) = p.diffuse_transmission;
        let (s, s_color, forward) = p.scatter;
        let t = p.plain.transmission;
        let scattered = s_color * (t * s);
        Self::of(Ingredients {
            metallic: p.plain.metallic,
            metal: Reflectance::schlick(base, 1.0).with_film(share, film(base)),
            dielectric: Reflectance::schlick(f0, p.plain.specular).with_film(share, film(f0)),
            facets: p.facets,
            diffuse: base * ((1.0 - t) * (1.0 - d)) + scattered * (1.0 - forward),
            through: d_color * ((1.0 - t) * d) + scattered * forward,
            straight: base * (t * (1.0 - s)),
            eta: p.eta,
            microfacet: p.plain.microfacet,
        })
    }

    fn of(i: Ingredients) -> Self {
        let reflection = Reflection::at(i.facets.mean_width(anisotropic::REFLECTED));
        let zero = Vec3::ZERO;
        let mut s = Self { i, reflection, metal_again: zero, coat_again: zero, entering: 1.0 };
        if s.multiple() {
            s.metal_again = i.metal.again(reflection.lost_average);
            s.coat_again = i.dielectric.again(reflection.lost_average);
        }
        let coat: f32 = NODES
            .iter()
            .map(|&(mu, weight)| 2.0 * mu * weight * s.coat_albedo(reflection.directional(mu)))
            .sum();
        s.entering = (1.0 - coat).max(1e-6);
        s
    }

    pub(super) fn set_tangent(&mut self, tangent: Vec2) {
        self.i.facets.tangent = tangent;
    }

    fn multiple(&self) -> bool {
        self.i.microfacet == Microfacet::Multiple
    }

    fn is_smooth(&self) -> bool {
        self.i.facets.alpha.max_element() < MIN_ROUGH_ALPHA
    }

    /// Whether every sample is a delta.
    pub fn is_delta(&self) -> bool {
        let lambertian = self.i.diffuse + self.i.through;
        self.is_smooth() && (self.i.metallic >= 1.0 || lambertian == Vec3::ZERO)
    }

    /// How it spreads the light that it reflects.
    pub(super) fn spread(&self) -> Spread {
        let dielectric = 1.0 - self.i.metallic;
        let opaque = self.i.diffuse + self.i.through;
        let color =
            self.i.metallic * self.i.metal.average() + dielectric * (opaque + self.i.dielectric.average());
        let lambertian = dielectric * opaque.max_element().min(1.0);
        Spread {
            lambertian,
            alpha: self.i.facets.mean_width(anisotropic::REFLECTED),
            color: color.min(Vec3::ONE),
        }
    }

    fn coat_albedo(&self, d: Directional) -> f32 {
        (self.i.dielectric.albedo(d) + self.coat_again * d.lost).max_element().min(1.0)
    }

    /// Colour of the Lambertian lobes on the side of `wo` and beyond it.
    fn lambertian(&self, outside: bool) -> (Vec3, Vec3) {
        let Ingredients { diffuse, through, eta, .. } = self.i;
        // Energy that is exchanged in equilibrium is limited by the rarer side.
        let ratio = if outside { eta.min(1.0).powi(2) } else { (1.0 / eta).min(1.0).powi(2) };
        (diffuse + through * (1.0 - ratio), through * ratio)
    }

    fn choice(&self, wo: Vec3, d: Directional) -> Choice {
        let dielectric = 1.0 - self.i.metallic;
        let mean = |c: Vec3| c.element_sum() * (1.0 / 3.0);
        let coat = self.i.dielectric.albedo(d) + self.coat_again * d.lost;
        let metal = self.i.metal.albedo(d) + self.metal_again * d.lost;
        let below = dielectric * (1.0 - self.coat_albedo(d));
        let (here, there) = self.lambertian(wo.z > 0.0);
        let least = |x: f32, exists: bool| if exists { x.max(LEAST_CHOICE) } else { 0.0 };
        let exists = |c: Vec3| dielectric > 0.0 && c.max_element() > 0.0;
        let reflect = mean(self.i.metallic * metal + dielectric * coat);
        let c = Choice {
            reflect: least(reflect, reflect > 0.0),
            straight: least(below * mean(self.i.straight), exists(self.i.straight)),
            diffuse: least(below * mean(here), exists(here)),
            through: least(below * mean(there), exists(there)),
            again: if self.multiple() { d.lost } else { 0.0 },
        };
        let sum = c.reflect + c.straight + c.diffuse + c.through;
        if sum <= 0.0 {
            return Choice { reflect: 1.0, ..c };
        }
        Choice {
            reflect: c.reflect / sum,
            straight: c.straight / sum,
            diffuse: c.diffuse / sum,
            through: c.through / sum,
            again: c.again,
        }
    }

    /// f·|cos θ_i| and the density of [`Substrate::sample`], deltas left out.
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if wo.z == 0.0 || wi.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let d = self.reflection.directional(wo.z.abs());
        self.eval_chosen(wo, wi, d, &self.choice(wo, d))
    }

    fn eval_chosen(&self, wo: Vec3, wi: Vec3, d: Directional, choice: &Choice) -> (Vec3, f32) {
        let below = wo.z * wi.z < 0.0;
        let facets = &self.i.facets;
        let (o, i) = (facets.turned(above(wo)), facets.turned(above(wi)));
        let di = self.reflection.directional(i.z);
        let dielectric = 1.0 - self.i.metallic;
        let entering = |d| 1.0 - self.coat_albedo(d);
        let lambert = i.z * FRAC_1_PI * dielectric;
        let coupled = if self.multiple() {
            entering(d) * entering(di) / self.entering
        } else {
            1.0 - self.i.dielectric.at(o.dot((o + i).normalize_or(Vec3::Z))).max_element()
        };
        let (here, there) = self.lambertian(wo.z > 0.0);
        let (mut f, mut pdf) = if below {
            let scale = if wo.z > 0.0 { self.i.eta.powi(-2) } else { self.i.eta.powi(2) };
            (there * (scale * lambert * coupled), choice.through * i.z * FRAC_1_PI)
        } else {
            (here * (lambert * coupled), choice.diffuse * i.z * FRAC_1_PI)
        };
        let chosen = if below { choice.straight } else { choice.reflect };
        if self.is_smooth() || chosen <= 0.0 {
            return (f, pdf);
        }
        let h = (o + i).normalize_or(Vec3::Z);
        let c = o.dot(h).clamp(0.0, 1.0);
        let visible = 0.5 * facets.distribution(h) * facets.masking_over_two_cos(o);
        let single = visible * facets.masking(i);
        let average = self.reflection.lost_average;
        let again =
            if self.multiple() && average > 0.0 { d.lost * di.lost * i.z * FRAC_1_PI / average } else { 0.0 };
        pdf += chosen * ((1.0 - choice.again) * visible + choice.again * i.z * FRAC_1_PI);
        let coat = self.i.dielectric.at(c);
        f += if below {
            let crossed = 1.0 - coat.max_element();
            let again = (1.0 - self.coat_again.max_element()) * again;
            self.i.straight * (dielectric * (crossed * single + again))
        } else {
            self.i.metallic * (self.i.metal.at(c) * single + self.metal_again * again)
                + dielectric * (coat * single + self.coat_again * again)
        };
        (f, pdf)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let d = self.reflection.directional(wo.z.abs());
        let choice = self.choice(wo, d);
        let lobes = [choice.reflect, choice.straight, choice.diffuse, choice.through];
        let (lobe, rest) = warp::choose(&lobes, u_lobe);
        let below = lobe == 1 || lobe == 3;
        let o = self.i.facets.turned(above(wo));
        let i = if lobe >= 2 || (!self.is_smooth() && rest < choice.again) {
            warp::cosine_hemisphere(u)
        } else if self.is_smooth() {
            return Some(self.sample_delta(wo, below, lobes[lobe]));
        } else {
            let h = self.i.facets.sample_visible(o, u);
            self.i.facets.back(2.0 * o.dot(h) * h - o)
        };
        if i.z <= 0.0 {
            return None;
        }
        let wi = placed(i.normalize(), wo, below);
        let (f, pdf) = self.eval_chosen(wo, wi, d, &choice);
        let valid = pdf > 0.0 && pdf.is_finite();
        valid.then(|| BsdfSample { wi, weight: f / pdf, pdf, delta: false, transmitted: below })
    }

    fn sample_delta(&self, wo: Vec3, below: bool, chosen: f32) -> BsdfSample {
        let dielectric = 1.0 - self.i.metallic;
        let c = wo.z.abs().min(1.0);
        let coat = self.i.dielectric.at(c);
        let f = if below {
            self.i.straight * (dielectric * (1.0 - coat.max_element()))
        } else {
            self.i.metallic * self.i.metal.at(c) + dielectric * coat
        };
        let wi = placed(Vec3::new(-wo.x, -wo.y, wo.z.abs()), wo, below);
        BsdfSample { wi, weight: f / chosen, pdf: chosen, delta: true, transmitted: below }
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
#[path = "substrate_tests.rs"]
mod tests;
