//! `KHR_materials_clearcoat` and `KHR_materials_coat` (draft): a dielectric GGX layer that light passes without bending,
//! with normals and a tangent of its own. Light lost by masking comes back as for [`super::metallic_roughness`].
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `f0` | ((η − 1)/(η + 1))² | reflectance at normal incidence, of Schlick's approximation; 0.04 of a clear coat |
//! | `crossing` | T(µ) = c^(1/(2 µ_t)) | what the coat's colour c leaves of light that passes it once, µ_t² = 1 − (1 − µ²)/η² |
//! | `internal` | K_r = 1 − (1 − F̄(η))/η² | share of diffuse light inside that the coat throws back to the base |
//! | `darkening` | Δ = (1 − K)/(1 − ρ K) | what is left of a base of colour ρ when it meets that light again and again |
//!
//! Absorption is the draft's, T(µ_o) T(µ_i) for its c^(1/µ_t) of the viewer alone, since light passes twice at two angles:
//! at normal incidence it is c. Darkening is OpenPBR's (§ coat darkening), K = F of the coat for a mirror, K_r for a diffuse
//! base, between them by how rough the base is. Both concern the share of the surface that the coat covers.

use super::anisotropic::Facets;
use super::base::Spread;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::facet_reflection::FacetReflection;
use super::fresnel::{self, SCHLICK_AVERAGE, f0_from_eta, schlick_weight};
use super::reflection_tables::Directional;
use super::top::{self, QUARTER, TopTable, mix};
use super::warp;
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Index of a clear coat.
const CLEAR_IOR: f32 = 1.5;
const SLICES: usize = 32;
/// Slices over √f0; that of a clear coat is the fifth.
const F0_SLICES: usize = 21;
/// A base that reflects more inside than this is a mirror in a box.
const MOST_INTERNAL: f32 = 0.9999;

/// Parameters of a [`Coat`], textures applied.
#[derive(Clone, Copy, Debug)]
pub struct CoatParameters {
    /// Share of the surface that it covers, \[0, 1\].
    pub weight: f32,
    /// GGX widths along the coat's tangent and across, \[0, 1\].
    pub alpha: Vec2,
    /// Index of refraction, ≥ 1.
    pub ior: f32,
    /// Linear colour of a white base seen through the coat at normal incidence, \[0, 1\].
    pub color: Vec3,
    /// How much of the darkening by reflections inside of the coat is there, \[0, 1\].
    pub darkening: f32,
}

/// A coat at one point.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    weight: f32,
    facets: Facets,
    f0: f32,
    reflection: FacetReflection,
    lost_average: f32,
    again: f32,
    /// What it does to light on its way to the base and back; `None` where that is nothing.
    tint: Option<Tint>,
    /// From the frame of the base to that of the coat, where they differ.
    to_coat: Option<Mat3>,
}

#[derive(Clone, Copy, Debug)]
struct Tint {
    ior: f32,
    color: Vec3,
    darkening: f32,
    /// K_r.
    internal: f32,
}

/// T(µ) of a coat of that index and colour.
pub fn crossing(ior: f32, color: Vec3, mu: f32) -> Vec3 {
    let sin2 = (1.0 - mu * mu).max(0.0) / (ior * ior).max(1e-6);
    let cos = (1.0 - sin2).max(0.0).sqrt();
    // A coat of index 1 is infinitely thick along the surface.
    let path = 0.5 / cos.max(1e-6);
    color.map(|c| if c >= 1.0 { 1.0 } else { c.max(0.0).powf(path) })
}

fn slice(k: usize, j: usize) -> &'static TopTable {
    static ALL: [[OnceLock<Box<TopTable>>; SLICES]; F0_SLICES] =
        [const { [const { OnceLock::new() }; SLICES] }; F0_SLICES];
    ALL[k][j].get_or_init(|| {
        let f0 = (k as f32 / (F0_SLICES - 1) as f32).powi(2);
        let coat = Coat::bare(1.0, Vec2::splat(j as f32 / (SLICES - 1) as f32), f0);
        Box::new(TopTable::new(|mu| coat.albedo_at(top::towards(mu, 0.0))))
    })
}

impl Coat {
    /// A clear coat on the share `weight` of the surface, GGX width `alpha`.
    pub fn new(weight: f32, alpha: f32) -> Self {
        Self::bare(weight, Vec2::splat(alpha), f0_from_eta(CLEAR_IOR))
    }

    /// A coat with these parameters.
    pub fn with(p: &CoatParameters) -> Self {
        let mut coat = Self::bare(p.weight, p.alpha, f0_from_eta(p.ior).min(1.0));
        let (color, darkening) = (p.color.clamp(Vec3::ZERO, Vec3::ONE), p.darkening.clamp(0.0, 1.0));
        if color != Vec3::ONE || darkening > 0.0 {
            let internal = 1.0 - (1.0 - fresnel::diffuse_reflectance(p.ior)) / (p.ior * p.ior);
            let internal = internal.clamp(0.0, MOST_INTERNAL);
            coat.tint = Some(Tint { ior: p.ior, color, darkening, internal });
        }
        coat
    }

    fn bare(weight: f32, alpha: Vec2, f0: f32) -> Self {
        let facets = Facets { alpha: alpha.clamp(Vec2::ZERO, Vec2::ONE), tangent: Vec2::X };
        let reflection = FacetReflection::new(&facets, false);
        let average = f0 + (1.0 - f0) * SCHLICK_AVERAGE;
        let lost = reflection.average().lost;
        let again = average * average * (1.0 - lost) / (1.0 - average * lost);
        let weight = weight.clamp(0.0, 1.0);
        Self { weight, facets, f0, reflection, lost_average: lost, again, tint: None, to_coat: None }
    }

