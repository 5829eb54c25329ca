//! Decoders of other people that meet hostile bytes: a panic inside one becomes a message.
//!
//! The decoders in use are safe Rust, and their authors mean them not to panic. Should one do so all the same, what it
//! was working on is thrown away with it, so that nothing half-done is seen afterwards.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs a decoder whose work nothing else shares.
///
/// # Errors
/// What the decoder says, or that it panicked.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err("the decoder gave up on the data, which are broken".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_becomes_a_message() {
        assert_eq!(guarded(|| Ok(1)), Ok(1));
        assert_eq!(guarded(|| Err::<u8, _>("no".to_owned())), Err("no".to_owned()));
        let empty: Vec<u8> = Vec::new();
        assert!(guarded(|| Ok(empty[empty.len()])).is_err());
    }
}
