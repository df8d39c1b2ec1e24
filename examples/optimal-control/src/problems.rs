//! The problems that the program solves and the tests check.

use modyn::na::DVector;
use modyn::simulate::{Gains, Reference, SolvedStep, State};
use modyn::{ContactSurface, StepSettings};

use crate::jump::Jump;
use crate::lqr::{Regulator, Weights};
use crate::reaching::Reaching;
use crate::robots::{Arm, ArmLink, Quadruped, QuadrupedContacts, Settings, standing};

/// Returns the problem of an arm that moves the point between its fingers to a pose within a second.
pub(crate) fn reaching() -> Reaching<Arm> {
    let goal = [0.9, 0.5, -0.6, -1.4, 0.7, 1.2, -0.5];
    Reaching {
        start: State::at_rest([-0.5, -0.4, 0.2, -2.3, -0.1, 2.1, 0.7]),
        link: ArmLink::GraspPoint,
        target: Arm::link_pose(&goal, ArmLink::GraspPoint),
        dt: 0.01,
    }
}

/// Returns a hundred steps of the torques that hold the arm at its start.
pub(crate) fn hold(problem: &Reaching<Arm>) -> Vec<DVector<f64>> {
    vec![DVector::from(Arm::gravity_torques(&problem.start.q).to_vec()); 100]
}

/// Returns the problem of a quadruped that jumps to a place above, in front and to the left, and rotates on the way.
pub(crate) fn jump() -> Jump {
    let mut goal = standing();
    goal[0] += 0.05;
    goal[1] += 0.02;
    goal[2] = 0.38;
    let mut rotation = [0.0; 18];
    rotation[4..6].copy_from_slice(&[-0.1, 0.2]); // about y and z, rad
    Jump {
        start: State::at_rest(standing()),
        goal: Quadruped::integrate(&goal, &rotation),
        standing: 40,
        dt: 0.01,
    }
}

/// Returns the torques that stand, for the steps on the ground, then no torques for 15 steps in the air.
pub(crate) fn stand(problem: &Jump) -> Vec<DVector<f64>> {
    let rest = [0.0; 18];
    let contacts = QuadrupedContacts::ALL;
    let found = Quadruped::constrained_inverse_dynamics(
        &problem.start.q,
        &rest,
        &rest,
        contacts,
        &Settings::DEFAULT,
    );
    let standing = vec![DVector::from(found.tau[6..].to_vec()); problem.standing];
    [standing, vec![DVector::zeros(12); 15]].concat()
}

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
