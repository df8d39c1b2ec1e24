//! The residual of the constraints: the displacements and velocities that violate them.

use super::relative_motion::{RelativeMotion, RelativePose, common_ancestor, relative_to_ancestor};
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::Mechanism;
use crate::spatial::Twist;

/// Computes the displacement and the velocity of each constraint's second frame relative to its first,
/// in the first frame's axes. Components along free directions are zero.
///
/// A rotation is given as its axis times the sine of its angle. For a hinge it is the cross product of
/// the axis directions of both frames.
pub fn constraint_residual<S: Scalar>(
    model: &Mechanism<S>,
    (q, qd): (&[S], &[S]),
    workspace: &mut Workspace<S>,
    (displacements, velocities): (&mut [Twist<S>], &mut [Twist<S>]),
) {
    let results = displacements.iter_mut().zip(velocities);
    for (constraint, (displacement, velocity)) in model.loop_constraints.iter().zip(results) {
        let ancestor = common_ancestor(model, constraint);
        let seen =
            constraint.ends.map(|end| relative_to_ancestor(model, end, ancestor, q, |_, _| {}));
        let pose = RelativePose::new(&seen);
        let motion = RelativeMotion::new(model, constraint, &pose, (q, qd), workspace);
        *displacement = constraint.constrained_part(motion.displacement);
        *velocity = constraint.constrained_part(motion.velocity);
    }
}
