//! A refracting boundary whose facets are not those of a bare dielectric: KHR_materials_specular, _iridescence and
//! _anisotropy on a material that lets light into its volume.
//!
//! With F the exact reflectance, F0 that at normal incidence, and w = (F − F0)/(1 − F0) in the place of Schlick's weight,
//!
//! ```text
//! F' = s (F0 color + (1 − F0 color) w),      F' = 1 under total internal reflection,
//! ```
//!
//! blended with the reflectance of a film on a base of s F0 color, at the same angle outside. Directions are those of the bare dielectric. F' depends on
//! the facet alone, whichever side the light comes from, so the boundary is reciprocal, and what is not reflected crosses.
//! Light lost by masking comes back by the tables of the bare boundary (`docs/boundary.md` §5), weighed as they are: exact where F' = F.

use super::anisotropic::{self, Facets};
use super::boundary::{MATCHED_INDEX, Microfacet, lost_energy, sample_lost};
use super::boundary_tables::{self, BoundaryTables, Compensation, MIN_ROUGH_ALPHA};
use super::fresnel::{self, Interface};
use super::thin_film::ThinFilm;
use super::{BsdfSample, warp};
use glam::{Vec2, Vec3};

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
    compensation: Option<(Compensation<'static>, f32)>,
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
        let compensation = (rough && microfacet == Microfacet::Multiple).then(|| {
            let widths = anisotropic::BOUNDARY.map(|p| facets.mean_width(p));
            (BoundaryTables::get(eta).at_each(widths), boundary_tables::correlation(eta))
        });
        let f0 = Vec3::splat(fresnel::f0_from_eta(eta));
        Self { eta, facets, tint, strength: 1.0, f0, film: None, compensation }
    }

    /// With the factor and colour of KHR_materials_specular.
    #[must_use]
    pub fn with_specular(mut self, factor: f32, color: Vec3) -> Self {
        self.strength = factor.clamp(0.0, 1.0);
        self.f0 = (self.f0 * color).clamp(Vec3::ZERO, Vec3::ONE);
        self
    }

    /// With a thin film on a share of it.
    #[must_use]
    pub fn with_film(mut self, share: f32, film: ThinFilm) -> Self {
        self.film = Some((share, film));
        self
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

    /// The width that stands for those of its facets.
    pub(super) fn alpha(&self) -> f32 {
        self.facets.mean_width(anisotropic::REFLECTED)
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

    /// Which side of the tables light above a side is on, and the share that is lost from the cosine `mu`.
    fn lost(&self, outside: bool, mu: f32) -> (usize, f32) {
        let here = usize::from((self.eta < 1.0) == outside);
        (here, self.compensation.as_ref().map_or(0.0, |(c, _)| c.loss(here, mu)))
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
        let (here, lost) = self.lost(outside, o.z);
        let (single, density) =
            if i.z > 0.0 { self.reflected(o, i, outside) } else { self.refracted(o, i, outside, eta) };
        let again = self.compensation.as_ref().map_or(0.0, |(c, _)| lost_energy(c, here, o.z, i.z));
        let f = single + Vec3::splat(again);
        let pdf = (1.0 - lost) * density + again;
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
        let out = self.facets.masking(i);
        let passed = match &self.compensation {
            Some((_, correlation)) => {
                let seen = self.facets.masking(o);
                (1.0 - correlation) * out + correlation * (out / seen.max(f32::MIN_POSITIVE)).min(1.0)
            }
            None => out,
        };
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
        let (here, lost) = self.lost(outside, o.z);
        let (again, rest) = if delta { (1, u_lobe) } else { warp::choose(&[lost, 1.0 - lost], u_lobe) };
        let (i, meeting, reflects) = if let (0, Some((c, _))) = (again, &self.compensation) {
            (sample_lost(c, here, rest, warp::scramble(u, u_lobe)), None, false)
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
