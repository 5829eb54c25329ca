//! The numbers of one sample of one pixel: Owen-scrambled Sobol first, then a cheap generator.
//!
//! Follows Burley 2020, "Practical Hash-based Owen Scrambling" (JCGT 9(4)), as the crate `sobol_burley` implements
//! it: sets of four dimensions, each set shuffled and scrambled with a seed of its own (padding, §5), and each pixel
//! with seeds of its own, so that errors of neighbouring pixels are independent.
//!
//! The first [`SOBOL_DIMENSIONS`] numbers of a sample are low-discrepancy over the sample index; later ones come from
//! the [`SmallRng`] of the same sample. The crate's sequences end at 2¹⁶ points, so every block of 65 536 samples
//! starts new ones. All numbers are functions of (pixel, sample, seed) and of nothing else.

use glam::Vec2;

use super::rng::{SmallRng, hash3, mix64};

/// How many numbers of a sample are stratified over the samples of its pixel.
pub const SOBOL_DIMENSIONS: u32 = 32;

/// log₂ of the length of one Sobol sequence.
const BLOCK_BITS: u32 = 16;

/// Numbers of one sample of one pixel, in the order in which they are asked for.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Hash of pixel, block and seed; set `s` of four dimensions is seeded by a mix of it with `s`.
    key: u64,
    /// Index in the Sobol sequence of this block.
    index: u32,
    /// The next set of four dimensions.
    set: u32,
    cache: [f32; 4],
    /// How many of `cache` have been used.
    used: u8,
    /// An odd dimension that a pair skipped, for the next single number; NaN for none.
    spare: f32,
    rng: SmallRng,
}

impl Sampler {
    /// The numbers of sample `sample_index` of pixel `pixel_index` in a render with seed `seed`.
    #[inline]
    pub fn new(pixel_index: u32, sample_index: u32, seed: u32) -> Self {
        let block = sample_index >> BLOCK_BITS;
        Self {
            key: hash3(pixel_index, block, seed),
            index: sample_index & ((1 << BLOCK_BITS) - 1),
            set: 0,
            cache: [0.0; 4],
            used: 4,
            spare: f32::NAN,
            rng: SmallRng::for_sample(pixel_index, sample_index, seed),
        }
    }

