//! The GGX microsurface with a width for each of two perpendicular tangents (Burley 2012; Heitz 2018, "Sampling the GGX
//! Distribution of Visible Normals"), which is the isotropic one of [`super::ggx`] stretched:
//!
//! | name | symbol |
//! | --- | --- |
//! | [`Facets::distribution`] | D(h) = 1/(π αx αy (hx²/αx² + hy²/αy² + hz²)²) |
//! | [`Facets::masking`] | G1(ω) = 2 cos θ/(cos θ + √(cos²θ + αx² ωx² + αy² ωy²)) |
//!
//! What single scattering loses depends on the azimuth, too: [`super::facet_tables`]. Where one width has to stand for
//! both, in the choice of what becomes of light that was lost once, it is the mean of order [`REFLECTED`].

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Order of the mean of both widths, ((αx^p + αy^p)/2)^(1/p), whose facets lose as much of light from all directions as
/// those of both, to 0.5 % of it.
pub(super) const REFLECTED: f32 = 1.7;

/// Widths and direction of a microsurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facets {
    /// α along the tangent and across it, \[0, 1\].
    pub alpha: Vec2,
    /// Unit vector of the tangent in the local frame.
    pub tangent: Vec2,
}

impl Facets {
    /// The same width everywhere.
    pub fn isotropic(alpha: f32) -> Self {
        Self { alpha: Vec2::splat(alpha), tangent: Vec2::X }
    }

    /// A direction of the local frame with x along the tangent.
    #[inline]
    pub(super) fn turned(&self, w: Vec3) -> Vec3 {
        let t = self.tangent;
        Vec3::new(t.x * w.x + t.y * w.y, t.x * w.y - t.y * w.x, w.z)
    }

    /// The inverse of [`Facets::turned`].
    #[inline]
    pub(super) fn back(&self, w: Vec3) -> Vec3 {
        let t = self.tangent;
        Vec3::new(t.x * w.x - t.y * w.y, t.x * w.y + t.y * w.x, w.z)
    }

    /// The width that stands for both where only one can be: their mean of order `p` > 0.
    pub(super) fn mean_width(&self, p: f32) -> f32 {
        let Vec2 { x, y } = self.alpha;
        if x == y { x } else { (0.5 * (x.powf(p) + y.powf(p))).powf(1.0 / p) }
    }

    /// D(h) of a turned direction.
    #[inline]
    pub(super) fn distribution(&self, h: Vec3) -> f32 {
        let a = self.alpha;
        let e = (h.x / a.x).powi(2) + (h.y / a.y).powi(2) + h.z * h.z;
        1.0 / (PI * a.x * a.y * e * e)
    }

    /// G1 of a turned direction, on either side.
    #[inline]
    pub(super) fn masking(&self, w: Vec3) -> f32 {
        2.0 * w.z.abs() * self.masking_over_two_cos(w)
    }

    /// G1/(2 |cos θ|) of a turned direction.
    #[inline]
    pub(super) fn masking_over_two_cos(&self, w: Vec3) -> f32 {
        let z = w.z.abs();
        let (x, y) = (self.alpha.x * w.x, self.alpha.y * w.y);
        1.0 / (z + (z * z + x * x + y * y).sqrt())
    }

    /// A turned normal seen from the turned direction `w` (`w.z` ≥ 0), with density G1(w) D(h) (w·h)/cos θ (Dupuy &
    /// Benyoub 2023).
    #[inline]
    pub(super) fn sample_visible(&self, w: Vec3, u: Vec2) -> Vec3 {
        let stretched = Vec3::new(self.alpha.x * w.x, self.alpha.y * w.y, w.z).normalize();
        let v = u.y * (1.0 + stretched.z);
        let z = 1.0 - v;
        let r = (v * (2.0 - v)).max(0.0).sqrt();
        let (sin, cos) = (TAU * u.x).sin_cos();
        let h = Vec3::new(r * cos + stretched.x, r * sin + stretched.y, z + stretched.z);
        Vec3::new(self.alpha.x * h.x, self.alpha.y * h.y, h.z.max(0.0)).normalize_or(Vec3::Z)
    }
}
