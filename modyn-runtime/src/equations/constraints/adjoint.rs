//! The adjoint of the equations of forward dynamics with loop constraints and contacts.

use alloc::{vec, vec::Vec};

use super::rows::constraint_rows;
use super::{ConstrainedCotangent, ConstraintInput, ConstraintWorkspaces};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::State;
use crate::equations::brge::{self, UduLayout};
use crate::mechanism::Mechanism;
use crate::spatial::{Twist, Wrench};

/// The solution of the adjoint of the equations of forward dynamics.
#[derive(Clone, Debug)]
pub struct ConstraintAdjoint<S> {
    /// The accelerations a.
    pub accelerations: Vec<S>,
    /// The wrench b of each constraint.
    pub wrenches: Vec<Wrench<S>>,
}

/// Returns the accelerations a and the wrenches b that solve the adjoint of the equations of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics),
///
/// ```text
/// I a + J^T b = x,  -J a + E b = y
/// ```
///
/// where E is the compliance of the contacts, x the weights of the joint accelerations, and y the
/// weights of the components of the constraints' wrenches. With K, L and A of
/// the [derivatives](super::ConstrainedDerivatives), a = K x - L y and b = L^T x + A^+ y. The
/// derivative of x^T qdd + y^T lambda is the derivative of -a^T (I qdd + h - tau - J^T lambda)
/// - b^T (J qdd - gamma) at constant a, b, qdd and lambda.
///
/// Where rows depend on others, b has the smallest norm, and y counts along the rows' range alone.
/// The wrenches b are zero for inactive contacts.
pub fn constraint_adjoint<S: Scalar, C: AsRef<[ContactTarget<S>]>>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    q: &[S],
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    weights: ConstrainedCotangent<'_, S>,
) -> ConstraintAdjoint<S> {
    let mut adjoint = ConstraintAdjoint {
        accelerations: vec![S::zero(); model.nv],
        wrenches: vec![Wrench::zero(); model.constraints.len()],
    };
    brge::factorize(model, layout, q, workspace, &mut memory.factors);
    memory.set_force(layout, weights.qdd);
    memory.fall.fill(S::zero());
    let rest = core::mem::take(&mut memory.rest);
    let targets = settings.targets.as_ref();
    let zeros = |_, _: &dyn Fn(Twist<S>) -> S, _: &_| [S::zero(), S::zero()];
    constraint_rows(model, State { q, qd: &rest }, targets, workspace, memory, zeros);
    memory.rest = rest;
    memory.factorize(model, layout, ConstraintInput { active, settings }, |memory| {
        let mut sides = memory.right_hand_sides[0].iter_mut();
        let mut frames = memory.frames.iter();
        for (constraint, weights) in model.constraints.iter().zip(weights.wrenches) {
            let frame = constraint.contact.then(|| frames.next()).flatten();
            let in_axes = |v| frame.map_or(v, |frame| frame.to_root(v));
            let angular = in_axes(weights.moment);
            let linear = in_axes(weights.force);
            let weights = Twist { angular, linear };
            for (row, side) in constraint.rows.iter().zip(&mut sides) {
                *side = -row.scaled_component(weights, constraint.length);
            }
        }
        memory.subtract_accelerations(model, layout);
    });
    memory.solve(model, 0);
    memory.respond(layout, 0, &mut adjoint.accelerations);
    memory.wrenches(model, 0, &mut adjoint.wrenches);
    for wrench in &mut adjoint.wrenches {
        *wrench = Wrench { moment: -wrench.moment, force: -wrench.force };
    }
    adjoint
}
