//! Layers on a base: fuzz over a coat over fibres over a surface, thin wall or boundary. `top` derives the coupling; the
//! order, and that light is not bent on its way through, are those of KHR_materials_clearcoat, _coat, _fuzz and _sheen.
//!
//! With E the share that the layers reflect, zero on a side that has none (below a boundary), and P what a coloured coat
//! leaves of light on its way to the base and out again:
//!
//! ```text
//! f = f_layers + P (min(1 − E_o, 1 − E_i) f_base + returned)
//! ```
//!
//! Opaque surfaces and thin walls have their layers on both sides. On a boundary, light from inside meets the layers after
//! it has crossed; what they hold back, they throw back inside: mirrored where the boundary is smooth, else diffusely.

use super::base::Base;
use super::coat::Coat;
use super::reflectance::NODES;
use super::sheen::Sheen;
use super::stack::{Held, Stack};
use super::{BsdfSample, top, warp};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Layers on a base.
#[derive(Clone, Debug)]
pub struct Layered {
    stack: Stack,
    base: Base,
    /// The opaque rest of a surface that is a boundary on a share of it, and that share.
    rest: Option<(Base, f32)>,
    /// Directions that are given once the frame is known.
    coat_normal: Option<Vec3>,
    coat_tangent: Option<Vec3>,
    fuzz_normal: Option<Vec3>,
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
    /// Fuzz, coat, sheen.
    layers: [f32; 3],
    back: f32,
    base: f32,
}

impl Layered {
    /// A coat and fibres on `base`; `rest` is the opaque remainder of a boundary, with the boundary's share.
    pub fn new(coat: Option<Coat>, sheen: Option<Sheen>, base: Base, rest: Option<(Base, f32)>) -> Self {
        Self::stacked(Stack { fuzz: None, coat, sheen }, base, rest)
    }

    /// Any layers on `base`, as [`Layered::new`].
    pub fn stacked(stack: Stack, base: Base, rest: Option<(Base, f32)>) -> Self {
        let mut layered = Self {
            stack,
            base,
            rest,
            coat_normal: None,
            coat_tangent: None,
            fuzz_normal: None,
            tangent: None,
            back: Back::default(),
        };
        if !stack.is_empty() {
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

    /// With the direction along which facets of the coat are rougher, in world space.
    #[must_use]
    pub fn with_coat_tangent(mut self, tangent: Vec3) -> Self {
        self.coat_tangent = Some(tangent);
        self
    }

    /// With a normal of the fuzz, in world space.
    #[must_use]
    pub fn with_fuzz_normal(mut self, normal: Vec3) -> Self {
        self.fuzz_normal = Some(normal);
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
        if let Some(coat) = &mut self.stack.coat
            && let Some(own) = own_frame(frame, self.coat_normal, self.coat_tangent)
        {
            coat.set_frame(own);
        }
        if let Some(fuzz) = &mut self.stack.fuzz
            && let Some(own) = own_frame(frame, self.fuzz_normal, None)
        {
            fuzz.set_frame(own);
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
            let held = mean(&|w| self.stack.mean_held(w.z).all);
            // Thrown back to the base again and again.
            let around = color * self.mean_thrown();
            let again = color * (1.0 - held) / (Vec3::ONE - around * held).max(Vec3::splat(1e-6));
            back.above = around * again * share;
            back.above_norm = 1.0 / average;
        }
        if let Some((_, tint)) = self.base.boundary().filter(|_| !self.base.is_delta()) {
            back.below_lost = mean(&|w| self.base.handed_back(w) * self.stack.mean_held(w.z).all);
            let average = mean(&|w| self.held_turned(w, back.below_lost));
            if average > 1e-6 {
                back.below =
                    tint * tint * self.mean_thrown() * (1.0 - if self.rest.is_some() { share } else { 0.0 });
                back.below_norm = 1.0 / average;
            }
        }
        back
    }

    /// Colour of diffuse light that the layers throw back.
    fn mean_thrown(&self) -> Vec3 {
        let (mut color, mut sum) = (Vec3::ZERO, 0.0);
        for (mu, w) in NODES {
            let held = 2.0 * mu * w * self.stack.mean_held(mu).all;
            color += held * self.stack.thrown(mu);
            sum += held;
        }
        if sum > 0.0 { color / sum } else { Vec3::ONE }
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
                sum += share * self.stack.mean_held(out.z.min(1.0)).all;
            }
        }
        sum / (STEPS * STEPS) as f32 + self.base.lost_inside(o) * again
    }

