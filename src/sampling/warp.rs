//! Maps from the unit square to the shapes that light transport samples. Local z is up; densities are with respect
//! to solid angle on spheres and to area on the unit disk.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3};

use super::ONE_MINUS_EPSILON;

/// Smallest squared cosine that [`cosine_hemisphere`] returns, so that its pdf is never 0: half a unit in the last
/// place of 1, below the rounding error of the length of a unit vector.
const MIN_COS_SQUARED: f32 = f32::EPSILON / 2.0;

/// A point uniform on the unit disk (Shirley & Chiu 1997): continuous, area preserving, little distortion.
#[inline]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p.x == 0.0 && p.y == 0.0 {
        return Vec2::ZERO;
    }
    let (r, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    let (sin, cos) = phi.sin_cos();
    Vec2::new(r * cos, r * sin)
}

/// A direction of the upper hemisphere with pdf cos θ/π (Malley's method); z > 0.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = concentric_disk(u);
    p.extend((1.0 - p.length_squared()).max(MIN_COS_SQUARED).sqrt())
}

/// Density of [`cosine_hemisphere`].
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// A direction uniform over the upper hemisphere, pdf [`UNIFORM_HEMISPHERE_PDF`]; z > 0.
#[inline]
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    uniform_cone(u, 0.0)
}

/// 1/2π.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// A direction uniform over the sphere, pdf [`UNIFORM_SPHERE_PDF`].
#[inline]
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    uniform_cone(u, -1.0)
}

/// 1/4π.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// A direction uniform over the cone around +z with cosine of the half angle `cos_max`. Accurate for narrow cones
/// only as far as `1 − cos_max` is.
#[inline]
pub fn uniform_cone(u: Vec2, cos_max: f32) -> Vec3 {
    let one_minus_cos = u.x * (1.0 - cos_max);
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
    Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - one_minus_cos)
}

/// Density of [`uniform_cone`] inside the cone.
#[inline]
pub fn uniform_cone_pdf(cos_max: f32) -> f32 {
    1.0 / (TAU * (1.0 - cos_max))
}

/// Barycentric coordinates of the second and third vertex, uniform over a triangle (Heitz 2019, "A Low-Distortion
/// Map Between Triangle and Square").
#[inline]
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let half = 0.5 * u.x;
        Vec2::new(half, u.y - half)
    } else {
        let half = 0.5 * u.y;
        Vec2::new(u.x - half, half)
    }
}

/// x in \[0, 1) with density proportional to the line from `a` at 0 to `b` at 1 (both ≥ 0; uniform if both are 0).
#[inline]
pub fn linear(u: f32, a: f32, b: f32) -> f32 {
    let sum = a + b;
    if !(sum > 0.0 && sum.is_finite()) {
        return u;
    }
    let (a, b) = (a / sum, b / sum);
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    if a + root > 0.0 { (u / (a + root)).min(ONE_MINUS_EPSILON) } else { 0.0 }
}

/// A point of the unit square with density proportional to the bilinear patch of the corner values
/// `[c00, c10, c01, c11]` (`c10` at x = 1, y = 0), all ≥ 0; uniform if all are 0.
#[inline]
pub fn bilinear(u: Vec2, c: [f32; 4]) -> Vec2 {
    let y = linear(u.y, 0.5 * c[0] + 0.5 * c[1], 0.5 * c[2] + 0.5 * c[3]);
    let x = linear(u.x, c[0] + y * (c[2] - c[0]), c[1] + y * (c[3] - c[1]));
    Vec2::new(x, y)
}

