//! The joints and the bodies that move a point, and the derivatives of its velocity and
//! acceleration.
//!
//! A displacement along a degree of freedom moves all bodies that it carries rigidly. Degree of
//! freedom k gives the point the velocity S_k = (w_k, v_k). The parent of its body has the angular
//! velocity W and the acceleration field E = A x + W x W x. The point moves relative to that parent
//! with the velocity (w, v) and the acceleration (a, b), angular and linear. Then its acceleration
//! has the derivatives
//!
//! ```text
//! by q_k:  angular W x (w_k x w) + w_k x a,  linear E v_k + 2 W x (w_k x v) + w_k x b
//! by qd_k: angular V x w_k + w_k x w,        linear V x v_k + w_k x u + W x v_k + w_k x v
//! ```
//!
//! where V is the angular velocity of the body of k, and u the velocity of the point relative to
//! that body. The joint forces of a wrench at the point that is constant in the root's axes change
//! for two reasons: the axes of descendant joints rotate with q_k, and the point of the wrench
//! moves relative to ancestor joints.

use alloc::vec::Vec;

use super::relative_motion::path;
use crate::Scalar;
use crate::equations::kinematics::acceleration::parent_motion_at_joint;
use crate::equations::kinematics::links::column_along;
use crate::equations::{Motion, Workspace};
use crate::mechanism::{BodyFrame, Mechanism};
use crate::spatial::{Field, Matrix3, Pose, Twist, Vector3, Wrench};

/// A degree of freedom that moves a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathJoint<S> {
    /// The index of the degree of freedom.
    pub(super) dof: usize,
    /// The position of its body in [`Path::bodies`].
    pub(super) body: usize,
    /// The velocity of the point, and of the frame there, at unit rate.
    pub(super) twist: Twist<S>,
}

/// The motion of a body, in the axes of the path's root.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathBody<S> {
    pub(super) omega: Vector3<S>,
    pub(super) alpha: Vector3<S>,
    /// The velocity of the body's material point at the path's point.
    pub(super) velocity: Vector3<S>,
    /// The classical acceleration of that material point.
    pub(super) acceleration: Vector3<S>,
}

/// The degrees of freedom and the bodies that move a point, in the axes of the path's root.
#[derive(Clone, Debug)]
pub(super) struct Path<S> {
    pub(super) joints: Vec<PathJoint<S>>,
    /// The root at rest, then the bodies from the root to the point.
    bodies: Vec<PathBody<S>>,
}

/// The root of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathRoot<S> {
    /// The motion of the root.
    pub(super) body: PathBody<S>,
    /// The axes of the root, as columns; `None` if the root has the axes of the first body.
    pub(super) axes: Option<Matrix3<S>>,
}

impl<S: Scalar> PathBody<S> {
    /// Returns a body at rest.
    pub(super) fn at_rest() -> Self {
        let zero = Vector3::zero();
        Self { omega: zero, alpha: zero, velocity: zero, acceleration: zero }
    }
}

/// Computes the accelerations of the bodies between a frame and its ancestor, relative to this
/// ancestor, in each body's axes; and the axes of the bodies in the ancestor's. The workspace's
/// path becomes the path of these bodies.
pub(super) fn relative_fields<S: Scalar>(
    model: &Mechanism<S>,
    end: BodyFrame<S>,
    ancestor: Option<usize>,
    Motion { q, qd, qdd }: Motion<'_, S>,
    workspace: &mut Workspace<S>,
    fields: &mut [Field<S>],
) {
    let Workspace { kinematic_path, motions, axes, .. } = workspace;
    kinematic_path.clear();
    kinematic_path.extend(path(model, end, ancestor));
    kinematic_path.reverse();
    let mut body_axes = Matrix3(Pose::identity().rotation);
    let mut field = Field::zero();
    for &i in &*kinematic_path {
        let body = &model.bodies[i];
        let motion = body.motion(q);
        body_axes = motion.rotate_axes(&body.placement.rotate_axes(&body_axes));
        let from_parent = parent_motion_at_joint(&field, body, &motion);
        field = motion.accelerate(from_parent, &model.rates(i, qd), Some(&model.rates(i, qdd)));
        (motions[i], axes[i], fields[i]) = (motion, body_axes, field);
    }
}

impl<S: Scalar> Path<S> {
    /// Returns a path without bodies.
    pub(super) fn new() -> Self {
        Self { joints: Vec::new(), bodies: Vec::new() }
    }

