//! The problems that the program solves and the tests check.

use modyn::simulate::{Gains, Reference, SolvedStep, State};
use modyn::{ContactSurface, StepSettings};

use crate::lqr::{Regulator, Weights};
use crate::robots::{Arm, Quadruped, standing};

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

/// The gains of the whole-body controller.
pub(crate) const GAINS: Gains = Gains { kp: 400.0, kd: 40.0 };

/// The ground of the simulation, nearly rigid.
const GROUND: StepSettings<f64, [ContactSurface<f64>; 4]> = StepSettings {
    surfaces: [ContactSurface {
        solref: [0.001, 1.0],
        solimp: [0.99, 0.999, 0.0005, 0.5],
        ..ContactSurface::<f64>::GROUND
    }; 4],
    ..StepSettings::<f64, [ContactSurface<f64>; 4]>::DEFAULT
};

/// Returns the quadruped after `duration` (s) on the ground of the simulation, which pushes and does not pull, and lets
/// feet slip and leave. The torques are constant; the steps of 0.5 ms suit the time constant of the contacts.
pub(crate) fn move_on_ground(
    state: &State<Quadruped>,
    duration: f64,
    tau: &[f64; 18],
) -> SolvedStep<Quadruped> {
    const STEP: f64 = 0.0005;
    let steps = (duration / STEP).round() as usize;
    let step = state.step(STEP, tau, &GROUND);
    (1..steps).fold(step, |step, _| step.step(STEP, tau, &GROUND))
}

/// A periodic motion of the base in all six directions that starts from rest.
pub(crate) struct Sway {
    /// The greatest displacement: of the base's position, m, and of its rotation, rad.
    displacement: [f64; 6],
    /// The angular frequency, rad/s.
    frequency: f64,
}

impl Default for Sway {
    fn default() -> Self {
        Self { displacement: [0.02, 0.015, -0.03, 0.05, 0.06, 0.1], frequency: 6.0 }
    }
}

impl Sway {
    /// Returns the desired motion at a time, s.
    pub(crate) fn at(&self, time: f64) -> Reference<Quadruped> {
        const SMALL: f64 = 1e-4;
        let start = standing();
        let at = |time: f64| {
            let share = 0.5 * (1.0 - (self.frequency * time).cos());
            let displacement =
                core::array::from_fn(|i| if i < 6 { share * self.displacement[i] } else { 0.0 });
            Quadruped::integrate(&start, &displacement)
        };
        // Differences in tangent space: the velocity and the acceleration in the base's axes.
        let q = at(time);
        let velocity = |time: f64| {
            Quadruped::difference(&at(time - SMALL), &at(time + SMALL)).map(|x| x / (2.0 * SMALL))
        };
        let (before, after) = (velocity(time - SMALL), velocity(time + SMALL));
        let qdd = core::array::from_fn(|i| (after[i] - before[i]) / (2.0 * SMALL));
        Reference { q, qd: velocity(time), qdd }
    }
}