    /// What layers hold back of a direction; nothing on a side without layers.
    fn held(&self, w: Vec3) -> Held {
        if self.has_layer_towards(w) { self.stack.held(above(w)) } else { Held::default() }
    }

    /// P of a base.
    fn passed(&self, base: &Base, wo: Vec3, wi: Vec3) -> Vec3 {
        let side = |w: Vec3| self.has_layer_towards(w).then(|| above(w));
        self.stack.passed([side(wo), side(wi)], base)
    }

    /// R of all layers, of a direction above.
    fn residue(&self, w: Vec3) -> f32 {
        if self.back.above == Vec3::ZERO { 0.0 } else { self.residue_turned(self.opaque().0.turned(w)) }
    }

    fn residue_turned(&self, w: Vec3) -> f32 {
        let (base, _) = self.opaque();
        let spread = base.spread(w);
        spread.share * self.stack.residue(w, &spread)
    }

    fn has_layer_towards(&self, w: Vec3) -> bool {
        w.z > 0.0 || self.base.boundary().is_none()
    }

    fn parts(&self, wo: Vec3, held: Held) -> Parts {
        let mean = |c: Vec3| c.element_sum() * (1.0 / 3.0);
        let layers = self.has_layer_towards(wo);
        let back = if layers {
            mean(self.back.above) * self.residue(above(wo))
        } else {
            mean(self.back.below) * self.held_below(above(wo))
        };
        let sum = 1.0 + back;
        let layers = [held.fuzz, held.coat - held.fuzz, held.all - held.coat].map(|share| share / sum);
        Parts { layers, back: back / sum, base: (1.0 - held.all) / sum }
    }

    /// Whether every sample is a delta.
    pub fn is_delta(&self) -> bool {
        self.stack.is_delta()
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
        let held = self.held(wo);
        self.eval_parts(wo, wi, held, &self.parts(wo, held))
    }

