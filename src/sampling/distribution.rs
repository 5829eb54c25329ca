//! Discrete and image distributions by inversion of their cumulative sums, which keeps the order of the entries and
//! so the stratification of the uniform numbers (an alias table would not).
//!
//! Cumulative sums are 32-bit fixed point: entry i covers the integers `cdf[i]..cdf[i + 1]`, every positive weight
//! covers at least one, and a probability is exactly `(cdf[i + 1] − cdf[i]) / 2³²`, so sampling and pdf cannot
//! disagree whatever the dynamic range. A guide table (Chen & Asau 1974) starts each search near its end.

use glam::Vec2;

use super::ONE_MINUS_EPSILON;

/// One quantum of a fixed-point cumulative sum as a probability.
const QUANTUM: f32 = 1.0 / 4_294_967_296.0;

/// Appends `weights.len() + 1` fixed-point cumulative sums from 0 to `u32::MAX`; returns the total weight, or `None`
/// (with the output untouched) where the total is not positive and finite.
fn push_cdf(weights: &[f64], out: &mut [u32]) -> Option<f64> {
    let total: f64 = weights.iter().sum();
    let positive = weights.iter().filter(|&&w| w > 0.0).count();
    if !(total > 0.0 && total.is_finite()) || positive >= u32::MAX as usize {
        return None;
    }
    // Each positive weight gets one quantum, the others are shared out in proportion.
    let shared = (u64::from(u32::MAX) - positive as u64) as f64;
    let (mut sum, mut count) = (0.0, 0u64);
    for (i, &w) in weights.iter().enumerate() {
        out[i] = ((sum / total * shared) as u64 + count) as u32;
        if w > 0.0 {
            sum += w;
            count += 1;
        }
    }
    out[weights.len()] = u32::MAX;
    // Zero weights at the end must not inherit the rounding of the sum.
    for i in (0..weights.len()).rev().take_while(|&i| weights[i] <= 0.0) {
        out[i] = u32::MAX;
    }
    Some(total)
}

/// log₂ of the number of guide cells for `n` entries: one cell for two to four entries.
fn guide_bits(n: usize) -> u32 {
    (n / 2).max(1).ilog2()
}

/// Fills guide cells with the entry that holds the first key of the cell.
fn fill_guide(cdf: &[u32], bits: u32, guide: &mut [u32]) {
    let mut entry = 0;
    for (cell, first) in guide.iter_mut().enumerate() {
        let key = ((cell as u64) << (32 - bits)).min(u64::from(u32::MAX - 1)) as u32;
        while cdf[entry + 1] <= key {
            entry += 1;
        }
        *first = entry as u32;
    }
}

/// The entry `i` with `cdf[i] ≤ key < cdf[i + 1]`, which always has a positive probability.
#[inline]
fn search(cdf: &[u32], guide: &[u32], bits: u32, key: u32) -> usize {
    let cell = (u64::from(key) >> (32 - bits)) as usize;
    let mut low = guide[cell] as usize;
    let mut high = guide[cell + 1] as usize + 1;
    while high - low > 1 {
        let middle = (low + high) / 2;
        if cdf[middle] <= key {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The key of a uniform number in \[0, 1).
#[inline]
fn key_of(u: f32) -> u32 {
    ((u * 4_294_967_296.0) as u32).min(u32::MAX - 1)
}

#[inline]
fn remap(cdf: &[u32], i: usize, key: u32) -> f32 {
    ((key - cdf[i]) as f32 / (cdf[i + 1] - cdf[i]) as f32).min(ONE_MINUS_EPSILON)
}

/// A discrete distribution over `0..len`, equivalently a piecewise-constant density on \[0, 1).
#[derive(Clone, Debug)]
pub struct Distribution1D {
    cdf: Vec<u32>,
    guide: Vec<u32>,
    bits: u32,
    total: f64,
}

impl Distribution1D {
    /// Builds from weights; negative and NaN weights count as zero. `None` if the sum is not positive and finite.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let weights: Vec<f64> = weights.iter().map(|&w| f64::from(w).max(0.0)).collect();
        Self::from_f64(&weights)
    }

    fn from_f64(weights: &[f64]) -> Option<Self> {
        let mut cdf = vec![0; weights.len() + 1];
        let total = push_cdf(weights, &mut cdf)?;
        let bits = guide_bits(weights.len());
        let mut guide = vec![0; (1 << bits) + 1];
        fill_guide(&cdf, bits, &mut guide);
        Some(Self { cdf, guide, bits, total })
    }

    /// How many entries there are.
    pub fn len(&self) -> usize {
        self.cdf.len() - 1
    }

    /// Never: an empty distribution cannot be built.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// An index, its probability, and a number uniform in \[0, 1) made from what `u` has left. Monotone in `u`.
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32, f32) {
        let key = key_of(u);
        let i = search(&self.cdf, &self.guide, self.bits, key);
        (i, (self.cdf[i + 1] - self.cdf[i]) as f32 * QUANTUM, remap(&self.cdf, i, key))
    }

    /// Probability of an index; zero outside the table.
    #[inline]
    pub fn pdf(&self, index: usize) -> f32 {
        if index < self.len() { (self.cdf[index + 1] - self.cdf[index]) as f32 * QUANTUM } else { 0.0 }
    }
}

/// A cell that [`Distribution2D`] chose.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Probability of the cell.
    pub probability: f32,
    /// What is left of the uniform numbers, again uniform in \[0, 1)².
    pub rest: Vec2,
}

