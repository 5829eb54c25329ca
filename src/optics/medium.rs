//! A homogeneous scattering medium and the quantities derived from its coefficients.
//!
//! | name | symbol | meaning, unit |
//! | --- | --- | --- |
//! | `sigma_a`, `sigma_s`, `sigma_t` | σa, σs, σt = σa + σs | absorption, scattering, extinction, 1/m |
//! | `g` | g | mean cosine of Henyey–Greenstein |
//! | [`Medium::albedo`] | α = σs/σt | single-scattering albedo |
//! | [`Medium::reduced_scattering`] | σs′ = σs(1 − g) | 1/m |
//! | [`Medium::reduced_extinction`] | σt′ = σs′ + σa | 1/m |
//! | [`Medium::diffusion_coefficient`] | D = 1/(3σt′) | m |
//! | [`Medium::grosjean_coefficient`] | D_G = (2σa + σs′)/(3σt′²) | m, d'Eon & Irving 2011 |
//! | [`Medium::effective_transport`] | σtr = √(σa/D) = √(3σaσt′) | 1/m |
//!
//! Definitions as in Jensen et al. 2001 §2.

use super::phase::HenyeyGreenstein;
use super::{albedo, fresnel};
use glam::Vec3;

/// What light meets between boundaries. Coefficients per metre, one a colour channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient, 1/m, ≥ 0.
    pub sigma_a: Vec3,
    /// Scattering coefficient, 1/m, ≥ 0.
    pub sigma_s: Vec3,
    /// Extinction coefficient, the sum of the other two, 1/m.
    pub sigma_t: Vec3,
    /// Mean cosine of the Henyey–Greenstein phase function, in (−1, 1).
    pub g: f32,
    /// Index of refraction, > 0.
    pub ior: f32,
    /// Where media overlap, the higher one fills the overlap.
    pub priority: i32,
}

impl Medium {
    /// Nothing at all: index 1, the lowest priority.
    pub const VACUUM: Self = Self {
        sigma_a: Vec3::ZERO,
        sigma_s: Vec3::ZERO,
        sigma_t: Vec3::ZERO,
        g: 0.0,
        ior: 1.0,
        priority: i32::MIN,
    };

    /// A medium of the given coefficients.
    pub fn new(sigma_a: Vec3, sigma_s: Vec3, g: f32, ior: f32, priority: i32) -> Self {
        Self { sigma_a, sigma_s, sigma_t: sigma_a + sigma_s, g, ior, priority }
    }

    /// The phase function.
    #[inline]
    pub fn phase(&self) -> HenyeyGreenstein {
        HenyeyGreenstein { g: self.g }
    }

    /// Whether light passes without a trace.
    #[inline]
    pub fn is_clear(&self) -> bool {
        self.sigma_t == Vec3::ZERO
    }

    /// Single-scattering albedo σs/σt in \[0, 1\]; 0 where nothing happens.
    #[inline]
    pub fn albedo(&self) -> Vec3 {
        quotient(self.sigma_s, self.sigma_t, 0.0)
    }

    /// Reduced albedo σs′/σt′ in \[0, 1\]; 0 where nothing happens.
    pub fn reduced_albedo(&self) -> Vec3 {
        quotient(self.reduced_scattering(), self.reduced_extinction(), 0.0)
    }

    /// About how much of the light that crosses into an object of this medium comes out again: what goes straight through on
    /// the mean chord (four volumes over the area, m), and what a half space of it returns of the rest. To choose by, not
    /// to calculate with.
    pub fn returned(&self, chord: f32) -> Vec3 {
        let inside = albedo::multiple_from_single_rgb(self.albedo(), self.g);
        let out = 1.0 / (self.ior * self.ior).max(1.0);
        let returned = inside * out / (Vec3::ONE - inside * (1.0 - out));
        let through = (-self.sigma_a * chord).exp();
        returned + (Vec3::ONE - returned) * through
    }

