//! The boundary between two dielectrics: smooth, or a GGX microsurface with or without the energy that single
//! scattering loses. `docs/boundary.md` derives the model; equation numbers here are its.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `eta` | η | index at z < 0 over index at z > 0 |
//! | `alpha` | α | roughness² |
//! | `wo`, `wi` | ω_o, ω_i | unit, local frame, pointing away from the surface; wo.z < 0: the path is inside |
//! | `tint` | | multiplies light at each crossing |
//!
//! Paths carry radiance from the camera. With e the share of energy per steradian that light arriving along ω_o sends
//! to ω_i (∫ e dω_i = 1 where nothing is absorbed), a path that crosses from index n_o to n_i has
//! f·|cos θ_i| = (n_o/n_i)² e: entering a medium multiplies by (n_outside/n_inside)², leaving undoes it (Veach 1997,
//! §5.2). Single scattering: Walter et al. 2007 with separable Smith masking, eqs. 16, 20, 21, 23.

use super::boundary_tables::{self, BoundaryTables, Compensation, MIN_ROUGH_ALPHA};
use super::{BsdfSample, fresnel, ggx, warp};
use fresnel::Interface;
use glam::{Vec2, Vec3};

/// What becomes of light that meets the microsurface more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Microfacet {
    /// It is handed back, so that nothing is lost.
    #[default]
    Multiple,
    /// It is lost: the plain model, for comparisons.
    Single,
}

/// Indices closer to 1 than this are matched: light passes straight through, whatever the roughness. The reflectance
/// that is ignored is below 2e-5 of diffuse light, the deviation below a thousandth of a degree.
pub const MATCHED_INDEX: f32 = 1e-5;

/// A boundary between two dielectrics.
#[derive(Clone, Copy, Debug)]
pub struct DielectricBoundary {
    eta: f32,
    alpha: f32,
    tint: Vec3,
    kind: Kind,
    /// Worth of what crosses from z > 0, for one of what is reflected there.
    below: f32,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Matched,
    Smooth,
    Single,
    Multiple { compensation: Compensation<'static>, correlation: f32, front: usize },
}

/// The side a path is on, seen so that it is above: directions mirrored in z where it is not.
struct Side {
    wo: Vec3,
    /// Index below over index above.
    eta: f32,
    /// −1 where mirrored.
    sign: f32,
}

impl DielectricBoundary {
    /// A boundary of relative index `eta` > 0 (index at z < 0 over index at z > 0) and roughness `alpha` in \[0, 1\].
    ///
    /// Below [`MIN_ROUGH_ALPHA`] it is smooth. Takes some tens of nanoseconds once the tables of this index exist; the
    /// first call for an index builds them (see [`BoundaryTables::get`]).
    #[inline]
    pub fn new(eta: f32, alpha: f32, microfacet: Microfacet) -> Self {
        let needs_tables = microfacet == Microfacet::Multiple
            && alpha >= MIN_ROUGH_ALPHA
            && (eta - 1.0).abs() > MATCHED_INDEX;
        Self::build(eta, alpha, needs_tables.then(|| BoundaryTables::get(eta)))
    }

    /// The energy-conserving boundary, with tables at hand: those of [`BoundaryTables::get`] for `eta`.
    #[inline]
    pub fn with_tables(eta: f32, alpha: f32, tables: &'static BoundaryTables) -> Self {
        Self::build(eta, alpha, Some(tables))
    }

    #[inline]
    fn build(eta: f32, alpha: f32, tables: Option<&'static BoundaryTables>) -> Self {
        let alpha = alpha.min(1.0);
        let kind = if (eta - 1.0).abs() <= MATCHED_INDEX {
            Kind::Matched
        } else if alpha < MIN_ROUGH_ALPHA {
            Kind::Smooth
        } else if let Some(tables) = tables {
            Kind::Multiple {
                compensation: tables.at(alpha),
                correlation: boundary_tables::correlation(eta),
                front: usize::from(eta < 1.0),
            }
        } else {
            Kind::Single
        };
        Self { eta, alpha, tint: Vec3::ONE, kind, below: 1.0 }
    }

    /// Multiplies light by `tint` at each crossing, reflections never.
    #[must_use]
    pub fn with_transmission_tint(mut self, tint: Vec3) -> Self {
        self.tint = tint;
        self
    }

    /// Chooses between reflection and crossing, where a path comes from z > 0, as if only the share `below` in (0, 1]
    /// of what crosses counted: reflections of a dark medium are its highlights, and rarely found by energy alone.
    /// Samples are weighed for it. Densities are those of the choice up to the (small) share of light that compensation
    /// hands back, which is sampled by energy: use them for weights between techniques only.
    #[must_use]
    pub fn with_worth_below(mut self, below: f32) -> Self {
        self.below = below;
        self
    }

    /// Probability to choose the reflection where the facet's is `reflectance`.
    #[inline]
    fn chosen(&self, reflectance: f32, from_above: bool) -> f32 {
        if from_above && self.below < 1.0 {
            reflectance / (reflectance + (1.0 - reflectance) * self.below)
        } else {
            reflectance
        }
    }

