//! The impulses of a step with contacts, in a fixed number of sweeps.

use alloc::vec::Vec;

use super::contact_problem::ContactProblemOutputs;
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::solve::{Contact, GroundEquations, add_scaled, relative_velocity, soften};

/// The sweeps of a step. Three are typical for feet of different legs, and the next step starts
/// from the impulses of the last.
const SWEEPS: usize = 6;

/// Finds the impulses of a step of the time `dt` on the ground of `targets`, from the impulses of
/// the last step on, and adds their effects to the velocities of the problem. Returns the largest
/// velocity of a contact that contradicts the laws of contacts.
///
/// `impulses` are along the rows of the contacts: two directions in the plane, then the normal.
pub fn sweep_contacts<S: Scalar>(
    problem: &mut ContactProblemOutputs<'_, S>,
    dt: S,
    targets: &[ContactTarget<S>],
    impulses: &mut [S],
) -> S {
    let rows = impulses.len();
    let mut a: Vec<Vec<S>> = problem.mobility.chunks(rows.max(1)).map(<[S]>::to_vec).collect();
    soften(targets, &mut a);
    let mut b = Vec::with_capacity(rows);
    for (c, target) in targets.iter().enumerate() {
        let motion = [problem.heights[c], problem.before[c].0[2], dt];
        b.extend(relative_velocity(problem.free[c].0, motion, target));
    }
    let mut contacts: Vec<_> = targets.iter().map(|target| Contact::new(target.friction)).collect();
    let mut equations = GroundEquations { a: &a, b: &b, contacts: &mut contacts, stops: &mut [] };
    let residual = equations.sweep_times(impulses, SWEEPS);
    let velocities = problem.responses.chunks(problem.qd.len().max(1));
    for (response, &impulse) in velocities.zip(&*impulses) {
        add_scaled(problem.qd, impulse, response);
    }
    residual
}
