//! Masses and first moments of the bodies, summed towards the root.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, BodyTree, Mechanism};
use crate::spatial::{RigidInertia, Vector3};

/// Returns the first moment of mass in world axes. Expects the joint transforms at q.
pub(in crate::equations) fn first_moment<S: Scalar>(
    model: &Mechanism<S>,
    workspace: &mut Workspace<S>,
    inertia: impl Fn(&Body<S>) -> RigidInertia<S>,
) -> Vector3<S> {
    accumulate_masses(model, workspace, inertia);
    let mut first_moment = Vector3::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        if body.parent.is_none() {
            let whole = workspace.composite[i];
            let motion = &workspace.motions[i];
            first_moment += body.mass_to_parent(motion, whole.mass, whole.first_moment).1;
        }
    }
    first_moment
}

/// Sums masses and first moments towards the root.
pub(in crate::equations) fn accumulate_masses<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    workspace: &mut Workspace<S>,
    inertia: impl Fn(&Body<S>) -> RigidInertia<S>,
) {
    let model = tree.mechanism();
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = inertia(body);
    }
    for i in (0..model.bodies.len()).rev() {
        let whole = workspace.composite[i];
        let motion = &workspace.motions[i];
        tree.mass_to_parents(
            i,
            motion,
            whole.mass,
            whole.first_moment,
            |parent, (mass, moment)| {
                let composite = &mut workspace.composite[parent];
                composite.mass = composite.mass + mass;
                composite.first_moment += moment;
            },
        );
    }
}
