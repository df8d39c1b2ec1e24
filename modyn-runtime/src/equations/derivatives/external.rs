//! Derivatives under external wrenches.
//!
//! External wrenches f add the generalized forces J^T f to the joint forces. The derivatives of
//! inverse and forward dynamics follow from the derivatives of J^T f by the chain rule. A
//! displacement of one degree of freedom displaces the wrenches on its body and on the body's
//! descendants, which changes the forces on the joints of the ancestors. Wrenches in world axes do
//! not rotate with their links: relative to the links they rotate back, which changes the forces on
//! all joints between.

use alloc::vec::Vec;
use core::mem;

use super::forward::{ForwardDerivatives, forward_dynamics_derivatives};
use super::inverse::inverse_dynamics_derivatives;
use super::projection::displaced;
use crate::Scalar;
use crate::equations::dynamics::Forces;
use crate::equations::factorization::UduLayout;
use crate::equations::{ForwardInput, Motion, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{Matrix3, SpatialAxis, Vector3, Wrench};

/// Computes the derivatives of inverse dynamics under external wrenches with respect to q and qd:
/// nv x nv matrices, stored by columns. The wrenches are constant in the axes in which they are
/// given.
pub fn inverse_dynamics_external_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    motion: Motion<'_, S>,
    forces: Forces<'_, S>,
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
    dtau_dqd: &mut [S],
) {
    let memory = in_memory(model, motion.q, forces, workspace);
    inverse_dynamics_derivatives(model, motion, workspace, dtau_dq, dtau_dqd);
    for (entry, &change) in dtau_dq.iter_mut().zip(&memory[model.nv..]) {
        *entry = *entry - change;
    }
    workspace.external = memory;
}

/// Computes the joint accelerations under the joint forces `tau` and external wrenches, and their
/// derivatives with respect to q, qd and tau. The wrenches are constant in the axes in which they
/// are given.
pub fn forward_dynamics_external_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    forces: Forces<'_, S>,
    workspace: &mut Workspace<S>,
    outputs: ForwardDerivatives<'_, S>,
) {
    let n = model.nv;
    let mut memory = in_memory(model, q, forces, workspace);
    let (total, change) = memory.split_at_mut(n);
    for (total, &tau) in total.iter_mut().zip(tau) {
        *total = *total + tau;
    }
    let ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau } = outputs;
    let without =
        ForwardDerivatives { qdd, dqdd_dq: &mut *dqdd_dq, dqdd_dqd, dqdd_dtau: &mut *dqdd_dtau };
    forward_dynamics_derivatives(
        model,
        layout,
        ForwardInput { q, qd, tau: total },
        workspace,
        without,
    );
    for (by_q, change) in dqdd_dq.chunks_mut(n.max(1)).zip(change.chunks(n.max(1))) {
        for (by_tau, &change) in dqdd_dtau.chunks(n.max(1)).zip(change) {
            for (by_q, &by_tau) in by_q.iter_mut().zip(by_tau) {
                *by_q = *by_q + by_tau * change;
            }
        }
    }
    workspace.external = memory;
}

/// Returns the results of [`generalized_forces`], the derivatives after the forces. The memory is
/// the memory of `workspace.external`.
fn in_memory<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    forces: Forces<'_, S>,
    workspace: &mut Workspace<S>,
) -> Vec<S> {
    let mut memory = mem::take(&mut workspace.external);
    memory.resize(model.nv * (1 + model.nv), S::zero());
    let (tau, dq) = memory.split_at_mut(model.nv);
    generalized_forces(model, q, forces, workspace, tau, dq);
    memory
}

