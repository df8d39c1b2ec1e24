//! Inverse dynamics of a robot that stands on its contacts.

use super::factorization::Factorization;
use super::rows::constraint_rows;
use super::{
    ConstrainedInverseOutputs, ConstraintInput, ConstraintWorkspace, ConstraintWorkspaces,
};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::dynamics::inverse_dynamics;
use crate::equations::{Motion, State};
use crate::joint::ElementaryJoint;
use crate::mechanism::Mechanism;

/// Returns the indices in qd of the velocities of floating joints, which have no motor.
pub(super) fn unactuated<S>(model: &Mechanism<S>) -> impl Iterator<Item = usize> + '_ {
    let floats =
        |d: usize| model.bodies[model.dofs[d].body].elementary_joint == ElementaryJoint::Floating;
    (0..model.dofs.len()).filter(move |&d| floats(d)).map(|d| model.dofs[d].v)
}

/// Returns whether an entry of qd is a rotation.
fn is_rotation<S>(model: &Mechanism<S>, v: usize) -> bool {
    model.dofs.iter().any(|dof| dof.v == v && dof.axis().is_angular())
}

/// Computes the joint forces `tau` of the accelerations `qdd`, and the wrenches of the active
/// contacts that carry the floating bases. Returns the number of independent directions in which
/// the contacts carry the bases.
///
/// The wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight over the contacts. The
/// entries of `tau` of a floating base are the wrench on it that no contact can carry: zero within
/// rounding if the contacts suffice. The wrenches of loop constraints are zero.
///
/// ```text
/// tau + J^T lambda = M qdd + h,  lambda = W J_b (J_b^T W J_b)^+ (M qdd + h)_b
/// ```
///
/// with the columns J_b of the bases.
pub fn constrained_inverse_dynamics<S: Scalar, C: AsRef<[ContactTarget<S>]>>(
    model: &Mechanism<S>,
    Motion { q, qd, qdd }: Motion<'_, S>,
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    ConstrainedInverseOutputs { tau, wrenches }: ConstrainedInverseOutputs<'_, S>,
) -> S {
    inverse_dynamics(model, State { q, qd }, Some(qdd), None, workspace, tau);
    let targets = settings.targets.as_ref();
    constraint_rows(model, State { q, qd }, targets, workspace, memory, |_, _, _| [S::zero(); 2]);
    let n = model.nv.max(1);
    let loops = model.constraints.len() - targets.len();
    let ConstraintWorkspace { jacobian, owner, carried, right_hand_sides, residuals, .. } = memory;
    let Carried { entries, factorization, forces, missed, weights } = carried;
    for (weight, &constraint) in weights.iter_mut().zip(&*owner) {
        *weight = constraint
            .checked_sub(loops)
            .map_or(S::zero(), |contact| active[contact] * targets[contact].weight);
    }
    // Moments are divided by the mean characteristic length of the contacts, so all rows are
    // forces.
    let lengths = model.constraints[loops..].iter().map(|contact| contact.length);
    let count = S::from_f64(targets.len() as f64);
    let length =
        lengths.reduce(|sum, length| sum + length).map_or(S::one(), |sum| sum * count.recip());
    let scale = |v: usize| if is_rotation(model, v) { length.recip() } else { S::one() };
    let rows = weights.len();
    let column = |row: usize, v: usize| jacobian[row * n + v] * scale(v);
    factorization.fill(|i, j| {
        let i = entries[i];
        let j = entries[j];
        let products = (0..rows).map(|row| column(row, i) * (weights[row] * column(row, j)));
        products.reduce(|sum, x| sum + x).unwrap_or(S::zero())
    });
    let trace = factorization.trace();
    factorization.factorize(&[trace], settings.tolerance, settings.rounding);
    for (force, &v) in forces.iter_mut().zip(&*entries) {
        *force = tau[v] * scale(v);
    }
    factorization.solve(forces, missed);
    let multipliers = &mut right_hand_sides[0];
    for (row, multiplier) in multipliers.iter_mut().enumerate() {
        let products = entries.iter().zip(&*forces).map(|(&v, &force)| column(row, v) * force);
        let sum = products.reduce(|sum, x| sum + x).unwrap_or(S::zero());
        *multiplier = weights[row] * sum;
        for (tau, &entry) in tau.iter_mut().zip(&jacobian[row * n..][..n]) {
            *tau = *tau - entry * *multiplier;
        }
    }
    residuals.fill(S::zero());
    memory.wrenches(model, 0, wrenches);
    memory.carried.factorization.rank()
}

/// Memory for the wrenches that carry floating bases.
#[derive(Clone, Debug)]
pub(super) struct Carried<S> {
    /// The indices in qd of the velocities of floating joints.
    pub(super) entries: alloc::vec::Vec<usize>,
    pub(super) factorization: Factorization<S>,
    forces: alloc::vec::Vec<S>,
    missed: alloc::vec::Vec<S>,
    /// For each constrained row, the weight of its contact; zero if the contact is not active.
    weights: alloc::vec::Vec<S>,
}

impl<S: Scalar> Carried<S> {
    pub(super) fn new(model: &Mechanism<S>, rows: usize) -> Self {
        let entries: alloc::vec::Vec<usize> = unactuated(model).collect();
        let count = entries.len();
        let factorization = Factorization::new(core::iter::once((count, count)));
        let numbers = |count| alloc::vec![S::zero(); count];
        Self {
            factorization,
            forces: numbers(count),
            missed: numbers(count),
            weights: numbers(rows),
            entries,
        }
    }
}