/// A piecewise-constant density on the unit square, `width × height` cells, row 0 at v = 0.
#[derive(Clone, Debug)]
pub struct Distribution2D {
    width: usize,
    rows: Distribution1D,
    /// `width + 1` sums a row; rows without weight hold zeros and are never chosen.
    cdf: Vec<u32>,
    guide: Vec<u32>,
    bits: u32,
}

impl Distribution2D {
    /// Builds from a weight for every cell, `weight_row(y, row)` filling the `width` weights of row `y`. Weights must be
    /// ≥ 0; `None` if `width` or `height` is zero or the sum is not positive and finite. Rows are built in parallel;
    /// the result does not depend on that.
    pub fn new(width: usize, height: usize, weight_row: impl Fn(usize, &mut [f64]) + Sync) -> Option<Self> {
        use rayon::prelude::*;
        if width == 0 || height == 0 {
            return None;
        }
        let bits = guide_bits(width);
        let guide_width = (1usize << bits) + 1;
        let mut cdf = vec![0; (width + 1) * height];
        let mut guide = vec![0; guide_width * height];
        let totals: Vec<f64> = cdf
            .par_chunks_mut(width + 1)
            .zip(guide.par_chunks_mut(guide_width))
            .enumerate()
            .map_init(
                || vec![0.0; width],
                |weights, (y, (cdf, guide))| {
                    weights.fill(0.0);
                    weight_row(y, weights);
                    let total = push_cdf(weights, cdf).unwrap_or(0.0);
                    if total > 0.0 {
                        fill_guide(cdf, bits, guide);
                    }
                    total
                },
            )
            .collect();
        Some(Self { width, rows: Distribution1D::from_f64(&totals)?, cdf, guide, bits })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.rows.len()
    }

    /// The sum of the weights.
    pub fn total(&self) -> f64 {
        self.rows.total()
    }

    /// Chooses a cell. Monotone in `u.y`, and for one row in `u.x`.
    #[inline]
    pub fn sample_cell(&self, u: Vec2) -> Cell {
        let (y, row_probability, rest_y) = self.rows.sample(u.y);
        let cdf = &self.cdf[y * (self.width + 1)..(y + 1) * (self.width + 1)];
        let guide_width = (1usize << self.bits) + 1;
        let guide = &self.guide[y * guide_width..(y + 1) * guide_width];
        let key = key_of(u.x);
        let x = search(cdf, guide, self.bits, key);
        let probability = row_probability * ((cdf[x + 1] - cdf[x]) as f32 * QUANTUM);
        Cell { x, y, probability, rest: Vec2::new(remap(cdf, x, key), rest_y) }
    }

    /// Probability of a cell; zero outside the grid.
    #[inline]
    pub fn cell_probability(&self, x: usize, y: usize) -> f32 {
        if x >= self.width {
            return 0.0;
        }
        let row = self.rows.pdf(y);
        if row == 0.0 {
            return 0.0;
        }
        let i = y * (self.width + 1) + x;
        row * ((self.cdf[i + 1] - self.cdf[i]) as f32 * QUANTUM)
    }

