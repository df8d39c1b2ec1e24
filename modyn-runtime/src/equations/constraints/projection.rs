//! The projection of coordinates and velocities onto the constraints.

use super::rows::constraint_rows;
use super::{ConstraintWorkspace, Settings};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::mechanism::Mechanism;

/// Computes the step `dq` of the coordinates and the step `dqd` of the velocities that satisfy the constraints.
/// Returns the number of independent rows.
///
/// `dq` satisfies the constraints to first order. Both steps are -I^-1 J^T (J I^-1 J^T)^+ times the violation
/// (displacements for `dq`, velocities for `dqd`): the smallest steps in the metric of the mass matrix.
pub fn project_constraints<S: Scalar, C: AsRef<[ContactTarget<S>]>>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    (q, qd): (&[S], &[S]),
    (active, settings): Settings<'_, S, C>,
    (workspace, memory): (&mut Workspace<S>, &mut ConstraintWorkspace<S>),
    (dq, dqd): (&mut [S], &mut [S]),
) -> S {
    brge::factorize(model, layout, q, workspace, &mut memory.factors);
    let contacts = settings.contacts.as_ref();
    constraint_rows(model, (q, qd), contacts, workspace, memory, |_, component, motion| {
        [-component(motion.displacement), -component(motion.velocity)]
    });
    memory.factorize(model, layout, (active, settings), |_| {});
    memory.force.fill(S::zero());
    for (side, step) in [dq, dqd].into_iter().enumerate() {
        memory.solve(model, side);
        memory.respond(layout, side, step);
    }
    memory.factorization.rank()
}