    /// The next number, in \[0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        if !self.spare.is_nan() {
            return std::mem::replace(&mut self.spare, f32::NAN);
        }
        if self.used == 4 && !self.refill() {
            return self.rng.f32();
        }
        let value = self.cache[usize::from(self.used)];
        self.used += 1;
        value
    }

    /// The next two numbers, each in \[0, 1), stratified as a pair.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        if self.used & 1 == 1 {
            // Pairs are dimensions (0, 1) or (2, 3) of a set; the odd one out serves the next single number.
            if self.spare.is_nan() {
                self.spare = self.cache[usize::from(self.used)];
            }
            self.used += 1;
        }
        if self.used == 4 && !self.refill() {
            return self.rng.vec2();
        }
        let i = usize::from(self.used);
        self.used += 2;
        Vec2::new(self.cache[i], self.cache[i + 1])
    }

    /// The generator of this sample, for walks that need many numbers. It is independent of the stratified numbers,
    /// and shared with the numbers after the first [`SOBOL_DIMENSIONS`].
    #[inline]
    pub fn rng(&mut self) -> &mut SmallRng {
        &mut self.rng
    }

    #[inline]
    fn refill(&mut self) -> bool {
        if self.set >= SOBOL_DIMENSIONS / 4 {
            return false;
        }
        let seed = (mix64(self.key.wrapping_add(u64::from(self.set))) >> 32) as u32;
        self.cache = sobol_burley::sample_4d(self.index, 0, seed);
        self.set += 1;
        self.used = 0;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::statistics::{Estimate, chi_square_z};

    #[test]
    fn numbers_depend_on_the_sample_only() {
        for (p, s, seed) in [(0, 0, 0), (123, 65_535, 1), (9, 70_000, 2), (u32::MAX, u32::MAX, u32::MAX)] {
            let (mut a, mut b) = (Sampler::new(p, s, seed), Sampler::new(p, s, seed));
            for i in 0..100 {
                let (x, y) = if i % 3 == 0 {
                    (a.next_2d(), b.next_2d())
                } else {
                    (Vec2::splat(a.next_1d()), Vec2::splat(b.next_1d()))
                };
                assert_eq!(x, y);
                assert!(x.min_element() >= 0.0 && x.max_element() < 1.0);
            }
            assert_eq!(a.rng().next_u32(), b.rng().next_u32());
        }
    }

    #[test]
    fn singles_and_pairs_never_use_a_number_twice() {
        let mut sampler = Sampler::new(5, 6, 7);
        let mut seen = Vec::new();
        for i in 0..60 {
            if (i * 7) % 3 == 0 {
                seen.push(sampler.next_1d());
            } else {
                let pair = sampler.next_2d();
                seen.extend([pair.x, pair.y]);
            }
        }
        let n = seen.len();
        seen.sort_by(f32::total_cmp);
        seen.dedup();
        // About 100 numbers of 2⁻²³ resolution: a chance repetition has probability 6e-4 for this fixed seed.
        assert_eq!(seen.len(), n);
    }

    #[test]
    fn pairs_fill_every_elementary_interval() {
        // Dimensions 0 and 1 of Sobol are a (0, 2)-sequence: 2^m consecutive aligned points put exactly one point
        // into every box 2^-a × 2^-(m-a); Owen scrambling and shuffling keep that.
        let m = 8u32;
        for first in [0u32, 256, 65_536, 131_072 + 512] {
            for skip in 0..4 {
                for a in 0..=m {
                    let (nx, ny) = (1usize << a, 1usize << (m - a));
                    let mut counts = vec![0; nx * ny];
                    for i in 0..1u32 << m {
                        let mut sampler = Sampler::new(77, first + i, 3);
                        for _ in 0..skip {
                            sampler.next_2d();
                            sampler.next_2d();
                        }
                        let p = sampler.next_2d();
                        counts[(p.x * nx as f32) as usize * ny + (p.y * ny as f32) as usize] += 1;
                    }
                    assert!(counts.iter().all(|&c| c == 1), "set {skip}, boxes {nx} × {ny}");
                }
            }
        }
    }

    #[test]
    fn every_dimension_is_stratified() {
        let n = 1024u32;
        let mut bins = vec![vec![0u32; n as usize]; SOBOL_DIMENSIONS as usize];
        for i in 0..n {
            let mut sampler = Sampler::new(4, i, 9);
            for bin in &mut bins {
                bin[(sampler.next_1d() * n as f32) as usize] += 1;
            }
        }
        assert!(bins.iter().flatten().all(|&count| count == 1));
    }

    #[test]
    fn first_samples_of_pixels_are_uniform_and_independent() {
        let n = 200_000u32;
        for dimension in [0usize, 3, 17, 40] {
            let value = |pixel: u32| {
                let mut sampler = Sampler::new(pixel, 0, 0);
                (0..=dimension).map(|_| sampler.next_1d()).last().unwrap_or_default()
            };
            let mut counts = vec![0u64; 256];
            for pixel in 0..n {
                let (a, b) = (value(pixel), value(pixel + 1));
                counts[(a * 16.0) as usize * 16 + (b * 16.0) as usize] += 1;
            }
            let z = chi_square_z(&counts, &[f64::from(n) / 256.0; 256]);
            assert!(z.abs() < 4.0, "dimension {dimension}: z = {z}");
        }
    }

    #[test]
    fn sets_of_one_pixel_are_independent() {
        // Means of dimension products over independent pixels: E[(x−½)(y−½)] = 0, variance 1/144.
        for (i, j) in [(0, 4), (0, 5), (1, 4), (3, 7), (0, 31), (0, 33), (32, 33)] {
            let mut product = Estimate::default();
            for pixel in 0..40_000 {
                let mut sampler = Sampler::new(pixel, pixel % 7, 0);
                let values: Vec<f32> = (0..=j).map(|_| sampler.next_1d()).collect();
                product.add(f64::from(values[i] - 0.5) * f64::from(values[j] - 0.5));
            }
            let z = product.mean() / product.standard_error();
            assert!(z.abs() < 4.0, "dimensions {i} and {j}: z = {z}");
        }
    }

    #[test]
    fn blocks_of_samples_are_independent() {
        let mut product = Estimate::default();
        for i in 0..65_536 {
            let (a, b) = (Sampler::new(1, i, 0).next_1d(), Sampler::new(1, i + 65_536, 0).next_1d());
            product.add(f64::from(a - 0.5) * f64::from(b - 0.5));
        }
        let z = product.mean() / product.standard_error();
        assert!(z.abs() < 4.0, "z = {z}");
    }
}
