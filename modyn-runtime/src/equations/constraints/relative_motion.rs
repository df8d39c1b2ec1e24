//! The motion of a constraint's second frame relative to its first, in the first frame's axes.
//!
//! Only the bodies between the frames and their closest common ancestor take part.

use alloc::vec::Vec;

use crate::Scalar;
use crate::equations::kinematics::kinematic_path::{self, BodyMotion};
use crate::equations::kinematics::links::{LinkInBody, add_columns};
use crate::equations::{State, Workspace};
use crate::mechanism::{BodyFrame, ConstrainedFrames, Mechanism};
use crate::spatial::{Matrix3, Twist, Vector3};

/// Returns the closest common ancestor of a constraint's two bodies; `None` is the world.
pub(super) fn common_ancestor<S>(
    model: &Mechanism<S>,
    constraint: &ConstrainedFrames<S>,
) -> Option<usize> {
    let [mut a, mut b] = constraint.ends.each_ref().map(|end| end.body);
    while a != b {
        // Parents have lower indices than their children, and `None` (the world) is lower than all.
        let later = if a > b { &mut a } else { &mut b };
        *later = later.and_then(|i| model.bodies[i].parent);
    }
    a
}

/// Returns the bodies from a frame's body towards the world, without `ancestor` and its ancestors.
pub(super) fn path<S>(
    model: &Mechanism<S>,
    end: BodyFrame<S>,
    ancestor: Option<usize>,
) -> impl Iterator<Item = usize> {
    kinematic_path::towards_world(model, end.body).take_while(move |&i| Some(i) != ancestor)
}

/// Returns a frame as seen from the body `ancestor`. For each body on the path, `visit` is called
/// with the frame as seen from that body.
pub(super) fn relative_to_ancestor<S: Scalar>(
    model: &Mechanism<S>,
    end: BodyFrame<S>,
    ancestor: Option<usize>,
    q: &[S],
    mut visit: impl FnMut(usize, &LinkInBody<S>),
) -> LinkInBody<S> {
    path(model, end, ancestor).fold(LinkInBody::fixed(&end.pose), |seen, i| {
        visit(i, &seen);
        seen.towards_world(&model.bodies[i], q)
    })
}

/// Returns the relative pose of a loop constraint's two frames, and fills `columns` with the
/// Jacobian of each frame relative to the common ancestor, in the frame's axes.
pub(super) fn relative_columns<S: Scalar>(
    model: &Mechanism<S>,
    constraint: &ConstrainedFrames<S>,
    q: &[S],
    columns: &mut [Vec<Twist<S>>; 2],
) -> RelativePose<S> {
    let ancestor = common_ancestor(model, constraint);
    let columns_of = |end, columns: &mut [Twist<S>]| {
        columns.fill(Twist::zero());
        relative_to_ancestor(model, end, ancestor, q, |i, seen| {
            add_columns(model, i, &seen.axes, seen.point, columns);
        })
    };
    let [a, b] = constraint.ends;
    let [first, second] = columns;
    RelativePose::new(&[columns_of(a, first), columns_of(b, second)])
}

/// The pose of the second frame relative to the first.
pub(super) struct RelativePose<S> {
    /// The second frame's axes in the first frame, as columns.
    rotation: Matrix3<S>,
    /// The second frame's origin in the first frame, m.
    origin: Vector3<S>,
}

impl<S: Scalar> RelativePose<S> {
    /// Returns the relative pose of two frames, both seen from their common ancestor.
    pub(super) fn new([first, second]: &[LinkInBody<S>; 2]) -> Self {
        Self {
            rotation: first.axes.times(&second.axes.transposed()),
            origin: first.axes.mul_vector(second.point - first.point),
        }
    }

    /// Rotates a twist from the second frame's axes into the first frame's axes.
    fn rotated(&self, second: Twist<S>) -> Twist<S> {
        let Twist { angular, linear } = second;
        Twist {
            angular: self.rotation.mul_vector(angular),
            linear: self.rotation.mul_vector(linear),
        }
    }

    /// Returns the twist of the second frame relative to the first, at the second frame's origin in
    /// the first frame's axes. The arguments are the twists of both frames, each at its own origin
    /// and in its own axes.
    pub(super) fn twist(&self, first: Twist<S>, second: Twist<S>) -> Twist<S> {
        let second = self.rotated(second);
        Twist {
            angular: second.angular - first.angular,
            linear: second.linear - first.linear - first.angular.cross(self.origin),
        }
    }

    /// Returns the rotation error. For a hinge it is the cross product of the axis directions of
    /// both frames. Otherwise it is the axis of the relative rotation times the sine of its angle.
    fn rotation_error(&self, hinge: Option<Vector3<S>>) -> Vector3<S> {
        if let Some(hinge) = hinge {
            return hinge.cross(self.rotation.mul_vector(hinge));
        }
        let Matrix3([[_, xy, xz], [yx, _, yz], [zx, zy, _]]) = self.rotation;
        Vector3([zy - yz, xz - zx, yx - xy]).scale(S::from_f64(0.5))
    }
}

/// The displacement of the second frame relative to the first, its velocity and its bias
/// acceleration.
pub(super) struct RelativeMotion<S> {
    /// The rotation error (angular) and the position of the second frame's origin (linear).
    pub(super) displacement: Twist<S>,
    pub(super) velocity: Twist<S>,
    /// The time derivative of the velocity's components at constant qd.
    pub(super) jacobian_dot_qd: Twist<S>,
}

impl<S: Scalar> RelativeMotion<S> {
    /// Returns the relative motion at `state` of two frames whose relative pose is `pose`.
    pub(super) fn new(
        model: &Mechanism<S>,
        constraint: &ConstrainedFrames<S>,
        pose: &RelativePose<S>,
        state: State<'_, S>,
        workspace: &mut Workspace<S>,
    ) -> Self {
        let ancestor = common_ancestor(model, constraint);
        let [first, second] = constraint.ends.map(|end| {
            workspace.kinematic_path.clear();
            workspace.kinematic_path.extend(path(model, end, ancestor));
            let bodies = workspace.kinematic_path.iter().rev();
            bodies
                .fold(BodyMotion::at_rest(), |motion, &i| motion.to_child(model, i, state))
                .at(&end.pose)
        });
        let velocity = pose.twist(first.velocity, second.velocity);
        // The second frame's components are in axes that rotate relative to the first frame, and
        // the first frame's velocity at the second frame's origin changes as that origin moves.
        let omega = first.velocity.angular;
        let second_velocity = pose.rotated(second.velocity);
        let transport = Twist {
            angular: velocity.angular.cross(second_velocity.angular),
            linear: velocity.angular.cross(second_velocity.linear) - omega.cross(velocity.linear),
        };
        let rotation_error = pose.rotation_error(constraint.hinge);
        Self {
            displacement: Twist { angular: rotation_error, linear: pose.origin },
            velocity,
            jacobian_dot_qd: pose.twist(first.rate, second.rate) + transport,
        }
    }
}
