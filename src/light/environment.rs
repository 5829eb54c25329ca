//! Light from infinitely far away: nothing, one radiance, or an equirectangular map.
//!
//! The map is looked up bilinearly and sampled in proportion to that very look-up: the plane between texel centres
//! is cut into cells with four texels as corners, a cell is chosen by its integral, and a point inside it by the
//! bilinear patch of the corners. So the pdf is `mean(L) s / Z`, with `mean` the mean of the colour channels, and is
//! positive wherever the map is.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `u` | u | atan2(z, x)/2π + ½, wraps |
//! | `v` | v | from the *top*: ½ − asin(y)/π; clamped beyond the first and last row of texel centres |
//! | `sin_row` | s | mean of sin θ over a row of cells: (cos θ₀ − cos θ₁)/(θ₁ − θ₀) |
//! | `density_scale` | 1/Z | so that `mean(L) s / Z` integrates to 1 over (u, v) |
//!
//! dω = 2π² sin θ du dv. A constant environment is sampled uniformly over the sphere, or by the cosine about a normal.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::irradiance::Irradiance;
use crate::sampling::{Distribution2D, Frame, atan2, warp};
use crate::scene::EnvironmentDescription;

/// Smallest sin θ that a pdf divides by: the poles are points, and a pdf must stay finite there.
const MIN_SIN_THETA: f32 = 1e-7;

/// Largest radiance of a channel; more (or infinity) in a map is brought down to it, so that sums stay finite.
pub const MAX_RADIANCE: f32 = 1e18;

/// A direction chosen in proportion to the environment's light.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// Unit direction towards the light.
    pub direction: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density with respect to solid angle, > 0.
    pub pdf: f32,
}

/// Light from infinitely far away, ready to be looked up and sampled.
#[derive(Clone, Debug)]
pub enum Environment {
    /// Darkness.
    None,
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// An equirectangular map.
    Map(Box<EnvironmentMap>),
}

impl Environment {
    /// Prepares a description. A map without any positive finite pixel, or whose pixels do not fill its size, is darkness.
    pub fn new(description: &EnvironmentDescription) -> Self {
        match description {
            EnvironmentDescription::Constant(radiance) => {
                let radiance = sanitize(*radiance).0;
                if radiance == Vec3::ZERO { Self::None } else { Self::Constant(radiance) }
            }
            EnvironmentDescription::Map { width, height, pixels, scale, rotation } => {
                EnvironmentMap::new(*width, *height, pixels, *scale, *rotation)
                    .map_or(Self::None, |map| Self::Map(Box::new(map)))
            }
        }
    }

    /// Whether no light comes from anywhere.
    pub fn is_none(&self) -> bool {
        matches!(self, Self::None)
    }

    /// Radiance from a unit direction (pointing away from the scene).
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// A direction with its radiance; `None` where there is no light. With a normal a constant environment is sampled
    /// over its hemisphere only.
    #[inline]
    pub fn sample(&self, normal: Option<Vec3>, u: Vec2) -> Option<EnvironmentSample> {
        match self {
            Self::None => None,
            Self::Constant(radiance) => Some(match normal {
                Some(normal) => {
                    let local = warp::cosine_hemisphere(u);
                    let direction = Frame::from_normal(normal).to_world(local);
                    let pdf = warp::cosine_hemisphere_pdf(normal.dot(direction));
                    if pdf <= 0.0 {
                        return None;
                    }
                    EnvironmentSample { direction, radiance: *radiance, pdf }
                }
                None => EnvironmentSample {
                    direction: warp::uniform_sphere(u),
                    radiance: *radiance,
                    pdf: warp::UNIFORM_SPHERE_PDF,
                },
            }),
            Self::Map(map) => map.sample(u),
        }
    }

