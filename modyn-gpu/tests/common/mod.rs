//! Robots and numbers of the tests. No test uses all of them.
#![allow(dead_code)]

use std::path::Path;

use modyn_codegen::Builder;

/// Returns the builder of a robot of the repository.
pub fn robot(name: &str) -> Builder {
    Builder::new()
        .urdf(Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robots/{name}.urdf")))
}

/// Returns numbers in [-1, 1).
pub fn numbers(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    // In single precision, so that both sides start from the same numbers.
    (0..count).map(|_| f64::from(next() as f32)).collect()
}

/// Returns states by columns: scalar `j` of state `i` of `n` at `j n + i`.
pub fn columns(states: &[Vec<f64>]) -> Vec<f32> {
    let scalars = states[0].len();
    (0..scalars).flat_map(|j| states.iter().map(move |state| state[j] as f32)).collect()
}
