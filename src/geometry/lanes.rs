//! Eight `f32` at a time: the vocabulary in which the traversal kernels are written once.
//!
//! [`Portable`] is plain arrays; `Avx2` is one register through `std::arch`. Both round alike, operation by
//! operation, so that kernels give the same bits with either; the tests compare them. [`Native`] is the one that
//! this build uses.

/// Number of lanes.
pub(super) const WIDTH: usize = 8;

/// A vector of eight `f32` and the operations of the kernels.
///
/// `min` and `max` are those of x86: the second operand where either is NaN or both are zeros.
pub(super) trait Lanes: Copy {
    /// One truth value a lane.
    type Mask: Copy;
    /// One index below sixteen a lane.
    type Indices: Copy;

    fn splat(x: f32) -> Self;
    fn load(x: &[f32; WIDTH]) -> Self;
    /// Four numbers, then zeros.
    fn load_half(x: &[f32; WIDTH / 2]) -> Self;
    fn store(self) -> [f32; WIDTH];
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    /// `self * b + c`, rounded once.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, rounded once.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    fn min(self, b: Self) -> Self;
    fn max(self, b: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn lt(self, b: Self) -> Self::Mask;
    fn le(self, b: Self) -> Self::Mask;
    /// `a` where the mask is set, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Lane i as bit i.
    fn bits(mask: Self::Mask) -> u32;
    /// Lane i has bits 4 i to 4 i + 3.
    fn indices(nibbles: u32) -> Self::Indices;
    /// Lane `at` of the sixteen of `low` and `high`.
    fn pick(low: Self, high: Self, at: Self::Indices) -> Self;
}

/// Eight lanes as an array.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "the twin is only used by tests where the machine has AVX2")]
pub(super) struct Portable([f32; WIDTH]);

impl Portable {
    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], b.0[i])))
    }
}

impl Lanes for Portable {
    type Mask = [bool; WIDTH];
    type Indices = [usize; WIDTH];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; WIDTH])
    }
    #[inline(always)]
    fn load(x: &[f32; WIDTH]) -> Self {
        Self(*x)
    }
    #[inline(always)]
    fn load_half(x: &[f32; WIDTH / 2]) -> Self {
        Self(std::array::from_fn(|i| x.get(i).copied().unwrap_or(0.0)))
    }
    #[inline(always)]
    fn store(self) -> [f32; WIDTH] {
        self.0
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        self.zip(b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self.zip(b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        self.zip(b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        self.zip(b, |a, b| a / b)
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].mul_add(b.0[i], c.0[i])))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(std::array::from_fn(|i| (-self.0[i]).mul_add(b.0[i], c.0[i])))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.zip(b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.zip(b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] < b.0[i])
    }
    #[inline(always)]
    fn le(self, b: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] <= b.0[i])
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|i| if mask[i] { a.0[i] } else { b.0[i] }))
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        mask.iter().enumerate().fold(0, |bits, (i, &set)| bits | (u32::from(set) << i))
    }
    #[inline(always)]
    fn indices(nibbles: u32) -> Self::Indices {
        std::array::from_fn(|i| (nibbles >> (4 * i)) as usize & 15)
    }
    #[inline(always)]
    fn pick(low: Self, high: Self, at: Self::Indices) -> Self {
        Self(at.map(|i| if i < WIDTH { low.0[i & 7] } else { high.0[i & 7] }))
    }
}

/// The lanes of this build.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub(super) type Native = Portable;
/// The lanes of this build.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
pub(super) type Native = avx2::Avx2;

#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
mod avx2 {
    use super::{Lanes, WIDTH};
    use std::arch::x86_64::*;

    /// Eight lanes in one register.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Avx2(__m256);

    // Every intrinsic below belongs to AVX, AVX2 or FMA, which the `cfg` above makes part of the whole build; that of
    // AVX-512 has a `cfg` of its own.
    impl Lanes for Avx2 {
        type Mask = __m256;
        type Indices = __m256i;

        #[inline(always)]
        fn splat(x: f32) -> Self {
            Self(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(x: &[f32; WIDTH]) -> Self {
            // SAFETY: the reference is to eight floats, and the load asks for no alignment.
            Self(unsafe { _mm256_loadu_ps(x.as_ptr()) })
        }
        #[inline(always)]
        fn load_half(x: &[f32; WIDTH / 2]) -> Self {
            // SAFETY: the reference is to four floats, and the load asks for no alignment.
            Self(unsafe { _mm256_zextps128_ps256(_mm_loadu_ps(x.as_ptr())) })
        }
        #[inline(always)]
        fn store(self) -> [f32; WIDTH] {
            let mut out = [0.0; WIDTH];
            // SAFETY: `out` is eight floats, and the store asks for no alignment.
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn add(self, b: Self) -> Self {
            Self(unsafe { _mm256_add_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn sub(self, b: Self) -> Self {
            Self(unsafe { _mm256_sub_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn mul(self, b: Self) -> Self {
            Self(unsafe { _mm256_mul_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn div(self, b: Self) -> Self {
            Self(unsafe { _mm256_div_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm256_sqrt_ps(self.0) })
        }
        #[inline(always)]
        fn mul_add(self, b: Self, c: Self) -> Self {
            Self(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn neg_mul_add(self, b: Self, c: Self) -> Self {
            Self(unsafe { _mm256_fnmadd_ps(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn min(self, b: Self) -> Self {
            Self(unsafe { _mm256_min_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn max(self, b: Self) -> Self {
            Self(unsafe { _mm256_max_ps(self.0, b.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn lt(self, b: Self) -> Self::Mask {
            unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, b.0) }
        }
        #[inline(always)]
        fn le(self, b: Self) -> Self::Mask {
            unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, b.0) }
        }
        #[inline(always)]
        fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
            Self(unsafe { _mm256_blendv_ps(b.0, a.0, mask) })
        }
        #[inline(always)]
        fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
            unsafe { _mm256_and_ps(a, b) }
        }
        #[inline(always)]
        fn bits(mask: Self::Mask) -> u32 {
            (unsafe { _mm256_movemask_ps(mask) }) as u32
        }
        #[inline(always)]
        fn indices(nibbles: u32) -> Self::Indices {
            // The bits above are those of other lanes, and `pick` does not look at them.
            unsafe {
                let shifts = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
                _mm256_srlv_epi32(_mm256_set1_epi32(nibbles as i32), shifts)
            }
        }
        #[inline(always)]
        fn pick(low: Self, high: Self, at: Self::Indices) -> Self {
            #[cfg(all(target_feature = "avx512f", target_feature = "avx512vl"))]
            return Self(unsafe { _mm256_permutex2var_ps(low.0, at, high.0) });
            #[cfg(not(all(target_feature = "avx512f", target_feature = "avx512vl")))]
            unsafe {
                let (low, high) = (_mm256_permutevar8x32_ps(low.0, at), _mm256_permutevar8x32_ps(high.0, at));
                Self(_mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32::<28>(at))))
            }
        }
    }
}
