//! The kinematic path of a link: its body and the body's ancestors. The link's motion depends on no
//! other body.

use alloc::vec::Vec;

use crate::Scalar;
use crate::equations::{State, Workspace};
use crate::joint::JointTransform;
use crate::mechanism::Mechanism;
use crate::spatial::{Matrix3, Pose, Twist, Vector3};

/// Returns body `last` and its ancestors, from the body towards the world.
pub(in crate::equations) fn towards_world<S>(
    model: &Mechanism<S>,
    last: Option<usize>,
) -> impl Iterator<Item = usize> {
    core::iter::successors(last, |&i| model.bodies[i].parent)
}

/// Stores body `last` and its ancestors in `path`, from the world towards the body.
pub(in crate::equations) fn from_world<S>(
    model: &Mechanism<S>,
    last: Option<usize>,
    path: &mut Vec<usize>,
) {
    path.clear();
    path.extend(towards_world(model, last));
    path.reverse();
}

/// Computes the joint transforms and the axes in the world of body `last` and its ancestors. Stores
/// these bodies in the workspace's path.
pub(in crate::equations) fn move_to_world<S: Scalar>(
    model: &Mechanism<S>,
    last: usize,
    q: &[S],
    workspace: &mut Workspace<S>,
) {
    from_world(model, Some(last), &mut workspace.kinematic_path);
    for k in 0..workspace.kinematic_path.len() {
        let i = workspace.kinematic_path[k];
        workspace.motions[i] = model.bodies[i].motion(q);
        rotate_axes(model, i, workspace);
    }
}

/// Computes body `i`'s axes in the world. Expects the joint transform and the parent's axes.
pub(in crate::equations) fn rotate_axes<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    workspace: &mut Workspace<S>,
) {
    workspace.axes[i] = workspace.motions[i].rotate_axes(&axes_at_joint(model, i, workspace));
}

/// Returns the world axes of body `i`'s degrees of freedom. A joint axis is the same before and
/// after the joint, and the axes before the joint need one rotation less.
pub(in crate::equations) fn joint_axes<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    workspace: &Workspace<S>,
) -> Matrix3<S> {
    if model.bodies[i].elementary_joint.has_axis() {
        axes_at_joint(model, i, workspace)
    } else {
        workspace.axes[i]
    }
}

/// Returns the world axes of the frame before body `i`'s joint.
fn axes_at_joint<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    workspace: &Workspace<S>,
) -> Matrix3<S> {
    let body = &model.bodies[i];
    let world = || Matrix3(Pose::identity().rotation);
    body.placement.rotate_axes(&body.parent.map_or_else(world, |parent| workspace.axes[parent]))
}

/// The motion of a link's origin relative to one of the link's ancestors, in that ancestor's axes.
#[derive(Clone, Copy)]
pub(in crate::equations) struct OriginMotion<S> {
    /// The position of the link's origin.
    pub(in crate::equations) point: Vector3<S>,
    pub(in crate::equations) velocity: Twist<S>,
    /// The angular acceleration, and the classical acceleration of the link's origin.
    pub(in crate::equations) acceleration: Twist<S>,
}

impl<S: Scalar> OriginMotion<S> {
    /// Returns the motion of a link that is fixed to the body.
    pub(in crate::equations) fn fixed(point: Vector3<S>) -> Self {
        Self { point, velocity: Twist::zero(), acceleration: Twist::zero() }
    }

    /// Returns the motion relative to body `i`'s parent, from the motion relative to body `i`.
    pub(in crate::equations) fn towards_world(
        self,
        model: &Mechanism<S>,
        i: usize,
        State { q, qd }: State<'_, S>,
        qdd: Option<&[S]>,
    ) -> Self {
        let body = &model.bodies[i];
        let motion = body.motion(q);
        let rates = model.add_rates(i, Twist::zero(), qd);
        let changes = qdd.map(|qdd| model.add_rates(i, Twist::zero(), qdd));
        // A joint axis has the same components before the joint, where the vectors that are fixed
        // to the link are already rotated.
        let at_joint = if body.elementary_joint.has_axis() {
            self.across_joint(&motion).with_joint_motion(rates, changes)
        } else {
            self.with_joint_motion(rates, changes).across_joint(&motion)
        };
        let rotated = at_joint.rotated(|v| body.placement.to_parent(v));
        Self { point: body.placement.point_to_parent(at_joint.point), ..rotated }
    }

