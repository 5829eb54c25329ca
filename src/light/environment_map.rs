//! An equirectangular environment map: look-up, and sampling by radiance times cosine.
//!
//! The map is looked up bilinearly and sampled in proportion to that very look-up: the plane between texel centres is
//! cut into cells with four texels as corners, a cell is chosen by its integral, and a point inside it by the bilinear
//! patch of the corners. For light from all sides the pdf is so `mean(L) s / Z`, with `mean` the mean of the colour
//! channels, and is positive wherever the map is. For a surface the cells are first chosen in blocks (`blocks.rs`), and
//! the pdf is multiplied by what a block is worth there.
//!
//! | name | symbol | meaning |
//! | --- | --- | --- |
//! | `u` | u | atan2(z, x)/2π + ½, wraps |
//! | `v` | v | from the *top*: ½ − asin(y)/π; clamped beyond the first and last row of texel centres |
//! | `sin_row` | s | mean of sin θ over a row of cells: (cos θ₀ − cos θ₁)/(θ₁ − θ₀) |
//! | `density_scale` | 1/Z | so that `mean(L) s / Z` integrates to 1 over (u, v) |
//!
//! dω = 2π² sin θ du dv.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::blocks::{Blocks, Grid};
use super::environment::{EnvironmentSample, Facing, mean, sanitize};
use super::irradiance::Irradiance;
use crate::sampling::{Distribution2D, atan2, warp};

/// Smallest sin θ that a pdf divides by: the poles are points, and a pdf must stay finite there.
const MIN_SIN_THETA: f32 = 1e-7;

/// An equirectangular map with its sampling tables.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Radiance with the scale multiplied in, row 0 at the top.
    pixels: Vec<Vec3>,
    /// Cosine and sine of the rotation about +Y.
    rotation: (f32, f32),
    /// `width × (height + 1)` cells, in blocks; row 0 lies above the first row of texel centres.
    grid: Grid,
    blocks: Blocks,
    /// The cells of each block; `None` where they are black.
    cells: Vec<Option<Distribution2D>>,
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
    /// channels become 0, larger ones than [`super::environment::MAX_RADIANCE`] that; [`Self::repaired`] counts them.
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
        let weigh = |row: usize, first: usize, weights: &mut [f64]| {
            let (y0, y1) = (row.saturating_sub(1), row.min(height - 1));
            let (upper, lower) = (&pixels[y0 * width..], &pixels[y1 * width..]);
            let row_weight = sin_rows[row] * (edges[row + 1] - edges[row]) * height as f64;
            let column = |x: usize| f64::from(mean(upper[x])) + f64::from(mean(lower[x]));
            let mut left = column(first);
            for (i, weight) in weights.iter_mut().enumerate() {
                let right = column((first + i + 1) % width);
                *weight = 0.25 * (left + right) * row_weight;
                left = right;
            }
        };
        let grid = Grid::new(width, height + 1);
        let cells: Vec<_> = (0..grid.len())
            .map(|block| {
                let (x, y) = grid.cells(block);
                Distribution2D::new(x.len(), y.len(), |row, weights| weigh(y.start + row, x.start, weights))
            })
            .collect();
        let powers: Vec<f64> = cells.iter().map(|c| c.as_ref().map_or(0.0, Distribution2D::total)).collect();
        let total: f64 = powers.iter().sum();
        let rotation = (rotation.cos(), rotation.sin());
        let at = |x: f64, y: f64| {
            let (top, below) = (edges[y as usize], edges[(y as usize + 1).min(height + 1)]);
            let theta = std::f64::consts::PI * (top + (below - top) * y.fract());
            turn(rotation, from_angles(theta as f32, column_angle(x as f32, width)))
        };
        let blocks = Blocks::new(&grid, &powers, at)?;
        let mean_density = total / (width as f64 * height as f64);
        let mean_radiance = sphere_mean(&edges, &pixels, width);
        let effective_solid_angle = effective_solid_angle(&pixels, width) as f32;
        let irradiance =
            Irradiance::of_map(width, height, |d| turn(rotation, d), |texel| mean(pixels[texel]));
        Some(Self {
            width,
            height,
            pixels,
            rotation,
            grid,
            blocks,
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

    /// Mean radiance over the sphere, averaged over the channels.
    pub fn mean_radiance(&self) -> f32 {
        self.mean_radiance
    }

    /// As [`super::Environment::effective_solid_angle`].
    pub fn effective_solid_angle(&self) -> f32 {
        self.effective_solid_angle
    }

    /// As [`super::Environment::irradiance`].
    #[inline]
    pub fn irradiance(&self, normal: Vec3) -> f32 {
        self.irradiance.towards(normal)
    }

    /// Radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.blend(&self.footprint(direction).0)
    }

    /// Density of [`Self::sample`] with respect to solid angle.
    #[inline]
    pub fn pdf(&self, facing: Facing, direction: Vec3) -> f32 {
        let (footprint, sin_theta) = self.footprint(direction);
        let density = self.density(&footprint, mean(self.blend(&footprint)), sin_theta);
        match facing {
            Facing::All => density,
            _ => density * self.blocks.worth(self.grid.block(footprint.x[0], footprint.cell_row), facing),
        }
    }

    /// A direction, about in proportion to the map times the cosine.
    #[inline]
    pub fn sample(&self, facing: Facing, u: Vec2) -> Option<EnvironmentSample> {
        let chosen = self.blocks.choose(facing, u)?;
        let cell = self.cells[chosen.block].as_ref()?.sample_cell(chosen.rest);
        let (columns, rows) = self.grid.cells(chosen.block);
        let (x, y) = (columns.start + cell.x, rows.start + cell.y);
        let mut footprint = Footprint {
            x: [x, if x + 1 == self.width { 0 } else { x + 1 }],
            y: [y.saturating_sub(1), y.min(self.height - 1)],
            fraction: Vec2::ZERO,
            cell_row: y,
        };
        let corners = self.corners(&footprint);
        footprint.fraction = warp::bilinear(cell.rest, corners.map(mean));
        let radiance = self.blend(&footprint);

        // The first and last row of cells are half as high: they end at the poles.
        let along = footprint.fraction.y;
        let row = match y {
            0 => 0.5 * along,
            y if y == self.height => y as f32 - 0.5 + 0.5 * along,
            y => y as f32 - 0.5 + along,
        };
        let theta = PI * row / self.height as f32;
        let phi = column_angle(x as f32 + footprint.fraction.x, self.width);
        let direction = self.to_world(from_angles(theta, phi));
        let sin_theta = theta.sin();
        let pdf = self.density(&footprint, mean(radiance), sin_theta) * chosen.worth;
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

/// φ of a column of cells, counted from the left edge of the first.
#[inline]
fn column_angle(x: f32, width: usize) -> f32 {
    TAU * ((x + 0.5) / width as f32 - 0.5)
}

/// The direction of a place of the map.
#[inline]
fn from_angles(theta: f32, phi: f32) -> Vec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi)
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
