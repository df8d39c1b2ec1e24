//! Times of a function with warm and with cold caches.
//!
//! Cold calls are measured by the method of `lab/benches/peers`: every line of the process's memory is flushed from all levels of the
//! caches before a call.

#[path = "../../peers/modyn-runner/src/cold.rs"]
mod cold;

use std::hint::black_box;
use std::time::Instant;

/// A form of the code of a function, measured.
pub struct Form {
    pub operations: usize,
    /// The median time of a call in ns, when the code and the data are in the caches.
    pub warm: f64,
    /// The median time of a call in ns, when the code and the data are in no cache; NaN on other processors than x86-64.
    pub cold: f64,
}

/// Returns the median of several times.
fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A state: coordinates, velocities and joint forces.
pub type State<const NQ: usize, const NV: usize> = ([f64; NQ], [f64; NV], [f64; NV]);

/// Measures a function at these states: warm over 31 repetitions of about a millisecond, cold over 401 calls.
pub fn measured<const NQ: usize, const N: usize, R>(
    operations: usize,
    states: &[State<NQ, N>],
    function: impl Fn(&[f64; NQ], &[f64; N], &[f64; N]) -> R,
) -> Form {
    let call = |state: &State<NQ, N>| {
        let (q, qd, tau) = black_box(state);
        black_box(function(q, qd, tau));
    };
    let pass = || states.iter().for_each(call);
    let start = Instant::now();
    pass();
    let passes = (1e-3 / start.elapsed().as_secs_f64()).ceil().max(1.0) as u32;
    let repetition = |_| {
        let start = Instant::now();
        (0..passes).for_each(|_| pass());
        start.elapsed().as_secs_f64() * 1e9 / (states.len() as f64 * f64::from(passes))
    };
    let warm = median((0..31).map(repetition).collect());
    let cold =
        cold::cold(states.len(), |i| call(&states[i])).map_or(f64::NAN, |[median, ..]| median);
    Form { operations, warm, cold }
}
