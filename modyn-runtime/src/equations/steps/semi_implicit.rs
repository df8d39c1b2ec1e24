//! The semi-implicit Euler method: the new velocities move the robot.

use super::{StepOutputs, StepWorkspace, add_scaled, scale};
use crate::Scalar;
use crate::equations::derivatives::{ForwardDerivatives, forward_dynamics_derivatives};
use crate::equations::dynamics::{Elimination, forward_dynamics};
use crate::equations::factorization::UduLayout;
use crate::equations::kinematics::coordinates;
use crate::equations::{ForwardInput, NextState, TimeStepInput, Workspace};
use crate::mechanism::Mechanism;

/// Computes the coordinates and velocities after the time `dt`: qd' = qd + dt qdd(q, qd, tau) and
/// q' = q (+) dt qd'.
pub fn step_semi_implicit<S: Scalar>(
    model: &Mechanism<S>,
    elimination: &Elimination,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut StepWorkspace<S>,
    NextState { q: next_q, qd: next_qd }: NextState<'_, S>,
) {
    let StepWorkspace { displacement, accelerations: [qdd, ..], .. } = memory;
    forward_dynamics(model, elimination, ForwardInput { q, qd, tau }, None, workspace, qdd);
    add_scaled(qd, dt, qdd, next_qd);
    scale(dt, next_qd, displacement);
    coordinates::integrate(model, q, displacement, next_q);
}

/// Computes the coordinates and velocities after the time `dt`, and their derivatives in tangent
/// space.
///
/// With the derivatives F of the accelerations, the derivatives of the velocities are 1 + dt F. The
/// derivatives of the coordinates follow from them by the derivatives of
/// [`coordinates::integrate`].
pub fn step_semi_implicit_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut StepWorkspace<S>,
    outputs: StepOutputs<'_, S>,
) {
    let StepOutputs { q: next_q, qd: next_qd, a, b } = outputs;
    let StepWorkspace { displacement, accelerations: [qdd, ..], matrices, .. } = memory;
    let n = model.nv;
    let [dqdd_dq, dqdd_dqd, dqdd_dtau] = &mut *matrices;
    let derivatives = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
    forward_dynamics_derivatives(
        model,
        layout,
        ForwardInput { q, qd, tau },
        workspace,
        derivatives,
    );
    add_scaled(qd, dt, qdd, next_qd);
    scale(dt, next_qd, displacement);
    coordinates::integrate(model, q, displacement, next_q);
    if n == 0 {
        return;
    }
    // The derivatives of the velocities.
    let columns = a.chunks_mut(2 * n).chain(b.chunks_mut(2 * n));
    for (column, derivative) in columns.zip(matrices.iter().flat_map(|matrix| matrix.chunks(n))) {
        scale(dt, derivative, &mut column[n..]);
    }
    for (j, column) in a.chunks_mut(2 * n).skip(n).enumerate() {
        column[n + j] = S::one() + column[n + j];
    }
    // The derivatives of the coordinates.
    let [by_q, by_displacement, _] = matrices;
    coordinates::integrate_derivatives(model, displacement, by_q, by_displacement);
    for column in a.chunks_mut(2 * n).chain(b.chunks_mut(2 * n)) {
        let (moved, rates) = column.split_at_mut(n);
        for (i, moved) in moved.iter_mut().enumerate() {
            let products = by_displacement.chunks(n).zip(&*rates).map(|(by, &rate)| by[i] * rate);
            *moved = dt * products.fold(S::zero(), |sum, product| sum + product);
        }
    }
    for (column, by_q) in a.chunks_mut(2 * n).zip(by_q.chunks(n)) {
        for (moved, &by_q) in column.iter_mut().zip(by_q) {
            *moved = by_q + *moved;
        }
    }
}