    /// Rotates the motion into the axes before the joint. It stays relative to the body.
    fn across_joint(self, motion: &JointTransform<S>) -> Self {
        let rotated = self.rotated(|v| motion.to_parent(v));
        Self { point: motion.point_to_parent(self.point), ..rotated }
    }

    fn rotated(self, rotate: impl Fn(Vector3<S>) -> Vector3<S>) -> Self {
        let twist = |t: Twist<S>| Twist { angular: rotate(t.angular), linear: rotate(t.linear) };
        let velocity = twist(self.velocity);
        let acceleration = twist(self.acceleration);
        Self { velocity, acceleration, ..self }
    }

    /// Adds the motion of the body's joint: its velocity `rates` and its acceleration `changes`.
    fn with_joint_motion(self, rates: Twist<S>, changes: Option<Twist<S>>) -> Self {
        let Self { point, velocity: before, acceleration } = self;
        let omega = rates.angular;
        let over_origin = |t: Twist<S>| Twist { linear: t.linear + t.angular.cross(point), ..t };
        let velocity = before + over_origin(rates);
        // Centripetal and Coriolis: omega x (v_joint + omega x point) + 2 omega x v.
        let coriolis = Twist {
            angular: omega.cross(before.angular),
            linear: omega.cross(before.linear + velocity.linear),
        };
        let mut acceleration = acceleration + coriolis;
        if let Some(changes) = changes {
            acceleration = acceleration + over_origin(changes);
        }
        Self { point, velocity, acceleration }
    }
}

/// A body's velocity in its own axes at its origin, and the time derivative of these six components
/// at constant joint rates: the spatial acceleration.
#[derive(Clone, Copy)]
pub(in crate::equations) struct BodyMotion<S> {
    pub(in crate::equations) velocity: Twist<S>,
    pub(in crate::equations) rate: Twist<S>,
}

impl<S: Scalar> BodyMotion<S> {
    /// Returns the motion of the world.
    pub(in crate::equations) fn at_rest() -> Self {
        Self { velocity: Twist::zero(), rate: Twist::zero() }
    }

    /// Returns the motion of body `i`, from its parent's motion.
    pub(in crate::equations) fn to_child(
        self,
        model: &Mechanism<S>,
        i: usize,
        State { q, qd }: State<'_, S>,
    ) -> Self {
        let body = &model.bodies[i];
        let motion = body.motion(q);
        let from_parent = body.twist_to_child(&motion, self.velocity);
        let rates = model.add_rates(i, Twist::zero(), qd);
        // The parent's motion is expressed in axes that rotate and move with the joint.
        let of_rotating_axes = Twist {
            angular: from_parent.angular.cross(rates.angular),
            linear: from_parent.angular.cross(rates.linear)
                + from_parent.linear.cross(rates.angular),
        };
        let rate = body.twist_to_child(&motion, self.rate) + of_rotating_axes;
        Self { velocity: from_parent + rates, rate }
    }

    /// Returns the motion of a frame that is fixed to the body at `pose`.
    pub(in crate::equations) fn at(self, pose: &Pose<S>) -> Self {
        let axes = Matrix3(pose.rotation).transposed();
        let point = Vector3(pose.translation);
        let twist = |t: Twist<S>| Twist {
            angular: axes.mul_vector(t.angular),
            linear: axes.mul_vector(t.linear + t.angular.cross(point)),
        };
        Self { velocity: twist(self.velocity), rate: twist(self.rate) }
    }
}
