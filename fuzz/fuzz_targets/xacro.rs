//! Any xacro is expanded to well-formed XML, or refused at places of the text. Nothing panics, and everything ends.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use modyn_read::{Format, expand_xacro};

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    let options = modyn_fuzz::read_options(choice);
    let is_read = Format::Xacro.read(&text, "fuzz.xacro", &options).is_ok();
    match expand_xacro(&text, "fuzz.xacro", &options) {
        // The text of an expansion is a URDF without xacro, which is read as the xacro is.
        Ok((urdf, _)) => {
            let urdf_is_read = Format::Urdf.read(&urdf, "fuzz.urdf", &options).is_ok();
            assert_eq!(is_read, urdf_is_read, "{urdf}");
        }
        Err(found) => assert!(!is_read && found.has_errors()),
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    modyn_fuzz::mutate(data, size, max_size, seed, &modyn_fuzz::vocabulary::XACRO)
});
