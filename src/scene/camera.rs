//! Cameras as ray generators, and the automatic framing used when a file has none.

use super::Footprint;
use super::description::{CameraDescription, Clip, Projection};
use crate::geometry::Ray;
use glam::{Affine3A, Mat3, Vec2, Vec3};

/// Full vertical field of view of the automatic camera, radians (35°, a 57 mm lens on full frame).
const AUTO_YFOV: f32 = 35.0 * std::f32::consts::PI / 180.0;
/// Free space the automatic camera leaves around the bounding sphere, as a factor of its radius.
const AUTO_MARGIN: f32 = 1.08;

/// A camera bound to an image size.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: Vec3,
    axes: Mat3,
    /// Half width and half height of the view: tangents (perspective) or metres (orthographic).
    half_extent: Vec2,
    orthographic: bool,
    size: Vec2,
    clip: Clip,
}

impl Camera {
    /// Binds a camera to an image of `width` × `height` pixels. The vertical extent is the file's; the horizontal
    /// one follows from the image.
    pub fn new(description: &CameraDescription, width: u32, height: u32) -> Self {
        let (half_height, orthographic) = match description.projection {
            Projection::Perspective { yfov, .. } => ((0.5 * yfov).tan(), false),
            Projection::Orthographic { ymag, .. } => (ymag, true),
        };
        let axes = Mat3::from(description.transform.matrix3);
        let axes = Mat3::from_cols(
            axes.x_axis.normalize_or(Vec3::X),
            axes.y_axis.normalize_or(Vec3::Y),
            axes.z_axis.normalize_or(Vec3::Z),
        );
        Self {
            origin: description.transform.translation.into(),
            axes,
            half_extent: Vec2::new(half_height * width as f32 / height as f32, half_height),
            orthographic,
            size: Vec2::new(width as f32, height as f32),
            clip: description.clip,
        }
    }

    /// How far a ray from `position`, which is seen from the camera in `direction`, has to the far plane.
    pub fn reach(&self, position: Vec3, direction: Vec3) -> f32 {
        if self.clip.far == f32::INFINITY {
            return f32::INFINITY;
        }
        let view = -self.axes.z_axis;
        let depth = (position - self.origin).dot(view);
        ((self.clip.far - depth) / direction.dot(view)).max(0.0)
    }

    /// The narrow side of a pixel that a ray of this camera is one of `samples` of.
    pub fn footprint(&self, ray: &Ray, samples: u32) -> Footprint {
        let side = 2.0 * self.half_extent.y / self.size.y;
        if self.orthographic {
            Footprint::of_pixel(side, 0.0, samples)
        } else {
            // Off the axis pixels are nearer to edge-on, and farther along the ray than along the axis.
            let cos = -ray.direction.dot(self.axes.z_axis);
            let spread = side * cos * cos;
            Footprint::of_pixel(spread * (self.clip.near / cos), spread, samples)
        }
    }

    /// The ray through `raster`, in pixels from the top left corner; it starts at the near plane.
    pub fn ray(&self, raster: Vec2) -> Ray {
        let ndc = raster / self.size * 2.0 - Vec2::ONE;
        let plane = Vec2::new(ndc.x, -ndc.y) * self.half_extent;
        if self.orthographic {
            let origin = self.origin + self.axes * Vec3::new(plane.x, plane.y, -self.clip.near);
            Ray { origin, direction: -self.axes.z_axis, t_max: f32::INFINITY }
        } else {
            let through = self.axes * Vec3::new(plane.x, plane.y, -1.0);
            let origin = self.origin + self.clip.near * through;
            Ray { origin, direction: through.normalize(), t_max: f32::INFINITY }
        }
    }
}

impl CameraDescription {
    /// The index of a camera, by its name or else by its index as text.
    pub fn find(cameras: &[Self], wanted: &str) -> Option<usize> {
        let by_name = cameras.iter().position(|camera| camera.name == wanted);
        by_name.or_else(|| wanted.parse().ok().filter(|&index| index < cameras.len()))
    }
}

