//! The hot generator of long walks: xoshiro128++ (Blackman & Vigna 2021, "Scrambled Linear Pseudorandom Number
//! Generators"), seeded through SplitMix64's finaliser (Steele et al. 2014; Stafford's variant 13).
//!
//! The state is 16 bytes and one number costs a handful of register operations. A seed is hashed to two 64-bit
//! words, so streams of neighbouring pixels and samples start at unrelated points of a period of 2¹²⁸ − 1.

/// Increment of SplitMix64, 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijective 64-bit mix in which every input bit affects every output bit (Stafford's variant 13).
#[inline]
pub fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Hashes three 32-bit words; for a fixed `seed` distinct `(a, b)` give distinct results.
#[inline]
pub fn hash3(a: u32, b: u32, seed: u32) -> u64 {
    let seed = mix64(u64::from(seed).wrapping_add(GOLDEN));
    mix64(((u64::from(a) << 32) | u64::from(b)) ^ seed)
}

/// The first state of the stream that belongs to a key.
#[inline(always)]
pub(super) fn state_of(key: u64) -> [u32; 4] {
    let a = mix64(key.wrapping_add(GOLDEN));
    let b = mix64(key.wrapping_add(GOLDEN.wrapping_mul(2)));
    // Only the zero state is a fixed point; distinct inputs of a bijection cannot both give zero.
    [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32]
}

/// A small, fast, statistically sound generator; not for cryptography.
#[derive(Clone, Debug)]
pub struct SmallRng {
    state: [u32; 4],
}

impl SmallRng {
    /// The stream that belongs to a 64-bit key; keys may be consecutive.
    #[inline]
    pub fn new(key: u64) -> Self {
        Self { state: state_of(key) }
    }

    /// The stream of sample `sample` of pixel `pixel` in a render with seed `seed`.
    #[inline]
    pub fn for_sample(pixel: u32, sample: u32, seed: u32) -> Self {
        Self::new(hash3(pixel, sample, seed))
    }

    /// 32 uniform bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let [s0, s1, s2, s3] = self.state;
        let result = s0.wrapping_add(s3).rotate_left(7).wrapping_add(s0);
        let s2 = s2 ^ s0;
        let s3 = s3 ^ s1;
        self.state = [s0 ^ s3, s1 ^ s2, s2 ^ (s1 << 9), s3.rotate_left(11)];
        result
    }

    /// Uniform in \[0, 1), a multiple of 2⁻²⁴.
    #[inline]
    pub fn f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in the open interval (0, 1), an odd multiple of 2⁻²⁴: safe as the argument of a logarithm.
    #[inline]
    pub fn open01(&mut self) -> f32 {
        ((self.next_u32() >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0)
    }

    /// Two independent numbers in \[0, 1).
    #[inline]
    pub fn vec2(&mut self) -> glam::Vec2 {
        let x = self.f32();
        glam::Vec2::new(x, self.f32())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::statistics::chi_square_z;

    #[test]
    fn first_numbers_follow_the_published_recurrence() {
        // Reference output of xoshiro128++ for the state 1, 2, 3, 4 (rand_xoshiro's test vector).
        let mut rng = SmallRng { state: [1, 2, 3, 4] };
        let expected = [641, 1573767, 3222811527, 3517856514, 836907274, 4247214768, 3867114732, 1355841295];
        for value in expected {
            assert_eq!(rng.next_u32(), value);
        }
    }

    #[test]
    fn floats_stay_inside_their_intervals() {
        for state in [[0, 0, 0, u32::MAX], [u32::MAX; 4], [0, 1, 0, 0]] {
            let mut rng = SmallRng { state };
            let mut twin = rng.clone();
            for _ in 0..1000 {
                let u = rng.f32();
                assert!((0.0..1.0).contains(&u));
                let v = twin.open01();
                assert!(v > 0.0 && v < 1.0);
            }
        }
        let top = ((u32::MAX >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0);
        assert!(top < 1.0);
    }

    #[test]
    fn a_stream_is_uniform() {
        let mut rng = SmallRng::new(7);
        let mut counts = vec![0u64; 1024];
        for _ in 0..1_000_000 {
            counts[(rng.f32() * 1024.0) as usize] += 1;
        }
        let z = chi_square_z(&counts, &[1_000_000.0 / 1024.0; 1024]);
        assert!(z.abs() < 4.0, "z = {z}");
    }

    #[test]
    fn first_numbers_of_neighbouring_streams_are_independent() {
        // Pairs (this stream, the next) binned 16×16, for neighbours in pixel, sample and seed.
        for axis in 0..3 {
            let stream = |i: u32| match axis {
                0 => SmallRng::for_sample(i, 3, 0),
                1 => SmallRng::for_sample(3, i, 0),
                _ => SmallRng::for_sample(3, 5, i),
            };
            let mut counts = vec![0u64; 256];
            let n = 200_000;
            for i in 0..n {
                let (a, b) = (stream(i).f32(), stream(i + 1).f32());
                counts[(a * 16.0) as usize * 16 + (b * 16.0) as usize] += 1;
            }
            let z = chi_square_z(&counts, &[f64::from(n) / 256.0; 256]);
            assert!(z.abs() < 4.0, "axis {axis}: z = {z}");
        }
    }

    #[test]
    fn free_flights_have_unit_mean() {
        let mut rng = SmallRng::new(1);
        let n = 1_000_000;
        let sum: f64 = (0..n).map(|_| -f64::from(rng.open01()).ln()).sum();
        let z = (sum / n as f64 - 1.0) * (n as f64).sqrt();
        assert!(z.abs() < 4.0, "z = {z}");
    }
}
