//! `EXT_lights_image_based`: a cube of images around the scene becomes its environment.
//!
//! The extension carries images blurred for mirrors of several roughnesses, and nine coefficients of irradiance. A path
//! tracer wants radiance as it is, so only the sharpest images are used: PNGs as RGBD (colour over alpha), the rest as
//! plain colour, all decoded from sRGB as the implementations do. Faces are what is seen from the inside, that is those
//! of OpenGL's cube maps flipped about their vertical axes. Where there are no images, radiance is made from the
//! coefficients: L_lm = E_lm / A_l with A = π, 2π/3, π/4 (Ramamoorthi & Hanrahan 2001, eq. 7 and 8).

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use super::Extension;
use crate::asset::{AssetError, Json, Loader};
use crate::scene::texture::srgb_to_linear;
use crate::scene::{EnvironmentDescription, ImageData, ImagePixels};

/// Faces are read at no more than this many pixels a side: the map has 4 × 2 of them.
const LARGEST_FACE: usize = 1024;
/// Rows of a map made from coefficients.
const SMOOTH_ROWS: usize = 64;
/// A denser alpha than this stands for a brightness that no number of eight bits was meant to reach.
const LEAST_ALPHA: f32 = 1.0 / 255.0;

pub(super) struct LightsImageBased;

impl Extension for LightsImageBased {
    fn name(&self) -> &str {
        "EXT_lights_image_based"
    }

    fn document(&self, loader: &mut Loader<'_>, own: &Json<'_>) -> Result<(), AssetError> {
        let Some(index) = own.usize("light")? else { return Ok(()) };
        let lights = loader.root().extension(self.name()).and_then(|root| root.get("lights"));
        let Some(light) = lights.and_then(|lights| lights.item(index)) else {
            return loader.invalid(&own.pointer_to("light"), format!("there is no light {index}"));
        };
        light.as_object()?;
        let intensity = loader.factor(&light, "intensity", 1.0, 0.0..=1e9)?;
        let [x, y, z, w] = loader.factors(&light, "rotation", [0.0, 0.0, 0.0, 1.0], -1.0..=1.0)?;
        let rotation = Quat::from_xyzw(x, y, z, w);
        let to_light =
            if rotation.length_squared() > 0.0 { rotation.normalize().inverse() } else { Quat::IDENTITY };
        let (rows, radiance): (usize, Box<dyn Fn(Vec3) -> Vec3 + Sync>) = match faces(loader, &light)? {
            Some(faces) => {
                let side = faces.iter().map(|f| f.width.max(f.height) as usize).max().unwrap_or(1);
                (2 * side.min(LARGEST_FACE), Box::new(move |d| look(&faces, d)))
            }
            None => {
                let Some(coefficients) = coefficients(loader, &light)? else { return Ok(()) };
                (SMOOTH_ROWS, Box::new(move |d| harmonics(&coefficients, d)))
            }
        };
        let pixels = equirectangular(rows, |d| radiance(to_light * d));
        let scale = Vec3::splat(intensity);
        loader.scene.environment =
            EnvironmentDescription::Map { width: 2 * rows, height: rows, pixels, scale, rotation: 0.0 };
        Ok(())
    }
}

/// The six faces of the sharpest cube; `None` where one is not to be had.
fn faces(loader: &mut Loader<'_>, light: &Json<'_>) -> Result<Option<Vec<ImageData>>, AssetError> {
    let Some(sharpest) = light.get("specularImages").and_then(|levels| levels.item(0)) else {
        return Ok(None);
    };
    let images: Vec<Json<'_>> = sharpest.items()?.collect();
    if images.len() != 6 {
        loader.invalid(sharpest.pointer(), format!("{} images where a cube has six faces", images.len()))?;
        return Ok(None);
    }
    let mut faces = Vec::new();
    for image in images {
        let Some(face) = loader.image_pixels(image.as_usize()?.into(), image.pointer())? else {
            return Ok(None);
        };
        faces.push(face);
    }
    Ok(Some(faces))
}

/// Nine coefficients of three colours.
fn coefficients(loader: &mut Loader<'_>, light: &Json<'_>) -> Result<Option<[Vec3; 9]>, AssetError> {
    let rows = light.array("irradianceCoefficients")?;
    if rows.len() != 9 {
        loader.invalid(light.pointer(), "has neither six images nor nine coefficients; it gives no light")?;
        return Ok(None);
    }
    let mut coefficients = [Vec3::ZERO; 9];
    for (coefficient, row) in coefficients.iter_mut().zip(&rows) {
        let numbers = row.items()?.take(4).map(|n| n.as_f64()).collect::<Result<Vec<f64>, _>>()?;
        let [r, g, b] = numbers[..] else { return Err(row.error("three numbers are expected")) };
        *coefficient = Vec3::new(r as f32, g as f32, b as f32);
    }
    Ok(Some(coefficients))
}

/// A map of `rows` rows and twice as many columns, in the coordinates of [`EnvironmentDescription::Map`].
fn equirectangular(rows: usize, radiance: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    let columns = 2 * rows;
    let texel = |i: usize| {
        let phi = ((i % columns) as f32 + 0.5) / columns as f32 * TAU - PI;
        let (sin_theta, cos_theta) = (((i / columns) as f32 + 0.5) / rows as f32 * PI).sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        radiance(Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi))
    };
    (0..columns * rows).map(texel).collect()
}

