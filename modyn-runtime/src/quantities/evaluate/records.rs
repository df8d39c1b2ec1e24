//! The evaluation of functions whose results have objects beside numbers.

use super::super::arguments::{APPLIED, CONTACTS, COTANGENT, Q, WARM_START, WRENCH_COTANGENT};
use super::components::{read, write};
use super::given::Given;
use crate::Scalar;
use crate::equations::constraints::{
    ConstrainedCotangent, ConstrainedInverseOutputs, ConstrainedOutputs, ImpulseOutputs,
    OperationalSpaceInertiaOutputs, ProjectionOutputs, ResidualOutputs,
};
use crate::equations::derivatives::CentroidalOutputs;
use crate::equations::soft_constraints::ActuatedInput;
use crate::interpreter::{
    ConstrainedDerivatives, ConstrainedHessianOutputs, Interpreter, ShapeError, StateDerivatives,
    StepSolutionOutputs,
};
use crate::spatial::Momentum;

pub(super) fn centroidal_composite_inertia<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    out: &mut [S],
) -> Result<(), ShapeError> {
    let mut columns = [Momentum::zero(); 6];
    robot.centroidal_composite_inertia(&given[Q], &mut columns)?;
    write(&columns, out);
    Ok(())
}

pub(super) fn centroidal_momentum_derivatives<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [momentum, rate, momentum_dq, rate_dq, rate_dqd]: [&mut [S]; 5],
) -> Result<(), ShapeError> {
    let mut values = [Momentum::zero(); 2];
    let mut columns = [&*momentum_dq, rate_dq, rate_dqd].map(read);
    let [first, second] = &mut values;
    let [by_q, rate_by_q, rate_by_qd] = &mut columns;
    let outputs = CentroidalOutputs {
        momentum: first,
        rate: second,
        momentum_dq: by_q,
        rate_dq: rate_by_q,
        rate_dqd: rate_by_qd,
    };
    robot.centroidal_momentum_derivatives(given.motion(), outputs)?;
    write(&values[..1], momentum);
    write(&values[1..], rate);
    for (columns, place) in columns.iter().zip([momentum_dq, rate_dq, rate_dqd]) {
        write(columns, place);
    }
    Ok(())
}

pub(super) fn constrained_forward_dynamics<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [qdd, wrenches, residuals, rank]: [&mut [S]; 4],
) {
    robot.activate(&given[CONTACTS]);
    let mut held = read(wrenches);
    let mut unmet = read(residuals);
    let outputs = ConstrainedOutputs { qdd, wrenches: &mut held, residuals: &mut unmet };
    rank[0] = robot.solve_constrained(given.forward_input(), &given.settings(), outputs);
    write(&held, wrenches);
    write(&unmet, residuals);
}

pub(super) fn constraint_residual<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [displacements, velocities]: [&mut [S]; 2],
) -> Result<(), ShapeError> {
    let mut displaced = read(displacements);
    let mut moving = read(velocities);
    let outputs = ResidualOutputs { displacements: &mut displaced, velocities: &mut moving };
    robot.constraint_residual(given.state(), &given.settings(), outputs)?;
    write(&displaced, displacements);
    write(&moving, velocities);
    Ok(())
}

pub(super) fn project_constraints<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [dq, dqd, rank]: [&mut [S]; 3],
) {
    robot.activate(&given[CONTACTS]);
    let outputs = ProjectionOutputs { dq, dqd };
    rank[0] = robot.solve_projection(given.state(), &given.settings(), outputs);
}

pub(super) fn constrained_forward_dynamics_derivatives<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    parts: [&mut [S]; 9],
) {
    let [qdd, wrenches, dqdd_dq, dqdd_dqd, dqdd_dtau, changes @ .., rank] = parts;
    robot.activate(&given[CONTACTS]);
    let mut held = read(wrenches);
    let mut changes_of_wrenches = changes.each_ref().map(|numbers| read(numbers));
    let [dwrenches_dq, dwrenches_dqd, dwrenches_dtau] = &mut changes_of_wrenches;
    let outputs = ConstrainedDerivatives {
        qdd,
        wrenches: &mut held,
        dqdd_dq,
        dqdd_dqd,
        dqdd_dtau,
        dwrenches_dq,
        dwrenches_dqd,
        dwrenches_dtau,
    };
    rank[0] = robot.solve_derivatives(given.forward_input(), &given.settings(), outputs);
    write(&held, wrenches);
    for (wrenches, place) in changes_of_wrenches.iter().zip(changes) {
        write(wrenches, place);
    }
}

