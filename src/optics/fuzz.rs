//! `KHR_materials_fuzz` (draft): a layer of fibres or dust that only scatters, as Zeltner, Burley & Chiang 2022 fit it
//! ("Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines"), the model that the draft recommends.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `reflected` | R(µ) | share that white fuzz reflects, by the rational fit that MaterialX makes to the paper's table |
//! | `Bent` | a, b | M⁻¹ = ((a, 0, b), (0, a, 0), (0, 0, 1)) in the plane of ω_o: ω_i bent to a cosine lobe |
//! | `kernel` | K(o, i) = a²/(π ǀM⁻¹ω_iǀ⁴) | the lobe over cos θ_i; times cos θ_i it integrates to 1 |
//!
//! The paper's lobe R(o) K(o, i) is not reciprocal, the volume that it fits is: here it is the mean of both directions,
//! (R(o) K(o, i) + R(i) K(i, o))/2, divided by max(1, E₀(o), E₀(i)) with E₀ what that reflects, so that no energy is made.
//! What fuzz does not reflect passes it without being coloured.

use super::base::Spread;
use super::top::{self, TopTable, mix};
use super::warp;
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::OnceLock;

/// Smaller roughnesses reflect at the horizon only: a fifth there, nothing at 10° above it.
const LEAST_ROUGHNESS: f32 = 0.05;
/// Roughnesses of the tables, geometric.
const SLICES: usize = 32;

/// Fuzz at one point.
#[derive(Clone, Copy, Debug)]
pub struct Fuzz {
    weight: f32,
    color: Vec3,
    roughness: f32,
    /// From the frame of the base to that of the fuzz, where they differ.
    to_fuzz: Option<Mat3>,
}

struct Slice {
    raw: TopTable,
    kept: TopTable,
}

fn slice(j: usize) -> &'static Slice {
    static ALL: [OnceLock<Box<Slice>>; SLICES] = [const { OnceLock::new() }; SLICES];
    ALL[j].get_or_init(|| {
        let roughness = LEAST_ROUGHNESS.powf(1.0 - j as f32 / (SLICES - 1) as f32);
        let nodes = nodes(roughness);
        let raw = TopTable::new(|mu| albedo(mu, roughness, &nodes, |_| 1.0));
        let held = |mu| raw.albedo(mu).max(1.0);
        let kept = TopTable::new(|mu| albedo(mu, roughness, &nodes, |t| held(mu).max(held(t))).min(1.0));
        Box::new(Slice { raw, kept })
    })
}

/// A cosine of the quadrature, its weight, and what belongs to it.
struct Node {
    mu: f32,
    weight: f32,
    reflected: f32,
    bent: Bent,
}

/// Midpoints of √µ: lobes of upright fibres lie along the horizon.
fn nodes(roughness: f32) -> Vec<Node> {
    const POLAR: usize = 160;
    let at = |k: usize| {
        let x = (k as f32 + 0.5) / POLAR as f32;
        let mu = x * x;
        let weight = 2.0 * x / POLAR as f32;
        Node { mu, weight, reflected: reflected(mu, roughness), bent: Bent::new(mu, roughness) }
    };
    (0..POLAR).map(at).collect()
}

/// ∫ f cos θ_i dω_i of white fuzz, f divided by a function of the cosine θ_i.
fn albedo(mu: f32, roughness: f32, nodes: &[Node], held: impl Fn(f32) -> f32) -> f32 {
    const AZIMUTHS: usize = 24;
    let o = direction(mu, 0.0);
    let (of_o, bent) = (reflected(mu, roughness), Bent::new(mu, roughness));
    let around: [(f32, f32); AZIMUTHS] = std::array::from_fn(|k| {
        let (sin, cos) = (PI * (k as f32 + 0.5) / AZIMUTHS as f32).sin_cos();
        (cos, sin)
    });
    let mut sum = 0.0;
    for node in nodes {
        let r = ((1.0 - node.mu) * (1.0 + node.mu)).max(0.0).sqrt();
        let mut ring = 0.0;
        for (cos, sin) in around {
            let i = Vec3::new(r * cos, r * sin, node.mu);
            ring += of_o * bent.kernel(o, i) + node.reflected * node.bent.kernel(i, o);
        }
        sum += ring * node.weight * node.mu / held(node.mu);
    }
    0.5 * sum * TAU / AZIMUTHS as f32
}

fn direction(mu: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), mu)
}

/// R(µ): a Gaussian of the cosine and a constant, whose parameters are rational functions of the roughness (MaterialX,
/// `mx_microfacet_sheen.glsl`).
fn reflected(mu: f32, y: f32) -> f32 {
    let width = y * (0.020_660_7 + 1.584_91 * y) / (0.037_942_4 + y * (1.322_27 + y));
    let middle = y * (-0.193_854 + y * (-1.148_85 + y * (1.793_2 - 0.959_43 * y * y))) / (0.046_391 + y);
    let least = y * (0.000_654_023 + y * (-0.020_781_8 + 0.119_681 * y)) / (1.262_64 + y * (-1.920_21 + y));
    let x = (mu - middle) / width;
    ((-0.5 * x * x).exp() / (width * TAU.sqrt()) + least).clamp(0.0, 1.0)
}

