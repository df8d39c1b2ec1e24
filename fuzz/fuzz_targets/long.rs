//! Long texts of a few patterns are read in a thread with a small stack, by a number of steps in
//! proportion to their length. Nothing panics.
//!
//! An input is a text whose lines after the first are patterns: the start, an opening and a closing
//! pattern that are repeated, the text between them, and the end. The first line is the name of the
//! file. `#` stands for the number of the repetition. The last byte selects the number of
//! repetitions.
#![no_main]

use libfuzzer_sys::fuzz_target;
use modyn_read::internals::counted_steps;
use modyn_read::{ReadOptions, read};

/// The bytes of the stack. Depths are checked before any recursion, except that of a xacro within
/// its limits.
const STACK: usize = 256 << 10;

/// The bytes of the stack that the deepest xacro needs.
const XACRO_STACK: usize = 2 << 20;

/// The largest number of bytes of a text.
const LONGEST: usize = 1 << 20;

/// The largest number of steps for each byte: twenty misspelt names are compared with all names.
const STEPS_PER_BYTE: usize = 50;

/// The largest number of steps of any short text: the operations of a xacro.
const STEPS: usize = 2_000_000;

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    let mut lines = text.lines();
    let mut next = || lines.next().unwrap_or_default();
    let [file, start, open, close, between, end] = [(); 6].map(|()| next());
    let count = 1_usize << (choice % 18);
    let count = count.min(LONGEST / (open.len() + close.len() + 8));
    let repeated = |pattern: &str| {
        (0..count).map(|i| pattern.replace('#', &i.to_string())).collect::<String>()
    };
    let long = [start, &repeated(open), between, &repeated(close), end].concat();
    let stack = if file.ends_with(".xacro") { XACRO_STACK } else { STACK };
    let steps = modyn_fuzz::with_stack(stack, || {
        let options = ReadOptions { shapes: true, ..ReadOptions::default() };
        modyn_fuzz::check(&long, &read(&long, file, &options));
        counted_steps()
    });
    assert!(steps < STEPS + STEPS_PER_BYTE * long.len(), "{steps} steps for {} bytes", long.len());
});
