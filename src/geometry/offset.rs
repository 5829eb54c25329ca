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
    // `next_up` where the offset is positive, `next_down` where it is negative, without a branch.
    let away = |p: f32, offset: f32| {
        let q = p + offset;
        let outwards = (q > 0.0) == (offset > 0.0);
        let next = q.to_bits().wrapping_add(if outwards { 1 } else { u32::MAX });
        let next = if q == 0.0 { 1 | offset.to_bits() & 0x8000_0000 } else { next };
        if offset == 0.0 || !q.is_finite() { q } else { f32::from_bits(next) }
    };
    Vec3::new(away(p.x, offset.x), away(p.y, offset.y), away(p.z, offset.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_rounded_away_from_the_point() {
        let values =
            [0.0, -0.0, 1e-45, -1e-45, 1e-38, 0.3, -0.3, 7.0, -7.0, 1e30, f32::MAX, f32::INFINITY, f32::NAN];
        for p in values {
            for error in [0.0, 1e-45, 1e-9, 0.1, 7.0, 1e30] {
                for up in [Vec3::X, Vec3::NEG_X] {
                    let got = offset_origin(Vec3::splat(p), Vec3::splat(error), Vec3::X, up).x;
                    let q = p + up.x * error;
                    let expected = match up.x * error {
                        offset if offset > 0.0 => q.next_up(),
                        offset if offset < 0.0 => q.next_down(),
                        _ => q,
                    };
                    let same =
                        got == expected || got.is_nan() && expected.is_nan() || !q.is_finite() && got == q;
                    assert!(same, "{p} by {error} towards {up}: {got} for {expected}");
                }
            }
        }
    }
}