/// The linear transform for light that leaves at one cosine.
#[derive(Clone, Copy)]
struct Bent {
    a: f32,
    b: f32,
}

impl Bent {
    fn new(x: f32, y: f32) -> Self {
        let flatness = 2.540_53e-5 + 1.712_28 * x - 1.715_06 * x * y + 1.341_74 * y * y;
        Self {
            a: (2.581_26 * x + 0.813_703 * y) * y / (1.0 + 0.310_327 * x * x + 2.609_94 * x * y),
            b: (1.0 - x).max(0.0).sqrt() * (y - 1.0) * y.powi(3) / flatness,
        }
    }

    /// K(o, i).
    fn kernel(&self, o: Vec3, i: Vec3) -> f32 {
        let along = o.truncate().normalize_or(Vec2::X);
        let (x, y) = (along.dot(i.truncate()), along.perp_dot(i.truncate()));
        let straight = Vec3::new(self.a * x + self.b * i.z, self.a * y, i.z);
        let scale = self.a / straight.length_squared().max(1e-20);
        FRAC_1_PI * scale * scale
    }

    /// A direction with the density K(o, i) cos θ_i.
    fn sample(&self, o: Vec3, u: Vec2) -> Vec3 {
        let h = warp::cosine_hemisphere(u);
        let (x, y) = ((h.x - self.b * h.z) / self.a, h.y / self.a);
        let along = o.truncate().normalize_or(Vec2::X);
        Vec3::new(along.x * x - along.y * y, along.y * x + along.x * y, h.z).normalize_or(Vec3::Z)
    }
}

impl Fuzz {
    /// Fuzz on the share `weight` of the surface, of a linear colour and a roughness, all in \[0, 1\].
    pub fn new(weight: f32, color: Vec3, roughness: f32) -> Self {
        Self {
            weight: weight.clamp(0.0, 1.0),
            color: color.clamp(Vec3::ZERO, Vec3::ONE),
            roughness: roughness.clamp(LEAST_ROUGHNESS, 1.0),
            to_fuzz: None,
        }
    }

    /// With a normal of its own: `to_fuzz` turns directions of the base's frame to those of the fuzz's.
    pub(super) fn set_frame(&mut self, to_fuzz: Mat3) {
        self.to_fuzz = Some(to_fuzz);
    }

    pub(super) fn color(&self) -> Vec3 {
        self.color
    }

    fn table(&self, get: impl Fn(&Slice) -> f32) -> f32 {
        let (j, t) = top::slice(1.0 - self.roughness.ln() / LEAST_ROUGHNESS.ln(), SLICES);
        mix(get(slice(j)), get(slice(j + 1)), t)
    }

    fn local(&self, w: Vec3) -> Vec3 {
        warp::tilted(w, self.to_fuzz.as_ref())
    }

    /// Share of light at a cosine that fuzz keeps from what is below.
    pub fn held(&self, mu: f32) -> f32 {
        self.weight * self.table(|s| s.kept.albedo(mu))
    }

    /// The same of a direction above the surface.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        self.held(self.local(w).z)
    }

    /// R of a base that spreads light so, for a direction turned to its facets.
    pub(super) fn residue(&self, w: Vec3, spread: &Spread) -> f32 {
        self.weight * self.table(|s| s.kept.base_residue(w, spread))
    }

    /// f·cos θ_i and the density of [`Fuzz::sample`], both directions above the surface.
    pub(super) fn eval_pdf(&self, o: Vec3, i: Vec3) -> (Vec3, f32) {
        let (o, i) = (self.local(o), self.local(i));
        let y = self.roughness;
        let there = Bent::new(o.z, y).kernel(o, i);
        let back = Bent::new(i.z, y).kernel(i, o);
        let held = self.table(|s| s.raw.albedo(o.z).max(s.raw.albedo(i.z))).max(1.0);
        let f = 0.5 * (reflected(o.z, y) * there + reflected(i.z, y) * back) / held;
        (self.color * (self.weight * f * i.z), 0.5 * (there * i.z + 1.0 / TAU))
    }

    /// A direction, of the paper's lobe or uniform over the hemisphere; above the fuzz, which may be below the surface.
    pub(super) fn sample(&self, o: Vec3, u_lobe: f32, u: Vec2) -> Vec3 {
        let o = self.local(o);
        let i = if u_lobe < 0.5 {
            Bent::new(o.z, self.roughness).sample(o, u)
        } else {
            warp::uniform_hemisphere(u)
        };
        self.to_fuzz.map_or(i, |m| m.transpose() * i)
    }
}

#[cfg(test)]
#[path = "fuzz_tests.rs"]
mod tests;
