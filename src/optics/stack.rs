//! The layers on a base, from the top: fuzz, a coat, fibres.
//!
//! With Z, C and S what each reflects alone, A = Z + (1 − Z) C is what fuzz and coat hold back together, and
//! E = A + (1 − A) S what all do. Each layer gets min(1 − x_o, 1 − x_i) of its light, x what the layers above it hold back.

use super::base::{Base, Spread};
use super::coat::Coat;
use super::fuzz::Fuzz;
use super::sheen::Sheen;
use glam::Vec3;
use std::f32::consts::TAU;

/// Where, below a cosine, what a coat holds back lies on average: at 1/4 of Schlick's (1 − µ)⁵ under Lambert's law, and
/// not above the direction.
const COAT_HOLDS: f32 = 0.6;
const COAT_HOLDS_SCHLICK: f32 = 0.25;

/// Layers; each may be missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stack {
    /// KHR_materials_fuzz.
    pub fuzz: Option<Fuzz>,
    /// KHR_materials_clearcoat or KHR_materials_coat.
    pub coat: Option<Coat>,
    /// KHR_materials_sheen.
    pub sheen: Option<Sheen>,
}

/// Z, A and E of one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    pub fuzz: f32,
    pub coat: f32,
    pub all: f32,
}

impl Held {
    fn of(z: f32, c: f32, s: f32) -> Self {
        let (z, c, s) = (z.min(1.0), c.min(1.0), s.min(1.0));
        let coat = z + (1.0 - z) * c;
        Self { fuzz: z, coat, all: coat + (1.0 - coat) * s }
    }
}

impl Stack {
    pub(super) fn is_empty(&self) -> bool {
        self.fuzz.is_none() && self.coat.is_none() && self.sheen.is_none()
    }

    /// Whether every sample of a layer is a delta.
    pub(super) fn is_delta(&self) -> bool {
        self.fuzz.is_none() && self.sheen.is_none() && self.coat.as_ref().is_none_or(Coat::is_smooth)
    }

    /// What is held back of light from a direction above.
    pub(super) fn held(&self, w: Vec3) -> Held {
        Held::of(
            self.fuzz.as_ref().map_or(0.0, |f| f.albedo(w)),
            self.coat.as_ref().map_or(0.0, |c| c.albedo(w)),
            self.sheen.as_ref().map_or(0.0, |s| s.albedo(w.z)),
        )
    }

    /// The same at a cosine, whatever the layers' own normals.
    pub(super) fn mean_held(&self, mu: f32) -> Held {
        Held::of(
            self.fuzz.as_ref().map_or(0.0, |f| f.held(mu)),
            self.coat.as_ref().map_or(0.0, |c| c.mean_albedo(mu)),
            self.sheen.as_ref().map_or(0.0, |s| s.albedo(mu)),
        )
    }

    /// Colour of what is thrown back below the layers at a cosine: fuzz colours it, and it passes the coat twice on its
    /// way to fuzz and back.
    pub(super) fn thrown(&self, mu: f32) -> Vec3 {
        let held = self.mean_held(mu);
        let twice = self.coat.as_ref().map_or(Vec3::ONE, |c| c.twice(mu));
        match &self.fuzz {
            Some(fuzz) if held.all > 0.0 => {
                twice * (fuzz.color() * held.fuzz + (held.all - held.fuzz)) / held.all
            }
            _ => twice,
        }
    }

    /// R of all layers on a base that spreads light so, for a direction turned to its facets.
    ///
    /// Of fuzz on a coat E_i − E_o = (Z_i − Z_o)(1 − C_o) + (1 − Z_i)(C_i − C_o), with Z_i where the coat holds back most
    /// of what is below the direction.
    pub(super) fn residue(&self, w: Vec3, spread: &Spread) -> f32 {
        let mut coat = self.coat.as_ref().map_or(0.0, |c| c.residue(w, spread));
        let mut fuzz = 0.0;
        if let Some(layer) = &self.fuzz {
            fuzz = layer.residue(w, spread) * (1.0 - self.coat.as_ref().map_or(0.0, |c| c.mean_albedo(w.z)));
            coat *= 1.0 - layer.held((COAT_HOLDS * w.z).min(COAT_HOLDS_SCHLICK));
        }
        fuzz + coat + self.sheen.as_ref().map_or(0.0, |s| s.residue(w, spread))
    }

    /// What a coat leaves of light on its way to a base and out again, from the sides on which there are layers.
    pub(super) fn passed(&self, ways: [Option<Vec3>; 2], base: &Base) -> Vec3 {
        match &self.coat {
            Some(coat) if coat.is_tinted() => coat.passed(ways, base.color(), base.seen_roughness()),
            _ => Vec3::ONE,
        }
    }

    /// f·cos θ_i of all layers and the density of their samples, chosen with these probabilities, of directions above.
    pub(super) fn eval_pdf(
        &self,
        (o, held_o): (Vec3, Held),
        (i, held_i): (Vec3, Held),
        chosen: [f32; 3],
    ) -> (Vec3, f32) {
        let (mut f, mut pdf) = (Vec3::ZERO, 0.0);
        if let Some(fuzz) = &self.fuzz {
            let (g, q) = fuzz.eval_pdf(o, i);
            f += g;
            pdf += chosen[0] * q;
        }
        if let Some(coat) = &self.coat {
            let (g, q) = coat.eval_pdf(o, i);
            f += Vec3::splat(g * (1.0 - held_o.fuzz.max(held_i.fuzz)));
            pdf += chosen[1] * q;
        }
        if let Some(sheen) = &self.sheen {
            f += sheen.eval(o, i) * (1.0 - held_o.coat.max(held_i.coat));
            pdf += chosen[2] / TAU;
        }
        (f, pdf)
    }
}
