//! Impulses: the velocities after an impact.

use super::rows::constraint_rows;
use super::{ConstraintInput, ConstraintWorkspaces, ImpulseOutputs};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::{State, brge};
use crate::spatial::Matrix3;

/// Computes the velocities `after` an impact that satisfies the constraints at once, and the
/// impulse on each constraint's second link, in the axes and at the point of its
/// [wrench](super::constrained_forward_dynamics). Returns the number of independent rows.
///
/// Along the normal of its target, a contact's frame leaves with `restitution` times its speed
/// before the impact. In all other directions it has the velocity of the target.
///
/// Limbs of `tree` may be merged, as in
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics).
///
/// ```text
/// M (qd+ - qd) = J^T lambda,  J qd+ = -e n n^T J qd
/// ```
pub fn impact_dynamics<S: Scalar, T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
    tree: &T,
    layout: &T::Layout,
    State { q, qd }: State<'_, S>,
    ConstraintInput { active, settings }: ConstraintInput<'_, S, C>,
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    ImpulseOutputs { qd: after, impulses }: ImpulseOutputs<'_, S>,
) -> S {
    let model = tree.mechanism();
    brge::factorize(tree, layout.layout(), q, workspace, &mut memory.factors);
    let targets = settings.targets.as_ref();
    constraint_rows(model, State { q, qd }, targets, workspace, memory, |_, component, motion| {
        [-component(motion.velocity), S::zero()]
    });
    let mut row = 0;
    let mut touching = memory.frames.iter().zip(targets);
    for constraint in &model.constraints {
        let rows = row..row + constraint.rows.len();
        row = rows.end;
        let Some((frame, target)) = constraint.contact.then(|| touching.next()).flatten() else {
            continue;
        };
        let normal = frame.to_root(Matrix3(target.pose.rotation).column(2));
        // The displacements are the first three rows.
        let stops = &mut memory.right_hand_sides[0][rows.start..][..3];
        let approach = (0..3).fold(S::zero(), |sum, k| sum + normal[k] * stops[k]);
        let rebound = target.restitution * approach;
        stops.iter_mut().zip(normal.0).for_each(|(stop, n)| *stop = *stop + rebound * n);
    }
    memory.factorize(tree, layout, ConstraintInput { active, settings }, |_| {});
    memory.force.fill(S::zero());
    memory.solve(tree, 0);
    memory.respond(layout, 0, after);
    for (after, &before) in after.iter_mut().zip(qd) {
        *after = before + *after;
    }
    memory.wrenches(model, 0, impulses);
    memory.factorization.rank()
}
