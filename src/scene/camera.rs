//! Cameras as ray generators, and the automatic framing used when a file has none.

use super::Footprint;
use super::description::{CameraDescription, Projection};
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
        }
    }

    /// The eye (perspective), or the centre of the view plane (orthographic).
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Whether rays are parallel, and start at points of their own.
    pub fn is_orthographic(&self) -> bool {
        self.orthographic
    }

    /// The narrow side of a pixel that a ray of this camera is one of `samples` of.
    pub fn footprint(&self, ray: &Ray, samples: u32) -> Footprint {
        let side = 2.0 * self.half_extent.y / self.size.y;
        if self.orthographic {
            Footprint::of_pixel(side, 0.0, samples)
        } else {
            // Off the axis pixels are nearer to edge-on, and farther along the ray than along the axis.
            let cos = -ray.direction.dot(self.axes.z_axis);
            Footprint::of_pixel(0.0, side * cos * cos, samples)
        }
    }

    /// The ray through `raster`, in pixels from the top left corner.
    pub fn ray(&self, raster: Vec2) -> Ray {
        let ndc = raster / self.size * 2.0 - Vec2::ONE;
        let plane = Vec2::new(ndc.x, -ndc.y) * self.half_extent;
        if self.orthographic {
            let origin = self.origin + self.axes * Vec3::new(plane.x, plane.y, 0.0);
            Ray { origin, direction: -self.axes.z_axis, t_max: f32::INFINITY }
        } else {
            let direction = (self.axes * Vec3::new(plane.x, plane.y, -1.0)).normalize();
            Ray { origin: self.origin, direction, t_max: f32::INFINITY }
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
        };
        let camera = Camera::new(&c, 200, 100);
        assert!((camera.ray(Vec2::new(100.0, 50.0)).direction - Vec3::NEG_Z).length() < 1e-6);
        let top = camera.ray(Vec2::new(100.0, 0.0)).direction;
        assert!((top - Vec3::new(0.0, 1.0, -1.0).normalize()).length() < 1e-6);
        let right = camera.ray(Vec2::new(200.0, 50.0)).direction;
        assert!((right - Vec3::new(2.0, 0.0, -1.0).normalize()).length() < 1e-6);
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
