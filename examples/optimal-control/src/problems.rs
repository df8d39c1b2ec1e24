//! The problems that the program solves and the tests check.

use modyn::simulate::State;

use crate::lqr::{Regulator, Weights};
use crate::robots::Arm;

/// The weights of the regulator.
pub(crate) const WEIGHTS: Weights = Weights { displacement: 1.0, velocity: 0.01, effort: 0.01 };

/// Returns a regulator of the arm about a posture, for steps of 10 ms.
///
/// # Panics
///
/// Panics if the Riccati recursion does not converge, which cannot happen where the arm can be controlled.
pub(crate) fn regulator() -> Regulator<Arm> {
    let q = [0.4, 0.6, -0.3, -1.3, 0.5, 1.8, 0.2];
    Regulator::about(q, &WEIGHTS, 0.01).expect("every joint has a motor")
}

/// Returns a source of numbers uniformly distributed in [0, 1), the same on every machine: a linear congruential
/// generator.
pub(crate) fn uniform(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Returns a moving state of the arm, 0.2 rad away from a regulator's posture.
pub(crate) fn displaced(regulator: &Regulator<Arm>) -> State<Arm> {
    State {
        q: core::array::from_fn(|i| regulator.rest.q[i] + 0.2 * (2.0 * i as f64).cos()),
        qd: core::array::from_fn(|i| 0.5 * (3.0 * i as f64).sin()),
    }
}
