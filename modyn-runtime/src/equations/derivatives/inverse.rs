//! Derivatives of inverse dynamics.

use super::composite::{gather, gather_wrenches};
use super::deviation::{by_coordinates, by_rates};
use super::projection::{By, project};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::mechanism::Prepared;

/// d tau / d q and d tau / d qd of [`inverse_dynamics`](crate::equations::inverse_dynamics), nv x nv
/// by columns; d tau / d qdd is the [`mass_matrix`](crate::equations::mass_matrix).
///
/// The jump of Coulomb friction counts as slope 0.
pub fn inverse_dynamics_derivatives<S: Scalar>(
    model: &Prepared<S>,
    (q, qd, qdd): (&[S], &[S], &[S]),
    workspace: &mut Workspace<S>,
    dtau_dq: &mut [S],
    dtau_dqd: &mut [S],
) {
    workspace.move_to(model, q);
    link_wrenches(model, qd, Accelerations::Given(qdd), workspace);
    gather(model, qd, workspace);
    gather_wrenches(model, |_| None, workspace);
    by_coordinates(model, qd, false, workspace);
    project(model, By::Coordinates, workspace, dtau_dq, None);
    by_rates(model, qd, false, workspace);
    project(model, By::Rates, workspace, dtau_dqd, None);
    add_resistance(model, qd, dtau_dqd);
}

/// Adds what damping and friction do to d tau / d qd.
pub(super) fn add_resistance<S: Scalar>(model: &Prepared<S>, qd: &[S], dtau_dqd: &mut [S]) {
    for dof in &model.dofs {
        if let Some(slope) = model.resistance_slope(dof, qd) {
            let sum = &mut dtau_dqd[dof.v * model.nv + dof.v];
            *sum = *sum + dof.scale(dof.scale(slope));
        }
    }
}
