//! Cameras as ray generators, pinholes or with a lens ([`super::lens`]), and the automatic framing used when a file has none.

use super::Footprint;
use super::description::{CameraDescription, Clip, Projection};
use crate::geometry::Ray;
use crate::sampling::warp;
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
    /// Radius of the opening and distance of focus; `None` for pinholes.
    aperture: Option<(f32, f32)>,
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
            aperture: description.lens.filter(|_| !orthographic).and_then(|lens| lens.aperture()),
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

    /// The footprint of a ray of this camera, averaged over a width of `filter` times the narrow side of its pixel.
    pub fn footprint(&self, ray: &Ray, filter: f32) -> Footprint {
        let side = 2.0 * self.half_extent.y / self.size.y;
        if self.orthographic {
            Footprint::of_pixel(side, 0.0, filter)
        } else {
            // Off the axis pixels are nearer to edge-on, and farther along the ray than along the axis.
            let cos = -ray.direction.dot(self.axes.z_axis);
            let spread = side * cos * cos;
            Footprint::of_pixel(spread * (self.clip.near / cos), spread, filter)
        }
    }

    /// Whether rays start all over a lens.
    pub fn has_lens(&self) -> bool {
        self.aperture.is_some()
    }

    /// The ray from a point of the lens, `u` in the unit square, to where [`Self::ray`] meets the plane of focus; it starts
    /// at the near plane, too. Without a lens it is that ray.
    pub fn lens_ray(&self, raster: Vec2, u: Vec2) -> Ray {
        let Some((radius, focus)) = self.aperture else { return self.ray(raster) };
        let lens = radius * warp::concentric_disk(u);
        let way = self.plane(raster) - lens / focus;
        let start = lens + self.clip.near * way;
        let origin = self.origin + self.axes * start.extend(-self.clip.near);
        Ray { origin, direction: (self.axes * way.extend(-1.0)).normalize(), t_max: f32::INFINITY }
    }

    /// Corners of a rectangle that holds where all rays start.
    pub fn starts(&self) -> [Vec3; 4] {
        let Self { size, aperture, clip: Clip { near, .. }, .. } = *self;
        let Some((radius, focus)) = aperture else {
            return [Vec2::ZERO, Vec2::new(size.x, 0.0), Vec2::new(0.0, size.y), size]
                .map(|corner| self.ray(corner).origin);
        };
        let half = near * self.half_extent + radius * (1.0 - near / focus).abs();
        [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
            .map(|(x, y)| self.origin + self.axes * (Vec2::new(x, y) * half).extend(-near))
    }

    /// Where a point of the picture is on the plane at depth 1, or on any plane for parallel rays.
    fn plane(&self, raster: Vec2) -> Vec2 {
        let ndc = raster / self.size * 2.0 - Vec2::ONE;
        Vec2::new(ndc.x, -ndc.y) * self.half_extent
    }

    /// The ray through `raster`, in pixels from the top left corner; it starts at the near plane.
    pub fn ray(&self, raster: Vec2) -> Ray {
        let plane = self.plane(raster);
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
        lens: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;

    #[test]
    fn the_centre_ray_looks_along_minus_z_and_the_top_row_looks_up() {
        let c = CameraDescription {
            name: String::new(),
            transform: Affine3A::IDENTITY,
            projection: Projection::Perspective { yfov: std::f32::consts::FRAC_PI_2, aspect: None },
            clip: Clip::NONE,
            lens: None,
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
                lens: None,
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
                let (mut near, mut eye) = (camera.footprint(&free, 1.0), open.footprint(&free, 1.0));
                near.travel(1.0);
                eye.travel(1.0 + (origin - free.origin).length());
                assert!((near.width - eye.width).abs() < 1e-5 * eye.width);
            }
        }
    }

    #[test]
    fn rays_of_a_lens_meet_on_the_plane_of_focus_and_start_within_the_rectangle() {
        let lens =
            Lens { focal_length: 0.4, sensor: [0.036, 0.024], f_stop: Some(2.0), focus_distance: Some(4.0) };
        for near in [0.0, 0.5, 4.0, 6.0] {
            let description = CameraDescription {
                name: String::new(),
                transform: Affine3A::from_mat3_translation(
                    Mat3::from_rotation_y(0.5),
                    Vec3::new(1.0, 2.0, 3.0),
                ),
                projection: Projection::Perspective { yfov: 1.2, aspect: None },
                clip: Clip { near, far: 9.0 },
                lens: Some(lens),
            };
            let camera = Camera::new(&description, 200, 100);
            let sharp = Camera::new(&CameraDescription { lens: None, ..description.clone() }, 200, 100);
            let to_camera = description.transform.inverse();
            let starts = camera.starts().map(|c| to_camera.transform_point3(c));
            let mut widest = 0.0_f32;
            for i in 0..64 {
                let u = Vec2::new((i % 8) as f32 / 7.0, (i / 8) as f32 / 7.0).min(Vec2::splat(0.999_999));
                let raster = Vec2::new(3.1 * i as f32, (7 * i % 100) as f32);
                let (ray, middle) = (camera.lens_ray(raster, u), sharp.ray(raster));
                let origin = to_camera.transform_point3(ray.origin);
                let at_depth = |r: &Ray, depth: f32| {
                    let (o, d) =
                        (to_camera.transform_point3(r.origin), to_camera.transform_vector3(r.direction));
                    o + d * ((-depth - o.z) / d.z)
                };
                assert!((origin.z + near).abs() < 1e-5);
                assert!((at_depth(&ray, 4.0) - at_depth(&middle, 4.0)).length() < 1e-5, "focus");
                // At the depth d the cone has the radius A/2 · |d − s| / s.
                let off = (at_depth(&ray, 9.0) - at_depth(&middle, 9.0)).truncate().length();
                widest = widest.max(off);
                assert!(off <= 0.1 * 5.0 / 4.0 + 1e-5, "{off}");
                let inside = |x: f32, a: f32, b: f32| a.min(b) - 1e-5 <= x && x <= a.max(b) + 1e-5;
                assert!(
                    inside(origin.x, starts[0].x, starts[1].x) && inside(origin.y, starts[0].y, starts[2].y)
                );
            }
            assert!((widest - 0.125).abs() < 1e-4, "{widest}");
            // Stopped down it is a pinhole; parallel rays have no lens.
            let closed = Lens { f_stop: Some(1e9), ..lens };
            let closed =
                Camera::new(&CameraDescription { lens: Some(closed), ..description.clone() }, 200, 100);
            let (a, b) =
                (closed.lens_ray(Vec2::new(20.0, 30.0), Vec2::ZERO), sharp.ray(Vec2::new(20.0, 30.0)));
            assert!((a.origin - b.origin).length() < 1e-6 && (a.direction - b.direction).length() < 1e-6);
            let projection = Projection::Orthographic { ymag: 1.0, aspect: None };
            assert!(!Camera::new(&CameraDescription { projection, ..description }, 8, 8).has_lens());
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
