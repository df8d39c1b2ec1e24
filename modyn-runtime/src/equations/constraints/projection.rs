//! The projection of coordinates and velocities onto the constraints.

use super::ConstraintWorkspace;
use super::rows::constraint_rows;
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::mechanism::Mechanism;
use crate::results::ConstraintSettings;

/// Computes the step `dq` of the coordinates and the step `dqd` of the velocities that satisfy the
/// constraints. Returns the number of independent rows.
///
/// `dq` satisfies the constraints to first order. Both steps are -I^-1 J^T (J I^-1 J^T)^+ times the
/// violation (displacements for `dq`, velocities for `dqd`): the smallest steps in the metric of the
/// mass matrix.
pub fn project_constraints<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    (q, qd): (&[S], &[S]),
    settings: &ConstraintSettings<S>,
    (workspace, room): (&mut Workspace<S>, &mut ConstraintWorkspace<S>),
    (dq, dqd): (&mut [S], &mut [S]),
) -> S {
    brge::factorize(model, layout, q, workspace, &mut room.factors);
    constraint_rows(model, (q, qd), workspace, room, |component, motion| {
        [-component(motion.displacement), -component(motion.velocity)]
    });
    room.factorize(model, layout, settings);
    for (side, step) in [dq, dqd].into_iter().enumerate() {
        step.fill(S::zero());
        room.solve(side);
        room.add_response(side, step);
    }
    room.factorization.rank()
}