    /// Whether every sample is a delta, so that light can only be found by following them.
    #[inline]
    pub fn is_delta(&self) -> bool {
        matches!(self.kind, Kind::Matched | Kind::Smooth)
    }

    /// Index at z < 0 over index at z > 0.
    #[inline]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    #[inline]
    pub(super) fn alpha(&self) -> f32 {
        self.alpha
    }

    /// A direction outside to which a visible facet refracts light from inside, and the share that gets there.
    pub(super) fn emerging(&self, o: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        let h = ggx::sample_visible(o, self.alpha, u);
        let c = o.dot(h).clamp(0.0, 1.0);
        let Interface { reflectance, g } = fresnel::interface(c, 1.0 / self.eta);
        let out = (g > 0.0).then(|| fresnel::refract_with(o, h, c, g, 1.0 / self.eta))?;
        (out.z < 0.0).then(|| (mirror(out), (1.0 - reflectance) * self.passed(o, out)))
    }

    /// Share of light from a cosine inside that compensation sends outside.
    pub(super) fn lost_inside(&self, mu: f32) -> f32 {
        match &self.kind {
            Kind::Multiple { compensation: c, front, .. } => c.loss(1 - front, mu) * c.transmitted[1 - front],
            _ => 0.0,
        }
    }

    /// Density of what compensation sends to a cosine outside, over that of Lambert's law.
    pub(super) fn handed_back(&self, mu: f32) -> f32 {
        match &self.kind {
            Kind::Multiple { compensation: c, front, .. } if c.total[*front] > 0.0 => {
                c.loss(*front, mu) / c.total[*front]
            }
            _ => 1.0,
        }
    }

    /// f·|cos θ_i| for radiance carried along `wo`; zero for a delta.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let e = self.pdf_and_energy(wo, wi).1;
        if wo.z * wi.z > 0.0 { Vec3::splat(e) } else { self.crossing_weight(wo) * e }
    }

