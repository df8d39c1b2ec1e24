//! The Jacobian and the bias acceleration of constraints.

use super::ConstraintWorkspaces;
use super::contact::ContactFrame;
use super::relative_motion::{
    RelativeMotion, RelativePose, common_ancestor, relative_columns, relative_to_ancestor,
};
use crate::Scalar;
use crate::equations::kinematics::kinematic_path::{self, OriginMotion};
use crate::equations::{State, Workspace};
use crate::mechanism::{ConstrainedFrames, Mechanism};
use crate::spatial::{Twist, Vector3};

/// Computes the Jacobian of each constraint: a column for each entry of qd. The product with qd is,
/// for a loop constraint, the constrained part of the twist of its second frame relative to its
/// first, in the first frame's axes; for a contact, the constrained part of its frame's twist in
/// world axes.
pub fn constraint_jacobian<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    ConstraintWorkspaces { workspace, memory }: ConstraintWorkspaces<'_, S>,
    columns: &mut [Twist<S>],
) {
    let results = columns.chunks_mut(model.nv.max(1));
    for (constraint, columns) in model.constraints.iter().zip(results) {
        if constraint.contact {
            let end = constraint.ends[1];
            let frame = ContactFrame::new(model, end, q, workspace, columns);
            for column in columns {
                *column = frame.twist_to_world(constraint.constrained_part(*column));
            }
            continue;
        }
        let pose = relative_columns(model, constraint, q, &mut memory.columns);
        let [first, second] = &memory.columns;
        for (column, (&a, &b)) in columns.iter_mut().zip(first.iter().zip(second)) {
            *column = constraint.constrained_part(pose.twist(a, b));
        }
    }
}

/// Computes the bias acceleration of each constraint: the time derivative of its Jacobian times qd,
/// in the same axes.
pub fn constraint_jacobian_dot_qd<S: Scalar>(
    model: &Mechanism<S>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
    accelerations: &mut [Twist<S>],
) {
    for (constraint, acceleration) in model.constraints.iter().zip(accelerations) {
        *acceleration = if constraint.contact {
            contact_jacobian_dot_qd(model, constraint, State { q, qd })
        } else {
            let ancestor = common_ancestor(model, constraint);
            let seen =
                constraint.ends.map(|end| relative_to_ancestor(model, end, ancestor, q, |_, _| {}));
            let pose = RelativePose::new(&seen);
            let motion = RelativeMotion::new(model, constraint, &pose, State { q, qd }, workspace);
            constraint.constrained_part(motion.jacobian_dot_qd)
        };
    }
}

/// Returns the classical acceleration of a contact's frame at zero joint accelerations, in world
/// axes.
fn contact_jacobian_dot_qd<S: Scalar>(
    model: &Mechanism<S>,
    constraint: &ConstrainedFrames<S>,
    State { q, qd }: State<'_, S>,
) -> Twist<S> {
    let end = constraint.ends[1];
    let fixed = OriginMotion::fixed(Vector3(end.pose.translation));
    let motion = kinematic_path::towards_world(model, end.body)
        .fold(fixed, |frame, i| frame.towards_world(model, i, State { q, qd }, None));
    // A point's rows are all displacements, a surface's all six: the axes do not matter.
    constraint.constrained_part(motion.acceleration)
}