    /// Density with respect to solid angle with which [`Self::sample`] chooses a direction.
    #[inline]
    pub fn pdf(&self, normal: Option<Vec3>, direction: Vec3) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Constant(_) => {
                normal.map_or(warp::UNIFORM_SPHERE_PDF, |n| warp::cosine_hemisphere_pdf(n.dot(direction)))
            }
            Self::Map(map) => map.pdf(direction),
        }
    }

    /// Mean radiance over the sphere, averaged over the channels.
    pub fn mean_radiance(&self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Constant(radiance) => mean(*radiance),
            Self::Map(map) => map.mean_radiance,
        }
    }

    /// The solid angle that most light comes from, steradians: (∫ L dω)² / ∫ L² dω, 4π where all directions are alike.
    pub fn effective_solid_angle(&self) -> f32 {
        match self {
            Self::None | Self::Constant(_) => 4.0 * PI,
            Self::Map(map) => map.effective_solid_angle,
        }
    }

    /// About the irradiance of a surface with that unit normal, channel mean: positive wherever there is light.
    #[inline]
    pub fn irradiance(&self, normal: Vec3) -> f32 {
        match self {
            Self::Map(map) => map.irradiance.towards(normal),
            _ => PI * self.mean_radiance(),
        }
    }

    /// Power in watts (channel mean) that enters a sphere of the given radius: 4π² r² L.
    pub fn power(&self, scene_radius: f32) -> f32 {
        4.0 * PI * PI * scene_radius * scene_radius * self.mean_radiance()
    }
}

/// An equirectangular map with its sampling tables.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Radiance with the scale multiplied in, row 0 at the top.
    pixels: Vec<Vec3>,
    /// Cosine and sine of the rotation about +Y.
    rotation: (f32, f32),
    /// `width × (height + 1)` cells; row 0 lies above the first row of texel centres.
    cells: Distribution2D,
    /// s of each row of cells.
    sin_rows: Vec<f32>,
    density_scale: f32,
    mean_radiance: f32,
    effective_solid_angle: f32,
    irradiance: Irradiance,
    repaired: usize,
}

/// Where a look-up falls: texel columns and rows of the four corners, the fractions between them, the row of cells.
struct Footprint {
    x: [usize; 2],
    y: [usize; 2],
    fraction: Vec2,
    cell_row: usize,
}

