//! The built-in studio: an equirectangular map for assets that bring no light.
//!
//! It is a photographer's set for things that light goes through, seen from the front (+Z) or the three-quarter view
//! of the automatic camera: a large soft key box at the upper left front, a strong rim strip and a back box behind
//! (light *through* the object is what shows translucency), a cool fill at the right, and a floor that throws a
//! little light back up. Lamps are rounded rectangles on the sphere with soft edges, above what a camera that looks
//! at the object from the front sees as its background, which is a dim neutral gradient.
//!
//! Level: a white diffuse sphere is 0.66 on average (the mean radiance of the map), so it needs no exposure.

use crate::scene::EnvironmentDescription;
use glam::{Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// Texels in a row of the map.
const WIDTH: usize = 512;
/// Rows of the map.
const HEIGHT: usize = WIDTH / 2;
/// Mean radiance over the sphere, channels averaged.
const MEAN: f32 = 0.66;

/// A soft box: a rounded rectangle on the sphere of directions, bright in the middle.
struct Lamp {
    /// Azimuth of the centre from +Z towards +X, degrees.
    azimuth: f32,
    /// Elevation of the centre, degrees.
    elevation: f32,
    /// Half width and half height, degrees.
    half_size: [f32; 2],
    /// Width of the soft edge, degrees.
    edge: f32,
    /// Radiance before the map is brought to [`MEAN`].
    radiance: Vec3,
}

const LAMPS: [Lamp; 5] = [
    // Key, slightly warm.
    Lamp {
        azimuth: -42.0,
        elevation: 40.0,
        half_size: [24.0, 18.0],
        edge: 7.0,
        radiance: vec3(8.0, 7.6, 7.1),
    },
    // Rim strip, tall and narrow, behind on the right.
    Lamp {
        azimuth: 150.0,
        elevation: 42.0,
        half_size: [7.0, 26.0],
        edge: 4.0,
        radiance: vec3(16.0, 15.9, 15.6),
    },
    // Back box, behind on the left and above.
    Lamp {
        azimuth: -152.0,
        elevation: 50.0,
        half_size: [16.0, 12.0],
        edge: 6.0,
        radiance: vec3(9.0, 8.8, 8.5),
    },
    // Fill, slightly cool.
    Lamp {
        azimuth: 82.0,
        elevation: 22.0,
        half_size: [20.0, 22.0],
        edge: 12.0,
        radiance: vec3(1.35, 1.5, 1.7),
    },
    // Top light, wide and weak.
    Lamp {
        azimuth: 0.0,
        elevation: 88.0,
        half_size: [22.0, 22.0],
        edge: 16.0,
        radiance: vec3(1.2, 1.2, 1.2),
    },
];

/// The studio as a map of 512 × 256 texels of linear Rec. 709 radiance, mean 0.66.
pub fn studio() -> EnvironmentDescription {
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    let (mut sum, mut weight) = (0.0f64, 0.0f64);
    let lamps = LAMPS.map(PlacedLamp::new);
    for row in 0..HEIGHT {
        let elevation = PI * (0.5 - (row as f32 + 0.5) / HEIGHT as f32);
        for column in 0..WIDTH {
            let phi = TAU * ((column as f32 + 0.5) / WIDTH as f32 - 0.5);
            let direction = vec3(phi.cos() * elevation.cos(), elevation.sin(), phi.sin() * elevation.cos());
            let radiance = lamps
                .iter()
                .fold(backdrop(direction.y), |sum, lamp| sum + lamp.lamp.radiance * lamp.shape(direction));
            sum += f64::from(radiance.element_sum() / 3.0 * elevation.cos());
            weight += f64::from(elevation.cos());
            pixels.push(radiance);
        }
    }
    let scale = (f64::from(MEAN) * weight / sum) as f32;
    for pixel in &mut pixels {
        *pixel *= scale;
    }
    EnvironmentDescription::Map { width: WIDTH, height: HEIGHT, pixels, scale: Vec3::ONE, rotation: 0.0 }
}

/// The set without lamps: a dim wall that is darkest a little above the horizon and a floor that brightens towards
/// the nadir.
fn backdrop(y: f32) -> Vec3 {
    let floor = smoothstep(0.1, -1.0, y);
    let ceiling = smoothstep(0.0, 1.0, y);
    Vec3::splat(0.11) + vec3(0.204, 0.20, 0.192) * floor + vec3(0.10, 0.105, 0.11) * ceiling
}

/// A lamp in its own frame.
struct PlacedLamp {
    lamp: Lamp,
    axis: Vec3,
    right: Vec3,
    up: Vec3,
    /// Cosine of the angle from the axis to the corners, beyond which there is no light.
    min_forward: f32,
}

impl PlacedLamp {
    fn new(lamp: Lamp) -> Self {
        let (sin_a, cos_a) = lamp.azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = lamp.elevation.to_radians().sin_cos();
        let axis = vec3(sin_a * cos_e, sin_e, cos_a * cos_e);
        let right = vec3(cos_a, 0.0, -sin_a);
        let corner = lamp.half_size.map(|angle| angle.to_radians().tan());
        let min_forward = 1.0 / (1.0 + corner[0] * corner[0] + corner[1] * corner[1]).sqrt();
        Self { axis, right, up: axis.cross(right), min_forward, lamp }
    }

    /// 1 in the middle, 0 beyond the edge. The direction is measured as the two angles by which it leaves the axis
    /// sideways and upwards.
    fn shape(&self, direction: Vec3) -> f32 {
        let forward = direction.dot(self.axis);
        if forward < self.min_forward {
            return 0.0;
        }
        let Lamp { half_size, edge, .. } = self.lamp;
        let across = direction.dot(self.right).atan2(forward).to_degrees().abs() - half_size[0] + edge;
        let along = direction.dot(self.up).atan2(forward).to_degrees().abs() - half_size[1] + edge;
        let outside = across.max(0.0).hypot(along.max(0.0));
        let falloff = 1.0 - 0.25 * (1.0 - forward);
        falloff * smoothstep(edge, 0.0, outside)
    }
}

/// Hermite step from 0 at `from` to 1 at `to`; `from` may be the larger one.
fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Vec<Vec3> {
        let EnvironmentDescription::Map { width, height, pixels, .. } = studio() else { panic!("not a map") };
        assert_eq!((width, height, pixels.len()), (WIDTH, HEIGHT, WIDTH * HEIGHT));
        pixels
    }

    /// Exitant radiance of a white diffuse surface with that normal: ∫ L cos⁺ dω / π.
    fn white_diffuse(pixels: &[Vec3], normal: Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (row, texels) in pixels.chunks(WIDTH).enumerate() {
            let elevation = PI * (0.5 - (row as f32 + 0.5) / HEIGHT as f32);
            let solid_angle = TAU / WIDTH as f32 * PI / HEIGHT as f32 * elevation.cos();
            for (column, &texel) in texels.iter().enumerate() {
                // The convention again, written the other way round: u = atan2(z, x)/2π + ½.
                let u = (column as f32 + 0.5) / WIDTH as f32;
                let (sin, cos) = (TAU * (u - 0.5)).sin_cos();
                let direction = vec3(cos * elevation.cos(), elevation.sin(), sin * elevation.cos());
                sum += texel * (direction.dot(normal).max(0.0) * solid_angle / PI);
            }
        }
        sum
    }

    #[test]
    fn a_white_sphere_is_well_exposed_from_every_usual_view() {
        let pixels = map();
        let camera = |azimuth: f32, elevation: f32| {
            let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
            let (sin_e, cos_e) = elevation.to_radians().sin_cos();
            vec3(sin_a * cos_e, sin_e, cos_a * cos_e)
        };
        for (azimuth, elevation) in [(0.0, 0.0), (30.0, 20.0), (-30.0, 20.0), (0.0, 30.0)] {
            let view = camera(azimuth, elevation);
            let (side, up) = (view.cross(Vec3::Y).normalize(), view.cross(Vec3::Y).normalize().cross(view));
            let (mut sum, mut n, mut brightest) = (0.0, 0, 0.0f32);
            for i in 0..9 {
                for j in 0..9 {
                    let (x, y) = ((i as f32 - 4.0) / 4.5, (j as f32 - 4.0) / 4.5);
                    if x * x + y * y < 1.0 {
                        let normal = side * x + up * y + view * (1.0 - x * x - y * y).sqrt();
                        let value = white_diffuse(&pixels, normal);
                        sum += value.element_sum() / 3.0;
                        brightest = brightest.max(value.max_element());
                        n += 1;
                    }
                }
            }
            let mean = sum / n as f32;
            println!("camera {azimuth}, {elevation}: mean {mean}, brightest {brightest}");
            assert!((0.55..0.85).contains(&mean), "{mean}");
            assert!(brightest < 1.5, "{brightest}");
        }
    }

    #[test]
    fn light_comes_from_behind_too_and_is_neutral() {
        let pixels = map();
        let front = white_diffuse(&pixels, Vec3::Z);
        let back = white_diffuse(&pixels, Vec3::NEG_Z);
        let below = white_diffuse(&pixels, Vec3::NEG_Y);
        println!("front {front}, back {back}, below {below}");
        assert!(back.y > 0.7 * front.y, "{back} {front}");
        assert!(below.y > 0.15, "{below}");
        let mean = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z]
            .into_iter()
            .map(|n| white_diffuse(&pixels, n))
            .sum::<Vec3>();
        assert!((mean / mean.y - 1.0).abs().max_element() < 0.06, "tinted: {mean}");
        assert!(
            white_diffuse(&pixels, vec3(-0.6, 0.5, 0.6).normalize()).y > white_diffuse(&pixels, Vec3::X).y
        );
    }

    #[test]
    fn every_texel_is_finite_and_lit() {
        assert!(map().iter().all(|t| t.is_finite() && t.min_element() > 0.01));
    }
}
