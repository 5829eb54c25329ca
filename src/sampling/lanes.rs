//! Eight generators side by side: one step of all is a few vector operations.
//!
//! A long walk wants more random numbers than anything else, and a generator is a chain of operations that wait for
//! each other. Eight chains of xoshiro128++ ([`super::SmallRng`]) run at once, which the compiler makes vectors of.

use super::rng::{SmallRng, state_of};

/// Number of generators.
pub const LANES: usize = 8;

/// Eight streams.
#[derive(Clone, Debug)]
pub struct WideRng {
    state: [[u32; LANES]; 4],
}

impl WideRng {
    /// Streams of their own, which a generator chooses among 2⁶⁴.
    #[inline]
    pub fn new(rng: &mut SmallRng) -> Self {
        let key = u64::from(rng.next_u32()) << 32 | u64::from(rng.next_u32());
        let mut state = [[0; LANES]; 4];
        for lane in 0..LANES {
            let words = state_of(key.wrapping_add(lane as u64));
            for (row, word) in state.iter_mut().zip(words) {
                row[lane] = word;
            }
        }
        Self { state }
    }

    /// 32 uniform bits from each stream.
    #[inline(always)]
    pub fn next_u32(&mut self) -> [u32; LANES] {
        let mut result = [0; LANES];
        let [s0, s1, s2, s3] = &mut self.state;
        for i in 0..LANES {
            result[i] = s0[i].wrapping_add(s3[i]).rotate_left(7).wrapping_add(s0[i]);
            let (a, b) = (s2[i] ^ s0[i], s3[i] ^ s1[i]);
            let low = s1[i] << 9;
            (s1[i], s0[i]) = (s1[i] ^ a, s0[i] ^ b);
            (s2[i], s3[i]) = (a ^ low, b.rotate_left(11));
        }
        result
    }

    /// Uniform in \[0, 1), multiples of 2⁻²⁴.
    #[inline(always)]
    pub fn f32(&mut self) -> [f32; LANES] {
        let (bits, mut numbers) = (self.next_u32(), [0.0; LANES]);
        for (number, bits) in numbers.iter_mut().zip(bits) {
            *number = (bits >> 8) as f32 * (1.0 / 16_777_216.0);
        }
        numbers
    }

    /// Uniform in the open interval (0, 1), odd multiples of 2⁻²⁴.
    #[inline(always)]
    pub fn open01(&mut self) -> [f32; LANES] {
        let (bits, mut numbers) = (self.next_u32(), [0.0; LANES]);
        for (number, bits) in numbers.iter_mut().zip(bits) {
            *number = ((bits >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0);
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lane_is_a_generator_of_its_own() {
        let mut source = SmallRng::new(5);
        let mut twin = source.clone();
        let key = u64::from(twin.next_u32()) << 32 | u64::from(twin.next_u32());
        let mut wide = WideRng::new(&mut source);
        let mut single: Vec<SmallRng> = (0..LANES as u64).map(|lane| SmallRng::new(key + lane)).collect();
        for _ in 0..100 {
            let expected: Vec<u32> = single.iter_mut().map(SmallRng::next_u32).collect();
            assert_eq!(wide.next_u32().to_vec(), expected);
        }
    }
}
