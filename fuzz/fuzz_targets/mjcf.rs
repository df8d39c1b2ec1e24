//! Any text that is read as a `MuJoCo` model becomes a model that the compiler accepts, or errors at places of the text.
//! Nothing panics.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use modyn_read::read_mjcf;

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    let result = read_mjcf(&text, "fuzz.xml", &modyn_fuzz::read_options(choice));
    modyn_fuzz::check(&text, &result);
    // Compiling takes far longer than reading.
    if let Ok(reading) = result
        && choice >> 7 == 1
        && reading.model.nv() < 30
    {
        modyn_fuzz::compile(reading);
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    modyn_fuzz::mutate(data, size, max_size, seed, &modyn_fuzz::vocabulary::MJCF)
});
