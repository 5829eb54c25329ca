//! Environment images: see `nephrite_fuzz::environments`.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fuzz_target!(
    init: nephrite_fuzz::forgive_decoders(),
    |data: &[u8]| {
        nephrite_fuzz::environments(data);
    }
);

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    nephrite_fuzz::mutate_in_place(data, size, max_size, seed, nephrite_fuzz::mutate::environments, fuzzer_mutate)
});
