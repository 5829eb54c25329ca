//! Directions uniform over the solid angle of a triangle that is close: hardly above the point, or seen edge on.
//!
//! There two vertices may lie in nearly opposite directions, and all three near the horizon. What
//! [`super::SphericalTriangle`] computes then is a difference of nearly equal numbers: it knows the sub-triangle A B C′ by
//! the length of its edge A C′, on which the whole area may depend in the last digits. Here C′ is known by the angle β′
//! of the sub-triangle at B instead. With the angle α at A, the edge c = AB and the area σ′ of the sub-triangle,
//!
//! ```text
//! tan β′ = 2 sin(σ′/2) sin(α − σ′/2) / (sin α (cos σ′ − cos c) − cos α sin σ′)                      (1)
//! cot a′ = (cos c cos β′ sin α + sin β′ cos α) / (sin c sin α),   a′ = B C′                         (2)
//! ```
//!
//! (1) follows from σ′ = α + β′ + γ′ − π and cos γ′ = −cos α cos β′ + sin α sin β′ cos c, (2) is the cotangent rule. Both
//! hold to the last digit for a triangle that fills the hemisphere, where β′ = σ′/2, and for a lune, where A = −B. Vertices
//! are differences of single floats, which are exact in double precision.

use glam::{DVec3, Vec2};

/// A triangle seen from a point, in double precision.
#[derive(Clone, Copy, Debug)]
pub struct CloseTriangle {
    /// Solid angle in steradians, in \[0, 2π\].
    pub solid_angle: f64,
    b: DVec3,
    /// At B: the direction towards A, and that towards C perpendicular to it.
    towards_a: DVec3,
    towards_c: DVec3,
    sin_alpha: f64,
    cos_alpha: f64,
    sin_c: f64,
    cos_c: f64,
}

impl CloseTriangle {
    /// The triangle whose vertices lie at `edges` from the point, which is not on their plane. `None` where the point is on
    /// the line of an edge.
    pub fn new(edges: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = edges;
        let (ab, ac) = (a.cross(b - a), a.cross(c - a));
        let volume = ab.dot(c);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        let solid_angle = 2.0 * volume.abs().atan2(below);
        // (A × B) × (A × C) = (A · B × C) A.
        let (sin_alpha, cos_alpha) = (la * volume.abs(), ab.dot(ac));
        let (scale, area) = (sin_alpha.hypot(cos_alpha), ab.length());
        let normal = ab / area;
        let usable = scale > 0.0 && area > 0.0 && lb > 0.0 && solid_angle > 0.0;
        usable.then(|| Self {
            solid_angle,
            b: b / lb,
            towards_a: (b / lb).cross(normal),
            towards_c: normal * volume.signum(),
            sin_alpha: sin_alpha / scale,
            cos_alpha: cos_alpha / scale,
            sin_c: area / (la * lb),
            cos_c: a.dot(b) / (la * lb),
        })
    }

    /// A unit direction uniform over the triangle, pdf `1 / solid_angle`.
    pub fn sample(&self, u: Vec2) -> DVec3 {
        let Self { sin_alpha, cos_alpha, sin_c, cos_c, .. } = *self;
        let (u, v) = (f64::from(u.x), f64::from(u.y));
        let (sin_half, cos_half) = (0.5 * u * self.solid_angle).sin_cos();
        let sin_area = 2.0 * sin_half * cos_half;
        // cos σ′ − cos c, both taken from 1: a short edge makes them nearly equal.
        let one_minus_c = if cos_c > 0.0 { sin_c * sin_c / (1.0 + cos_c) } else { 1.0 - cos_c };
        let above = one_minus_c - 2.0 * sin_half * sin_half;
        let (cos_beta, sin_beta) = unit(
            sin_alpha * above - cos_alpha * sin_area,
            2.0 * sin_half * (sin_alpha * cos_half - cos_alpha * sin_half),
        );
        let (cos_edge, sin_edge) =
            unit(cos_c * cos_beta * sin_alpha + sin_beta * cos_alpha, sin_c * sin_alpha);
        // A point of the arc from B to C′, uniform in the cosine from B.
        let one_minus_edge =
            if cos_edge > 0.0 { sin_edge * sin_edge / (1.0 + cos_edge) } else { 1.0 - cos_edge };
        let down = (1.0 - v) * one_minus_edge;
        let (cos, sin) = (1.0 - down, (down * (2.0 - down)).max(0.0).sqrt());
        self.b * cos + (self.towards_a * cos_beta + self.towards_c * sin_beta) * sin
    }
}