    /// A point of the unit square, its density, and its cell (column, row).
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32, [usize; 2]) {
        let cell = self.sample_cell(u);
        let size = Vec2::new(self.width as f32, self.height() as f32);
        let uv = (Vec2::new(cell.x as f32, cell.y as f32) + cell.rest) / size;
        (uv.min(Vec2::splat(ONE_MINUS_EPSILON)), cell.probability * size.x * size.y, [cell.x, cell.y])
    }

    /// The density at a point of the unit square.
    #[inline]
    pub fn pdf(&self, uv: Vec2) -> f32 {
        let (w, h) = (self.width, self.height());
        let x = ((uv.x * w as f32).max(0.0) as usize).min(w - 1);
        let y = ((uv.y * h as f32).max(0.0) as usize).min(h - 1);
        self.cell_probability(x, y) * w as f32 * h as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{SmallRng, statistics::chi_square_z};

    #[test]
    fn one_dimension_matches_its_weights() {
        let mut rng = SmallRng::new(3);
        for n in [1usize, 2, 3, 5, 64, 1000] {
            let mut weights: Vec<f32> = (0..n).map(|_| rng.f32().powi(6)).collect();
            if n > 3 {
                weights[0] = 0.0;
                weights[2] = 0.0;
                weights[n - 1] = 0.0;
            }
            let d = Distribution1D::new(&weights).unwrap();
            let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
            assert!((d.total() - total).abs() <= 1e-12 * total);
            let pdf_sum: f64 = (0..n).map(|i| f64::from(d.pdf(i))).sum();
            assert!((pdf_sum - 1.0).abs() < 1e-6);
            let mut counts = vec![0u64; n];
            let samples = 300_000;
            let mut last = 0;
            for k in 0..samples {
                let (i, pdf, rest) = d.sample(k as f32 / samples as f32);
                assert!(i >= last && (0.0..1.0).contains(&rest));
                assert_eq!(pdf, d.pdf(i));
                assert!(weights[i] > 0.0);
                last = i;
                counts[d.sample(rng.f32()).0] += 1;
            }
            if n > 1 {
                let expected: Vec<f64> =
                    weights.iter().map(|&w| f64::from(w) / total * f64::from(samples)).collect();
                let z = chi_square_z(&counts, &expected);
                assert!(z.abs() < 4.0, "n = {n}: z = {z}");
            }
        }
    }

    #[test]
    fn tiny_weights_keep_a_probability_and_zeros_have_none() {
        let d = Distribution1D::new(&[0.0, 1e-30, 1.0, 1e-30, 0.0]).unwrap();
        assert_eq!((d.pdf(0), d.pdf(4), d.pdf(5)), (0.0, 0.0, 0.0));
        assert!(d.pdf(1) > 0.0 && d.pdf(3) > 0.0);
        assert_eq!(d.sample(0.0).0, 1);
        for u in [1e-9, 0.5, ONE_MINUS_EPSILON] {
            assert_eq!(d.sample(u).0, 2);
        }
        assert!(Distribution1D::new(&[]).is_none());
        assert!(Distribution1D::new(&[0.0, f32::NAN, -1.0]).is_none());
        assert!(Distribution1D::new(&[f32::INFINITY]).is_none());
    }

    #[test]
    fn two_dimensions_match_their_weights() {
        let (w, h) = (13, 7);
        let weight = |x: usize, y: usize| {
            if y == 3 || (x == 5 && y == 1) { 0.0 } else { 1.0 + ((x * 31 + y * 17) % 11) as f64 }
        };
        let d = Distribution2D::new(w, h, |y, row| {
            for (x, value) in row.iter_mut().enumerate() {
                *value = weight(x, y);
            }
        })
        .unwrap();
        let mut rng = SmallRng::new(5);
        let n = 500_000;
        let mut counts = vec![0u64; w * h];
        let mut rest_counts = vec![0u64; 64];
        for _ in 0..n {
            let u = rng.vec2();
            let (uv, pdf, [x, y]) = d.sample(u);
            assert!(
                (pdf - d.pdf(uv)).abs() < 1e-5 * pdf
                    || (uv * Vec2::new(13.0, 7.0)).fract().min_element() < 1e-5
            );
            counts[y * w + x] += 1;
            let rest = d.sample_cell(u).rest;
            rest_counts[(rest.x * 8.0) as usize * 8 + (rest.y * 8.0) as usize] += 1;
        }
        let expected: Vec<f64> =
            (0..w * h).map(|i| weight(i % w, i / w) / d.total() * f64::from(n)).collect();
        let z = chi_square_z(&counts, &expected);
        assert!(z.abs() < 4.0, "z = {z}");
        let z = chi_square_z(&rest_counts, &[f64::from(n) / 64.0; 64]);
        assert!(z.abs() < 4.0, "rest: z = {z}");
        let mean_pdf: f64 = (0..w * h)
            .map(|i| {
                let uv = Vec2::new(((i % w) as f32 + 0.5) / w as f32, ((i / w) as f32 + 0.5) / h as f32);
                f64::from(d.pdf(uv)) / (w * h) as f64
            })
            .sum();
        assert!((mean_pdf - 1.0).abs() < 1e-6);
    }
}
