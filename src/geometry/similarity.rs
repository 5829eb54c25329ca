//! Rotation, uniform scale and translation: the maps under which a walk through a medium looks the same.

use super::offset::{ROUNDING, gamma};
use super::ray::{Aabb, Ray};
use glam::{Affine3A, DMat3, DVec3, Mat3, Vec3};

/// How far a linear part may be from a similarity, relative to its scale: a few roundings of a product of `f32`
/// matrices. Beyond it, the linear part is baked into a mesh of its own.
const TOLERANCE: f64 = 4.0e-6;
/// Volume of the linear part relative to the product of its column lengths at or below which it has no inverse.
const SINGULAR: f64 = 1.0e-12;

/// A map from local to world space: `world = scale * rotation * local + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Orthonormal; its determinant is −1 where the map mirrors.
    pub rotation: Mat3,
    /// World metres for one unit of local length, positive.
    pub scale: f32,
    /// World position of the local origin.
    pub translation: Vec3,
    inverse_rotation: Mat3,
    inverse_scale: f32,
}

/// What kind of map an affine transform is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Similar(Similarity),
    /// Invertible, but shears or stretches.
    Affine,
    /// Not invertible, or not finite.
    Singular,
}

impl Similarity {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        rotation: Mat3::IDENTITY,
        scale: 1.0,
        translation: Vec3::ZERO,
        inverse_rotation: Mat3::IDENTITY,
        inverse_scale: 1.0,
    };

    /// A pure translation.
    pub fn from_translation(translation: Vec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// The similarity that an affine map is (to a few roundings), or `None` if it shears, stretches or flattens.
    pub fn from_affine(transform: &Affine3A) -> Option<Self> {
        match Self::classify(transform) {
            Kind::Similar(similarity) => Some(similarity),
            _ => None,
        }
    }

    pub(super) fn classify(transform: &Affine3A) -> Kind {
        let linear = Mat3::from(transform.matrix3).as_dmat3();
        let translation = Vec3::from(transform.translation);
        let lengths = DVec3::new(linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length());
        let volume = linear.determinant();
        let regular = volume.abs() > SINGULAR * lengths.x * lengths.y * lengths.z;
        if !linear.is_finite() || !translation.is_finite() || !regular {
            return Kind::Singular;
        }
        let scale = (lengths.length_squared() / 3.0).sqrt();
        let r = linear * (1.0 / scale);
        let off = r.transpose() * r - DMat3::IDENTITY;
        let worst = off.to_cols_array().iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        let inverse_scale = (1.0 / scale) as f32;
        if worst > 2.0 * TOLERANCE || !inverse_scale.is_normal() || !(scale as f32).is_normal() {
            return Kind::Affine;
        }
        // One step of Newton's iteration for the polar decomposition (Higham 1986) squares the error.
        let rotation = (r * (DMat3::IDENTITY - 0.5 * off)).as_mat3();
        Kind::Similar(Self {
            rotation,
            scale: scale as f32,
            translation,
            inverse_rotation: rotation.transpose(),
            inverse_scale,
        })
    }

    /// Local point to world.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * (self.scale * p) + self.translation
    }

    /// Local unit direction (or normal of a front face) to world.
    #[inline]
    pub fn direction(&self, d: Vec3) -> Vec3 {
        self.rotation * d
    }

    /// World point to local.
    #[inline]
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_rotation * (self.inverse_scale * (p - self.translation))
    }

    /// World unit direction to local.
    #[inline]
    pub fn inverse_direction(&self, d: Vec3) -> Vec3 {
        self.inverse_rotation * d
    }

    /// World length to local.
    #[inline]
    pub fn inverse_length(&self, length: f32) -> f32 {
        self.inverse_scale * length
    }

    /// World ray to local; distances shrink by the scale.
    #[inline]
    pub fn inverse_ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.inverse_point(ray.origin),
            direction: self.inverse_direction(ray.direction),
            t_max: self.inverse_scale * ray.t_max,
        }
    }

    /// Whether it mirrors, so that triangles counter-clockwise in local space are clockwise in the world.
    pub fn mirrors(&self) -> bool {
        self.rotation.determinant() < 0.0
    }

    /// Bound of what world coordinates are sums of, on each axis, for local points of at most these coordinates.
    pub fn magnitude(&self, local: Vec3) -> Vec3 {
        if *self == Self::IDENTITY {
            return local;
        }
        let r = &self.rotation;
        let rotation = Mat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
        rotation * (self.scale * local) + self.translation.abs()
    }

    /// Local point with its error bounds to world, with bounds that also cover the way back by [`Self::inverse_point`].
    #[inline]
    pub fn point_with_error(&self, p: Vec3, error: Vec3) -> (Vec3, Vec3) {
        if *self == Self::IDENTITY {
            return (p, error);
        }
        let magnitude = Mat3 {
            x_axis: self.rotation.x_axis.abs(),
            y_axis: self.rotation.y_axis.abs(),
            z_axis: self.rotation.z_axis.abs(),
        };
        let there = magnitude * (self.scale * p.abs());
        let back = magnitude * (magnitude.transpose() * there);
        let error = magnitude * (self.scale * error);
        let error =
            (1.0 + gamma(8)) * error + gamma(6) * there + gamma(8) * back + gamma(2) * self.translation.abs();
        (self.point(p), error)
    }

    /// Local box around a world one, with room for rounding.
    pub fn inverse_bounds(&self, world: &Aabb) -> Aabb {
        if world.is_empty() {
            return Aabb::EMPTY;
        }
        let corner = |i: u32| {
            let pick =
                |bit: u32, axis: usize| if i >> bit & 1 == 0 { world.min[axis] } else { world.max[axis] };
            self.inverse_point(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        };
        let local = Aabb::from_points(&std::array::from_fn::<_, 8, _>(|i| corner(i as u32)));
        let largest = world.min.abs().max(world.max.abs()).max(self.translation.abs()).max_element();
        let room = self.inverse_length(ROUNDING * largest);
        Aabb { min: local.min - room, max: local.max + room }
    }

    /// World box of a local one, with room for rounding.
    pub fn bounds(&self, local: &Aabb) -> Aabb {
        if local.is_empty() {
            return Aabb::EMPTY;
        }
        let mut out = Aabb::EMPTY;
        for corner in 0..8 {
            let pick = |bit: u32, axis: usize| {
                if corner >> bit & 1 == 0 { local.min[axis] } else { local.max[axis] }
            };
            let p = Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2));
            let (p, error) = self.point_with_error(p, Vec3::ZERO);
            out = out.union(Aabb { min: p - 2.0 * error, max: p + 2.0 * error });
        }
        out
    }
}
