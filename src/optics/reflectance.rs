//! What microfacets of an opaque or thin surface reflect, by the angle of incidence on the facet: Schlick's approximation,
//! with or without a thin film over it.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | [`Reflectance::at`] | F(c) | reflectance of a facet |
//! | [`Reflectance::average`] | F̄ | its hemispherical average |
//! | [`Reflectance::albedo`] | E(µ) | share of light from µ that single scattering reflects |
//!
//! Schlick's E is linear in f0 and f90, and tabulated. A film has no such table: what it adds is taken at the facet angle
//! at which (1 − c)⁵ has the mean that the table tells, exact for smooth surfaces.

use super::fresnel::{SCHLICK_AVERAGE, schlick_weight};
use super::reflection_tables::Directional;
use super::thin_film::ThinFilm;
use glam::Vec3;

/// Reflectance of facets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance {
    f0: Vec3,
    f90: f32,
    /// Share of the film, the film, and the average of what it adds.
    film: Option<(f32, ThinFilm, Vec3)>,
}

/// Nodes and weights of Gauss–Legendre quadrature on \[0, 1\], eight points.
pub(super) const NODES: [(f32, f32); 8] = [
    (0.019_855_072, 0.050_614_268),
    (0.101_666_76, 0.111_190_52),
    (0.237_233_79, 0.156_853_32),
    (0.408_282_68, 0.181_341_89),
    (0.591_717_3, 0.181_341_89),
    (0.762_766_2, 0.156_853_32),
    (0.898_333_25, 0.111_190_52),
    (0.980_144_9, 0.050_614_268),
];

impl Reflectance {
    /// f0 + (f90 − f0)(1 − c)⁵.
    pub(super) fn schlick(f0: Vec3, f90: f32) -> Self {
        Self { f0, f90, film: None }
    }

    /// With a film on `share` of the surface.
    pub(super) fn with_film(mut self, share: f32, film: Option<ThinFilm>) -> Self {
        if let Some(film) = film.filter(|_| share > 0.0) {
            let added: Vec3 = NODES
                .iter()
                .map(|&(mu, weight)| (film.reflectance(mu) - self.plain(mu)) * (2.0 * mu * weight))
                .sum();
            self.film = Some((share, film, added));
        }
        self
    }

    #[inline]
    fn plain(&self, c: f32) -> Vec3 {
        self.f0 + (Vec3::splat(self.f90) - self.f0) * schlick_weight(c)
    }

    /// F(c).
    #[inline]
    pub(super) fn at(&self, c: f32) -> Vec3 {
        let plain = self.plain(c);
        match &self.film {
            None => plain,
            Some((share, film, _)) => plain + *share * (film.reflectance(c) - plain),
        }
    }

    /// F̄ = ∫₀¹ 2µ F(µ) dµ.
    pub(super) fn average(&self) -> Vec3 {
        let plain = self.f0 + (Vec3::splat(self.f90) - self.f0) * SCHLICK_AVERAGE;
        match &self.film {
            None => plain,
            Some((share, _, added)) => (plain + *share * *added).clamp(Vec3::ZERO, Vec3::ONE),
        }
    }

    /// E(µ), given what the tables say of that direction.
    pub(super) fn albedo(&self, d: Directional) -> Vec3 {
        let kept = 1.0 - d.lost;
        let plain = self.f0 * (kept - d.schlick) + self.f90 * d.schlick;
        match &self.film {
            None => plain,
            Some((share, film, _)) => {
                let c = 1.0 - (d.schlick / kept.max(1e-6)).clamp(0.0, 1.0).powf(0.2);
                plain + *share * (kept * film.reflectance(c) - plain)
            }
        }
    }

    /// What returns of light that perfectly reflecting facets would hand back after several reflections, when a share
    /// `lost` of diffuse light is reflected more than once: F̄² Ē/(1 − F̄(1 − Ē)), Ē = 1 − `lost` (Kulla & Conty 2017).
    pub(super) fn again(&self, lost: f32) -> Vec3 {
        let f = self.average();
        f * f * (1.0 - lost) / (Vec3::ONE - f * lost).max(Vec3::splat(1e-6))
    }
}