/// A camera that sees all of a bounding box: three-quarter view from slightly above.
pub fn auto_camera(min: Vec3, max: Vec3, aspect: f32) -> CameraDescription {
    let centre = 0.5 * (min + max);
    let radius = (0.5 * (max - min).length()).max(f32::MIN_POSITIVE) * AUTO_MARGIN;
    let half_angle = if aspect < 1.0 { ((0.5 * AUTO_YFOV).tan() * aspect).atan() } else { 0.5 * AUTO_YFOV };
    let toward_eye = Vec3::new(0.45, 0.35, 1.0).normalize();
    let eye = centre + toward_eye * (radius / half_angle.sin());
    let right = Vec3::Y.cross(toward_eye).normalize();
    let up = toward_eye.cross(right);
    CameraDescription {
        name: "automatic".into(),
        transform: Affine3A::from_mat3_translation(Mat3::from_cols(right, up, toward_eye), eye),
        projection: Projection::Perspective { yfov: AUTO_YFOV, aspect: None },
        clip: Clip::NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_ray_looks_along_minus_z_and_the_top_row_looks_up() {
        let c = CameraDescription {
            name: String::new(),
            transform: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov: std::f32::consts::FRAC_PI_2, aspect: None },
            clip: Clip::NONE,
        };
        let camera = Camera::new(&c, 200, 100);
        assert!((camera.ray(Vec2::new(100.0, 50.0)).direction - Vec3::NEG_Z).length() < 1e-6);
        let top = camera.ray(Vec2::new(100.0, 0.0)).direction;
        assert!((top - Vec3::new(0.0, 1.0, -1.0).normalize()).length() < 1e-6);
        let right = camera.ray(Vec2::new(200.0, 50.0)).direction;
        assert!((right - Vec3::new(2.0, 0.0, -1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn rays_start_at_the_near_plane_and_end_at_the_far_plane() {
        let turn = Mat3::from_rotation_y(0.5);
        for projection in [
            Projection::Perspective { yfov: 1.2, aspect: None },
            Projection::Orthographic { ymag: 3.0, aspect: None },
        ] {
            let description = CameraDescription {
                name: String::new(),
                transform: Affine3A::from_mat3_translation(turn, Vec3::new(1.0, 2.0, 3.0)),
                projection,
                clip: Clip { near: 2.0, far: 5.0 },
            };
            let camera = Camera::new(&description, 200, 100);
            for raster in [Vec2::ZERO, Vec2::new(30.0, 99.0), Vec2::new(100.0, 50.0)] {
                let Ray { origin, direction, .. } = camera.ray(raster);
                let depth = |p: Vec3| -description.transform.inverse().transform_point3(p).z;
                let end = origin + camera.reach(origin, direction) * direction;
                assert!((depth(origin) - 2.0).abs() < 1e-5 && (depth(end) - 5.0).abs() < 1e-5);
                // The same line as without planes.
                let open =
                    Camera::new(&CameraDescription { clip: Clip::NONE, ..description.clone() }, 200, 100);
                let free = open.ray(raster);
                assert_eq!(free.direction, direction);
                assert!((origin - free.origin).cross(direction).length() < 1e-5);
                assert_eq!(open.reach(origin, direction), f32::INFINITY);
                // What one pixel covers does not depend on where its ray starts.
                let (mut near, mut eye) = (camera.footprint(&free, 1), open.footprint(&free, 1));
                near.travel(1.0);
                eye.travel(1.0 + (origin - free.origin).length());
                assert!((near.width - eye.width).abs() < 1e-5 * eye.width);
            }
        }
    }

    #[test]
    fn the_automatic_camera_sees_all_corners() {
        let (min, max) = (Vec3::new(-1.0, 2.0, -3.0), Vec3::new(4.0, 2.5, 8.0));
        for aspect in [0.5, 1.0, 2.0] {
            let (w, h) = ((400.0 * aspect) as u32, 400);
            let d = auto_camera(min, max, aspect);
            let inverse = d.transform.inverse();
            let tan = (0.5 * AUTO_YFOV).tan();
            for i in 0..8 {
                let corner = Vec3::new(
                    if i & 1 == 0 { min.x } else { max.x },
                    if i & 2 == 0 { min.y } else { max.y },
                    if i & 4 == 0 { min.z } else { max.z },
                );
                let p = inverse.transform_point3(corner);
                assert!(
                    p.z < 0.0 && (p.y / -p.z).abs() < tan && (p.x / -p.z).abs() < tan * w as f32 / h as f32
                );
            }
        }
    }
}
