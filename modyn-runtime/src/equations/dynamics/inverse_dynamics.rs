//! Inverse dynamics: the joint torques of a motion.

use super::Forces;
use super::newton_euler::{Accelerations, link_wrenches};
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::Prepared;

/// tau = I(q) qdd + h(q, qd) - the external `forces`' share, gravity, rotors and what resists the
/// joints' motion included: the recursive Newton-Euler algorithm.
///
/// Without `qdd` these are the bias forces h(q, qd).
pub fn inverse_dynamics<S: Scalar>(
    model: &Prepared<S>,
    (q, qd, qdd): (&[S], &[S], Option<&[S]>),
    forces: Option<Forces<'_, S>>,
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    workspace.move_to(model, q);
    let accelerations = qdd.map_or(Accelerations::None, Accelerations::Given);
    link_wrenches(model, qd, accelerations, workspace);
    if let Some(forces) = forces {
        forces.subtract(model, workspace);
    }
    tau.fill(S::zero());
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let wrench = workspace.wrenches[i];
        for dof in model.dofs_of(i) {
            let mut felt = wrench.components()[dof.component];
            if let (Some(armature), Some(qdd)) = (dof.armature, qdd) {
                felt = felt + armature * dof.rate(qdd);
            }
            if let Some(resistance) = model.resistance(dof, qd) {
                felt = felt + resistance;
            }
            dof.add(felt, tau);
        }
        body.wrench_to_parents(&workspace.motions[i], wrench, |parent, carried| {
            workspace.wrenches[parent] += carried;
        });
    }
}
