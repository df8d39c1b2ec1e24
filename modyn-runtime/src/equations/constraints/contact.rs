//! The motion of a contact's frame relative to its target.
//!
//! All quantities are in the axes of the contact's root: the first body on the kinematic path from
//! the world to the frame. In these axes most columns of a floating base are constants. The rows do
//! not depend on the choice of axes: they are three orthogonal displacements and, for a surface,
//! three orthogonal rotations.

use super::relative_motion::RelativeMotion;
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::Workspace;
use crate::equations::kinematics::kinematic_path;
use crate::equations::kinematics::links::add_columns;
use crate::mechanism::{BodyFrame, Mechanism};
use crate::spatial::{Matrix3, Pose, Twist, Vector3};

/// The frame of a contact relative to the contact's root.
#[derive(Clone, Debug)]
pub(super) struct ContactFrame<S> {
    /// The axes of the body that carries the frame, as columns.
    body_axes: Matrix3<S>,
    /// The frame on the body that carries it.
    on_body: BodyFrame<S>,
    /// The frame's origin.
    origin: Vector3<S>,
    /// The root's axes in the world, as columns.
    root_axes: Matrix3<S>,
    /// The root's origin in the world.
    root_origin: Vector3<S>,
}

impl<S: Scalar> ContactFrame<S> {
    /// Returns the frame `end` at `q`, and writes its Jacobian to `columns`, a column for each
    /// entry of qd.
    pub(super) fn new(
        model: &Mechanism<S>,
        end: BodyFrame<S>,
        q: &[S],
        workspace: &mut Workspace<S>,
        columns: &mut [Twist<S>],
    ) -> Self {
        columns.fill(Twist::zero());
        kinematic_path::from_world(model, end.body, &mut workspace.kinematic_path);
        let path = core::mem::take(&mut workspace.kinematic_path);
        let identity = || Matrix3(Pose::identity().rotation);
        for (k, &i) in path.iter().enumerate() {
            let body = &model.bodies[i];
            workspace.motions[i] = body.motion(q);
            let parent = k.checked_sub(1).map(|before| workspace.axes[path[before]]);
            workspace.axes[i] = parent.map_or_else(identity, |parent| {
                workspace.motions[i].rotate_axes(&body.placement.rotate_axes(&parent))
            });
        }
        let mut frame = Self {
            body_axes: path.last().map_or_else(identity, |&i| workspace.axes[i]),
            on_body: end,
            origin: Vector3(end.pose.translation),
            root_axes: identity(),
            root_origin: Vector3::zero(),
        };
        for (k, &i) in path.iter().enumerate().rev() {
            let body = &model.bodies[i];
            let motion = &workspace.motions[i];
            let at_joint = motion.point_to_parent(frame.origin);
            if k == 0 {
                add_columns(model, i, &identity(), frame.origin, columns);
                frame.root_axes = motion.rotate_axes(&body.placement.rotate_axes(&identity()));
                frame.root_origin =
                    body.placement.point_to_parent(motion.point_to_parent(Vector3::zero()));
                break;
            }
            // The axis has the same direction in the parent's axes, which are one rotation shorter.
            if body.elementary_joint.has_axis() {
                let axes = body.placement.rotate_axes(&workspace.axes[path[k - 1]]);
                add_columns(model, i, &axes, at_joint, columns);
            } else {
                add_columns(model, i, &workspace.axes[i], frame.origin, columns);
            }
            frame.origin = body.placement.point_to_parent(at_joint);
        }
        workspace.kinematic_path = path;
        frame
    }

    /// Returns the frame's axes in the root's axes, as columns.
    pub(super) fn axes(&self) -> Matrix3<S> {
        self.body_axes.times(&Matrix3(self.on_body.pose.rotation))
    }

    /// Returns a vector in the root's axes, given in world axes.
    pub(super) fn to_root(&self, v: Vector3<S>) -> Vector3<S> {
        Vector3(core::array::from_fn(|j| self.root_axes.column(j).dot(v)))
    }

    /// Returns a vector in world axes, given in the root's axes.
    pub(super) fn to_world(&self, v: Vector3<S>) -> Vector3<S> {
        self.root_axes.mul_vector(v)
    }

    /// Returns the rotation from the root's axes to the axes that are the columns of `axes` in the
    /// world.
    pub(super) fn root_to(&self, axes: &Matrix3<S>) -> Matrix3<S> {
        axes.transposed().times(&self.root_axes)
    }

    /// Returns a twist in world axes, given in the root's axes.
    pub(super) fn twist_to_world(&self, t: Twist<S>) -> Twist<S> {
        Twist { angular: self.to_world(t.angular), linear: self.to_world(t.linear) }
    }

    /// Returns the displacement from the target in world axes, its tangential part multiplied by
    /// `target.tangential`. The rotation is zero unless the contact is a surface.
    pub(super) fn displacement(&self, target: &ContactTarget<S>, surface: bool) -> Twist<S> {
        let Pose { rotation, translation } = target.pose;
        let to_axes = Matrix3(rotation);
        let normal = to_axes.column(2);
        let place = self.root_origin + self.root_axes.mul_vector(self.origin);
        // n (n . d) + share (d - n (n . d))
        let share = target.tangential;
        let rest = S::one() - share;
        let whole = place - Vector3(translation);
        let linear = whole.scale(share) + normal.scale(rest * normal.dot(whole));
        let mut angular = Vector3::zero();
        if surface {
            let axes = self.root_axes.times(&self.axes());
            let cross = |k: usize| to_axes.column(k).cross(axes.column(k));
            let about = normal.dot(cross(0) + cross(1)) * S::from_f64(0.5);
            angular = cross(2) + normal.scale(share * about);
        }
        Twist { angular, linear }
    }

    /// Returns the motion relative to the target, in the root's axes. The bias acceleration expects
    /// the bodies' accelerations under gravity at zero joint accelerations, with the origin of a
    /// floating base in free fall.
    pub(super) fn motion(
        &self,
        model: &Mechanism<S>,
        target: &ContactTarget<S>,
        surface: bool,
        columns: &[Twist<S>],
        qd: &[S],
        workspace: &Workspace<S>,
    ) -> RelativeMotion<S> {
        let moves = columns.iter().zip(qd).map(|(&column, &rate)| column.scale(rate));
        let velocity = moves.fold(Twist::zero(), |sum, twist| sum + twist);
        let of_target = target.velocity;
        let velocity = Twist {
            angular: velocity.angular - self.to_root(of_target.angular),
            linear: velocity.linear - self.to_root(of_target.linear),
        };
        let in_world = self.displacement(target, surface);
        let displacement = Twist {
            angular: self.to_root(in_world.angular),
            linear: self.to_root(in_world.linear),
        };
        let field = self.on_body.body.map(|body| &workspace.fields[body]);
        let jacobian_dot_qd = field.map_or_else(Twist::zero, |field| {
            let linear =
                field.a + field.relative_acceleration(Vector3(self.on_body.pose.translation));
            Twist {
                angular: self.body_axes.mul_vector(field.alpha),
                linear: self.body_axes.mul_vector(linear) + self.to_root(model.gravity),
            }
        });
        RelativeMotion { displacement, velocity, jacobian_dot_qd }
    }
}