    /// About how many scattering events a walk has in an object of that mean chord, m, in its longest channel: as many
    /// as the mean chord holds, η² times as many for light that the boundary keeps in, or as absorption leaves.
    pub fn events(&self, chord: f32) -> f32 {
        let through = self.sigma_s * (chord * self.ior * self.ior);
        let absorbed = Vec3::ONE - self.albedo();
        (through / (Vec3::ONE + through * absorbed)).max_element()
    }

    /// Mean free path 1/σt, m; infinite in a clear channel.
    pub fn mean_free_path(&self) -> Vec3 {
        quotient(Vec3::ONE, self.sigma_t, f32::INFINITY)
    }

    /// Transport mean free path 1/σt′, m; infinite in a clear channel.
    pub fn transport_mean_free_path(&self) -> Vec3 {
        quotient(Vec3::ONE, self.reduced_extinction(), f32::INFINITY)
    }

    /// σs(1 − g), 1/m.
    pub fn reduced_scattering(&self) -> Vec3 {
        self.sigma_s * (1.0 - self.g)
    }

    /// σs(1 − g) + σa, 1/m.
    pub fn reduced_extinction(&self) -> Vec3 {
        self.reduced_scattering() + self.sigma_a
    }

    /// D = 1/(3σt′), m; infinite in a clear channel.
    pub fn diffusion_coefficient(&self) -> Vec3 {
        quotient(Vec3::ONE, 3.0 * self.reduced_extinction(), f32::INFINITY)
    }

    /// Grosjean's D_G = (2σa + σs′)/(3σt′²), m; infinite in a clear channel.
    pub fn grosjean_coefficient(&self) -> Vec3 {
        let t = self.reduced_extinction();
        quotient(2.0 * self.sigma_a + self.reduced_scattering(), 3.0 * t * t, f32::INFINITY)
    }

    /// Effective transport coefficient √(3σaσt′), 1/m; its inverse is the diffuse mean free path.
    pub fn effective_transport(&self) -> Vec3 {
        (3.0 * self.sigma_a * self.reduced_extinction()).map(f32::sqrt)
    }

    /// Diffuse mean free path 1/σtr, m; infinite without absorption.
    pub fn diffuse_mean_free_path(&self) -> Vec3 {
        quotient(Vec3::ONE, self.effective_transport(), f32::INFINITY)
    }

    /// Multi-scatter albedo: the share of diffuse light that a semi-infinite medium of this kind returns where its
    /// boundary does not refract, in \[0, 1\] (van de Hulst's fit, see [`albedo`]).
    pub fn multiple_albedo(&self) -> Vec3 {
        albedo::multiple_from_single_rgb(self.albedo(), self.g)
    }

    /// The colour that a thick object shows: the share of diffuse outside light that enters through a smooth boundary
    /// in air, is scattered and leaves again, without the surface reflection, in \[0, 1\].
    ///
    /// Light that the medium returns meets the boundary from inside again and again (Saunderson 1942). The medium is
    /// taken to return R(µ, µ′) = ρ k(µ) k(µ′) with k ∝ 1/(1 + 2sµ) (Hapke 1981), ρ the multi-scatter albedo and s the
    /// similarity parameter of [`albedo`]; then, with F the reflectance from inside and T = 1 − F,
    /// n² ρ (∫2µ k T dµ)² / (1 − ρ ∫2µ k² F dµ). Against adding–doubling for n = 1–1.5 it is within 0.01
    /// where scattering is isotropic, moderately forward or dense, and within 0.035 for g = −0.5 and for dark media of
    /// g = 0.9, whose few scattering events keep their direction.
    pub fn effective_albedo(&self) -> Vec3 {
        let (albedo, multiple) = (self.albedo(), self.multiple_albedo());
        Vec3::from_array(std::array::from_fn(|i| effective_albedo(albedo[i], multiple[i], self.g, self.ior)))
    }
}

