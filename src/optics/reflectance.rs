//! What microfacets of an opaque or thin surface reflect, by the angle of incidence on the facet: Schlick's approximation,
//! with or without a thin film over it.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | [`Reflectance::at`] | F(c) | reflectance of a facet |
//! | [`Reflectance::average`] | F̄ | its hemispherical average |
//! | [`Reflectance::albedo`] | E(ω) | share of light from ω that single scattering reflects |
//!
//! Schlick's E is linear in f0 and f90, and tabulated. A film is F(c) = F(1) + (1 − F(1))(1 − c)⁵ and a rest that is
//! resolved into hat functions, whose shares are tabulated. What hats miss of the rest is taken at the facet angle at
//! which (1 − c)⁵ has the mean that the table tells: exact for smooth surfaces.

use super::facet_reflection::Shares;
use super::facet_tables::{HATS, hat};
use super::fresnel::{SCHLICK_AVERAGE, schlick_weight};
use super::thin_film::ThinFilm;
use glam::Vec3;

/// Reflectance of facets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance {
    f0: Vec3,
    f90: f32,
    film: Option<Film>,
}

/// A film on a share of the surface.
#[derive(Clone, Copy, Debug)]
struct Film {
    share: f32,
    film: ThinFilm,
    /// Reflectance at normal incidence.
    normal: Vec3,
    /// The average of what it adds.
    added: Vec3,
    /// What it has beyond Schlick's approximation at the nodes of the hats.
    rest: [Vec3; HATS],
}

impl Film {
    fn schlick(&self, weight: f32) -> Vec3 {
        self.normal + (Vec3::ONE - self.normal) * weight
    }

    fn rest_at(&self, c: f32) -> Vec3 {
        let (k, t) = hat(c);
        self.rest[k] + t * (self.rest[k + 1] - self.rest[k])
    }

    /// What it reflects of light that meets facets so.
    fn albedo(&self, s: &Shares) -> Vec3 {
        let kept = 1.0 - s.plain.lost;
        let c = 1.0 - (s.plain.schlick / kept.max(1e-6)).clamp(0.0, 1.0).powf(0.2);
        let Some(hats) = s.hats else { return kept * self.film.reflectance(c) };
        let rest: Vec3 = hats.iter().zip(&self.rest).map(|(&share, &rest)| share * rest).sum();
        let missed = self.film.reflectance(c) - self.schlick(schlick_weight(c)) - self.rest_at(c);
        let schlick = self.normal * kept + (Vec3::ONE - self.normal) * s.plain.schlick;
        (schlick + rest + kept * missed).clamp(Vec3::ZERO, Vec3::splat(kept))
    }
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
            let normal = film.reflectance(1.0);
            let mut film = Film { share, film, normal, added, rest: [Vec3::ZERO; HATS] };
            film.rest = std::array::from_fn(|k| {
                let c = k as f32 / (HATS - 1) as f32;
                film.film.reflectance(c) - film.schlick(schlick_weight(c))
            });
            self.film = Some(film);
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
            Some(f) => plain + f.share * (f.film.reflectance(c) - plain),
        }
    }

    /// F̄ = ∫₀¹ 2µ F(µ) dµ.
    pub(super) fn average(&self) -> Vec3 {
        let plain = self.f0 + (Vec3::splat(self.f90) - self.f0) * SCHLICK_AVERAGE;
        match &self.film {
            None => plain,
            Some(f) => (plain + f.share * f.added).clamp(Vec3::ZERO, Vec3::ONE),
        }
    }

    /// E(ω), given what the tables say of that direction.
    pub(super) fn albedo(&self, s: &Shares) -> Vec3 {
        let kept = 1.0 - s.plain.lost;
        let plain = self.f0 * (kept - s.plain.schlick) + self.f90 * s.plain.schlick;
        match &self.film {
            None => plain,
            Some(film) => plain + film.share * (film.albedo(s) - plain),
        }
    }

    /// Whether there is a film.
    pub(super) fn has_film(&self) -> bool {
        self.film.is_some()
    }

    /// What returns of light that perfectly reflecting facets would hand back after several reflections, when a share
    /// `lost` of diffuse light is reflected more than once: F̄² Ē/(1 − F̄(1 − Ē)), Ē = 1 − `lost` (Kulla & Conty 2017).
    pub(super) fn again(&self, lost: f32) -> Vec3 {
        let f = self.average();
        f * f * (1.0 - lost) / (Vec3::ONE - f * lost).max(Vec3::splat(1e-6))
    }
}