    /// Density of [`DielectricBoundary::sample`] at `wi`, per steradian; zero for a delta.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.pdf_and_energy(wo, wi).0
    }

    /// [`DielectricBoundary::eval`] and [`DielectricBoundary::pdf`] at the price of one.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let (pdf, e) = self.pdf_and_energy(wo, wi);
        (if wo.z * wi.z > 0.0 { Vec3::splat(e) } else { self.crossing_weight(wo) * e }, pdf)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)². `None` where single scattering loses the sample.
    ///
    /// With [`Microfacet::Multiple`] the density *is* the share of energy: the weight is 1 for every reflection and
    /// `tint · (n_o/n_i)²` for every crossing, without variance and whatever the error of the tables.
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        match self.kind {
            Kind::Matched => {
                Some(BsdfSample { wi: -wo, weight: self.tint, pdf: 1.0, delta: true, transmitted: true })
            }
            Kind::Smooth => self.sample_smooth(wo, u_lobe),
            Kind::Single | Kind::Multiple { .. } => self.sample_rough(wo, u_lobe, u),
        }
    }

    #[inline]
    fn side(&self, wo: Vec3) -> Side {
        if wo.z >= 0.0 {
            Side { wo, eta: self.eta, sign: 1.0 }
        } else {
            Side { wo: mirror(wo), eta: 1.0 / self.eta, sign: -1.0 }
        }
    }

    /// tint · (n_o/n_i)².
    #[inline]
    fn crossing_weight(&self, wo: Vec3) -> Vec3 {
        let scale = if wo.z > 0.0 { 1.0 / (self.eta * self.eta) } else { self.eta * self.eta };
        self.tint * scale
    }

    fn sample_smooth(&self, wo: Vec3, u_lobe: f32) -> Option<BsdfSample> {
        let side = self.side(wo);
        let Interface { reflectance, g } = fresnel::interface(side.wo.z, side.eta);
        let chosen = self.chosen(reflectance, side.sign > 0.0);
        if u_lobe < chosen {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample {
                wi,
                weight: Vec3::splat(reflectance / chosen),
                pdf: chosen,
                delta: true,
                transmitted: false,
            });
        }
        let mut wi = fresnel::refract_with(side.wo, Vec3::Z, side.wo.z, g, side.eta);
        wi.z *= side.sign;
        Some(BsdfSample {
            wi: wi.normalize(),
            weight: self.crossing_weight(wo) * ((1.0 - reflectance) / (1.0 - chosen)),
            pdf: 1.0 - chosen,
            delta: true,
            transmitted: true,
        })
    }

    fn sample_rough(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let side = self.side(wo);
        let h = ggx::sample_visible(side.wo, self.alpha, u);
        let c = side.wo.dot(h).max(0.0);
        let Interface { reflectance, g } = fresnel::interface(c, side.eta);
        let chosen = self.chosen(reflectance, side.sign > 0.0);
        let (single, rest, worth) = if u_lobe < chosen {
            let wi = 2.0 * c * h - side.wo;
            (Some(wi).filter(|w| w.z > 0.0), u_lobe / chosen, reflectance / chosen)
        } else {
            let wi = fresnel::refract_with(side.wo, h, c, g, side.eta);
            let rest = (u_lobe - chosen) / (1.0 - chosen);
            (Some(wi).filter(|w| w.z < 0.0), rest, (1.0 - reflectance) / (1.0 - chosen))
        };
        let single = single.map(Vec3::normalize);
        let passed = single.map_or(0.0, |wi| self.passed(side.wo, wi));
        let (wi, weight) = match self.kind {
            Kind::Multiple { compensation, front, .. } => {
                let wi = match single {
                    Some(wi) if rest < passed => wi,
                    _ => {
                        let rest = warp::clamp_unit((rest - passed) / (1.0 - passed));
                        let here = if side.sign > 0.0 { front } else { 1 - front };
                        compensation.sample_lost(here, rest, warp::scramble(u, u_lobe))
                    }
                };
                (wi, worth)
            }
            _ => (single?, worth * passed),
        };
        let transmitted = wi.z < 0.0;
        let wi = Vec3::new(wi.x, wi.y, wi.z * side.sign);
        let pdf = self.pdf(wo, wi);
        if !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        let weight = if transmitted { self.crossing_weight(wo) * weight } else { Vec3::splat(weight) };
        Some(BsdfSample { wi, weight, pdf, delta: false, transmitted })
    }

    /// Share of single-scattered light towards `wi` that is not masked on its way out, given that it was visible from
    /// `wo`: G/G1(wo), eqs. (2) and (5).
    #[inline]
    fn passed(&self, wo: Vec3, wi: Vec3) -> f32 {
        let out = ggx::masking(wi, self.alpha);
        match self.kind {
            Kind::Multiple { correlation, .. } if wi.z < 0.0 => {
                let seen = ggx::masking(wo, self.alpha);
                (1.0 - correlation) * out + correlation * if out < seen { out / seen } else { 1.0 }
            }
            _ => out,
        }
    }

    /// Density of the sampler, and share of energy e, at `wi`.
    fn pdf_and_energy(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        if self.is_delta() || wo.z == 0.0 || wi.z == 0.0 {
            return (0.0, 0.0);
        }
        let side = self.side(wo);
        let i = Vec3::new(wi.x, wi.y, wi.z * side.sign);
        let (facets, reflectance) = if i.z > 0.0 {
            self.reflecting_facets(side.wo, i, side.eta)
        } else {
            self.refracting_facets(side.wo, i, side.eta)
        };
        let chosen = self.chosen(reflectance, side.sign > 0.0);
        let (share, chosen) =
            if i.z > 0.0 { (reflectance, chosen) } else { (1.0 - reflectance, 1.0 - chosen) };
        let passed = self.passed(side.wo, i);
        let single = facets * share * passed;
        match self.kind {
            Kind::Multiple { compensation, front, .. } => {
                let here = if side.sign > 0.0 { front } else { 1 - front };
                let lost = compensation.lost_energy(here, side.wo.z, i.z);
                (facets * chosen * passed + lost, single + lost)
            }
            _ => (facets * chosen, single),
        }
    }

    /// Density of directions that visible facets would reflect to, D_o(h) / (4 ω_o·h), and the facet's reflectance.
    #[inline]
    fn reflecting_facets(&self, wo: Vec3, wi: Vec3, eta: f32) -> (f32, f32) {
        let h = (wo + wi).normalize_or(Vec3::Z);
        let c = wo.dot(h);
        if c <= 0.0 {
            return (0.0, 0.0);
        }
        let d = ggx::distribution(h, self.alpha);
        (0.5 * d * ggx::masking_over_two_cos(wo, self.alpha), fresnel::dielectric(c, eta))
    }

    /// Density of directions that visible facets would refract to, D_o(h) |∂h/∂ω_i|, Walter et al. 2007 eq. 17, and the
    /// facet's reflectance.
    ///
    /// With g = η cos θ_t, Snell's law turns the denominator ω_o·h + η ω_i·h into (1 − η²)/(c + g), exact for η ≈ 1.
    #[inline]
    fn refracting_facets(&self, wo: Vec3, wi: Vec3, eta: f32) -> (f32, f32) {
        let sum = (wo + wi) + (eta - 1.0) * wi;
        let h = if eta > 1.0 { -sum } else { sum }.normalize_or_zero();
        let c = wo.dot(h);
        let g = -eta * wi.dot(h);
        if h.z <= 0.0 || c <= 0.0 || g <= 0.0 {
            return (0.0, 0.0);
        }
        let ratio = (c + g) / ((1.0 - eta) * (1.0 + eta));
        let jacobian = eta * g * ratio * ratio;
        let visible = 2.0 * ggx::masking_over_two_cos(wo, self.alpha) * ggx::distribution(h, self.alpha) * c;
        (visible * jacobian, fresnel::reflectance(c, g, eta))
    }
}

#[inline]
fn mirror(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

#[cfg(test)]
#[path = "boundary_tests.rs"]
mod tests;
