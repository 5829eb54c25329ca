//! Whether there is memory for what is about to be made. A vector that cannot grow ends the program without a word about
//! why, so the largest tables are asked for before they are made, where their sizes are known.

/// Whether the system would give so many bytes now, as far as it tells before they are used: it does so where a limit is set
/// (`ulimit -v`, a job's limit of address space), and not where it promises more than it has.
pub(crate) fn is_there(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|n| Vec::<u8>::new().try_reserve_exact(n).is_ok())
}

#[cfg(test)]
mod tests {
    #[test]
    fn there_is_room_for_little_and_not_for_everything() {
        assert!(super::is_there(0) && super::is_there(1 << 20));
        assert!(!super::is_there(u64::MAX) && !super::is_there(1 << 62));
    }
}