    /// Computes the motion of the bodies of the workspace's path at the velocities `qd`, for the
    /// point `origin` of the last body.
    ///
    /// Expects the joint transforms, the bodies' axes in the axes of the path's root, and the
    /// bodies' accelerations `fields`.
    pub(super) fn fill(
        &mut self,
        model: &Mechanism<S>,
        root: PathRoot<S>,
        origin: Vector3<S>,
        qd: &[S],
        workspace: &Workspace<S>,
        fields: &[Field<S>],
    ) {
        let Self { joints, bodies } = self;
        let path = &workspace.kinematic_path;
        joints.clear();
        bodies.clear();
        bodies.resize(path.len() + 1, root.body);
        let mut point = origin;
        for (k, &i) in path.iter().enumerate().rev() {
            let body = &model.bodies[i];
            let field = &fields[i];
            let axes = &workspace.axes[i];
            bodies[k + 1].omega = axes.mul_vector(field.omega);
            bodies[k + 1].alpha = axes.mul_vector(field.alpha);
            bodies[k + 1].acceleration =
                axes.mul_vector(field.a + field.relative_acceleration(point));
            let at_joint = workspace.motions[i].point_to_parent(point);
            let parent = k.checked_sub(1).map_or(root.axes, |k| Some(workspace.axes[path[k]]));
            let (axes, lever) = match parent.filter(|_| body.elementary_joint.has_axis()) {
                Some(parent) => (body.placement.rotate_axes(&parent), at_joint),
                None => (*axes, point),
            };
            for dof in body.dofs.clone() {
                let twist = column_along(model.dofs[dof].component, &axes, lever);
                joints.push(PathJoint { dof, body: k + 1, twist });
            }
            point = body.placement.point_to_parent(at_joint);
        }
        for k in 1..bodies.len() {
            let moving = joints.iter().filter(|joint| joint.body == k);
            let moves =
                moving.map(|joint| joint.twist.linear.scale(model.dofs[joint.dof].rate(qd)));
            bodies[k].velocity = moves.fold(bodies[k - 1].velocity, |sum, v| sum + v);
        }
    }

    /// Returns the motion of the last body.
    pub(super) fn last(&self) -> &PathBody<S> {
        &self.bodies[self.bodies.len() - 1]
    }

    /// Returns the derivatives of the velocity and of the acceleration of the last body's material
    /// point with respect to a joint's coordinate. The material point moves with that coordinate.
    pub(super) fn by_coordinate(&self, joint: &PathJoint<S>) -> [Twist<S>; 2] {
        let front = &self.bodies[joint.body - 1];
        let last = self.last();
        let Twist { angular, linear } = joint.twist;
        let big = front.omega;
        let omega = last.omega - big;
        let velocity = last.velocity - front.velocity;
        let rotated = big.cross(velocity);
        let alpha = last.alpha - front.alpha - big.cross(omega);
        let acceleration = last.acceleration - front.acceleration - (rotated + rotated);
        let rotated_omega = angular.cross(omega);
        let rotated_velocity = angular.cross(velocity);
        let coriolis = big.cross(rotated_velocity);
        let first = Twist { angular: rotated_omega, linear: big.cross(linear) + rotated_velocity };
        let second = Twist {
            angular: big.cross(rotated_omega) + angular.cross(alpha),
            linear: front.alpha.cross(linear)
                + big.cross(big.cross(linear))
                + (coriolis + coriolis)
                + angular.cross(acceleration),
        };
        [first, second]
    }

    /// Returns the derivative of the acceleration of the last body's material point with respect to
    /// a joint's velocity.
    pub(super) fn by_rate(&self, joint: &PathJoint<S>) -> Twist<S> {
        let front = &self.bodies[joint.body - 1];
        let body = &self.bodies[joint.body];
        let last = self.last();
        let Twist { angular, linear } = joint.twist;
        let behind = (last.velocity - body.velocity) + (last.velocity - front.velocity);
        Twist {
            angular: body.omega.cross(angular) + angular.cross(last.omega - front.omega),
            linear: (body.omega + front.omega).cross(linear) + angular.cross(behind),
        }
    }

    /// Calls `add` with the change of each joint force of a wrench on the last body at the point,
    /// for each coordinate: the change, the degree of freedom of the force and the degree of
    /// freedom of the coordinate. The wrench is constant in the root's axes.
    pub(super) fn forces_under(
        &self,
        wrench: Wrench<S>,
        mut add: impl FnMut(S, &PathJoint<S>, &PathJoint<S>),
    ) {
        for a in &self.joints {
            let [rotated, moved] = a.moments_under(wrench);
            for b in &self.joints {
                // The joint force at `a` changes with a displacement along `b`, and at `b` with one
                // along `a`.
                if b.body <= a.body {
                    add(b.twist.angular.dot(rotated), a, b);
                }
                if b.body < a.body {
                    add(b.twist.angular.dot(moved), b, a);
                }
            }
        }
    }
}

impl<S: Scalar> PathJoint<S> {
    /// Returns v x f + w x m and v x f, with the joint's twist (w, v) and the moment m and the
    /// force f of `wrench`. The first is the change of the joint force for a rotation of the
    /// joint's axis, the second for a displacement of the point along the joint.
    pub(super) fn moments_under(&self, wrench: Wrench<S>) -> [Vector3<S>; 2] {
        let Twist { angular, linear } = self.twist;
        let moved = linear.cross(wrench.force);
        [moved + angular.cross(wrench.moment), moved]
    }
}