    fn base_eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let (f, p) = self.base.eval_pdf(wo, wi);
        let f = f * self.passed(&self.base, wo, wi);
        let Some((rest, share)) = &self.rest else { return (f, p) };
        let (g, q) = rest.eval_pdf(wo, wi);
        let g = g * self.passed(rest, wo, wi);
        (f * *share + g * (1.0 - share), p * share + q * (1.0 - share))
    }

    fn eval_parts(&self, wo: Vec3, wi: Vec3, held_o: Held, parts: &Parts) -> (Vec3, f32) {
        let held_i = self.held(wi);
        let (f, p) = self.base_eval_pdf(wo, wi);
        let (mut f, mut pdf) = (f * (1.0 - held_o.all.max(held_i.all)), p * parts.base);
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
        let (g, q) = self.stack.eval_pdf((o, held_o), (i, held_i), parts.layers);
        f += g;
        pdf += q;
        if self.back.above != Vec3::ZERO {
            let returned = self.residue(o) * self.residue(i) * self.back.above_norm;
            f += self.back.above * (returned * lambert) * self.passed(self.opaque().0, wo, wi);
        }
        (f, pdf)
    }

    /// Draws a direction; `u_lobe` in \[0, 1), `u` in \[0, 1)².
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let held = self.held(wo);
        let parts = self.parts(wo, held);
        let [fuzz, coat, sheen] = parts.layers;
        let (part, rest) = warp::choose(&[coat, sheen, parts.back, fuzz, parts.base], u_lobe);
        let side = |i: Vec3| if wo.z > 0.0 { i } else { Vec3::new(i.x, i.y, -i.z) };
        let wi = match (part, &self.stack) {
            (0, Stack { coat: Some(lobe), .. }) => {
                let i = lobe.sample(above(wo), rest, u);
                if lobe.is_smooth() {
                    // All that the coat reflects, in one direction.
                    let below = i.z <= 0.0;
                    let passed = 1.0 - held.fuzz.max(if below { 0.0 } else { self.stack.held(i).fuzz });
                    let weight = Vec3::splat(lobe.albedo(above(wo)).min(1.0) * passed / coat);
                    let wi = side(i);
                    return Some(BsdfSample { wi, weight, pdf: coat, delta: true, transmitted: false });
                }
                side(i)
            }
            (1, _) => side(Sheen::sample(u)),
            (2, _) => side(warp::cosine_hemisphere(u)),
            (3, Stack { fuzz: Some(lobe), .. }) => side(lobe.sample(above(wo), rest, u)),
            _ => {
                let sample = self.sample_base(wo, rest, u)?;
                if sample.delta {
                    return self.covered(wo, sample, parts.base, rest);
                }
                sample.wi
            }
        };
        let transmitted = wi.z * wo.z < 0.0;
        if part < 4 && transmitted {
            return None;
        }
        let (f, pdf) = self.eval_parts(wo, wi, held, &parts);
        let valid = pdf > 0.0 && pdf.is_finite();
        valid.then(|| BsdfSample { wi, weight: f / pdf, pdf, delta: false, transmitted })
    }

    fn sample_base(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let Some((rest, share)) = &self.rest else {
            let sample = self.base.sample(wo, u_lobe, u)?;
            return Some(self.tinted(&self.base, wo, sample));
        };
        let (part, again) = warp::choose(&[*share, 1.0 - share], u_lobe);
        let (base, share) = if part == 0 { (&self.base, *share) } else { (rest, 1.0 - share) };
        let mut sample = self.tinted(base, wo, base.sample(wo, again, u)?);
        sample.pdf *= share;
        Some(sample)
    }

    fn tinted(&self, base: &Base, wo: Vec3, sample: BsdfSample) -> BsdfSample {
        BsdfSample { weight: sample.weight * self.passed(base, wo, sample.wi), ..sample }
    }

    /// A delta of the base after the layers: out of a smooth boundary the layers throw a share back, mirrored.
    fn covered(&self, wo: Vec3, sample: BsdfSample, p: f32, u: f32) -> Option<BsdfSample> {
        let (e_o, e_i) = (self.held(wo).all, self.held(sample.wi).all);
        let pdf = sample.pdf * p;
        if let (true, Some((_, tint))) = (sample.transmitted && wo.z < 0.0, self.base.boundary()) {
            // The same number chose the lobe, so another one is made of it.
            if warp::scramble(Vec2::new(u, wo.x), wo.y) < e_i {
                let wi = Vec3::new(-wo.x, -wo.y, wo.z);
                let weight = tint * tint * self.stack.thrown(sample.wi.z.abs());
                return Some(BsdfSample { wi, weight, pdf: pdf * e_i, delta: true, transmitted: false });
            }
            return Some(BsdfSample { pdf: pdf * (1.0 - e_i), ..sample });
        }
        let weight = sample.weight * ((1.0 - e_o.max(e_i)) / p);
        Some(BsdfSample { weight, pdf, ..sample })
    }
}

/// From the frame of the surface to that of a layer with a normal or a tangent of its own, both in world space.
fn own_frame(frame: &Mat3, normal: Option<Vec3>, tangent: Option<Vec3>) -> Option<Mat3> {
    let mut n = normal.map_or(Vec3::Z, |normal| frame.transpose() * normal);
    if n.z < 0.0 {
        n = -n;
    }
    let along = tangent.map(|t| frame.transpose() * t);
    if n.z >= 0.9999 && along.is_none() {
        return None;
    }
    let t = along.unwrap_or(Vec3::X);
    let x = (t - n * n.dot(t)).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
    Some(Mat3::from_cols(x, n.cross(x), n).transpose())
}

#[inline]
fn above(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, w.z.abs())
}

#[cfg(test)]
#[path = "layered_tests.rs"]
mod tests;