fn effective_albedo(albedo: f32, multiple: f32, g: f32, ior: f32) -> f32 {
    const STEPS: usize = 256;
    let s = ((1.0 - albedo) / (1.0 - g * albedo)).max(0.0).sqrt();
    let (mut norm, mut crossing, mut returned) = (0.0, 0.0, 0.0);
    for i in 0..STEPS {
        let mu = (i as f32 + 0.5) / STEPS as f32;
        let k = 1.0 / (1.0 + 2.0 * s * mu);
        let weight = 2.0 * mu / STEPS as f32;
        let f = fresnel::dielectric(mu, 1.0 / ior);
        norm += weight * k;
        crossing += weight * k * (1.0 - f);
        returned += weight * k * k * f;
    }
    let (crossing, returned) = (crossing / norm, returned / (norm * norm));
    ior * ior * multiple * crossing * crossing / (1.0 - multiple * returned)
}

impl Default for Medium {
    fn default() -> Self {
        Self::VACUUM
    }
}

fn quotient(a: Vec3, b: Vec3, otherwise: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { otherwise }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vec3, b: f64, what: &str) {
        let a = f64::from(a.x);
        assert!((a - b).abs() <= 2e-6 * b.abs(), "{what}: {a} for {b}");
    }

    /// "Derived medium coefficients": σs = 9, σa = 0.1, g = 0.8.
    #[test]
    fn derived_coefficients_match_high_precision_values() {
        let m = Medium::new(Vec3::splat(0.1), Vec3::splat(9.0), 0.8, 1.5, 0);
        close(m.sigma_t, 9.1, "sigma_t");
        close(m.reduced_scattering(), 1.7999999999999996, "sigma_s'");
        close(m.reduced_extinction(), 1.8999999999999997, "sigma_t'");
        close(m.albedo(), 0.989010989010989, "albedo");
        close(m.reduced_albedo(), 0.9473684210526315, "albedo'");
        close(m.mean_free_path(), 0.10989010989010989, "mfp");
        close(m.transport_mean_free_path(), 0.5263157894736843, "mfp'");
        close(m.diffusion_coefficient(), 0.17543859649122812, "D");
        close(m.grosjean_coefficient(), 0.1846722068328717, "D_G");
        close(m.effective_transport(), 0.7549834435270749, "sigma_tr");
        close(m.diffuse_mean_free_path(), 1.3245323570650438, "dmfp");
    }

    /// Clear media return all, black ones nothing; white ones all again, whatever the index. Events: the mean chord holds
    /// σs η² chord of them (Blanco & Fournier 2003 and the radiance of a trapping boundary), absorption 1/(1 − α).
    #[test]
    fn what_objects_return_and_how_long_walks_are() {
        let medium = |a: f32, s: f32| Medium::new(Vec3::splat(a), Vec3::splat(s), 0.0, 1.5, 0);
        assert_eq!(medium(0.0, 0.0).returned(0.1), Vec3::ONE);
        assert!(medium(1e4, 0.0).returned(0.1).x < 1e-6);
        assert!((medium(0.0, 1e4).returned(0.1).x - 1.0).abs() < 1e-5);
        assert!(medium(1e3, 1e3).returned(0.1).x < 0.1);
        assert!((medium(0.0, 100.0).events(0.1) - 22.5).abs() < 1e-4);
        assert!((medium(1.0, 9.0).events(1e9) - 10.0).abs() < 1e-3);
    }

    #[test]
    fn clear_media_have_no_nans() {
        let m = Medium::new(Vec3::ZERO, Vec3::new(0.0, 1.0, 0.0), 0.3, 1.33, 0);
        assert_eq!(m.albedo(), Vec3::new(0.0, 1.0, 0.0));
        assert_eq!(m.mean_free_path().x, f32::INFINITY);
        assert_eq!(m.diffuse_mean_free_path(), Vec3::INFINITY);
        assert!(m.effective_albedo().is_finite());
    }

    /// (albedo, g, n, reflected share of diffuse light without the first surface): half spaces computed by
    /// adding–doubling, the table "Homogeneous slab of optical thickness tau" with tau = inf.
    const HALF_SPACES: [(f32, f32, f32, f32); 48] = [
        (0.5, -0.5, 1.0, 0.201646),
        (0.9, -0.5, 1.0, 0.546856),
        (0.99, -0.5, 1.0, 0.828736),
        (0.999, -0.5, 1.0, 0.942218),
        (0.5, 0.0, 1.0, 0.146544),
        (0.9, 0.0, 1.0, 0.478024),
        (0.99, 0.0, 1.0, 0.794564),
        (0.999, 0.0, 1.0, 0.929713),
        (0.5, 0.5, 1.0, 0.082436),
        (0.9, 0.5, 1.0, 0.360152),
        (0.99, 0.5, 1.0, 0.723441),
        (0.999, 0.5, 1.0, 0.902180),
        (0.5, 0.9, 1.0, 0.018254),
        (0.9, 0.9, 1.0, 0.132585),
        (0.99, 0.9, 1.0, 0.493415),
        (0.999, 0.9, 1.0, 0.795432),
        (0.5, -0.5, 1.33, 0.114042),
        (0.9, -0.5, 1.33, 0.353409),
        (0.99, -0.5, 1.33, 0.665259),
        (0.999, -0.5, 1.33, 0.835819),
        (0.5, 0.0, 1.33, 0.060984),
        (0.9, 0.0, 1.33, 0.275724),
        (0.99, 0.0, 1.33, 0.616294),
        (0.999, 0.0, 1.33, 0.815331),
        (0.5, 0.5, 1.33, 0.024130),
        (0.9, 0.5, 1.33, 0.175913),
        (0.99, 0.5, 1.33, 0.524262),
        (0.999, 0.5, 1.33, 0.771729),
        (0.5, 0.9, 1.33, 0.003003),
        (0.9, 0.9, 1.33, 0.038669),
        (0.99, 0.9, 1.33, 0.280312),
        (0.999, 0.9, 1.33, 0.616861),
        (0.5, -0.5, 1.5, 0.091809),
        (0.9, -0.5, 1.5, 0.290937),
        (0.99, -0.5, 1.5, 0.593889),
        (0.999, -0.5, 1.5, 0.787053),
        (0.5, 0.0, 1.5, 0.044344),
        (0.9, 0.0, 1.5, 0.216112),
        (0.99, 0.0, 1.5, 0.540183),
        (0.999, 0.0, 1.5, 0.762462),
        (0.5, 0.5, 1.5, 0.016616),
        (0.9, 0.5, 1.5, 0.132103),
        (0.99, 0.5, 1.5, 0.445807),
        (0.999, 0.5, 1.5, 0.711506),
        (0.5, 0.9, 1.5, 0.001979),
        (0.9, 0.9, 1.5, 0.026654),
        (0.99, 0.9, 1.5, 0.219082),
        (0.999, 0.9, 1.5, 0.540811),
    ];

    #[test]
    fn effective_albedo_is_close_to_adding_doubling() {
        let mut worst = 0.0f32;
        for (albedo, g, n, expected) in HALF_SPACES {
            let m = Medium::new(Vec3::splat(1.0 - albedo), Vec3::splat(albedo), g, n, 0);
            let got = m.effective_albedo().x;
            worst = worst.max((got - expected).abs());
            let tolerance = if g < 0.0 || albedo < 0.95 && g > 0.5 { 0.035 } else { 0.01 };
            assert!((got - expected).abs() < tolerance, "{albedo} {g} {n}: {got} for {expected}");
        }
        assert!(worst > 1e-3, "an approximation this good is suspect: {worst}");
    }

    #[test]
    fn without_absorption_all_that_enters_leaves() {
        let m = Medium::new(Vec3::ZERO, Vec3::ONE, 0.5, 1.5, 0);
        let entering = 1.0 - fresnel::diffuse_reflectance(1.5);
        assert!((m.effective_albedo().x - entering).abs() < 1e-3);
    }
}
