//! Closed loops in general position compared with Pinocchio's `constraintDynamics`.

use modyn_runtime::equations::constraints::{ConstrainedOutputs, ResidualOutputs};
use modyn_runtime::equations::{ForwardInput, State};
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ConstraintSettings, Interpreter};
use modyn_tests::close::assert_close;
use modyn_tests::golden::{Golden, PLANAR_LOOP, SPATIAL_LOOPS};

/// The tolerance that the reference data's README gives.
const TOLERANCE: f64 = 1e-9;

#[test]
fn states_are_closed() {
    for name in SPATIAL_LOOPS.into_iter().chain([PLANAR_LOOP]) {
        let golden = Golden::load(name);
        let loop_constraints = golden.model.loop_constraints().len();
        assert_eq!(loop_constraints, 1, "{name}");
        for state in &golden.states {
            let (mut displacement, mut velocity) =
                (vec![Twist::zero(); loop_constraints], vec![Twist::zero(); loop_constraints]);
            let mut interpreter = Interpreter::<f64>::new(golden.model.clone());
            let called = interpreter.constraint_residual(
                State { q: &state.q(), qd: &state.vector("v") },
                &ConstraintSettings::<f64>::EXACT,
                ResidualOutputs { displacements: &mut displacement, velocities: &mut velocity },
            );
            called.expect("the lengths are right");
            assert_close(name, &displacement[0].components(), &[0.0; 6], 1e-12);
            assert_close(name, &velocity[0].components(), &[0.0; 6], 1e-12);
        }
    }
}

/// Compares the accelerations at every state of `name`.
fn accelerations(name: &str) {
    let golden = Golden::load(name);
    assert_eq!(golden.states.len(), 4, "{name}");
    for state in &golden.states {
        let mut interpreter = Interpreter::<f64>::new(golden.model.clone());
        let mut qdd = vec![0.0; golden.model.nv()];
        let (mut wrenches, mut residuals) = ([Wrench::zero()], [Twist::zero()]);
        let called = interpreter.constrained_forward_dynamics(
            ForwardInput { q: &state.q(), qd: &state.vector("v"), tau: &state.vector("tau") },
            &[],
            &ConstraintSettings::<f64>::EXACT,
            ConstrainedOutputs {
                qdd: &mut qdd,
                wrenches: &mut wrenches,
                residuals: &mut residuals,
            },
        );
        let rank = called.expect("the lengths are right");
        assert_eq!(rank, state.number("rank"), "{name}");
        assert_close(name, &residuals[0].components(), &[0.0; 6], TOLERANCE);
        assert_close(name, &qdd, &state.vector("qdd"), TOLERANCE);
    }
}

#[test]
fn accelerations_of_spatial_loops() {
    SPATIAL_LOOPS.into_iter().for_each(accelerations);
}

/// The rows of the hinge's rotation are rounding noise.
#[test]
fn accelerations_of_a_planar_loop() {
    accelerations(PLANAR_LOOP);
}
