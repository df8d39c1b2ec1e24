//! The residual of the constraints: the displacements and velocities that violate them.

use super::contact::ContactFrame;
use super::relative_motion::{RelativeMotion, RelativePose, common_ancestor, relative_to_ancestor};
use super::{ConstraintWorkspaces, ResidualOutputs};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::State;
use crate::mechanism::Mechanism;

/// Computes the displacement and the velocity of each loop constraint's second frame relative to
/// its first, in the first frame's axes, and of each contact's frame relative to its target, in
/// world axes. Components along free directions are zero.
///
/// A rotation is given as its axis times the sine of its angle. For a hinge it is the cross product
/// of the axis directions of both frames; for a surface on a plane, the cross product of the two
/// normals.
pub fn constraint_residual<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    targets: &[ContactTarget<S>],
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    ResidualOutputs { displacements, velocities }: ResidualOutputs<'_, S>,
) {
    let columns = &mut memory.columns[0];
    let loops = model.constraints.len() - model.contacts();
    let results = displacements.iter_mut().zip(velocities);
    for ((c, constraint), (displacement, velocity)) in
        model.constraints.iter().enumerate().zip(results)
    {
        if constraint.contact {
            let frame = ContactFrame::new(model, constraint.ends[1], q, workspace, columns);
            let surface = constraint.holds_rotation();
            let target = &targets[c - loops];
            *displacement = frame.displacement(target, surface);
            let motion = frame.motion(model, target, surface, columns, qd, workspace);
            *velocity = frame.twist_to_world(constraint.constrained_part(motion.velocity));
            continue;
        }
        let ancestor = common_ancestor(model, constraint);
        let seen =
            constraint.ends.map(|end| relative_to_ancestor(model, end, ancestor, q, |_, _| {}));
        let pose = RelativePose::new(&seen);
        let motion = RelativeMotion::new(model, constraint, &pose, State { q, qd }, workspace);
        *displacement = constraint.constrained_part(motion.displacement);
        *velocity = constraint.constrained_part(motion.velocity);
    }
}
