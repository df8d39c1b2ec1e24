//! Inverse dynamics: the joint forces of a motion.

use super::Forces;
use super::newton_euler::{Accelerations, link_wrenches};
use crate::Scalar;
use crate::equations::{State, Workspace};
use crate::mechanism::{BodyTree, Mechanism};

/// Computes the joint forces tau = I(q) qdd + h(q, qd) - J^T f, f being the external forces.
///
/// Gravity, rotor armature, springs, damping and friction are included. Without `qdd` the result is
/// the bias forces h(q, qd). The method is the recursive Newton-Euler algorithm (Featherstone 2008,
/// chapter 5).
pub fn inverse_dynamics<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    qdd: Option<&[S]>,
    forces: Option<Forces<'_, S>>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    move_bodies(model, State { q, qd }, qdd, workspace);
    if let Some(forces) = forces {
        forces.subtract(model, workspace);
    }
    joint_torques(model, qd, qdd, workspace, tau);
}

/// Computes the joint forces without external forces. Limbs of `tree` may be merged.
pub fn recursive_newton_euler<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    State { q, qd }: State<'_, S>,
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    move_bodies(tree, State { q, qd }, qdd, workspace);
    joint_torques(tree, qd, qdd, workspace, tau);
}

/// Computes the joint forces at zero joint accelerations with floating bases in free fall; see
/// [`free_fall`](super::newton_euler::free_fall). Leaves the bodies' accelerations in the
/// workspace.
pub(in crate::equations) fn bias_in_free_fall<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    workspace.move_with_forces(tree, q, Some(qd));
    link_wrenches(tree, qd, Accelerations::FreeFall, workspace);
    joint_torques(tree, qd, None, workspace, tau);
}

/// Computes the wrench that each body needs for its own motion.
fn move_bodies<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    State { q, qd }: State<'_, S>,
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
) {
    workspace.move_with_forces(tree, q, Some(qd));
    let accelerations = qdd.map_or(Accelerations::None, Accelerations::Given);
    link_wrenches(tree, qd, accelerations, workspace);
}

/// Sums the bodies' wrenches towards the root, and writes their components along the joints to
/// `tau`.
fn joint_torques<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    tau.fill(S::zero());
    for i in (0..tree.mechanism().bodies.len()).rev() {
        joint_torque(tree, i, qd, qdd, workspace, tau);
    }
}

/// Adds the forces of body `i`'s joint to `tau`, and the body's wrench to its parent's wrench.
pub(super) fn joint_torque<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    i: usize,
    qd: &[S],
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    let model = tree.mechanism();
    let wrench = workspace.wrenches[i];
    for (dof, passive) in
        model.dofs_of(i).iter().zip(&workspace.passive[model.bodies[i].dofs.clone()])
    {
        let mut force = wrench.components()[dof.component];
        if let (Some(armature), Some(qdd)) = (dof.armature, qdd) {
            force = force + armature * dof.rate(qdd);
        }
        if let Some(dissipation) = model.dissipation(dof, qd) {
            force = force + dissipation;
        }
        if let Some(passive) = *passive {
            force = force + passive;
        }
        dof.add(force, tau);
    }
    tree.wrench_to_parents(i, &workspace.motions[i], wrench, |parent, at_parent| {
        workspace.wrenches[parent] += at_parent;
    });
}
