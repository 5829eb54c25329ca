//! Directions uniform over the solid angle of a triangle (Arvo 1995, "Stratified Sampling of Spherical Triangles").
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `a`, `b`, `c` | A, B, C | unit directions to the vertices |
//! | `sin_alpha`, `cos_alpha` | α | inner angle at A |
//! | `e` | 1 − cos c | of the edge AB |
//! | `area` | σ′ | area of the sub-triangle A B C′ |
//! | `m` | 1 − cos σ′ | |
//! | `x` | 1 − cos b′ | of the edge A C′ |
//!
//! Arvo's cosine of b′ is a quotient of differences that cancel in thin triangles. With φ = σ′ − α, u = cos φ − cos α,
//! v = sin φ + sin α cos c in his equation for cos b′ and φ + α = σ′, it shortens to
//!
//! ```text
//! 1 − cos b′ = m (2 − e) / (m − e sin α sin φ)
//! ```
//!
//! which has nothing to cancel, since φ is negative unless the triangle is large. The solid angle is Van Oosterom &
//! Strackee's (1983) arctangent for the same reason.

use glam::{Vec2, Vec3};

use super::arctangent::atan2;

/// The solid angle of a triangle, steradians in \[0, 2π\], with the arguments of [`SphericalTriangle::with_volume`]:
/// tan(σ/2) = volume / (|A||B||C| + (A·B)|C| + (B·C)|A| + (C·A)|B|).
#[inline]
pub fn solid_angle(edges: [Vec3; 3], volume: f32) -> f32 {
    let [a, b, c] = edges;
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    2.0 * atan2(volume, la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// A triangle seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    /// Solid angle in steradians, in \[0, 2π\].
    pub solid_angle: f32,
    a: Vec3,
    b: Vec3,
    c: Vec3,
}

impl SphericalTriangle {
    /// The triangle of `vertices` seen from `point`; its solid angle is 0 where it is seen edge on or where `point` is
    /// a vertex.
    #[inline]
    pub fn new(vertices: [Vec3; 3], point: Vec3) -> Self {
        let [a, b, c] = vertices.map(|v| v - point);
        // A · (B × C), taken of edge vectors so that small triangles do not cancel.
        let volume = a.dot((b - a).cross(c - a)).abs();
        Self::with_volume([a, b, c], volume)
    }

    /// The triangle whose vertices lie at `edges` from the point; `volume` is six times that of the tetrahedron with the
    /// point: twice the area times the height of the point above the triangle's plane.
    #[inline]
    pub fn with_volume(edges: [Vec3; 3], volume: f32) -> Self {
        let [a, b, c] = edges.map(|v| v.normalize_or_zero());
        Self { solid_angle: solid_angle(edges, volume), a, b, c }
    }

    /// The unit directions to the three vertices (zero where the point is the vertex).
    #[inline]
    pub fn vertices(&self) -> [Vec3; 3] {
        [self.a, self.b, self.c]
    }

    /// A unit direction uniform over the triangle, pdf `1 / solid_angle`; `None` where the triangle is too thin for its
    /// angles to be computed.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Option<Vec3> {
        let (a, b, c) = (self.a, self.b, self.c);
        // The inner angle at A, between the planes AB and AC.
        let n_ab = (b - a).cross(a);
        let n_ac = (c - a).cross(a);
        let (cos_alpha, sin_alpha) = (n_ab.dot(n_ac), n_ab.cross(n_ac).length());
        let scale = 1.0 / (cos_alpha * cos_alpha + sin_alpha * sin_alpha).sqrt();
        if !(scale.is_finite() && self.solid_angle > 0.0) {
            return None;
        }
        let (sin_alpha, cos_alpha) = (sin_alpha * scale, cos_alpha * scale);
        let e = 0.5 * (b - a).length_squared();

        let area = u.x * self.solid_angle;
        let (sin_half, cos_half) = (0.5 * area).sin_cos();
        let m = 2.0 * sin_half * sin_half;
        let sin_phi = 2.0 * sin_half * cos_half * cos_alpha - (1.0 - m) * sin_alpha;
        let x = (m * (2.0 - e) / (m - e * sin_alpha * sin_phi)).clamp(0.0, 2.0);
        let toward_c = ((c - a) - a * (c - a).dot(a)).try_normalize()?;
        let c_new = a * (1.0 - x) + toward_c * (x * (2.0 - x)).sqrt();

        // A point of the arc from B to C', uniform in the cosine from B.
        let one_minus = (1.0 - u.y) * 0.5 * (c_new - b).length_squared();
        let cos_theta = 1.0 - one_minus;
        let sin_theta = (one_minus * (2.0 - one_minus)).max(0.0).sqrt();
        let direction = match ((c_new - b) - b * (c_new - b).dot(b)).try_normalize() {
            Some(side) => b * cos_theta + side * sin_theta,
            None => b,
        };
        direction.try_normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{ONE_MINUS_EPSILON, SmallRng, statistics::chi_square_z};
    use glam::DVec3;

    /// Solid angle in double precision.
    fn solid_angle(v: [DVec3; 3]) -> f64 {
        let [a, b, c] = v.map(DVec3::normalize);
        2.0 * a.dot((b - a).cross(c - a)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    }

    fn inside(v: [DVec3; 3], d: DVec3) -> bool {
        let [a, b, c] = v;
        let orientation = a.dot(b.cross(c)).signum();
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| p.cross(*q).dot(d) * orientation >= 0.0)
    }

    fn triangles() -> Vec<[Vec3; 3]> {
        vec![
            [Vec3::X, Vec3::Y, Vec3::Z],
            [Vec3::new(1.0, 0.1, 1.0), Vec3::new(-1.0, 0.1, 1.0), Vec3::new(0.0, 0.1, -1.0)],
            [Vec3::new(-0.02, 1.0, 0.0), Vec3::new(0.02, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.03)],
            [Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.1, 1.0, 0.1)],
            [Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.1, 1.0, 0.003)],
            [Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.003), Vec3::new(-1.0, 1.0, 0.0)],
            [Vec3::new(1.0, 0.02, 0.0), Vec3::new(-0.6, 0.02, 1.0), Vec3::new(-0.6, 0.02, -1.0)],
        ]
    }

    #[test]
    fn octant_and_small_triangles_have_their_solid_angle() {
        let octant = SphericalTriangle::new([Vec3::X, Vec3::Y, Vec3::Z], Vec3::ZERO);
        assert!((octant.solid_angle - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        let d = 1000.0;
        let far = [Vec3::new(0.0, 0.0, d), Vec3::new(1.0, 0.0, d), Vec3::new(0.0, 1.0, d)];
        let far = SphericalTriangle::new(far, Vec3::ZERO).solid_angle;
        assert!((far / 0.5e-6 - 1.0).abs() < 1e-3, "{far}");
        for flat in [[Vec3::X, Vec3::Y, Vec3::X + Vec3::Y], [Vec3::ZERO, Vec3::X, Vec3::Y]] {
            let flat = SphericalTriangle::new(flat, Vec3::ZERO);
            assert_eq!(flat.solid_angle, 0.0);
            assert!(flat.sample(Vec2::splat(0.5)).is_none());
        }
    }

    #[test]
    fn directions_are_uniform_and_inside() {
        for vertices in triangles() {
            let triangle = SphericalTriangle::new(vertices, Vec3::ZERO);
            let v = vertices.map(|v| v.as_dvec3());
            assert!((f64::from(triangle.solid_angle) / solid_angle(v) - 1.0).abs() < 1e-4);
            // 64 small triangles of the plane one, each with a known solid angle.
            let k = 8usize;
            let at = |i: usize, j: usize| {
                v[0] + (v[1] - v[0]) * (i as f64 / k as f64) + (v[2] - v[0]) * (j as f64 / k as f64)
            };
            let mut parts = Vec::new();
            for i in 0..k {
                for j in 0..k - i {
                    parts.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < k {
                        parts.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
            let n = 100_000;
            let mut rng = SmallRng::new(31);
            let mut counts = vec![0u64; parts.len()];
            let mut outside = 0;
            for _ in 0..n {
                let d = triangle.sample(rng.vec2()).unwrap().as_dvec3();
                match parts.iter().position(|&part| inside(part, d)) {
                    Some(i) => counts[i] += 1,
                    None => outside += 1,
                }
            }
            // Rounding puts a few of the points of the edges just outside.
            assert!(outside < n / 1000, "{outside}");
            let total = solid_angle(v);
            let expected: Vec<f64> =
                parts.iter().map(|&p| solid_angle(p) / total * f64::from(n - outside)).collect();
            let z = chi_square_z(&counts, &expected);
            assert!(z.abs() < 4.0, "{vertices:?}: z = {z}");
        }
    }

    #[test]
    fn corners_of_the_square_are_safe() {
        for vertices in triangles() {
            let triangle = SphericalTriangle::new(vertices, Vec3::ZERO);
            for x in [0.0, 1e-7, 0.5, ONE_MINUS_EPSILON] {
                for y in [0.0, 1e-7, 0.5, ONE_MINUS_EPSILON] {
                    if let Some(d) = triangle.sample(Vec2::new(x, y)) {
                        assert!((d.length() - 1.0).abs() < 1e-5);
                    }
                }
            }
        }
    }
}
