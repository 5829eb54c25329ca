//! Orthonormal frames around a direction (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1)).

use glam::Vec3;

/// Two unit vectors that form a right-handed basis `(tangent, bitangent, normal)` with the unit vector `normal`.
#[inline]
pub fn orthonormal_basis(normal: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

/// An orthonormal, right-handed frame; local z is `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x.
    pub tangent: Vec3,
    /// Local y.
    pub bitangent: Vec3,
    /// Local z.
    pub normal: Vec3,
}

impl Frame {
    /// Any frame around the unit vector `normal`; the tangents are continuous except across the plane z = 0 at −z.
    #[inline]
    pub fn from_normal(normal: Vec3) -> Self {
        let (tangent, bitangent) = orthonormal_basis(normal);
        Self { tangent, bitangent, normal }
    }

    /// The frame around `normal` whose x axis is `tangent` made perpendicular; any frame if the two are parallel.
    #[inline]
    pub fn from_normal_tangent(normal: Vec3, tangent: Vec3) -> Self {
        let projected = tangent - normal * normal.dot(tangent);
        match projected.try_normalize() {
            Some(tangent) => Self { tangent, bitangent: normal.cross(tangent), normal },
            None => Self::from_normal(normal),
        }
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, warp};

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let mut rng = SmallRng::new(0);
        let special = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z, Vec3::new(1e-20, 0.0, -1.0)];
        let random = (0..1000).map(|_| warp::uniform_sphere(rng.vec2()));
        for normal in special.into_iter().chain(random) {
            let frame = Frame::from_normal(normal);
            assert!(frame.tangent.dot(frame.bitangent).abs() < 1e-6);
            assert!(frame.tangent.dot(normal).abs() < 1e-6);
            assert!((frame.tangent.length() - 1.0).abs() < 1e-6);
            assert!((frame.tangent.cross(frame.bitangent) - normal).length() < 1e-6);
            let v = Vec3::new(0.3, -0.5, 0.7);
            assert!((frame.to_local(frame.to_world(v)) - v).length() < 1e-6);
        }
        let frame = Frame::from_normal_tangent(Vec3::Y, Vec3::new(1.0, 5.0, 0.0));
        assert!((frame.tangent - Vec3::X).length() < 1e-6);
        assert!((frame.tangent.cross(frame.bitangent) - Vec3::Y).length() < 1e-6);
    }
}
