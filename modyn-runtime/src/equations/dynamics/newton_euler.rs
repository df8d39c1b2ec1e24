//! The wrenches that a motion asks of each body by itself, by Newton and Euler.
//!
//! Accelerations are the classical ones of the bodies' origins, in the bodies' own axes (see
//! [`Field`](crate::spatial::Field)). Gravity is an acceleration of the world upwards.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::kinematics::acceleration::parent_motion;
use crate::joint::ElementaryJoint;
use crate::mechanism::{BodyTree, Mechanism};
use crate::spatial::Vector3;

/// How the joints accelerate.
#[derive(Clone, Copy, Debug)]
pub(in crate::equations) enum Accelerations<'a, S> {
    /// Not at all.
    None,
    /// Not at all, but a floating base so that its origin is in free fall: see [`free_fall`].
    FreeFall,
    /// So.
    Given(&'a [S]),
    /// So, but a floating base's origin against free fall: its linear numbers are classical
    /// accelerations.
    AgainstFall(&'a [S]),
}

/// Fills `workspace.wrenches` with each body's own wrench, those of its children left out.
///
/// Expects the joints at q.
pub(in crate::equations) fn link_wrenches<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    accelerations: Accelerations<'_, S>,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for (i, body) in model.bodies.iter().enumerate() {
        let carried = parent_motion(tree, i, workspace);
        let own = match accelerations {
            Accelerations::Given(qdd) | Accelerations::AgainstFall(qdd) => {
                Some(model.rates(i, qdd))
            }
            _ => None,
        };
        let mut field =
            workspace.motions[i].accelerate(carried, &model.rates(i, qd), own.as_deref());
        if is_base(model, i) {
            match (accelerations, &own) {
                (Accelerations::FreeFall, _) => field.a = Vector3::zero(),
                (Accelerations::AgainstFall(_), Some(own)) => {
                    field.a = Vector3([own[0], own[1], own[2]]);
                }
                _ => {}
            }
        }
        workspace.fields[i] = field;
        workspace.wrenches[i] = field.wrench(&body.base_inertia);
    }
}

/// Whether body `i` is a base that floats in the world. (One with rotors does not fall freely.)
pub(in crate::equations) fn is_base<S: Scalar>(model: &Mechanism<S>, i: usize) -> bool {
    let body = &model.bodies[i];
    let floats = body.parent.is_none() && body.elementary_joint == ElementaryJoint::Floating;
    floats && model.dofs_of(i).iter().all(|dof| dof.armature.is_none())
}

/// The linear acceleration, as its joint has it, of a floating base `i` in free fall:
/// g - omega x v.
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