impl EnvironmentMap {
    /// Prepares a map; `None` if its size does not match its pixels or nothing in it is positive. Negative and NaN
    /// channels become 0, larger ones than [`MAX_RADIANCE`] that; [`Self::repaired`] counts them.
    pub fn new(width: usize, height: usize, pixels: &[Vec3], scale: Vec3, rotation: f32) -> Option<Self> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(pixels.len()) {
            return None;
        }
        let mut repaired = 0;
        let pixels: Vec<Vec3> = pixels
            .iter()
            .map(|&pixel| {
                let (radiance, changed) = sanitize(pixel * scale);
                repaired += usize::from(changed);
                radiance
            })
            .collect();
        let edges: Vec<f64> = cell_row_edges(height);
        let sin_rows: Vec<f64> = edges
            .windows(2)
            .map(|v| {
                let (top, bottom) = (v[0] * std::f64::consts::PI, v[1] * std::f64::consts::PI);
                (top.cos() - bottom.cos()) / (bottom - top)
            })
            .collect();
        // The weight of a cell is the integral of mean(L) s over it, in units of one texel's (u, v) area.
        let cells = Distribution2D::new(width, height + 1, |row, weights| {
            let (y0, y1) = (row.saturating_sub(1), row.min(height - 1));
            let (upper, lower) = (&pixels[y0 * width..], &pixels[y1 * width..]);
            let row_weight = sin_rows[row] * (edges[row + 1] - edges[row]) * height as f64;
            let mut left = f64::from(mean(upper[0])) + f64::from(mean(lower[0]));
            for (x, weight) in weights.iter_mut().enumerate() {
                let next = if x + 1 == width { 0 } else { x + 1 };
                let right = f64::from(mean(upper[next])) + f64::from(mean(lower[next]));
                *weight = 0.25 * (left + right) * row_weight;
                left = right;
            }
        })?;
        let mean_density = cells.total() / (width as f64 * height as f64);
        let mean_radiance = sphere_mean(&edges, &pixels, width);
        let effective_solid_angle = effective_solid_angle(&pixels, width) as f32;
        let rotation = (rotation.cos(), rotation.sin());
        let irradiance =
            Irradiance::of_map(width, height, |d| turn(rotation, d), |texel| mean(pixels[texel]));
        Some(Self {
            width,
            height,
            pixels,
            rotation,
            cells,
            sin_rows: sin_rows.iter().map(|&s| s as f32).collect(),
            density_scale: (1.0 / mean_density) as f32,
            mean_radiance: mean_radiance as f32,
            effective_solid_angle,
            irradiance,
            repaired,
        })
    }

    /// How many pixels had a negative, not finite or enormous channel, and were changed.
    pub fn repaired(&self) -> usize {
        self.repaired
    }

    /// Radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.blend(&self.footprint(direction).0)
    }

    /// Density of [`Self::sample`] with respect to solid angle.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let (footprint, sin_theta) = self.footprint(direction);
        self.density(&footprint, mean(self.blend(&footprint)), sin_theta)
    }

    /// A direction in proportion to the map.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Option<EnvironmentSample> {
        let cell = self.cells.sample_cell(u);
        let mut footprint = Footprint {
            x: [cell.x, if cell.x + 1 == self.width { 0 } else { cell.x + 1 }],
            y: [cell.y.saturating_sub(1), cell.y.min(self.height - 1)],
            fraction: Vec2::ZERO,
            cell_row: cell.y,
        };
        let corners = self.corners(&footprint);
        footprint.fraction = warp::bilinear(cell.rest, corners.map(mean));
        let radiance = self.blend(&footprint);

        // The first and last row of cells are half as high: they end at the poles.
        let along = footprint.fraction.y;
        let row = match cell.y {
            0 => 0.5 * along,
            y if y == self.height => y as f32 - 0.5 + 0.5 * along,
            y => y as f32 - 0.5 + along,
        };
        let theta = PI * row / self.height as f32;
        let (sin_theta, cos_theta) = theta.sin_cos();
        let phi = TAU * ((cell.x as f32 + 0.5 + footprint.fraction.x) / self.width as f32 - 0.5);
        let (sin_phi, cos_phi) = phi.sin_cos();
        let direction = self.to_world(Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi));
        let pdf = self.density(&footprint, mean(radiance), sin_theta);
        (pdf > 0.0).then_some(EnvironmentSample { direction, radiance, pdf })
    }

    #[inline]
    fn density(&self, footprint: &Footprint, mean_radiance: f32, sin_theta: f32) -> f32 {
        mean_radiance * self.sin_rows[footprint.cell_row] * self.density_scale
            / (2.0 * PI * PI * sin_theta.max(MIN_SIN_THETA))
    }

    /// The footprint of a direction and its sin θ.
    #[inline]
    fn footprint(&self, direction: Vec3) -> (Footprint, f32) {
        let d = self.to_map(direction);
        let sin_theta = (d.x * d.x + d.z * d.z).sqrt();
        let v = 0.5 - atan2(d.y, sin_theta) / PI;
        let x = (atan2(d.z, d.x) / TAU + 0.5) * self.width as f32 - 0.5;
        let y = (v * self.height as f32 - 0.5).clamp(-0.5, self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let column = |i: i64| i.rem_euclid(self.width as i64) as usize;
        let row = |i: i64| i.clamp(0, self.height as i64 - 1) as usize;
        let footprint = Footprint {
            x: [column(left as i64), column(left as i64 + 1)],
            y: [row(top as i64), row(top as i64 + 1)],
            fraction: Vec2::new(x - left, y - top),
            cell_row: (top as i64 + 1).clamp(0, self.height as i64) as usize,
        };
        (footprint, sin_theta)
    }

    #[inline]
    fn corners(&self, f: &Footprint) -> [Vec3; 4] {
        let at = |x: usize, y: usize| self.pixels[y * self.width + x];
        [at(f.x[0], f.y[0]), at(f.x[1], f.y[0]), at(f.x[0], f.y[1]), at(f.x[1], f.y[1])]
    }

    #[inline]
    fn blend(&self, footprint: &Footprint) -> Vec3 {
        let [c00, c10, c01, c11] = self.corners(footprint);
        let top = c00.lerp(c10, footprint.fraction.x);
        let bottom = c01.lerp(c11, footprint.fraction.x);
        top.lerp(bottom, footprint.fraction.y)
    }

    #[inline]
    fn to_world(&self, d: Vec3) -> Vec3 {
        turn(self.rotation, d)
    }

    #[inline]
    fn to_map(&self, d: Vec3) -> Vec3 {
        let (cos, sin) = self.rotation;
        Vec3::new(cos * d.x - sin * d.z, d.y, cos * d.z + sin * d.x)
    }
}

