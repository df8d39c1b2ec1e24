//! Any text becomes a model, or errors at places of the text. Nothing panics.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use modyn_read::read;

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    modyn_fuzz::check(&text, &read(&text, "fuzz.urdf", &modyn_fuzz::read_options(choice)));
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    modyn_fuzz::mutate(data, size, max_size, seed, &modyn_fuzz::vocabulary::URDF)
});
