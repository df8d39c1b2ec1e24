//! The projection of coordinates and velocities onto the constraints.

use super::rows::constraint_rows;
use super::{ConstraintInput, ConstraintWorkspaces, ProjectionOutputs};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::{State, brge};

/// Computes the step `step_q` of the coordinates and the step `step_qd` of the velocities that satisfy
/// the constraints. Returns the number of independent rows.
///
/// `step_q` satisfies the constraints to first order. Both steps are -M^-1 J^T (J M^-1 J^T)^+ times
/// the violation (displacements for `step_q`, velocities for `step_qd`): the smallest steps in the
/// metric of the mass matrix.
///
/// Limbs of `tree` may be merged, as in
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics).
pub fn project_constraints<S: Scalar, T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
    tree: &T,
    layout: &T::Layout,
    State { q, qd }: State<'_, S>,
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    ProjectionOutputs { step_q, step_qd }: ProjectionOutputs<'_, S>,
) -> S {
    let model = tree.mechanism();
    brge::factorize(tree, layout.layout(), q, workspace, &mut memory.factors);
    let targets = settings.targets.as_ref();
    constraint_rows(model, State { q, qd }, targets, workspace, memory, |_, component, motion| {
        [-component(motion.displacement), -component(motion.velocity)]
    });
    memory.factorize(tree, layout, ConstraintInput { active, settings }, |_| {});
    memory.force.fill(S::zero());
    for (side, step) in [step_q, step_qd].into_iter().enumerate() {
        memory.solve(tree, side);
        memory.respond(layout, side, step);
    }
    memory.factorization.rank()
}
