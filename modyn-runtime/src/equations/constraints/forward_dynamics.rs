//! Forward dynamics with loop constraints.

use super::ConstraintWorkspace;
use super::rows::constraint_rows;
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::equations::dynamics::inverse_dynamics;
use crate::mechanism::Mechanism;
use crate::results::ConstraintSettings;
use crate::spatial::{Twist, Wrench};

/// Computes the joint accelerations `qdd` under the joint forces `tau`, with all constraints satisfied.
/// Returns the number of independent rows.
///
/// `wrenches` receives, for each constraint, the wrench on its second link. `residuals` receives the
/// part of the required relative acceleration that contradictory rows leave unmet. Wrenches and
/// residuals are expressed in the first frame's axes, at the second frame's origin.
///
/// Featherstone 2008, "Rigid Body Dynamics Algorithms", chapter 8.
pub fn constrained_forward_dynamics<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    (q, qd, tau): (&[S], &[S], &[S]),
    settings: &ConstraintSettings<S>,
    (workspace, room): (&mut Workspace<S>, &mut ConstraintWorkspace<S>),
    (qdd, wrenches, residuals): (&mut [S], &mut [Wrench<S>], &mut [Twist<S>]),
) -> S {
    inverse_dynamics(model, (q, qd, None), None, workspace, qdd);
    for (qdd, &tau) in qdd.iter_mut().zip(tau) {
        *qdd = tau - *qdd;
    }
    brge::factorize(model, layout, q, workspace, &mut room.factors);
    brge::solve(layout, &room.factors, qdd);

    let two_alpha = settings.alpha + settings.alpha;
    let beta_squared = settings.beta * settings.beta;
    constraint_rows(model, (q, qd), workspace, room, |component, motion| {
        let damping = two_alpha * component(motion.velocity);
        let stiffness = beta_squared * component(motion.displacement);
        [-component(motion.bias_acceleration) - (damping + stiffness), S::zero()]
    });
    room.subtract_accelerations(qdd);
    room.factorize(model, layout, settings);
    room.solve(0);
    room.add_response(0, qdd);
    let (mut multipliers, mut missed) = (room.right_hand_sides[0].iter(), room.residuals.iter());
    let results = wrenches.iter_mut().zip(residuals).zip(&model.loop_constraints);
    for ((wrench, residual), constraint) in results {
        let Twist { angular, linear } = constraint.along_rows(multipliers.by_ref().copied());
        *wrench = Wrench { moment: angular.scale(constraint.length), force: linear };
        let Twist { angular, linear } = constraint.along_rows(missed.by_ref().copied());
        *residual = Twist { angular: angular.scale(constraint.length.recip()), linear };
    }
    room.factorization.rank()
}