/// A vector over its length; (1, 0) for none.
fn unit(x: f64, y: f64) -> (f64, f64) {
    let length = x.hypot(y);
    if length > 0.0 { (x / length, y / length) } else { (1.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{ONE_MINUS_EPSILON, SmallRng, SphericalTriangle, statistics::Estimate};
    use std::f64::consts::PI;

    /// Below a triangle: its middle, an edge, a vertex, beside it, and beyond an edge; with the share of the hemisphere that
    /// it fills from very near.
    fn places() -> [(DVec3, f64); 5] {
        [
            (DVec3::new(0.3, 0.0, 0.3), 1.0),
            (DVec3::new(0.5, 0.0, 0.0), 0.5),
            (DVec3::new(0.5, 0.0, 0.5), 0.5),
            (DVec3::ZERO, 0.25),
            (DVec3::new(-0.1, 0.0, 0.4), 0.0),
        ]
    }

    fn triangle(point: DVec3, gap: f64, turn: usize) -> CloseTriangle {
        let lift = DVec3::Y * gap;
        let mut edges = [DVec3::ZERO, DVec3::X, DVec3::Z].map(|v| v + lift - point);
        edges.rotate_left(turn);
        CloseTriangle::new(edges).expect("above the point")
    }

    #[test]
    fn the_solid_angle_is_that_of_the_hemisphere_it_fills() {
        for (point, share) in places() {
            for gap in [1e-5, 1e-7, 1e-10] {
                let found = triangle(point, gap, 0).solid_angle / (2.0 * PI);
                // Whatever is not filled is a rim as wide as the gap is high, seen from within a tenth; what two opposite
                // directions add up to is known to within a rounding, of the gap.
                let room = 20.0 * gap + 1e-16 / gap;
                assert!((found - share).abs() < room, "{point} {gap}: {found}");
            }
        }
    }

    /// Directions, taken to the plane by one more formula, lie in the triangle; their mean cosine is Lambert's.
    #[test]
    fn directions_are_inside_and_have_their_mean_cosine() {
        for (point, share) in places() {
            for gap in [1e-12, 1e-7, 1e-3, 0.1, 1.0] {
                // Lambert's formula tells nothing of what is seen edge on: its terms cancel.
                if share == 0.0 && gap < 1e-4 {
                    continue;
                }
                for turn in 0..3 {
                    let t = triangle(point, gap, turn);
                    let v = [DVec3::ZERO, DVec3::X, DVec3::Z].map(|v| v + DVec3::Y * gap - point);
                    let edge = |i: usize| {
                        let cross = v[i].cross(v[(i + 1) % 3] - v[i]);
                        let angle = cross.length().atan2(v[i].dot(v[(i + 1) % 3]));
                        angle * cross.y / cross.length()
                    };
                    let expected = 0.5 * (edge(0) + edge(1) + edge(2)).abs();
                    let mut rng = SmallRng::new(5);
                    let (mut estimate, mut outside) = (Estimate::default(), 0);
                    for _ in 0..20_000 {
                        let d = t.sample(rng.vec2());
                        assert!((d.length() - 1.0).abs() < 1e-12);
                        let p = point + d * (gap / d.y);
                        // As far off as rounding of the direction puts it.
                        let room = 1e-14 * (1.0 + (gap / d.y).abs()) / d.y.abs().max(1e-300);
                        outside += u32::from(!(p.x >= -room && p.z >= -room && p.x + p.z <= 1.0 + room));
                        estimate.add(d.y * t.solid_angle);
                    }
                    assert!(outside < 20, "{point} {gap} {turn}: {outside} outside");
                    let z = estimate.z(expected);
                    assert!(z.abs() < 4.0, "{point} {gap} {turn}: {} {expected} z {z}", estimate.mean());
                }
            }
        }
    }

    /// From a moderate distance both samplers are one map, seen from different sides.
    #[test]
    fn it_is_the_triangle_of_single_floats() {
        let (point, gap) = (DVec3::new(0.2, 0.0, 0.7), 0.5);
        let close = triangle(point, gap, 0);
        let edges = [DVec3::ZERO, DVec3::X, DVec3::Z].map(|v| (v + DVec3::Y * gap).as_vec3());
        let single = SphericalTriangle::new(edges, point.as_vec3());
        assert!((close.solid_angle - f64::from(single.solid_angle)).abs() < 1e-6);
        let mut rng = SmallRng::new(8);
        for _ in 0..1000 {
            let u = rng.vec2();
            let (a, b) = (close.sample(u), single.sample(u).expect("not thin").as_dvec3());
            assert!(a.distance(b) < 1e-5, "{u}: {a} {b}");
        }
    }

    #[test]
    fn corners_of_the_square_are_safe() {
        for (point, _) in places() {
            for x in [0.0, 1e-7, 0.5, ONE_MINUS_EPSILON] {
                for y in [0.0, 1e-7, 0.5, ONE_MINUS_EPSILON] {
                    let d = triangle(point, 1e-7, 0).sample(Vec2::new(x, y));
                    assert!((d.length() - 1.0).abs() < 1e-12);
                }
            }
        }
        assert!(CloseTriangle::new([DVec3::X, DVec3::X * 2.0, DVec3::Z]).is_none());
    }
}
