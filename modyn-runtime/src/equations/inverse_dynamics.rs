//! Inverse dynamics: the joint torques of a motion.

use super::Workspace;
use super::newton_euler::link_wrenches;
use crate::Scalar;
use crate::model::prepare::Prepared;

/// tau = I(q) qdd + h(q, qd), gravity included: the recursive Newton-Euler algorithm.
///
/// Without `qdd` these are the bias forces h(q, qd).
pub fn inverse_dynamics<S: Scalar>(
    model: &Prepared<S>,
    q: &[S],
    qd: &[S],
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    workspace.move_to(model, q);
    link_wrenches(model, qd, qdd, workspace);
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let (motion, wrench) = (&workspace.motions[i], workspace.wrenches[i]);
        tau[i] = motion.project(&wrench);
        if let Some(parent) = body.parent {
            let carried = body.wrench_to_parent(motion, wrench);
            workspace.wrenches[parent] += carried;
        }
    }
}
