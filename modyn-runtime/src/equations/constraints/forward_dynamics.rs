//! Forward dynamics with loop constraints and contacts.

use super::rows::constraint_rows;
use super::{ConstrainedOutputs, ConstraintInput, ConstraintWorkspaces};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::dynamics::bias_in_free_fall;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::{ForwardInput, State, brge};

/// Computes the joint accelerations `qdd` under the joint forces `tau`, with all constraints
/// satisfied. Returns the number of independent rows.
///
/// `wrenches` receives, for each constraint, the wrench on its second link. `residuals` receives
/// the part of the required relative acceleration that contradictory rows leave unmet. Both are at
/// the second frame's origin, in the first frame's axes for loop constraints and in world axes for
/// contacts.
///
/// The acceleration of a floating base's origin is computed relative to free fall, as in
/// [`forward_dynamics`](crate::equations::dynamics::forward_dynamics).
///
/// Limbs of `tree` may be merged, each group on one body, and their contacts with them. A merged
/// contact then stands for a contact of each limb, in the settings and in the results.
///
/// Featherstone 2008, "Rigid Body Dynamics Algorithms", chapter 8.
pub fn constrained_forward_dynamics<S: Scalar, T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
    tree: &T,
    layout: &T::Layout,
    ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    ConstrainedOutputs { qdd, wrenches, residuals }: ConstrainedOutputs<'_, S>,
) -> S {
    let model = tree.mechanism();
    bias_in_free_fall(tree, State { q, qd }, workspace, qdd);
    for (qdd, &tau) in qdd.iter_mut().zip(tau) {
        *qdd = tau - *qdd;
    }
    brge::factorize(tree, layout.layout(), q, workspace, &mut memory.factors);
    memory.set_force(layout, qdd);
    memory.set_fall(model, qd, workspace);
    let targets = settings.targets.as_ref();
    let loops = model.constraints.len() - targets.len();
    constraint_rows(model, State { q, qd }, targets, workspace, memory, |c, component, motion| {
        let (alpha, beta) = match c.checked_sub(loops) {
            None => (settings.alpha, settings.beta),
            Some(contact) => (targets[contact].alpha, targets[contact].beta),
        };
        let damping = (alpha + alpha) * component(motion.velocity);
        let stiffness = beta * beta * component(motion.displacement);
        [-component(motion.jacobian_dot_qd) - (damping + stiffness), S::zero()]
    });
    memory.factorize(tree, layout, ConstraintInput { active, settings }, |memory| {
        memory.subtract_accelerations(model, layout)
    });
    memory.solve(tree, 0);
    memory.respond(layout, 0, qdd);
    for (qdd, &fall) in qdd.iter_mut().zip(&memory.fall) {
        *qdd = *qdd + fall;
    }
    memory.wrenches(model, 0, wrenches);
    memory.missed(model, residuals);
    memory.factorization.rank()
}
