//! Calls whose code and data are in no cache, as `../cpp/cold.hpp` measures them.
//!
//! Between two calls, every line of the process's memory is flushed from all levels of the caches: the code of the program
//! and of its libraries, constants, states and results. A control loop that runs once a millisecond comes close to it,
//! since other programs use the caches meanwhile.
//!
//! Unsafe, since `clflush` takes an address: each address is in a mapping that `/proc/self/maps` names as readable, and
//! this thread, the only one, unmaps none between the list and the flush.

use std::hint::black_box;
use std::time::Instant;

/// The number of calls.
const CALLS: usize = 401;

/// Returns the readable mappings of this process, without the pages of the kernel, which the clock reads.
fn mappings() -> Vec<std::ops::Range<usize>> {
    let text = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let mapping = |line: &str| {
        let mut words = line.split_whitespace();
        let (begin, end) = words.next()?.split_once('-')?;
        let readable = words.next()?.starts_with('r');
        let name = words.nth(3).unwrap_or_default();
        let kernel = name.starts_with("[v");
        let address = |digits| usize::from_str_radix(digits, 16).ok();
        (readable && !kernel).then_some(address(begin)?..address(end)?)
    };
    text.lines().filter_map(mapping).collect()
}

/// Flushes the mappings from all caches.
#[cfg(target_arch = "x86_64")]
fn flush(mappings: &[std::ops::Range<usize>]) {
    use std::arch::x86_64::{_mm_clflush, _mm_mfence};
    for address in mappings.iter().cloned().flat_map(|mapping| mapping.step_by(64)) {
        // SAFETY: the address is in a readable mapping (see the head of this file).
        unsafe { _mm_clflush(address as *const u8) };
    }
    // SAFETY: every x86-64 processor has this instruction.
    unsafe { _mm_mfence() };
}

/// Returns the median, the 99th percentile and the largest time of a call with empty caches, ns, each less the median time of the
/// clock; `None` on other processors than x86-64 and other systems than Linux. `call(i)` computes at state i of `states`.
pub fn cold(states: usize, mut call: impl FnMut(usize)) -> Option<[f64; 3]> {
    #[cfg(target_arch = "x86_64")]
    {
        let mappings = mappings();
        let times = |call: &mut dyn FnMut(usize)| {
            let one = |i: usize| {
                flush(&mappings);
                // The code of the clock is in the caches again.
                black_box((Instant::now(), Instant::now()));
                let start = Instant::now();
                call(i % states);
                start.elapsed().as_secs_f64() * 1e9
            };
            let mut times: Vec<f64> = (0..CALLS).map(one).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        let clock = times(&mut |_| {})[CALLS / 2];
        let times = times(&mut call);
        let found = [CALLS / 2, CALLS * 99 / 100, CALLS - 1].map(|k| times[k] - clock);
        (!mappings.is_empty()).then_some(found)
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = (states, &mut call);
        None
    }
}
