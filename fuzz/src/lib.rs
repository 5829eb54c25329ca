//! What is fuzzed, and how its input is changed: shared by the targets of libFuzzer in `fuzz_targets/` and by the ordinary
//! tests of the main crate (`tests/fuzz/`), which run the same bodies over the same corpus.
//!
//! A body takes any bytes and returns, or panics: what panics, hangs, or takes more memory than it may is a finding. What
//! comes out of a load is held against what every scene must keep ([`sound`]), and small scenes are rendered.

pub mod bodies;
pub mod dictionary;
pub mod mutate;
pub mod sound;

pub use bodies::{environments, extensions, loader, payloads};

/// A panic inside of a decoder of other people is caught by the loader and is no finding; libFuzzer's hook would end the
/// program before it is caught.
pub fn forgive_decoders() {
    let strict = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let file = info.location().map_or("", |l| l.file());
        let theirs = file.contains("/registry/src/") || file.contains("/library/");
        if !theirs {
            strict(info);
        }
    }));
}

/// A structured mutation three times out of four, else one of libFuzzer's own; the new size.
pub fn mutate_in_place(
    data: &mut [u8],
    size: usize,
    max_size: usize,
    seed: u32,
    structured: fn(&[u8], u64) -> Option<Vec<u8>>,
    plain: fn(&mut [u8], usize, usize) -> usize,
) -> usize {
    if !seed.is_multiple_of(4)
        && let Some(changed) = structured(&data[..size], u64::from(seed))
        && changed.len() <= max_size
    {
        data[..changed.len()].copy_from_slice(&changed);
        return changed.len();
    }
    plain(data, size, max_size)
}
