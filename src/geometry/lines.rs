//! One piece of memory for the nodes and the leaves of a hierarchy, in lines of the cache.
//!
//! A node is followed by its leaves, and then by what is below its children, depth first. In a large mesh almost every
//! step to a node near the leaves, or to a leaf, misses the caches; what is visited together now shares a page, so that
//! it does not miss the table of pages besides.

/// Bytes of a line.
const LINE: usize = 64;

/// A line of the cache.
#[derive(Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Line([u32; LINE / size_of::<u32>()]);

impl Line {
    pub const ZERO: Self = Self([0; 16]);
}

/// What can lie in lines.
///
/// # Safety
///
/// The type has no padding, fills whole lines, is aligned to them, and whatever bits it has are a value.
pub(super) unsafe trait Lined: Copy {
    /// Number of lines that it fills.
    const LINES: usize = {
        assert!(align_of::<Self>() == LINE && size_of::<Self>().is_multiple_of(LINE));
        size_of::<Self>() / LINE
    };
}

/// The value that starts at a line.
#[inline(always)]
pub(super) fn get<T: Lined>(lines: &[Line], at: u32) -> &T {
    let at = at as usize;
    assert!(at + T::LINES <= lines.len());
    // SAFETY: those lines are there, they have the alignment of the value, and any bits will do.
    unsafe { &*lines.as_ptr().add(at).cast() }
}

/// The value that starts at a line, to be changed.
pub(super) fn get_mut<T: Lined>(lines: &mut [Line], at: u32) -> &mut T {
    let lines = &mut lines[at as usize..][..T::LINES];
    // SAFETY: as for `get`; there is no padding, so that lines stay initialized.
    unsafe { &mut *lines.as_mut_ptr().cast() }
}

/// Asks for the memory of a child that will be visited soon: of a node all of it, of a leaf some more.
#[inline(always)]
pub(super) fn prefetch(lines: *const Line, at: u32) {
    /// Those of a node.
    const COUNT: usize = 4;
    let start = lines.wrapping_add(at as usize);
    #[cfg(all(target_arch = "x86_64", target_feature = "sse"))]
    for line in 0..COUNT {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch has no effect on what a program computes, wherever it points.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line).cast()) };
    }
    #[cfg(not(all(target_arch = "x86_64", target_feature = "sse")))]
    let _ = start;
}
