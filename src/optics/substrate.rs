//! The opaque or thin surface of glTF in full generality: what [`super::metallic_roughness`] has, with microfacets of two
//! widths, a thin film, diffuse light that comes out on the other side, and diffuse facets. Plain surfaces use the plain
//! code, which is faster; where both apply they agree.
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
//!
//! With `diffuse_roughness` the Lambertian lobes are those of [`super::rough_diffuse`]; for light that goes through, with
//! the mirror image of ω_i below the surface in the place of ω_i.

use super::anisotropic::Facets;
use super::base::{self, Spread};
use super::boundary::Microfacet;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::facet_reflection::{FacetReflection, Shares};
use super::fresnel::f0_from_eta;
use super::metallic_roughness::SurfaceParameters;
use super::reflectance::{NODES, Reflectance};
use super::rough_diffuse::RoughDiffuse;
use super::thin_film::ThinFilm;
use super::{BsdfSample, top, warp};
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
    /// Roughness of the diffuse facets, \[0, 1\]; 0 is Lambert's law.
    pub diffuse_roughness: f32,
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
    reflection: FacetReflection,
    /// A: average share that single scattering loses.
    lost_average: f32,
    metal_again: Vec3,
    coat_again: Vec3,
    /// 1 − Ē of the coat.
    entering: f32,
    rough: Option<Rough>,
}