pub(super) fn constrained_forward_dynamics_hessian<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    parts: [&mut [S]; 10],
) {
    let [qdd, wrenches, dq, dqd, dtau, hessian @ .., rank] = parts;
    robot.activate(&given[CONTACTS]);
    let mut held = read(wrenches);
    let gradients = [dq, dqd, dtau];
    let outputs = ConstrainedHessianOutputs { qdd, wrenches: &mut held, gradients, hessian };
    let wrench_weights = read(&given[WRENCH_COTANGENT]);
    let weights = ConstrainedCotangent { qdd: &given[COTANGENT], wrenches: &wrench_weights };
    rank[0] = robot.solve_hessian(given.forward_input(), weights, &given.settings(), outputs);
    write(&held, wrenches);
}

pub(super) fn impact_dynamics<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [qd, impulses, rank]: [&mut [S]; 3],
) {
    robot.activate(&given[CONTACTS]);
    let mut transmitted = read(impulses);
    let outputs = ImpulseOutputs { qd, impulses: &mut transmitted };
    rank[0] = robot.solve_impulse(given.state(), &given.settings(), outputs);
    write(&transmitted, impulses);
}

pub(super) fn constrained_inverse_dynamics<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [tau, wrenches, rank]: [&mut [S]; 3],
) {
    robot.activate(&given[CONTACTS]);
    let mut transmitted = read(wrenches);
    let outputs = ConstrainedInverseOutputs { tau, wrenches: &mut transmitted };
    rank[0] = robot.solve_torques(given.motion(), &given.settings(), outputs);
    write(&transmitted, wrenches);
}

pub(super) fn operational_space_inertia<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [inverse, inertia, rank]: [&mut [S]; 3],
) {
    robot.activate(&given[CONTACTS]);
    let outputs = OperationalSpaceInertiaOutputs { inverse, inertia };
    rank[0] = robot.solve_inertia(&given[Q], &given.settings(), outputs);
}

pub(super) fn step<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [q, qd, qdd, forces, residual, iterations]: [&mut [S]; 6],
) -> Result<(), ShapeError> {
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    let outputs = StepSolutionOutputs { q, qd, qdd, forces, residual, iterations };
    robot.step(given.step_input(), &given.step_settings(), outputs)
}

pub(super) fn step_derivatives<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [q, qd, qdd, forces, a, b, residual, iterations]: [&mut [S]; 8],
) -> Result<(), ShapeError> {
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    let outputs = StepSolutionOutputs { q, qd, qdd, forces, residual, iterations };
    let derivatives = StateDerivatives { a, b };
    robot.step_derivatives(given.step_input(), &given.step_settings(), outputs, derivatives)
}

pub(super) fn step_actuated_derivatives<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [q, qd, act, qdd, forces, a, b, residual, iterations]: [&mut [S]; 9],
) -> Result<(), ShapeError> {
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    let outputs = StepSolutionOutputs { q, qd, qdd, forces, residual, iterations };
    let derivatives = StateDerivatives { a, b };
    let input = actuated_input(given);
    robot.step_actuated_derivatives(input, &given.step_settings(), outputs, act, derivatives)
}

fn actuated_input<'a, S: Scalar>(given: &'a Given<'a, S>) -> ActuatedInput<'a, S> {
    ActuatedInput {
        actuators: given.actuator_input(),
        applied: &given[APPLIED],
        warm_start: &given[WARM_START],
    }
}

pub(super) fn step_actuated<S: Scalar>(
    robot: &mut Interpreter<S>,
    given: &Given<'_, S>,
    [q, qd, act, qdd, forces, residual, iterations]: [&mut [S]; 7],
) -> Result<(), ShapeError> {
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    let outputs = StepSolutionOutputs { q, qd, qdd, forces, residual, iterations };
    robot.step_actuated(actuated_input(given), &given.step_settings(), outputs, act)
}
