//! Layers on a base: a clear coat over fibres over a surface, thin wall or boundary. `top` derives the coupling; the
//! order, and that light is not bent on its way through, are those of KHR_materials_clearcoat and KHR_materials_sheen.
//!
//! With E the share that the layers reflect, zero on a side that has none (below a boundary), C that of the coat alone:
//!
//! ```text
//! f = f_coat + min(1 − C_o, 1 − C_i) f_sheen + min(1 − E_o, 1 − E_i) f_base + returned
//! E = C + (1 − C) S,  S the fibres' albedo
//! ```
//!
//! Opaque surfaces and thin walls have their layers on both sides. On a boundary, light from inside meets the layers after
//! it has crossed; what they hold back, they throw back inside: mirrored where the boundary is smooth, else diffusely.

use super::base::Base;
use super::coat::Coat;
use super::reflectance::NODES;
use super::sheen::Sheen;
use super::{BsdfSample, top, warp};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Layers on a base.
#[derive(Clone, Debug)]
pub struct Layered {
    coat: Option<Coat>,
    sheen: Option<Sheen>,
    base: Base,
    /// The opaque rest of a surface that is a boundary on a share of it, and that share.
    rest: Option<(Base, f32)>,
    /// Directions that are given once the frame is known.
    coat_normal: Option<Vec3>,
    tangent: Option<Vec3>,
    back: Back,
}

/// The lobes that return what the layers hold back.
#[derive(Clone, Copy, Debug, Default)]
struct Back {
    /// Colour and weight of the lobe on the side of the layers.
    above: Vec3,
    /// 1/∫ 2µ R dµ for a weight of 1.
    above_norm: f32,
    /// Weight of the lobe below a rough boundary, and 1/∫ 2µ R dµ.
    below: Vec3,
    below_norm: f32,
    /// What the layers hold back of what a rough boundary hands back.
    below_lost: f32,
}

/// Probabilities of the parts for one direction.
struct Parts {
    coat: f32,
    sheen: f32,
    back: f32,
    base: f32,
}

impl Layered {
    /// Layers on `base`; `rest` is the opaque remainder of a boundary, with the boundary's share.
    pub fn new(coat: Option<Coat>, sheen: Option<Sheen>, base: Base, rest: Option<(Base, f32)>) -> Self {
        let mut layered =
            Self { coat, sheen, base, rest, coat_normal: None, tangent: None, back: Back::default() };
        if coat.is_some() || sheen.is_some() {
            layered.back = layered.returned();
        }
        layered
    }

    /// With a normal of the coat, in world space.
    #[must_use]
    pub fn with_coat_normal(mut self, normal: Vec3) -> Self {
        self.coat_normal = Some(normal);
        self
    }

    /// With the direction along which facets are rougher, in world space.
    #[must_use]
    pub fn with_tangent(mut self, tangent: Vec3) -> Self {
        self.tangent = Some(tangent);
        self
    }

    /// Tells the local frame (columns in world space).
    pub fn place(&mut self, frame: &Mat3) {
        if let Some(tangent) = self.tangent {
            let t = (frame.transpose() * tangent).truncate().normalize_or(Vec2::X);
            self.base.set_tangent(t);
            if let Some((rest, _)) = &mut self.rest {
                rest.set_tangent(t);
            }
        }
        let (Some(normal), Some(coat)) = (self.coat_normal, &mut self.coat) else { return };
        let mut n = frame.transpose() * normal;
        if n.z < 0.0 {
            n = -n;
        }
        if n.z < 0.9999 {
            let x = (Vec3::X - n * n.x).normalize_or(Vec3::X);
            coat.set_frame(Mat3::from_cols(x, n.cross(x), n).transpose());
        }
    }

    fn returned(&self) -> Back {
        let mut back = Back::default();
        let (base, share) = self.opaque();
        let azimuths: &[f32] = if base.is_isotropic() { &[0.0] } else { &top::QUARTER };
        // ∫ f µ dω/π of a function of the turned direction.
        let mean = |f: &dyn Fn(Vec3) -> f32| -> f32 {
            let around = |mu| azimuths.iter().map(|&phi| f(top::towards(mu, phi))).sum::<f32>();
            NODES.iter().map(|&(mu, w)| 2.0 * mu * w * around(mu)).sum::<f32>() / azimuths.len() as f32
        };
        let color = base.color();
        let average = if color == Vec3::ZERO { 0.0 } else { mean(&|w| self.residue_turned(w)) };
        if average > 1e-5 {
            let held = mean(&|w| self.top_albedo(w.z));
            // Thrown back to the base again and again.
            let again = color * (1.0 - held) / (Vec3::ONE - color * held).max(Vec3::splat(1e-6));
            back.above = color * again * share;
            back.above_norm = 1.0 / average;
        }
        if let Some((_, tint)) = self.base.boundary().filter(|_| !self.base.is_delta()) {
            back.below_lost = mean(&|w| self.base.handed_back(w) * self.top_albedo(w.z));
            let average = mean(&|w| self.held_turned(w, back.below_lost));
            if average > 1e-6 {
                back.below = tint * tint * (1.0 - if self.rest.is_some() { share } else { 0.0 });
                back.below_norm = 1.0 / average;
            }
        }
        back
    }