/// Diffuse facets, and the colours of what they reflect and let through after several events.
#[derive(Clone, Copy, Debug)]
struct Rough {
    lobes: RoughDiffuse,
    diffuse: Vec3,
    through: Vec3,
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
        let shares = |base: Vec3, d_color: Vec3, s_color: Vec3| {
            let scattered = s_color * (t * s);
            let diffuse = base * ((1.0 - t) * (1.0 - d)) + scattered * (1.0 - forward);
            (diffuse, d_color * ((1.0 - t) * d) + scattered * forward)
        };
        let (diffuse, through) = shares(base, d_color, s_color);
        let mut surface = Self::of(Ingredients {
            metallic: p.plain.metallic,
            metal: Reflectance::schlick(base, 1.0).with_film(share, film(base)),
            dielectric: Reflectance::schlick(f0, p.plain.specular).with_film(share, film(f0)),
            facets: p.facets,
            diffuse,
            through,
            straight: base * (t * (1.0 - s)),
            eta: p.eta,
            microfacet: p.plain.microfacet,
        });
        if p.diffuse_roughness > 0.0 {
            let lobes = if surface.multiple() {
                RoughDiffuse::new(p.diffuse_roughness, surface.entering, |mu| surface.mean_coat(mu))
            } else {
                RoughDiffuse::new(p.diffuse_roughness, 1.0, |_| 0.0)
            };
            let (diffuse, through) = shares(lobes.again(base), lobes.again(d_color), lobes.again(s_color));
            surface.rough = Some(Rough { lobes, diffuse, through });
        }
        surface
    }

    fn of(i: Ingredients) -> Self {
        let film = i.metal.has_film() || i.dielectric.has_film();
        let reflection = FacetReflection::new(&i.facets, film);
        let average = reflection.average();
        let zero = Vec3::ZERO;
        let (metal_again, coat_again) = if i.microfacet == Microfacet::Multiple {
            (i.metal.again(average.lost), i.dielectric.again(average.lost))
        } else {
            (zero, zero)
        };
        let lost_average = average.lost;
        let mut s = Self { i, reflection, lost_average, metal_again, coat_again, entering: 1.0, rough: None };
        let coat =
            if film { s.average_coat() } else { s.coat_albedo(&Shares { plain: average, hats: None }) };
        s.entering = (1.0 - coat).max(1e-6);
        s
    }

    /// Ē of the coat, whose strongest channel depends on the direction.
    fn average_coat(&self) -> f32 {
        NODES.iter().map(|&(mu, weight)| 2.0 * mu * weight * self.mean_coat(mu)).sum()
    }

    /// E of the coat at a cosine, averaged over azimuths.
    fn mean_coat(&self, mu: f32) -> f32 {
        // Facets of one width look the same from all sides.
        let azimuths: &[f32] =
            if self.i.facets.alpha.x == self.i.facets.alpha.y { &[0.0] } else { &top::QUARTER };
        let at = |&phi: &f32| self.coat_albedo(&self.reflection.towards(top::towards(mu, phi)));
        azimuths.iter().map(at).sum::<f32>() / azimuths.len() as f32
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

    pub(super) fn facets(&self) -> &Facets {
        &self.i.facets
    }

    /// How light from a turned direction is spread.
    pub(super) fn spread(&self, w: Vec3) -> Spread {
        let entering = |w| 1.0 - self.coat_albedo(&self.reflection.towards(w));
        let opaque = self.i.diffuse + self.i.through;
        let share = opaque.max_element() / (opaque + self.i.straight).max_element().max(1e-6);
        Spread {
            facets: self.i.facets,
            share: 1.0,
            diffuse: ((1.0 - self.i.metallic) * entering(w) * share).clamp(0.0, 1.0),
            grazing: base::grazing(entering(Vec3::Z), self.entering),
        }
    }

    /// Mean colour of what it sends back.
    pub(super) fn color(&self) -> Vec3 {
        let opaque = self.i.diffuse + self.i.through + self.i.dielectric.average();
        let color = self.i.metallic * self.i.metal.average() + (1.0 - self.i.metallic) * opaque;
        color.min(Vec3::ONE)
    }

    /// How rough it is to a coat on it: 1 where it is diffuse, the perceptual roughness where it is a metal.
    pub(super) fn seen_roughness(&self) -> f32 {
        1.0 - self.i.metallic * (1.0 - self.i.facets.mean_width(1.0).sqrt())
    }

    fn coat_albedo(&self, s: &Shares) -> f32 {
        (self.i.dielectric.albedo(s) + self.coat_again * s.plain.lost).max_element().min(1.0)
    }

    /// Colour of the Lambertian lobes on the side of `wo` and beyond it.
    fn lambertian(&self, outside: bool) -> (Vec3, Vec3) {
        self.divided(self.i.diffuse, self.i.through, outside)
    }

    fn divided(&self, diffuse: Vec3, through: Vec3, outside: bool) -> (Vec3, Vec3) {
        let eta = self.i.eta;
        // Energy that is exchanged in equilibrium is limited by the rarer side.
        let ratio = if outside { eta.min(1.0).powi(2) } else { (1.0 / eta).min(1.0).powi(2) };
        (diffuse + through * (1.0 - ratio), through * ratio)
    }

    fn choice(&self, wo: Vec3, s: &Shares) -> Choice {
        let dielectric = 1.0 - self.i.metallic;
        let mean = |c: Vec3| c.element_sum() * (1.0 / 3.0);
        let lost = s.plain.lost;
        let coat = self.i.dielectric.albedo(s) + self.coat_again * lost;
        let metal = self.i.metal.albedo(s) + self.metal_again * lost;
        let below = dielectric * (1.0 - self.coat_albedo(s));
        let (here, there) = self.lambertian(wo.z > 0.0);
        let least = |x: f32, exists: bool| if exists { x.max(LEAST_CHOICE) } else { 0.0 };
        let exists = |c: Vec3| dielectric > 0.0 && c.max_element() > 0.0;
        let reflect = mean(self.i.metallic * metal + dielectric * coat);
        let c = Choice {
            reflect: least(reflect, reflect > 0.0),
            straight: least(below * mean(self.i.straight), exists(self.i.straight)),
            diffuse: least(below * mean(here), exists(here)),
            through: least(below * mean(there), exists(there)),
            again: if self.multiple() { lost } else { 0.0 },
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
        let s = self.reflection.towards(self.i.facets.turned(wo));
        self.eval_chosen(wo, wi, &s, &self.choice(wo, &s))
    }

    fn eval_chosen(&self, wo: Vec3, wi: Vec3, at_o: &Shares, choice: &Choice) -> (Vec3, f32) {
        let below = wo.z * wi.z < 0.0;
        let facets = &self.i.facets;
        let (o, i) = (facets.turned(above(wo)), facets.turned(above(wi)));
        let at_i = &self.reflection.towards(i);
        let dielectric = 1.0 - self.i.metallic;
        let entering = |s| 1.0 - self.coat_albedo(s);
        let lambert = i.z * FRAC_1_PI * dielectric;
        let coupled = if self.multiple() {
            entering(at_o) * entering(at_i) / self.entering
        } else {
            1.0 - self.i.dielectric.at(o.dot((o + i).normalize_or(Vec3::Z))).max_element()
        };
        let outside = wo.z > 0.0;
        let (here, there) = self.lambertian(outside);
        let scale = if outside { self.i.eta.powi(-2) } else { self.i.eta.powi(2) };
        let ((color, scale), share) =
            if below { ((there, scale), choice.through) } else { ((here, 1.0), choice.diffuse) };
        let (mut f, mut pdf) = match &self.rough {
            None => (color * (scale * lambert * coupled), share * i.z * FRAC_1_PI),
            Some(rough) => {
                let (shares, coupled) = if self.multiple() {
                    ([entering(at_o), entering(at_i)], 1.0)
                } else {
                    ([1.0, 1.0], coupled)
                };
                let [once, more] = rough.lobes.eval(o, i, shares[0], shares[1]);
                let (here, there) = self.divided(rough.diffuse, rough.through, outside);
                let again = if below { there } else { here };
                let f = (color * once + again * more) * (scale * coupled * dielectric);
                (f, share * rough.lobes.pdf(o, i))
            }
        };
        let chosen = if below { choice.straight } else { choice.reflect };
        if self.is_smooth() || chosen <= 0.0 {
            return (f, pdf);
        }
        let h = (o + i).normalize_or(Vec3::Z);
        let c = o.dot(h).clamp(0.0, 1.0);
        let visible = 0.5 * facets.distribution(h) * facets.masking_over_two_cos(o);
        let single = visible * facets.masking(i);
        let average = self.lost_average;
        let again = if self.multiple() && average > 0.0 {
            at_o.plain.lost * at_i.plain.lost * i.z * FRAC_1_PI / average
        } else {
            0.0
        };
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
        let s = self.reflection.towards(self.i.facets.turned(wo));
        let choice = self.choice(wo, &s);
        let lobes = [choice.reflect, choice.straight, choice.diffuse, choice.through];
        let (lobe, rest) = warp::choose(&lobes, u_lobe);
        let below = lobe == 1 || lobe == 3;
        let o = self.i.facets.turned(above(wo));
        let i = if let (2.., Some(rough)) = (lobe, &self.rough) {
            self.i.facets.back(rough.lobes.sample(o, rest, u))
        } else if lobe >= 2 || (!self.is_smooth() && rest < choice.again) {
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
        let (f, pdf) = self.eval_chosen(wo, wi, &s, &choice);
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
