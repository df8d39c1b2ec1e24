//! Measures the time of a call: in the command, and as text in the program that it compiles.

use std::time::{Duration, Instant};

/// The total time of a measurement.
const MEASURING_TIME: Duration = Duration::from_millis(30);
/// The shortest pass that is measured accurately, s.
const MIN_SECONDS: f64 = 1e-4;

/// Returns the time of a call in nanoseconds; `pass` makes `calls` calls. It is the best of many
/// rounds, since other processes use the processor, too.
pub fn nanoseconds(calls: usize, mut pass: impl FnMut()) -> f64 {
    let mut passes = 1;
    let mut best = f64::INFINITY;
    let start = Instant::now();
    while start.elapsed() < MEASURING_TIME {
        let round = Instant::now();
        (0..passes).for_each(|_| pass());
        let seconds = round.elapsed().as_secs_f64();
        if seconds < MIN_SECONDS {
            passes *= 2;
        } else {
            best = best.min(seconds / f64::from(passes));
        }
    }
    best * 1e9 / calls as f64
}
