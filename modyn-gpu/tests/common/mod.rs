//! Numbers of the tests.

use crate::random::Random;

/// Returns numbers in [-1, 1), in single precision, so that both sides start from the same numbers.
pub fn numbers(count: usize) -> Vec<f64> {
    let mut random = Random::new(1);
    (0..count).map(|_| f64::from(random.between(-1.0, 1.0) as f32)).collect()
}

/// Returns states by columns: scalar `j` of state `i` of `n` at `j n + i`.
pub fn columns(states: &[Vec<f64>]) -> Vec<f32> {
    let scalars = states[0].len();
    (0..scalars).flat_map(|j| states.iter().map(move |state| state[j] as f32)).collect()
}
