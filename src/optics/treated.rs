//! A refracting boundary whose facets are not those of a bare dielectric: KHR_materials_specular, _iridescence and
//! _anisotropy on a material that lets light into its volume.
//!
//! With F the exact reflectance, F0 that at normal incidence, and w = (F − F0)/(1 − F0) in the place of Schlick's weight,
//!
//! ```text
//! F' = s (F0 color + (1 − F0 color) w),      F' = 1 under total internal reflection,
//! ```
//!
//! blended with the reflectance of a film on a base of s F0 color, at the same angle outside. Directions are those of
//! the bare dielectric. F' depends on the facet alone, whichever side the light comes from, so the boundary is
//! reciprocal, and what is not reflected crosses. Light lost by masking comes back as at the bare boundary
//! (`docs/boundary.md` §5), as much as facets of F' lose in each direction ([`super::boundary_losses`]).

use super::anisotropic::Facets;
use super::boundary::{MATCHED_INDEX, Microfacet};
use super::boundary_losses::{Losses, Treatment};
use super::boundary_tables::{self, MIN_ROUGH_ALPHA};
use super::facet_tables::HATS;
use super::fresnel::{self, Interface};
use super::thin_film::ThinFilm;
use super::{BsdfSample, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A boundary between two dielectrics, with treated facets.
#[derive(Clone, Copy, Debug)]
pub struct TreatedBoundary {
    eta: f32,
    facets: Facets,
    tint: Vec3,
    /// s, and F0 · color.
    strength: f32,
    f0: Vec3,
    film: Option<(f32, ThinFilm)>,
    /// Whether what is lost comes back, and how, once all of the treatment is known.
    multiple: bool,
    losses: Option<Losses>,
}

/// What facets do with light that meets them at one angle.
struct Meeting {
    reflected: Vec3,
    /// Probability of choosing reflection.
    p: f32,
    g: f32,
}

impl TreatedBoundary {
    /// A boundary of index `eta` (at z < 0 over z > 0). `specular` and `color` are those of KHR_materials_specular, `tint`
    /// multiplies light at each crossing.
    pub fn new(eta: f32, facets: Facets, microfacet: Microfacet, tint: Vec3) -> Self {
        let rough = facets.alpha.max_element() >= MIN_ROUGH_ALPHA && (eta - 1.0).abs() > MATCHED_INDEX;
        let f0 = Vec3::splat(fresnel::f0_from_eta(eta));
        let multiple = rough && microfacet == Microfacet::Multiple;
        Self { eta, facets, tint, strength: 1.0, f0, film: None, multiple, losses: None }.compensated()
    }

    /// With the losses of its treatment.
    fn compensated(mut self) -> Self {
        self.losses = self.multiple.then(|| Losses::new(self.eta, &self.facets, self.treatment()));
        self
    }

    /// Its reflectance by that of the bare boundary.
    fn treatment(&self) -> Treatment {
        let normal = fresnel::f0_from_eta(self.eta);
        // f + (1 − f) w by the reflectance F.
        let line = |f: Vec3| {
            let slope = (Vec3::ONE - f) / (1.0 - normal);
            (f - slope * normal, slope)
        };
        let (a, b) = line(self.f0);
        let (a, b) = (self.strength * a, self.strength * b);
        let Some((share, film)) = &self.film else { return Treatment { a, b, rest: None } };
        let at_normal = film.reflectance(1.0);
        let (c, d) = line(at_normal);
        let rest: [Vec3; HATS] = std::array::from_fn(|k| {
            let cos = k as f32 / (HATS - 1) as f32;
            let bare = fresnel::dielectric(cos, self.eta.max(1.0 / self.eta));
            *share * (film.reflectance(cos) - c - d * bare)
        });
        Treatment { a: a + *share * (c - a), b: b + *share * (d - b), rest: Some(rest) }
    }

    /// With the factor and colour of KHR_materials_specular.
    #[must_use]
    pub fn with_specular(mut self, factor: f32, color: Vec3) -> Self {
        self.strength = factor.clamp(0.0, 1.0);
        self.f0 = (self.f0 * color).clamp(Vec3::ZERO, Vec3::ONE);
        self.compensated()
    }

    /// With a thin film on a share of it.
    #[must_use]
    pub fn with_film(mut self, share: f32, film: ThinFilm) -> Self {
        self.film = Some((share, film));
        self.compensated()
    }

    pub(super) fn set_tangent(&mut self, tangent: Vec2) {
        self.facets.tangent = tangent;
    }

    /// F0 with the factor and colour of KHR_materials_specular: what a film lies on.
    pub fn f0(&self) -> Vec3 {
        self.strength * self.f0
    }

    /// Index at z < 0 over index at z > 0.
    pub fn eta(&self) -> f32 {
        self.eta
    }

    pub(super) fn facets(&self) -> &Facets {
        &self.facets
    }

    /// Mean reflectance at a cosine outside.
    pub(super) fn reflected_outside(&self, mu: f32) -> f32 {
        self.meet(mu, true).reflected.element_sum() * (1.0 / 3.0)
    }

    /// A direction outside to which a visible facet refracts light from the turned direction `o` inside, and the share that
    /// gets there.
    pub(super) fn emerging(&self, o: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        let h = self.facets.sample_visible(o, u);
        let c = o.dot(h).clamp(0.0, 1.0);
        let m = self.meet(c, false);
        let out = (m.g > 0.0).then(|| fresnel::refract_with(o, h, c, m.g, 1.0 / self.eta))?;
        let crossed = 1.0 - m.reflected.element_sum() * (1.0 / 3.0);
        (out.z < 0.0).then(|| (Vec3::new(out.x, out.y, -out.z), crossed * self.passed(o, out)))
    }

    /// Share of light from the turned direction `o` inside that compensation sends outside.
    pub(super) fn lost_inside(&self, o: Vec3) -> f32 {
        let (here, _, lost) = self.lost(false, o);
        self.losses.as_ref().map_or(0.0, |l| lost * l.crossing(here))
    }

    /// Density of what compensation sends to the turned direction `i` outside, over that of Lambert's law.
    pub(super) fn handed_back(&self, i: Vec3) -> f32 {
        let (here, _, lost) = self.lost(true, i);
        self.losses.as_ref().map_or(1.0, |l| lost / l.average(here).max(f32::MIN_POSITIVE))
    }

    /// Share of refracted light that is not masked on its way out, given that it was visible from `o`.
    fn passed(&self, o: Vec3, i: Vec3) -> f32 {
        let out = self.facets.masking(i);
        if self.losses.is_none() {
            return out;
        }
        let correlation = boundary_tables::correlation(self.eta);
        let seen = self.facets.masking(o);
        (1.0 - correlation) * out + correlation * (out / seen.max(f32::MIN_POSITIVE)).min(1.0)
    }

    /// Whether every sample is a delta.
    pub fn is_delta(&self) -> bool {
        self.facets.alpha.max_element() < MIN_ROUGH_ALPHA || (self.eta - 1.0).abs() <= MATCHED_INDEX
    }

    fn meet(&self, c: f32, outside: bool) -> Meeting {
        let eta = if outside { self.eta } else { 1.0 / self.eta };
        let Interface { reflectance, g } = fresnel::interface(c.clamp(0.0, 1.0), eta);
        self.treat(c, g, reflectance, outside)
    }

    /// As [`TreatedBoundary::meet`], given F and g = η cos θ_t.
    fn treat(&self, c: f32, g: f32, reflectance: f32, outside: bool) -> Meeting {
        if g <= 0.0 {
            return Meeting { reflected: Vec3::ONE, p: 1.0, g: 0.0 };
        }
        let f0 = fresnel::f0_from_eta(self.eta);
        let w = ((reflectance - f0) / (1.0 - f0)).clamp(0.0, 1.0);
        let mut reflected = self.strength * (self.f0 + (Vec3::ONE - self.f0) * w);
        if let Some((share, film)) = &self.film {
            let cos_outside = if outside { c } else { (g * self.eta).min(1.0) };
            reflected += *share * (film.reflectance(cos_outside) - reflected);
        }
        let p = (reflected.element_sum() * (1.0 / 3.0)).clamp(0.0, 1.0);
        // Both ways stay possible, since channels differ.
        let p = if reflected == Vec3::ONE { 1.0 } else { p.clamp(0.01, 0.99) };
        Meeting { reflected, p, g }
    }

    /// tint · (n_o/n_i)².
    fn crossing_weight(&self, wo: Vec3) -> Vec3 {
        self.tint * if wo.z > 0.0 { self.eta.powi(-2) } else { self.eta.powi(2) }
    }

    /// Which side of the tables light above a side is on, what is lost from the turned direction, and its mean.
    fn lost(&self, outside: bool, w: Vec3) -> (usize, Vec3, f32) {
        let here = usize::from((self.eta < 1.0) == outside);
        let lost = self.losses.as_ref().map_or(Vec3::ZERO, |l| l.lost(here, w));
        (here, lost, lost.element_sum() * (1.0 / 3.0))
    }

    /// f·|cos θ_i| and the density of [`TreatedBoundary::sample`]; zero for a delta.
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if self.is_delta() || wo.z == 0.0 || wi.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let outside = wo.z > 0.0;
        let eta = if outside { self.eta } else { 1.0 / self.eta };
        let o = self.facets.turned(Vec3::new(wo.x, wo.y, wo.z.abs()));
        let i = self.facets.turned(Vec3::new(wi.x, wi.y, if outside { wi.z } else { -wi.z }));
        let (here, lost, share) = self.lost(outside, o);
        let (single, density) =
            if i.z > 0.0 { self.reflected(o, i, outside) } else { self.refracted(o, i, outside, eta) };
        let (mut f, mut pdf) = (single, (1.0 - share) * density);
        if let Some(losses) = &self.losses {
            f += losses.again(here, lost, i);
            let crossing = losses.crossing(here);
            let side = if i.z < 0.0 { crossing } else { 1.0 - crossing };
            pdf += share * side * i.z.abs() * FRAC_1_PI;
        }
        (if i.z > 0.0 { f } else { self.crossing_weight(wo) * f }, pdf)
    }

    fn reflected(&self, o: Vec3, i: Vec3, outside: bool) -> (Vec3, f32) {
        let h = (o + i).normalize_or(Vec3::Z);
        let c = o.dot(h);
        if c <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let visible = 0.5 * self.facets.distribution(h) * self.facets.masking_over_two_cos(o);
        let m = self.meet(c, outside);
        (m.reflected * (visible * self.facets.masking(i)), m.p * visible)
    }

    /// As the bare boundary has it, with the same care for η near 1.
    fn refracted(&self, o: Vec3, i: Vec3, outside: bool, eta: f32) -> (Vec3, f32) {
        let sum = (o + i) + (eta - 1.0) * i;
        let h = if eta > 1.0 { -sum } else { sum }.normalize_or_zero();
        let (c, g) = (o.dot(h), -eta * i.dot(h));
        if h.z <= 0.0 || c <= 0.0 || g <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let ratio = (c + g) / ((1.0 - eta) * (1.0 + eta));
        let jacobian = eta * g * ratio * ratio;
        let visible = 2.0 * self.facets.masking_over_two_cos(o) * self.facets.distribution(h) * c * jacobian;
        let m = self.treat(c, g, fresnel::reflectance(c, g, eta), outside);
        let passed = self.passed(o, i);
        ((Vec3::ONE - m.reflected) * (visible * passed), (1.0 - m.p) * visible)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        if (self.eta - 1.0).abs() <= MATCHED_INDEX {
            return Some(BsdfSample { wi: -wo, weight: self.tint, pdf: 1.0, delta: true, transmitted: true });
        }
        let outside = wo.z > 0.0;
        let sign = if outside { 1.0 } else { -1.0 };
        let eta = if outside { self.eta } else { 1.0 / self.eta };
        let o = self.facets.turned(Vec3::new(wo.x, wo.y, wo.z.abs()));
        let delta = self.is_delta();
        let (here, _, lost) = self.lost(outside, o);
        let (again, rest) = if delta { (1, u_lobe) } else { warp::choose(&[lost, 1.0 - lost], u_lobe) };
        let (i, meeting, reflects) = if let (0, Some(losses)) = (again, &self.losses) {
            let i = warp::cosine_hemisphere(u);
            (if rest < losses.crossing(here) { Vec3::new(i.x, i.y, -i.z) } else { i }, None, false)
        } else {
            let h = if delta { Vec3::Z } else { self.facets.sample_visible(o, u) };
            let c = o.dot(h).max(0.0);
            let m = self.meet(c, outside);
            if rest < m.p {
                (Some(2.0 * c * h - o).filter(|i| i.z > 0.0)?, Some(m), true)
            } else {
                (Some(fresnel::refract_with(o, h, c, m.g, eta)).filter(|i| i.z < 0.0)?, Some(m), false)
            }
        };
        let i = self.facets.back(i.normalize());
        let transmitted = i.z < 0.0;
        let wi = Vec3::new(i.x, i.y, i.z * sign);
        if let (true, Some(m)) = (delta, meeting) {
            let (weight, pdf) = if reflects {
                (m.reflected / m.p, m.p)
            } else {
                (self.crossing_weight(wo) * (Vec3::ONE - m.reflected) / (1.0 - m.p), 1.0 - m.p)
            };
            return Some(BsdfSample { wi, weight, pdf, delta: true, transmitted });
        }
        let (f, pdf) = self.eval_pdf(wo, wi);
        let valid = pdf > 0.0 && pdf.is_finite();
        valid.then(|| BsdfSample { wi, weight: f / pdf, pdf, delta: false, transmitted })
    }
}

#[cfg(test)]
#[path = "treated_tests.rs"]
mod tests;
