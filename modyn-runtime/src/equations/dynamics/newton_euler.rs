//! The Newton-Euler equations of each body: the wrench that its own motion needs.
//!
//! Accelerations are the classical accelerations of the bodies' origins, in the bodies' own axes
//! (see [`Field`](crate::spatial::Field)). Gravity enters as an upward acceleration of the world.

use crate::Scalar;
use crate::equations::kinematics::acceleration::parent_motion;
use crate::equations::{State, Workspace};
use crate::joint::ElementaryJoint;
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::Vector3;

/// The joint accelerations.
#[derive(Clone, Copy, Debug)]
pub(in crate::equations) enum Accelerations<'a, S> {
    /// Zero.
    None,
    /// Zero, except that the origin of a floating base is in free fall: see [`free_fall`].
    FreeFall,
    /// These accelerations.
    Given(&'a [S]),
    /// These accelerations. The linear entries of a floating base are classical accelerations
    /// relative to free fall.
    AgainstFall(&'a [S]),
}

/// Fills `workspace.wrenches` with the wrench of each body's own motion, without its children.
///
/// Expects the joint transforms at q.
pub(in crate::equations) fn link_wrenches<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    accelerations: Accelerations<'_, S>,
    workspace: &mut Workspace<S>,
) {
    for i in 0..tree.mechanism().bodies.len() {
        link_wrench(tree, i, qd, accelerations, workspace);
    }
}

/// Fills body `i`'s entries of `workspace.fields` and `workspace.wrenches`.
///
/// Expects the joint's transform, and the motion of the parent.
pub(super) fn link_wrench<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    i: usize,
    qd: &[S],
    accelerations: Accelerations<'_, S>,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    let from_parent = parent_motion(tree, i, workspace);
    let accelerations_of_joint = match accelerations {
        Accelerations::Given(qdd) | Accelerations::AgainstFall(qdd) => Some(model.rates(i, qdd)),
        _ => None,
    };
    let mut field = workspace.motions[i].accelerate(
        from_parent,
        &model.rates(i, qd),
        accelerations_of_joint.as_deref(),
    );
    if is_base(model, i) {
        match (accelerations, &accelerations_of_joint) {
            (Accelerations::FreeFall, _) => field.a = Vector3::zero(),
            (Accelerations::AgainstFall(_), Some(of_joint)) => {
                field.a = Vector3([of_joint[0], of_joint[1], of_joint[2]]);
            }
            _ => {}
        }
    }
    workspace.fields[i] = field;
    workspace.wrenches[i] = field.wrench(&model.bodies[i].base_inertia);
}

/// Returns whether body `i` is a base that floats in the world. (A base with rotors does not fall
/// freely.)
#[must_use]
pub fn is_base<S: Scalar>(model: &Mechanism<S>, i: usize) -> bool {
    let body = &model.bodies[i];
    let floats = body.parent.is_none() && body.elementary_joint == ElementaryJoint::Floating;
    floats && model.dofs_of(i).iter().all(|dof| dof.armature.is_none())
}

/// Returns the bodies on the world with a floating joint that has no rotors, springs, damping and
/// friction. Their pose and linear velocity have no effect on the motion relative to free fall. A
/// robot with gravity compensation, which depends on the attitude, has none.
pub fn free_bases<S: Scalar>(model: &Mechanism<S>) -> impl Iterator<Item = usize> + '_ {
    let is_free = |i| {
        let resists = model.dofs_of(i).iter().any(|d| d.damping.is_some() || d.friction.is_some());
        is_base(model, i) && !resists && model.bodies[i].spring.is_none()
    };
    let bodies = if model.compensates_gravity() { 0 } else { model.bodies.len() };
    (0..bodies).filter(move |&i| is_free(i))
}

/// Computes the joint accelerations in free fall, nv entries: g - omega x v in the axes of the base
/// for the linear entries of each of the [`free_bases`], zero for all others.
pub fn free_fall_accelerations<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
    qdd: &mut [S],
) {
    qdd.fill(S::zero());
    workspace.move_to(model, q);
    for i in free_bases(model) {
        let rates = model.rates(i, qd);
        workspace.fields[i].omega = Vector3([rates[3], rates[4], rates[5]]);
        // The entries of a floating base are contiguous, the linear ones first.
        let first = model.dofs_of(i)[0].v;
        qdd[first..first + 3].copy_from_slice(&free_fall(model, i, qd, workspace).0);
    }
}

/// Returns the linear acceleration of a floating base `i` in free fall, in the coordinates of its
/// joint: g - omega x v.
pub(in crate::equations) fn free_fall<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    qd: &[S],
    workspace: &Workspace<S>,
) -> Vector3<S> {
    let rates = model.rates(i, qd);
    let velocity = Vector3([rates[0], rates[1], rates[2]]);
    let g = model.bodies[i].to_child(&workspace.motions[i], model.gravity);
    g - workspace.fields[i].omega.cross(velocity)
}