/// Solid angle of the sphere, for densities.
pub const SPHERE: f32 = 4.0 * PI;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, statistics::chi_square_z};

    const N: u32 = 400_000;

    /// χ² of a direction sampler over 16 × 16 bins in (cos θ, φ) against the measure `cdf` of cos θ below a value.
    fn test_directions(sample: impl Fn(Vec2) -> Vec3, cdf: impl Fn(f64) -> f64) {
        let mut rng = SmallRng::new(21);
        let mut counts = vec![0u64; 256];
        for _ in 0..N {
            let d = sample(rng.vec2());
            assert!((d.length() - 1.0).abs() < 1e-6);
            let z = ((d.z * 0.5 + 0.5) * 16.0).clamp(0.0, 15.0) as usize;
            let phi = ((d.y.atan2(d.x) / TAU + 0.5) * 16.0).clamp(0.0, 15.0) as usize;
            counts[z * 16 + phi] += 1;
        }
        let expected: Vec<f64> = (0..256)
            .map(|i| {
                let z = |k: usize| k as f64 / 8.0 - 1.0;
                (cdf(z(i / 16 + 1)) - cdf(z(i / 16))) * f64::from(N) / 16.0
            })
            .collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "z = {z}");
    }

    #[test]
    fn directions_have_their_densities() {
        test_directions(uniform_sphere, |z| (z + 1.0) / 2.0);
        test_directions(uniform_hemisphere, |z| z.max(0.0));
        test_directions(cosine_hemisphere, |z| z.max(0.0).powi(2));
        test_directions(|u| uniform_cone(u, 0.25), |z| ((z - 0.25) / 0.75).max(0.0));
    }

    #[test]
    fn corners_of_the_square_give_usable_directions() {
        let edge = [0.0, f32::EPSILON, 0.25, 0.5, 0.75, ONE_MINUS_EPSILON];
        for x in edge {
            for y in edge {
                let u = Vec2::new(x, y);
                assert!(cosine_hemisphere(u).z > 0.0 && (cosine_hemisphere(u).length() - 1.0).abs() < 1e-6);
                assert!(uniform_hemisphere(u).z > 0.0);
                assert!(uniform_sphere(u).is_finite());
                let b = uniform_triangle(u);
                assert!(b.min_element() >= 0.0 && b.x + b.y <= 1.0);
                let p = bilinear(u, [0.0, 0.0, 0.0, 1.0]);
                assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
            }
        }
    }

    #[test]
    fn disk_and_triangle_are_uniform() {
        let mut rng = SmallRng::new(22);
        let mut disk = vec![0u64; 256];
        let mut triangle = vec![0u64; 256];
        for _ in 0..N {
            let p = concentric_disk(rng.vec2());
            let ring = (p.length_squared() * 16.0).min(15.0) as usize;
            let phi = ((p.y.atan2(p.x) / TAU + 0.5) * 16.0).min(15.0) as usize;
            disk[ring * 16 + phi] += 1;
            let b = uniform_triangle(rng.vec2());
            // The classic map turned round: (1 − √…) strips of equal area.
            let s = (1.0 - b.x - b.y).max(0.0);
            let strip = ((1.0 - s).powi(2) * 16.0).min(15.0) as usize;
            let along = (b.x / (1.0 - s).max(1e-9) * 16.0).min(15.0) as usize;
            triangle[strip * 16 + along] += 1;
        }
        for counts in [disk, triangle] {
            let z = chi_square_z(&counts, &[f64::from(N) / 256.0; 256]);
            assert!(z.abs() < 4.0, "z = {z}");
        }
    }

    #[test]
    fn bilinear_patch_has_its_density() {
        let mut rng = SmallRng::new(23);
        for c in [[1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 2.0, 5.0], [3.0, 0.0, 0.0, 0.0], [0.0, 4.0, 4.0, 0.0]] {
            let mut counts = vec![0u64; 64];
            for _ in 0..N {
                let p = bilinear(rng.vec2(), c);
                counts[(p.y * 8.0) as usize * 8 + (p.x * 8.0) as usize] += 1;
            }
            let total: f64 = c.iter().map(|&v| f64::from(v)).sum::<f64>() / 4.0;
            let expected: Vec<f64> = (0..64)
                .map(|i| {
                    let (x, y) = ((i % 8) as f64 / 8.0 + 0.0625, (i / 8) as f64 / 8.0 + 0.0625);
                    let [c00, c10, c01, c11] = c.map(f64::from);
                    let value = (c00 * (1.0 - x) + c10 * x) * (1.0 - y) + (c01 * (1.0 - x) + c11 * x) * y;
                    value / total / 64.0 * f64::from(N)
                })
                .collect();
            let z = chi_square_z(&counts, &expected);
            assert!(z.abs() < 4.0, "{c:?}: z = {z}");
        }
    }
}
