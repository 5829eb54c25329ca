//! Leaving a surface without a magic epsilon.
//!
//! Pharr, Jakob & Humphreys, "Physically Based Rendering" (4th ed.), section 6.8: a computed point comes with a bound
//! of its rounding error on each axis, and a ray that leaves starts outside of that box, on its own side of the
//! surface. All bounds are relative, so scenes of micrometres and of kilometres are treated alike.

use glam::Vec3;

/// Rounding of coordinates and distances, relative to the largest of them: what is equal but for rounding may be off by
/// so much, 16 roundings.
pub const ROUNDING: f32 = 1.0 / (1_u32 << 20) as f32;

/// γₙ = n ε / (1 − n ε), the bound of n roundings in a row (equation 6.20), with ε = 2⁻²⁴.
pub const fn gamma(n: u32) -> f32 {
    let x = n as f64 / (1_u32 << 24) as f64;
    (x / (1.0 - x)) as f32
}

/// The origin of a ray that leaves the surface point `p` along `direction`.
///
/// It lies off the surface, along `geometric_normal` (unit) to the side that `direction` points to, by as much as
/// `error` (bounds of the error of `p` on each axis) requires and no more; coordinates are rounded away from `p`.
#[inline]
pub fn offset_origin(p: Vec3, error: Vec3, geometric_normal: Vec3, direction: Vec3) -> Vec3 {
    let distance = geometric_normal.abs().dot(error);
    let normal = if direction.dot(geometric_normal) < 0.0 { -geometric_normal } else { geometric_normal };
    let offset = distance * normal;
    let away = |p: f32, offset: f32| {
        let q = p + offset;
        if offset > 0.0 {
            q.next_up()
        } else if offset < 0.0 {
            q.next_down()
        } else {
            q
        }
    };
    Vec3::new(away(p.x, offset.x), away(p.y, offset.y), away(p.z, offset.z))
}
