//! `KHR_materials_clearcoat`: a dielectric GGX layer of index 1.5 (f0 = 0.04) that light passes without bending, with
//! normals of its own. Light lost by masking comes back as for [`super::metallic_roughness`].

use super::base::Spread;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::fresnel::{SCHLICK_AVERAGE, schlick_weight};
use super::reflection_tables::Reflection;
use super::top::{self, TopTable};
use super::{ggx, warp};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Reflectance at normal incidence.
const F0: f32 = 0.04;
const SLICES: usize = 32;
/// Normals of the coat are taken to be at least so far above the horizon.
const LEAST_COSINE: f32 = 1e-3;

/// A coat at one point.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    factor: f32,
    alpha: f32,
    reflection: Reflection,
    again: f32,
    /// From the frame of the base to that of the coat, where they differ.
    to_coat: Option<Mat3>,
}

fn slice(j: usize) -> &'static TopTable {
    static ALL: [OnceLock<TopTable>; SLICES] = [const { OnceLock::new() }; SLICES];
    ALL[j].get_or_init(|| {
        let coat = Coat::new(1.0, j as f32 / (SLICES - 1) as f32);
        TopTable::new(|mu| coat.albedo_at(mu))
    })
}

impl Coat {
    /// A coat on the share `factor` of the surface, GGX width `alpha`.
    pub fn new(factor: f32, alpha: f32) -> Self {
        let reflection = Reflection::at(alpha);
        let average = F0 + (1.0 - F0) * SCHLICK_AVERAGE;
        let lost = reflection.lost_average;
        let again = average * average * (1.0 - lost) / (1.0 - average * lost);
        Self { factor: factor.clamp(0.0, 1.0), alpha, reflection, again, to_coat: None }
    }

    /// With a normal of its own: `to_coat` turns directions of the base's frame to those of the coat's.
    pub(super) fn set_frame(&mut self, to_coat: Mat3) {
        self.to_coat = Some(to_coat);
    }

    fn albedo_at(&self, mu: f32) -> f32 {
        let d = self.reflection.directional(mu);
        self.factor * (F0 * (1.0 - d.lost - d.schlick) + d.schlick + self.again * d.lost)
    }

    #[inline]
    fn local(&self, w: Vec3) -> Vec3 {
        let w = self.to_coat.map_or(w, |m| m * w);
        if w.z >= LEAST_COSINE { w } else { Vec3::new(w.x, w.y, LEAST_COSINE).normalize() }
    }

    /// E for a direction above the surface.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        self.albedo_at(self.local(w).z)
    }

    /// R of a base that spreads light so, for a direction turned to its facets.
    pub(super) fn residue(&self, w: Vec3, spread: &Spread) -> f32 {
        let (j, t) = top::slice(self.alpha, SLICES);
        let of = |j: usize| slice(j).base_residue(w, spread);
        self.factor * top::mix(of(j), of(j + 1), t)
    }

    /// Whether it reflects in one direction only.
    pub(super) fn is_smooth(&self) -> bool {
        self.alpha < MIN_ROUGH_ALPHA
    }

    /// f·cos θ_i and the density of [`Coat::sample`], both directions above the surface.
    pub(super) fn eval_pdf(&self, o: Vec3, i: Vec3) -> (f32, f32) {
        if self.is_smooth() {
            return (0.0, 0.0);
        }
        let (o, i) = (self.local(o), self.local(i));
        let h = (o + i).normalize_or(Vec3::Z);
        let c = o.dot(h).clamp(0.0, 1.0);
        let (at_o, at_i) = (self.reflection.directional(o.z), self.reflection.directional(i.z));
        let visible = 0.5 * ggx::distribution(h, self.alpha) * ggx::masking_over_two_cos(o, self.alpha);
        let fresnel = F0 + (1.0 - F0) * schlick_weight(c);
        let lost = self.reflection.lost_average;
        let lambert = i.z * FRAC_1_PI;
        let again = if lost > 0.0 { at_o.lost * at_i.lost * lambert / lost } else { 0.0 };
        let f = fresnel * visible * ggx::masking(i, self.alpha) + self.again * again;
        (self.factor * f, (1.0 - at_o.lost) * visible + at_o.lost * lambert)
    }

    /// A direction; above the coat, which may be below the surface. For a smooth coat the mirror image.
    pub(super) fn sample(&self, o: Vec3, u_lobe: f32, u: Vec2) -> Vec3 {
        let o = self.local(o);
        let i = if self.is_smooth() {
            Vec3::new(-o.x, -o.y, o.z)
        } else if u_lobe < self.reflection.directional(o.z).lost {
            warp::cosine_hemisphere(u)
        } else {
            let h = ggx::sample_visible(o, self.alpha, u);
            2.0 * o.dot(h) * h - o
        };
        if i.z <= 0.0 {
            return Vec3::NEG_Z;
        }
        self.to_coat.map_or(i, |m| m.transpose() * i)
    }
}