    /// What lies below the layers besides a boundary, if anything does, and its share.
    fn opaque(&self) -> (&Base, f32) {
        match &self.rest {
            Some((rest, share)) => (rest, 1.0 - share),
            None => (&self.base, 1.0),
        }
    }

    /// What the layers hold back of light that a rough boundary lets out, by the direction inside, given above.
    fn held_below(&self, o: Vec3) -> f32 {
        if self.back.below == Vec3::ZERO {
            return 0.0;
        }
        self.held_turned(self.base.turned(o), self.back.below_lost)
    }

    /// The same of a turned direction, over a few visible normals; `again` is what is held back of light that was lost.
    fn held_turned(&self, o: Vec3, again: f32) -> f32 {
        const STEPS: usize = 6;
        let mut sum = 0.0;
        for k in 0..STEPS * STEPS {
            let u = Vec2::new((k % STEPS) as f32 + 0.5, (k / STEPS) as f32 + 0.5) / STEPS as f32;
            if let Some((out, share)) = self.base.emerging(o, u) {
                sum += share * self.top_albedo(out.z.min(1.0));
            }
        }
        sum / (STEPS * STEPS) as f32 + self.base.lost_inside(o) * again
    }

    /// E at a cosine, whatever the coat's own normal.
    fn top_albedo(&self, mu: f32) -> f32 {
        let w = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
        let c = self.coat.as_ref().map_or(0.0, |c| c.albedo(w));
        c + (1.0 - c) * self.sheen.as_ref().map_or(0.0, |s| s.albedo(mu))
    }

    /// C and E of a direction; nothing on a side without layers.
    fn albedos(&self, w: Vec3) -> (f32, f32) {
        if w.z < 0.0 && self.base.boundary().is_some() {
            return (0.0, 0.0);
        }
        let w = above(w);
        let c = self.coat.as_ref().map_or(0.0, |c| c.albedo(w)).min(1.0);
        let s = self.sheen.as_ref().map_or(0.0, |s| s.albedo(w.z)).min(1.0);
        (c, c + (1.0 - c) * s)
    }

    /// R of all layers, of a direction above.
    fn residue(&self, w: Vec3) -> f32 {
        if self.back.above == Vec3::ZERO { 0.0 } else { self.residue_turned(self.opaque().0.turned(w)) }
    }

    fn residue_turned(&self, w: Vec3) -> f32 {
        let (base, _) = self.opaque();
        let spread = base.spread(w);
        let coat = self.coat.as_ref().map_or(0.0, |c| c.residue(w, &spread));
        spread.share * (coat + self.sheen.as_ref().map_or(0.0, |s| s.residue(w, &spread)))
    }

    fn has_layer_towards(&self, w: Vec3) -> bool {
        w.z > 0.0 || self.base.boundary().is_none()
    }

    fn parts(&self, wo: Vec3) -> Parts {
        let (c, e) = self.albedos(wo);
        let mean = |c: Vec3| c.element_sum() * (1.0 / 3.0);
        let layers = self.has_layer_towards(wo);
        let back = if layers {
            mean(self.back.above) * self.residue(above(wo))
        } else {
            mean(self.back.below) * self.held_below(above(wo))
        };
        let sum = 1.0 + back;
        Parts { coat: c / sum, sheen: (e - c) / sum, back: back / sum, base: (1.0 - e) / sum }
    }

    /// Whether every sample is a delta.
    pub fn is_delta(&self) -> bool {
        self.coat.as_ref().is_none_or(Coat::is_smooth)
            && self.sheen.is_none()
            && self.base.is_delta()
            && self.rest.as_ref().is_none_or(|(rest, _)| rest.is_delta())
            && self.back.above == Vec3::ZERO
            && self.back.below == Vec3::ZERO
    }

