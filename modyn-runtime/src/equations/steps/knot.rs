//! The knot of optimal control: a semi-implicit step, and its derivatives in blocks.
//!
//! With the derivatives F of the accelerations by a variable, the derivatives of the velocities
//! qd' = qd + h qdd are h F (+ 1 by qd). The coordinates q' = q (+) h qd' depend on q and on
//! v = h qd' only. Their derivatives are 1, except at quaternions.

use super::{StepWorkspace, scale};
use crate::Scalar;
use crate::equations::derivatives::{ForwardDerivatives, forward_dynamics_derivatives};
use crate::equations::factorization::UduLayout;
use crate::equations::kinematics::coordinates;
use crate::equations::{TimeStepInput, Workspace};
use crate::mechanism::Mechanism;
use crate::mechanism::coordinates::quaternion_blocks;

/// The results of [`knot`]. Matrices are by rows.
#[derive(Debug)]
pub struct KnotOutputs<'a, S> {
    /// The velocities after the step.
    pub qd: &'a mut [S],
    /// Their derivatives with respect to q before the step, in tangent space.
    pub dqd_dq: &'a mut [S],
    /// Their derivatives with respect to qd before the step.
    pub dqd_dqd: &'a mut [S],
    /// Their derivatives with respect to tau.
    pub dqd_dtau: &'a mut [S],
    /// For each quaternion, the derivatives of the coordinates after the step with respect to the
    /// coordinates before: 6 x 6.
    pub dq_dq: &'a mut [S],
    /// For each quaternion, the derivatives of the coordinates after the step with respect to the
    /// displacement dt qd': 6 x 6.
    pub dq_dv: &'a mut [S],
}

/// Computes the velocities after a semi-implicit step, and its derivatives.
pub fn knot<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    input: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut StepWorkspace<S>,
    outputs: KnotOutputs<'_, S>,
) {
    let derivatives = ForwardDerivatives {
        qdd: &mut *outputs.qd,
        dqdd_dq: &mut *outputs.dqd_dq,
        dqdd_dqd: &mut *outputs.dqd_dqd,
        dqdd_dtau: &mut *outputs.dqd_dtau,
    };
    forward_dynamics_derivatives(model, layout, input.forward_input(), workspace, derivatives);
    outputs.complete(model, input, memory);
}

impl<S: Scalar> KnotOutputs<'_, S> {
    /// Replaces the accelerations and their derivatives, by columns, by the velocities after the
    /// step and their derivatives, and computes the derivatives of the coordinates.
    pub fn complete(
        self,
        model: &Mechanism<S>,
        TimeStepInput { qd, dt, .. }: TimeStepInput<'_, S>,
        memory: &mut StepWorkspace<S>,
    ) {
        let Self { qd: next, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv } = self;
        let n = model.nv;
        for (next, &qd) in next.iter_mut().zip(qd) {
            *next = qd + dt * *next;
        }
        for matrix in [&mut *dqd_dq, &mut *dqd_dqd, dqd_dtau] {
            for j in 0..n {
                (0..j).for_each(|i| matrix.swap(j * n + i, i * n + j));
            }
            matrix.iter_mut().for_each(|entry| *entry = dt * *entry);
        }
        for entry in dqd_dqd.iter_mut().step_by(n + 1) {
            *entry = S::one() + *entry;
        }
        let StepWorkspace { displacement, matrices: [by_start, by_displacement, _], .. } = memory;
        scale(dt, next, displacement);
        coordinates::integrate_derivatives(model, displacement, by_start, by_displacement);
        for (blocks, matrix) in [(dq_dq, by_start), (dq_dv, by_displacement)] {
            for (entry, place) in blocks.iter_mut().zip(quaternion_blocks(&model.coordinates, n)) {
                *entry = place.map_or(S::zero(), |place| matrix[place]);
            }
        }
    }
}
