//! The adjoint of the equations of forward dynamics with loop constraints and contacts.

use super::rows::constraint_rows;
use super::{ConstraintWorkspace, Settings};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::mechanism::Mechanism;
use crate::spatial::{Twist, Wrench};

/// Computes the accelerations a and the wrenches b that solve the adjoint of the equations of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics),
///
/// ```text
/// I a + J^T b = x,  -J a + E b = y
/// ```
///
/// where E is the compliance of the contacts, x is a weight for each joint acceleration, and y one
/// for each component of each constraint's wrench, in the axes of that function. With K, L and A of
/// the [derivatives](super::ConstrainedDerivatives), a = K x - L y and b = L^T x + A^+ y. The
/// derivative of x^T qdd + y^T lambda is that of -a^T (I qdd + h - tau - J^T lambda)
/// - b^T (J qdd - gamma) at constant a, b, qdd and lambda.
///
/// Where rows depend on others, b has the smallest norm, and y counts along the rows' range alone.
/// The wrenches b are zero for inactive contacts.
pub fn constraint_adjoint<S: Scalar, C: AsRef<[ContactTarget<S>]>>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    q: &[S],
    (active, settings): Settings<'_, S, C>,
    (workspace, memory): (&mut Workspace<S>, &mut ConstraintWorkspace<S>),
    (x, y): (&[S], &[Wrench<S>]),
    (a, b): (&mut [S], &mut [Wrench<S>]),
) {
    brge::factorize(model, layout, q, workspace, &mut memory.factors);
    memory.set_force(layout, x);
    memory.fall.fill(S::zero());
    let rest = core::mem::take(&mut memory.rest);
    let contacts = settings.contacts.as_ref();
    let zeros = |_, _: &dyn Fn(Twist<S>) -> S, _: &_| [S::zero(), S::zero()];
    constraint_rows(model, (q, &rest), contacts, workspace, memory, zeros);
    memory.rest = rest;
    memory.factorize(model, layout, (active, settings), |memory| {
        let mut sides = memory.right_hand_sides[0].iter_mut();
        let mut frames = memory.frames.iter();
        for (constraint, weights) in model.constraints.iter().zip(y) {
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
    memory.respond(layout, 0, a);
    memory.wrenches(model, 0, b);
    for wrench in b {
        *wrench = Wrench { moment: -wrench.moment, force: -wrench.force };
    }
}