    /// f·|cos θ_i| and the density of [`Layered::sample`], deltas left out.
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if wo.z == 0.0 || wi.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        self.eval_parts(wo, wi, &self.parts(wo))
    }

    fn base_eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let (f, p) = self.base.eval_pdf(wo, wi);
        let Some((rest, share)) = &self.rest else { return (f, p) };
        let (g, q) = rest.eval_pdf(wo, wi);
        (f * *share + g * (1.0 - share), p * share + q * (1.0 - share))
    }

    fn eval_parts(&self, wo: Vec3, wi: Vec3, parts: &Parts) -> (Vec3, f32) {
        let ((c_o, e_o), (c_i, e_i)) = (self.albedos(wo), self.albedos(wi));
        let (f, p) = self.base_eval_pdf(wo, wi);
        let (mut f, mut pdf) = (f * (1.0 - e_o.max(e_i)), p * parts.base);
        if wo.z * wi.z < 0.0 {
            return (f, pdf);
        }
        let (o, i) = (above(wo), above(wi));
        let lambert = i.z * FRAC_1_PI;
        pdf += parts.back * lambert;
        if !self.has_layer_towards(wo) {
            let returned = self.held_below(o) * self.held_below(i) * self.back.below_norm;
            return (f + self.back.below * (returned * lambert), pdf);
        }
        if let Some(coat) = &self.coat {
            let (g, q) = coat.eval_pdf(o, i);
            f += Vec3::splat(g);
            pdf += parts.coat * q;
        }
        if let Some(sheen) = &self.sheen {
            f += sheen.eval(o, i) * (1.0 - c_o.max(c_i));
            pdf += parts.sheen / TAU;
        }
        if self.back.above != Vec3::ZERO {
            let returned = self.residue(o) * self.residue(i) * self.back.above_norm;
            f += self.back.above * (returned * lambert);
        }
        (f, pdf)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let parts = self.parts(wo);
        let (part, rest) = warp::choose(&[parts.coat, parts.sheen, parts.back, parts.base], u_lobe);
        let side = |i: Vec3| if wo.z > 0.0 { i } else { Vec3::new(i.x, i.y, -i.z) };
        let wi = match (part, &self.coat) {
            (0, Some(coat)) => {
                let i = coat.sample(above(wo), rest, u);
                if coat.is_smooth() {
                    // All that the coat reflects, in one direction.
                    let weight = Vec3::splat(self.albedos(wo).0 / parts.coat);
                    let wi = side(i);
                    return Some(BsdfSample { wi, weight, pdf: parts.coat, delta: true, transmitted: false });
                }
                side(i)
            }
            (1, _) => side(Sheen::sample(u)),
            (2, _) => side(warp::cosine_hemisphere(u)),
            _ => {
                let sample = self.sample_base(wo, rest, u)?;
                if sample.delta {
                    return self.covered(wo, sample, parts.base, rest);
                }
                sample.wi
            }
        };
        let transmitted = wi.z * wo.z < 0.0;
        if part < 3 && transmitted {
            return None;
        }
        let (f, pdf) = self.eval_parts(wo, wi, &parts);
        let valid = pdf > 0.0 && pdf.is_finite();
        valid.then(|| BsdfSample { wi, weight: f / pdf, pdf, delta: false, transmitted })
    }

    fn sample_base(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let Some((rest, share)) = &self.rest else { return self.base.sample(wo, u_lobe, u) };
        let (part, again) = warp::choose(&[*share, 1.0 - share], u_lobe);
        let (base, share) = if part == 0 { (&self.base, *share) } else { (rest, 1.0 - share) };
        let mut sample = base.sample(wo, again, u)?;
        sample.pdf *= share;
        Some(sample)
    }

    /// A delta of the base after the layers: out of a smooth boundary the layers throw a share back, mirrored.
    fn covered(&self, wo: Vec3, sample: BsdfSample, p: f32, u: f32) -> Option<BsdfSample> {
        let (e_o, e_i) = (self.albedos(wo).1, self.albedos(sample.wi).1);
        let pdf = sample.pdf * p;
        if let (true, Some((_, tint))) = (sample.transmitted && wo.z < 0.0, self.base.boundary()) {
            // The same number chose the lobe, so another one is made of it.
            if warp::scramble(Vec2::new(u, wo.x), wo.y) < e_i {
                let wi = Vec3::new(-wo.x, -wo.y, wo.z);
                let weight = tint * tint;
                return Some(BsdfSample { wi, weight, pdf: pdf * e_i, delta: true, transmitted: false });
            }
            return Some(BsdfSample { pdf: pdf * (1.0 - e_i), ..sample });
        }
        let weight = sample.weight * ((1.0 - e_o.max(e_i)) / p);
        Some(BsdfSample { weight, pdf, ..sample })
    }
}

#[inline]
fn above(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, w.z.abs())
}

#[cfg(test)]
#[path = "layered_tests.rs"]
mod tests;