/// A positive rotation turns the map's content counter-clockwise seen from above: right-handed about +Y.
#[inline]
fn turn((cos, sin): (f32, f32), d: Vec3) -> Vec3 {
    Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
}

/// v of the edges of the rows of cells: the poles and the centres of the rows of texels.
fn cell_row_edges(height: usize) -> Vec<f64> {
    let centres = (0..height).map(|y| (y as f64 + 0.5) / height as f64);
    std::iter::once(0.0).chain(centres).chain(std::iter::once(1.0)).collect()
}

/// ∫ L dω / 4π of the bilinear look-up, exactly: L is linear in θ between the edges of a row of cells.
fn sphere_mean(edges: &[f64], pixels: &[Vec3], width: usize) -> f64 {
    let rows: Vec<f64> = pixels
        .chunks(width)
        .map(|row| row.iter().map(|&p| f64::from(mean(p))).sum::<f64>() / width as f64)
        .collect();
    let integral: f64 = edges
        .windows(2)
        .enumerate()
        .map(|(i, v)| {
            let (top, bottom) = (v[0] * std::f64::consts::PI, v[1] * std::f64::consts::PI);
            let whole = top.cos() - bottom.cos();
            // ∫ (θ − θ₀)/(θ₁ − θ₀) sin θ dθ
            let lower = (bottom.sin() - top.sin()) / (bottom - top) - bottom.cos();
            let (a, b) = (rows[i.saturating_sub(1)], rows[i.min(rows.len() - 1)]);
            a * (whole - lower) + b * lower
        })
        .sum();
    0.5 * integral
}

/// (∫ L dω)² / ∫ L² dω of the texels.
fn effective_solid_angle(pixels: &[Vec3], width: usize) -> f64 {
    use std::f64::consts::PI;
    let height = pixels.len() / width;
    let (mut first, mut second) = (0.0, 0.0);
    for (y, row) in pixels.chunks(width).enumerate() {
        let band = (PI * (y as f64) / height as f64).cos() - (PI * (y + 1) as f64 / height as f64).cos();
        let solid_angle = 2.0 * PI * band / width as f64;
        for radiance in row.iter().map(|&p| f64::from(mean(p))) {
            first += solid_angle * radiance;
            second += solid_angle * radiance * radiance;
        }
    }
    first * first / second
}

#[inline]
fn mean(v: Vec3) -> f32 {
    v.element_sum() * (1.0 / 3.0)
}

fn sanitize(v: Vec3) -> (Vec3, bool) {
    let repaired = Vec3::from_array(v.to_array().map(|c| if c > 0.0 { c.min(MAX_RADIANCE) } else { 0.0 }));
    (repaired, repaired != v)
}

#[cfg(test)]
#[path = "environment_tests.rs"]
mod tests;
