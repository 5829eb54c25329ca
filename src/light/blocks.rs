//! An environment map in blocks, so that light can be chosen by radiance times cosine.
//!
//! Half of a map is behind any surface, and often the brighter half. The cells of the map are grouped into a grid of blocks;
//! a block of power E, whose light comes from about the direction **d** and at most an angle r away from it, is chosen for a
//! surface of normal **n** in proportion to E c(**n**·**d**), and a cell within it by its own power. c is the clamped cosine
//! averaged over the block, roughly: with s = sin r
//!
//! ```text
//! c(x) = x              x ≥ s
//!      = (x + s)²/4s    −s < x < s                                                                (1)
//!      = 0              x ≤ −s, where no direction of the block is above the horizon.
//! ```
//!
//! So the density of a direction is that of the plain map times c ΣE / ΣEc, the *worth* of its block. Normals are
//! rounded to a few hundred directions, for each of which the choice is tabulated; s is larger by as much as rounding
//! may turn a normal.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::environment::Facing;
use crate::sampling::Distribution1D;

/// Most blocks in a row of them.
const COLUMNS: usize = 16;
/// Most rows of blocks.
const ROWS: usize = 8;
/// Normals are rounded to the cells of an octahedron that is unfolded to a square of as many cells along each side.
const NORMALS: usize = 16;
/// Sine of the largest angle between a direction and the middle of its cell; a test holds it.
const ROUNDING: f32 = 0.26;
/// Added to s where the normal is only about right. Measured.
const SOFTNESS: f32 = 0.5;
/// Least s, so that (1) can be divided by it.
const LEAST_SPREAD: f32 = 1e-3;
/// Steps along each side of a block, when its extent is measured.
const STEPS: usize = 8;

/// How cells are grouped.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    width: usize,
    height: usize,
    columns: usize,
    rows: usize,
}

impl Grid {
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, columns: width.min(COLUMNS), rows: height.min(ROWS) }
    }

    /// How many blocks there are.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Columns and rows of the cells of a block.
    #[inline]
    pub fn cells(&self, block: usize) -> (Range<usize>, Range<usize>) {
        let (x, y) = (block % self.columns, block / self.columns);
        let first = |i: usize, cells: usize, blocks: usize| (i * cells).div_ceil(blocks);
        let of = |i, cells, blocks| first(i, cells, blocks)..first(i + 1, cells, blocks);
        (of(x, self.width, self.columns), of(y, self.height, self.rows))
    }

    /// The block of a cell.
    #[inline]
    pub fn block(&self, x: usize, y: usize) -> usize {
        (y * self.rows / self.height) * self.columns + x * self.columns / self.width
    }
}

/// The blocks of a map.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    /// By power.
    all: Distribution1D,
    /// For each cell of normals; `None` where nothing counts.
    surface: Vec<Option<Distribution1D>>,
    about: Vec<Option<Distribution1D>>,
}

/// Where the light of a block comes from.
struct Cap {
    axis: Vec3,
    /// s.
    spread: f32,
}

/// A block that was chosen.
pub(super) struct Chosen {
    pub block: usize,
    /// Density over that of light for all sides.
    pub worth: f32,
    /// What is left of the random numbers.
    pub rest: Vec2,
}

impl Cap {
    /// Of the unit directions at the places of a block.
    fn around(directions: impl Iterator<Item = Vec3> + Clone) -> Self {
        let axis = directions.clone().sum::<Vec3>().normalize_or(Vec3::Y);
        let nearest = directions.map(|d| d.dot(axis)).fold(1.0, f32::min);
        // Wider than a half sphere: nothing is known.
        let spread = if nearest <= 0.0 { 1.0 } else { (1.0 - nearest * nearest).sqrt() };
        Self { axis, spread: spread.max(LEAST_SPREAD) }
    }

    /// (1), with a normal that may be off by an angle of that sine.
    fn cosine(&self, normal: Vec3, softness: f32) -> f32 {
        let s = (self.spread + softness).min(1.0);
        let x = normal.dot(self.axis);
        let partly = (x + s).clamp(0.0, 2.0 * s);
        partly * partly / (4.0 * s) + (x - s).max(0.0)
    }
}

