//! The wrenches that a motion asks of each link by itself, by Newton and Euler.
//!
//! Accelerations are the classical ones of the links' origins, in the links' own axes (see
//! [`Field`](crate::spatial::Field)). Gravity is an acceleration of the world upwards.

use super::Workspace;
use crate::Scalar;
use crate::joint::Carried;
use crate::model::prepare::Prepared;
use crate::spatial::Vector3;

/// Fills `workspace.wrenches` with each link's own wrench, those of its children left out.
///
/// Without `qdd` all joint accelerations are zero. Expects the joints at q.
pub(super) fn link_wrenches<S: Scalar>(
    model: &Prepared<S>,
    qd: &[S],
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
) {
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let to_child = |v| body.to_child(motion, v);
        let (omega, alpha, a) = match body.parent {
            None => (Vector3::zero(), Vector3::zero(), to_child(-model.gravity)),
            Some(parent) => {
                let parent = &workspace.fields[parent];
                let at_joint = parent.over_origin(body.placement.origin());
                (to_child(parent.omega), to_child(parent.alpha), to_child(parent.a + at_joint))
            }
        };
        let carried = Carried { omega, alpha, a };
        workspace.fields[i] = motion.accelerate(carried, qd[i], qdd.map(|qdd| qdd[i]));
        workspace.wrenches[i] = workspace.fields[i].wrench(&body.minimal);
    }
}
