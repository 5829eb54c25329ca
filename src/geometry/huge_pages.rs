//! Memory in pages of 2 MiB.
//!
//! A ray touches nodes and triangles all over a large mesh. With pages of 4 KiB most of these places need a walk through
//! the page table besides the access itself; Linux gives larger pages to memory that asks for them before it is first
//! touched. It is advice: nothing depends on whether it is taken.

/// Memory below this size is not worth a large page.
const LEAST: usize = 1 << 21;

/// An empty vector with room for `capacity` elements.
pub(super) fn with_huge_pages<T>(capacity: usize) -> Vec<T> {
    let vector = Vec::<T>::with_capacity(capacity);
    if capacity * size_of::<T>() >= LEAST {
        advise(vector.as_ptr().cast(), capacity * size_of::<T>());
    }
    vector
}

#[cfg(target_os = "linux")]
fn advise(start: *const u8, bytes: usize) {
    use std::ffi::{c_int, c_void};
    unsafe extern "C" {
        fn madvise(start: *mut c_void, bytes: usize, advice: c_int) -> c_int;
    }
    /// `MADV_HUGEPAGE` of `<sys/mman.h>`.
    const HUGE_PAGE: c_int = 14;
    /// Addresses must be multiples of the page size; 64 KiB is one on every architecture.
    const PAGE: usize = 1 << 16;
    let skip = start.align_offset(PAGE);
    if skip < bytes {
        // SAFETY: the range lies within one allocation; the advice changes neither its content nor its protection.
        unsafe {
            madvise(start.wrapping_add(skip).cast_mut().cast(), (bytes - skip) & !(PAGE - 1), HUGE_PAGE)
        };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise(_: *const u8, _: usize) {}