    /// With a frame of its own: `to_coat` turns directions of the base's frame to those of the coat's, x along its tangent.
    pub(super) fn set_frame(&mut self, to_coat: Mat3) {
        self.to_coat = Some(to_coat);
    }

    fn towards(&self, w: Vec3) -> Directional {
        self.reflection.towards(w).plain
    }

    fn albedo_at(&self, w: Vec3) -> f32 {
        let d = self.towards(w);
        self.weight * (self.f0 * (1.0 - d.lost - d.schlick) + d.schlick + self.again * d.lost)
    }

    #[inline]
    fn local(&self, w: Vec3) -> Vec3 {
        warp::tilted(w, self.to_coat.as_ref())
    }

    /// E for a direction above the surface.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        self.albedo_at(self.local(w))
    }

    /// E at a cosine with the coat's normal, averaged over azimuths.
    pub(super) fn mean_albedo(&self, mu: f32) -> f32 {
        if self.facets.alpha.x == self.facets.alpha.y {
            return self.albedo_at(top::towards(mu, 0.0));
        }
        QUARTER.iter().map(|&phi| self.albedo_at(top::towards(mu, phi))).sum::<f32>() / QUARTER.len() as f32
    }

    /// R of a base that spreads light so, for a direction turned to its facets. Of two widths their mean counts.
    pub(super) fn residue(&self, w: Vec3, spread: &Spread) -> f32 {
        let (j, t) = top::slice(self.facets.mean_width(super::anisotropic::REFLECTED), SLICES);
        let x = self.f0.sqrt() * (F0_SLICES - 1) as f32;
        let of = |k: usize| {
            let of = |j: usize| slice(k, j).base_residue(w, spread);
            mix(of(j), of(j + 1), t)
        };
        // An index whose tables there are needs no others.
        if (x - x.round()).abs() < 1e-3 {
            return self.weight * of((x.round() as usize).min(F0_SLICES - 1));
        }
        let (k, s) = top::slice(self.f0.sqrt(), F0_SLICES);
        self.weight * mix(of(k), of(k + 1), s)
    }

    /// Whether it reflects in one direction only.
    pub(super) fn is_smooth(&self) -> bool {
        self.facets.alpha.max_element() < MIN_ROUGH_ALPHA
    }

    /// Whether it changes the light that goes on to the base.
    pub(super) fn is_tinted(&self) -> bool {
        self.tint.is_some()
    }

    /// What remains of light on its way from the directions on whose side there is a coat to a base of colour `color` that
    /// is so rough, 0 to 1, and out again.
    pub(super) fn passed(&self, ways: [Option<Vec3>; 2], color: Vec3, roughness: f32) -> Vec3 {
        let Some(tint) = &self.tint else { return Vec3::ONE };
        let cosines = ways.map(|w| w.map(|w| self.local(w).z));
        let mut passed = Vec3::ONE;
        for mu in cosines.into_iter().flatten() {
            passed *= crossing(tint.ior, tint.color, mu);
        }
        if tint.darkening > 0.0 {
            let (mut mirrored, mut count) = (0.0, 0.0);
            for mu in cosines.into_iter().flatten() {
                mirrored += fresnel::dielectric(mu, tint.ior);
                count += 1.0;
            }
            let internal = mix(mirrored / f32::max(count, 1.0), tint.internal, roughness).min(MOST_INTERNAL);
            let left = (1.0 - internal) / (Vec3::ONE - color * internal);
            passed *= Vec3::ONE + tint.darkening * (left - Vec3::ONE);
        }
        Vec3::ONE + self.weight * (passed - Vec3::ONE)
    }

    /// What remains of light that passes the coat twice at one cosine with its normal.
    pub(super) fn twice(&self, mu: f32) -> Vec3 {
        let Some(tint) = &self.tint else { return Vec3::ONE };
        let once = crossing(tint.ior, tint.color, mu);
        Vec3::ONE + self.weight * (once * once - Vec3::ONE)
    }

    /// f·cos θ_i and the density of [`Coat::sample`], both directions above the surface.
    pub(super) fn eval_pdf(&self, o: Vec3, i: Vec3) -> (f32, f32) {
        if self.is_smooth() {
            return (0.0, 0.0);
        }
        let (o, i) = (self.local(o), self.local(i));
        let h = (o + i).normalize_or(Vec3::Z);
        let c = o.dot(h).clamp(0.0, 1.0);
        let (at_o, at_i) = (self.towards(o), self.towards(i));
        let visible = 0.5 * self.facets.distribution(h) * self.facets.masking_over_two_cos(o);
        let fresnel = self.f0 + (1.0 - self.f0) * schlick_weight(c);
        let lost = self.lost_average;
        let lambert = i.z * FRAC_1_PI;
        let again = if lost > 0.0 { at_o.lost * at_i.lost * lambert / lost } else { 0.0 };
        let f = fresnel * visible * self.facets.masking(i) + self.again * again;
        (self.weight * f, (1.0 - at_o.lost) * visible + at_o.lost * lambert)
    }

    /// A direction; above the coat, which may be below the surface. For a smooth coat the mirror image.
    pub(super) fn sample(&self, o: Vec3, u_lobe: f32, u: Vec2) -> Vec3 {
        let o = self.local(o);
        let i = if self.is_smooth() {
            Vec3::new(-o.x, -o.y, o.z)
        } else if u_lobe < self.towards(o).lost {
            warp::cosine_hemisphere(u)
        } else {
            let h = self.facets.sample_visible(o, u);
            2.0 * o.dot(h) * h - o
        };
        if i.z <= 0.0 {
            return Vec3::NEG_Z;
        }
        self.to_coat.map_or(i, |m| m.transpose() * i)
    }
}

#[cfg(test)]
#[path = "coat_tests.rs"]
mod tests;