/// The face that a direction meets, and where, from the upper left corner of the image.
fn place_on_cube(d: Vec3) -> (usize, f32, f32) {
    let a = d.abs();
    let (face, s, t, m) = if a.x >= a.y && a.x >= a.z {
        (usize::from(d.x < 0.0), -d.z * d.x.signum(), -d.y, a.x)
    } else if a.y >= a.z {
        (2 + usize::from(d.y < 0.0), d.x, d.z * d.y.signum(), a.y)
    } else {
        (4 + usize::from(d.z < 0.0), d.x * d.z.signum(), -d.y, a.z)
    };
    (face, 0.5 - 0.5 * s / m, 0.5 + 0.5 * t / m)
}

/// Radiance from a direction: texels of a face, blended.
fn look(faces: &[ImageData], d: Vec3) -> Vec3 {
    let (face, u, v) = place_on_cube(d);
    let image = &faces[face];
    let axis = |c: f32, size: u32| {
        let at = (c * size as f32 - 0.5).clamp(0.0, (size - 1) as f32);
        let low = at.floor();
        (low as u32, (low as u32 + 1).min(size - 1), at - low)
    };
    let ((x0, x1, fx), (y0, y1, fy)) = (axis(u, image.width), axis(v, image.height));
    let row = |y| texel(image, x0, y).lerp(texel(image, x1, y), fx);
    row(y0).lerp(row(y1), fy)
}

fn texel(image: &ImageData, x: u32, y: u32) -> Vec3 {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    let encoded: [f32; 4] = std::array::from_fn(|k| match &image.pixels {
        ImagePixels::Rgba8(p) => f32::from(p[at + k]) / f32::from(u8::MAX),
        ImagePixels::Rgba16(p) => f32::from(p[at + k]) / f32::from(u16::MAX),
        ImagePixels::Rgba32F(p) => p[at + k],
    });
    let [r, g, b, a] = encoded;
    if matches!(image.pixels, ImagePixels::Rgba32F(_)) {
        return Vec3::new(r, g, b);
    }
    Vec3::new(r, g, b).map(srgb_to_linear) / a.max(LEAST_ALPHA)
}

/// Radiance whose irradiance has these coefficients, as far as it is positive.
fn harmonics(irradiance: &[Vec3; 9], d: Vec3) -> Vec3 {
    let Vec3 { x, y, z } = d;
    let band = [PI, 2.0 * PI / 3.0, PI / 4.0];
    let basis = [
        0.282_094_8 / band[0],
        0.488_602_5 * y / band[1],
        0.488_602_5 * z / band[1],
        0.488_602_5 * x / band[1],
        1.092_548_4 * x * y / band[2],
        1.092_548_4 * y * z / band[2],
        0.315_391_6 * (3.0 * z * z - 1.0) / band[2],
        1.092_548_4 * x * z / band[2],
        0.546_274_2 * (x * x - y * y) / band[2],
    ];
    let sum: Vec3 = irradiance.iter().zip(basis).map(|(&e, b)| e * b).sum();
    sum.max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looking out with +Y up: to the right of +X is +Z, above the middle of every side is up.
    #[test]
    fn faces_are_what_is_seen_from_inside() {
        for (d, face) in
            [(Vec3::X, 0), (Vec3::NEG_X, 1), (Vec3::Y, 2), (Vec3::NEG_Y, 3), (Vec3::Z, 4), (Vec3::NEG_Z, 5)]
        {
            let (found, u, v) = place_on_cube(d);
            assert_eq!((found, u, v), (face, 0.5, 0.5));
            if d.y == 0.0 {
                let right = d.cross(Vec3::Y);
                let (_, u, v) = place_on_cube(d + 0.5 * right + 0.25 * Vec3::Y);
                assert_eq!((u, v), (0.75, 0.375), "{d}");
            }
        }
    }

    #[test]
    fn pixels_are_colour_over_alpha() {
        let face = |rgba: [u8; 4]| ImageData {
            name: String::new(),
            width: 1,
            height: 1,
            pixels: ImagePixels::Rgba8(rgba.to_vec()),
        };
        let mut faces: Vec<ImageData> = (0..6).map(|_| face([0, 0, 0, 255])).collect();
        faces[2] = face([255, 255, 0, 51]);
        assert!((look(&faces, Vec3::Y) - Vec3::new(5.0, 5.0, 0.0)).length() < 1e-5);
        let map = equirectangular(64, |d| look(&faces, d));
        assert!(map[0].x > 4.9 && map[map.len() - 1].x < 0.1, "the first row is up");
    }

    /// Irradiance of a constant radiance 1 is π, whose only coefficient is π · 2√π; that of 1 + y has in the next band
    /// 2π/3 · √(4π/3).
    #[test]
    fn coefficients_of_irradiance_give_radiance() {
        let mut irradiance = [Vec3::ZERO; 9];
        irradiance[0] = Vec3::splat(PI * 2.0 * PI.sqrt());
        irradiance[1] = Vec3::splat(2.0 * PI / 3.0 * (4.0 * PI / 3.0).sqrt());
        for d in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::new(0.6, 0.8, 0.0)] {
            assert!((harmonics(&irradiance, d).x - (1.0 + d.y)).abs() < 1e-5, "{d}");
        }
    }
}
