//! Derivatives of inverse dynamics.

use alloc::vec;

use super::composite::{accumulate_composites, accumulate_wrenches};
use super::perturbation::{perturbations_by_coordinates, perturbations_by_rates};
use super::projection::{Variable, project};
use crate::Scalar;
use crate::equations::dynamics::gravity_compensation::add_compensation_derivatives;
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::equations::{Motion, State, Workspace};
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::Vector3;

/// Computes the derivatives d tau / d q and d tau / d qd of
/// [`inverse_dynamics`](crate::equations::dynamics::inverse_dynamics): nv x nv matrices, stored by
/// columns.
///
/// d tau / d qdd is the [`mass_matrix`](crate::equations::dynamics::mass_matrix). The derivative of
/// Coulomb friction is taken as zero, also at its jump.
pub fn inverse_dynamics_derivatives<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    motion: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
    dtau_dqd: &mut [S],
) {
    let accelerations = Accelerations::Given(motion.qdd);
    differentiate(tree, motion.state(), accelerations, workspace, [dtau_dq, dtau_dqd], None);
}

/// Computes the derivatives of [`inverse_dynamics_derivatives`], and that by qdd, the mass matrix.
pub fn inverse_dynamics_derivatives_and_mass_matrix<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    motion: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
    dtau_dqd: &mut [S],
    dtau_dqdd: &mut [S],
) {
    let accelerations = Accelerations::Given(motion.qdd);
    let columns = [dtau_dq, dtau_dqd];
    differentiate(tree, motion.state(), accelerations, workspace, columns, Some(dtau_dqdd));
}

/// Computes the derivatives of [`inverse_dynamics_derivatives_and_mass_matrix`] by the accelerations
/// `motion.qdd`, whose linear entries of floating bases are relative to free fall. The position, the
/// attitude and the linear velocity of such a base have no effect.
pub(in crate::equations) fn derivatives_against_fall<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    motion: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
    dtau_dqd: &mut [S],
    dtau_dqdd: &mut [S],
) {
    let accelerations = Accelerations::AgainstFall(motion.qdd);
    let columns = [dtau_dq, dtau_dqd];
    differentiate(tree, motion.state(), accelerations, workspace, columns, Some(dtau_dqdd));
}

/// Computes the derivatives of the product of the mass matrix and the accelerations `qdd` with respect
/// to q, by columns. Expects the joint transforms and the composite inertias at q.
pub(in crate::equations) fn mass_matrix_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    qdd: &[S],
    workspace: &mut Workspace<S>,
    by_q: &mut [S],
) {
    let weightless = &Mechanism { gravity: Vector3::zero(), ..model.clone() };
    let at_rest = vec![S::zero(); model.nv];
    link_wrenches(weightless, &at_rest, Accelerations::AgainstFall(qdd), workspace);
    accumulate_wrenches(weightless, |_| None, workspace);
    perturbations_by_coordinates(weightless, &at_rest, true, workspace);
    project(weightless, Variable::Coordinates, workspace, by_q, None);
}

/// Computes the derivatives, and the mass matrix if it is wanted, which comes from the same sweep.
fn differentiate<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    State { q, qd }: State<'_, S>,
    accelerations: Accelerations<'_, S>,
    workspace: &mut Workspace<S>,
    [dtau_dq, dtau_dqd]: [&mut [S]; 2],
    mass_matrix: Option<&mut [S]>,
) {
    let model = tree.mechanism();
    let falling = matches!(accelerations, Accelerations::AgainstFall(_));
    workspace.move_with_forces(tree, q, Some(qd));
    link_wrenches(tree, qd, accelerations, workspace);
    accumulate_composites(tree, qd, workspace);
    accumulate_wrenches(tree, |_| None, workspace);
    perturbations_by_coordinates(tree, qd, falling, workspace);
    project(tree, Variable::Coordinates, workspace, dtau_dq, None);
    perturbations_by_rates(tree, qd, falling, workspace);
    project(tree, Variable::Rates, workspace, dtau_dqd, mass_matrix);
    add_dissipation(model, qd, dtau_dqd);
    add_passive(model, q, workspace, dtau_dq);
}

/// Adds the derivatives of the forces of springs and gravity compensation to d tau / d q. Expects
/// the joint transforms at q.
pub(super) fn add_passive<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
) {
    add_compensation_derivatives(model, workspace, dtau_dq);
    model.spring_derivatives(q, |row, column, entry| {
        let row = &model.dofs[row];
        let column = &model.dofs[column];
        let sum = &mut dtau_dq[column.v * model.nv + row.v];
        *sum = *sum + row.scale(column.scale(entry));
    });
}

/// Adds the derivatives of damping, friction and the velocity-dependent forces of armature to d
/// tau / d qd.
pub(super) fn add_dissipation<S: Scalar>(model: &Mechanism<S>, qd: &[S], dtau_dqd: &mut [S]) {
    for dof in &model.dofs {
        if let Some(slope) = model.dissipation_slope(dof, qd) {
            let sum = &mut dtau_dqd[dof.v * model.nv + dof.v];
            *sum = *sum + dof.scale(dof.scale(slope));
        }
    }
    model.armature_derivatives(qd, |row, column, entry| {
        let sum = &mut dtau_dqd[model.dofs[column].v * model.nv + model.dofs[row].v];
        *sum = *sum + entry;
    });
}