impl Blocks {
    /// From the power of each block and the unit direction at a place of the map, in cells. `None` without power.
    pub fn new(grid: &Grid, powers: &[f64], at: impl Fn(f64, f64) -> Vec3) -> Option<Self> {
        let total: f64 = powers.iter().sum();
        let powers: Vec<f32> = powers.iter().map(|p| (p / total) as f32).collect();
        let caps: Vec<Cap> = (0..grid.len())
            .map(|i| {
                let (x, y) = grid.cells(i);
                let along =
                    |r: &Range<usize>, k: usize| r.start as f64 + r.len() as f64 * k as f64 / STEPS as f64;
                let side = STEPS + 1;
                Cap::around((0..side * side).map(|k| at(along(&x, k % side), along(&y, k / side))))
            })
            .collect();
        let table = |softness: f32| {
            let of = |cell: usize| {
                let normal = middle(cell);
                let worth = |(power, cap): (&f32, &Cap)| power * cap.cosine(normal, softness + ROUNDING);
                Distribution1D::new(&powers.iter().zip(&caps).map(worth).collect::<Vec<_>>())
            };
            (0..NORMALS * NORMALS).map(of).collect()
        };
        Some(Self { all: Distribution1D::new(&powers)?, surface: table(0.0), about: table(SOFTNESS) })
    }

    #[inline]
    fn choice(&self, facing: Facing) -> Option<&Distribution1D> {
        match facing {
            Facing::All => Some(&self.all),
            Facing::Surface(n) => self.surface[cell(n)].as_ref(),
            Facing::About(n) => self.about[cell(n)].as_ref(),
        }
    }

    /// Chooses a block; `None` where none of them counts.
    #[inline]
    pub fn choose(&self, facing: Facing, u: Vec2) -> Option<Chosen> {
        let (block, probability, rest) = self.choice(facing)?.sample(u.x);
        Some(Chosen { block, worth: probability / self.all.pdf(block), rest: Vec2::new(rest, u.y) })
    }

    /// Density of a direction of a block over that of light for all sides.
    #[inline]
    pub fn worth(&self, block: usize, facing: Facing) -> f32 {
        let power = self.all.pdf(block);
        if power > 0.0 { self.choice(facing).map_or(0.0, |c| c.pdf(block) / power) } else { 0.0 }
    }
}

/// The cell of a unit normal: octahedral coordinates (Cigolle et al. 2014).
#[inline]
fn cell(n: Vec3) -> usize {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    let p = if n.z < 0.0 { folded(p) } else { p };
    let side = |x: f32| (((x * 0.5 + 0.5) * NORMALS as f32) as usize).min(NORMALS - 1);
    side(p.y) * NORMALS + side(p.x)
}

/// The direction in the middle of a cell.
fn middle(cell: usize) -> Vec3 {
    let side = |i: usize| (i as f32 + 0.5) / NORMALS as f32 * 2.0 - 1.0;
    let p = Vec2::new(side(cell % NORMALS), side(cell / NORMALS));
    let z = 1.0 - p.x.abs() - p.y.abs();
    (if z < 0.0 { folded(p) } else { p }).extend(z).normalize()
}

/// The lower half of the octahedron, folded outwards; its own inverse.
#[inline]
fn folded(p: Vec2) -> Vec2 {
    (Vec2::ONE - Vec2::new(p.y, p.x).abs()) * Vec2::ONE.copysign(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, warp};

    #[test]
    fn normals_are_turned_by_no_more_than_is_allowed_for() {
        let mut rng = SmallRng::new(1);
        let mut most: f32 = 0.0;
        for _ in 0..100_000 {
            let n = warp::uniform_sphere(rng.vec2());
            most = most.max(n.cross(middle(cell(n))).length());
            assert!(n.dot(middle(cell(n))) > 0.5);
        }
        assert!(most < ROUNDING && most > 0.8 * ROUNDING, "{most}");
    }

    #[test]
    fn cells_and_blocks_are_each_others() {
        for (width, height) in [(1, 2), (5, 3), (31, 18), (64, 33), (1024, 513)] {
            let grid = Grid::new(width, height);
            let mut cells = 0;
            for block in 0..grid.len() {
                let (x, y) = grid.cells(block);
                cells += x.len() * y.len();
                for corner in [(x.start, y.start), (x.end - 1, y.end - 1)] {
                    assert_eq!(grid.block(corner.0, corner.1), block, "{width} {height}");
                }
            }
            assert_eq!(cells, width * height);
        }
    }
}