/// Computes the generalized forces J^T f of external wrenches f (N m or N), and their derivatives
/// with respect to q, an nv x nv matrix by columns. The wrenches are constant in the axes in which
/// they are given.
pub fn generalized_forces<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    forces: Forces<'_, S>,
    workspace: &mut Workspace<S>,
    generalized: &mut [S],
    derivatives: &mut [S],
) {
    generalized.fill(S::zero());
    derivatives.fill(S::zero());
    workspace.move_to(model, q);
    accumulate_composites(model, forces, workspace);
    for dof in &model.dofs {
        dof.add(workspace.wrenches[dof.body].components()[dof.component], generalized);
    }
    for column in &model.dofs {
        let entries = &mut derivatives[column.v * model.nv..][..model.nv];
        let mut add = |body: usize, change: Wrench<S>| {
            for row in model.dofs_of(body) {
                row.add(column.scale(change.components()[row.component]), entries);
            }
        };
        let first = column.body;
        let mut change = displaced(workspace.wrenches[first], column.component);
        if let SpatialAxis::Angular(k) = column.axis()
            && matches!(forces, Forces::InWorldAxes(_))
        {
            let axis = Vector3::unit(k);
            let moment_change = rotated_back(workspace, first, axis);
            change += moment_change;
            add(first, moment_change);
            // Bodies are depth first: the descendants follow.
            workspace.points[first] = axis;
            for (i, body) in model.bodies.iter().enumerate().skip(first + 1) {
                let Some(parent) = body.parent.filter(|&parent| parent >= first) else { break };
                let axis = body.to_child(&workspace.motions[i], workspace.points[parent]);
                workspace.points[i] = axis;
                add(i, rotated_back(workspace, i, axis));
            }
        }
        let mut at = first;
        while let Some(parent) = model.bodies[at].parent {
            change = model.bodies[at].wrench_to_parent(&workspace.motions[at], change);
            add(parent, change);
            at = parent;
        }
    }
}

/// Computes the external wrench of each composite (`wrenches`), and the sums of x f^T over the
/// forces f at the points x of the composite (`force_moments`), both relative to the body's frame.
fn accumulate_composites<S: Scalar>(
    model: &Mechanism<S>,
    forces: Forces<'_, S>,
    workspace: &mut Workspace<S>,
) {
    workspace.wrenches.fill(Wrench::zero());
    workspace.force_moments.fill(Matrix3::zero());
    forces.for_each(model, workspace, |workspace, body, point, Wrench { moment, force }| {
        workspace.wrenches[body] += Wrench { moment: moment + point.cross(force), force };
        let sum = &mut workspace.force_moments[body];
        *sum = *sum + Matrix3::outer(point, force);
    });
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let Some(parent) = body.parent else { continue };
        let motion = &workspace.motions[i];
        let wrench = body.wrench_to_parent(motion, workspace.wrenches[i]);
        workspace.wrenches[parent] += wrench;
        if matches!(forces, Forces::InLinkAxes(_)) {
            continue;
        }
        let rotated = |columns: Matrix3<S>| {
            Matrix3::from_columns(|k| body.to_parent(motion, columns.column(k)))
        };
        let moments = rotated(rotated(workspace.force_moments[i]).transposed()).transposed();
        let mut origin = body.placement.origin();
        if let Some(displacement) = motion.displacement() {
            origin += body.placement.to_parent(displacement);
        }
        let sum = &mut workspace.force_moments[parent];
        *sum = *sum + moments + Matrix3::outer(origin, wrench.force);
    }
}

/// Returns the change of a composite's external wrench, in the body's frame, by a rotation of the
/// body about `axis` under forces and moments that do not rotate.
fn rotated_back<S: Scalar>(workspace: &Workspace<S>, body: usize, axis: Vector3<S>) -> Wrench<S> {
    let Wrench { moment, force } = workspace.wrenches[body];
    // (axis x x) x f = (x f^T - (x . f)) axis, minus the rotation of the wrench with the body.
    let moments = &workspace.force_moments[body];
    let trace = (0..3).fold(S::zero(), |sum, k| sum + moments.0[k][k]);
    Wrench {
        moment: moments.mul_vector(axis) - axis.scale(trace) - axis.cross(moment),
        force: -axis.cross(force),
    }
}
