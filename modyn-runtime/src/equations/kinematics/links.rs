//! The poses, velocities, accelerations and Jacobians of the links.

use super::acceleration::{parent_motion, parent_motion_at_joint};
use super::kinematic_path::{self, BodyMotion, OriginMotion};
use crate::Scalar;
use crate::equations::{Motion, State, Workspace};
use crate::mechanism::{Body, BodyFrame, BodyTree, Mechanism};
use crate::spatial::{Field, Matrix3, Pose, SpatialAxis, Twist, Vector3};

/// Computes the poses of all links of the description in the world, in the description's order.
pub fn link_poses<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    body_poses: &mut [Pose<S>],
    poses: &mut [Pose<S>],
) {
    workspace.move_to(model, q);
    compute_body_poses(model, workspace, body_poses);
    for (pose, frame) in poses.iter_mut().zip(&model.frames) {
        *pose = frame.body.map_or(frame.pose, |body| body_poses[body].compose(&frame.pose));
    }
}

/// Computes the poses of the bodies in the world. Expects the joint transforms at q.
pub(in crate::equations) fn compute_body_poses<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    workspace: &Workspace<S>,
    body_poses: &mut [Pose<S>],
) {
    for (i, body) in tree.mechanism().bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let [a, b, c, x] = parent_pose(tree, i, body_poses);
        let axes = Matrix3([a, b, c]);
        let origin = Vector3(x);
        let at_joint = body.placement.rotate_axes(&axes);
        let mut origin = origin + axes.mul_vector(body.placement.origin());
        if let Some(displacement) = motion.displacement() {
            origin += at_joint.mul_vector(displacement);
        }
        let rotation = motion.rotate_axes(&at_joint).0;
        body_poses[i] = Pose { rotation, translation: origin.0 };
    }
}

/// Returns the rows of the rotation of a body's parent, and its place.
fn parent_pose<S: Scalar, T: BodyTree<S>>(tree: &T, body: usize, poses: &[Pose<S>]) -> [[S; 3]; 4] {
    let numbers: [S; 12] = tree.broadcast_from_parents(body, |parent| {
        let Pose { rotation: [a, b, c], translation } =
            parent.map_or_else(Pose::identity, |parent| poses[parent]);
        let rows = [a, b, c, translation];
        core::array::from_fn(|k| rows[k / 3][k % 3])
    });
    core::array::from_fn(|row| core::array::from_fn(|k| numbers[3 * row + k]))
}

/// The axes of a link's motion. The reference point is the link's origin for both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axes {
    /// The world's axes, at the link's origin.
    World,
    /// The link's own axes.
    Link,
}

/// Returns the pose of link `frame` (an index of the description's links) in the world.
///
/// As all functions for one link here, it visits the bodies of the link's kinematic path only.
pub fn link_pose<S: Scalar>(model: &Mechanism<S>, frame: usize, q: &[S]) -> Pose<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let mut seen = LinkInBody::fixed(&pose);
    for i in kinematic_path::towards_world(model, body) {
        seen = seen.towards_world(&model.bodies[i], q);
    }
    Pose { rotation: seen.axes.transposed().0, translation: seen.point.0 }
}

/// Returns the pose of link `frame` in the world, as [`link_pose`] does, by the axes of the bodies
/// in the world.
///
/// It takes more operations than [`link_pose`], but fewer beyond the operations of [`jacobian`] in
/// world axes.
pub fn link_pose_from_world<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    q: &[S],
    workspace: &mut Workspace<S>,
) -> Pose<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let Some(last) = body else { return pose };
    kinematic_path::move_to_world(model, last, q, workspace);
    let mut point = Vector3(pose.translation);
    for i in kinematic_path::towards_world(model, body) {
        let placement = &model.bodies[i].placement;
        point = placement.point_to_parent(workspace.motions[i].point_to_parent(point));
    }
    let rotation = workspace.axes[last].times(&Matrix3(pose.rotation));
    Pose { rotation: rotation.0, translation: point.0 }
}

/// Returns the velocity of link `frame` relative to the world, rad/s and m/s, at the link's origin
/// in `axes`.
pub fn link_velocity<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    State { q, qd }: State<'_, S>,
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    velocity_and_bias(model, frame, State { q, qd }, axes, workspace).0
}

/// Returns the acceleration of link `frame` relative to the world, in `axes`: the angular
/// acceleration, rad/s^2, and the classical acceleration of the link's origin, m/s^2.
///
/// Gravity is not included: the acceleration of a link at rest is zero.
pub fn link_acceleration<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    Motion { q, qd, qdd }: Motion<'_, S>,
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    match axes {
        Axes::World => in_world_axes(model, frame, State { q, qd }, Some(qdd)).acceleration,
        Axes::Link => {
            let BodyFrame { body, pose } = model.frames[frame];
            kinematic_path::from_world(model, body, &mut workspace.kinematic_path);
            let field = workspace.kinematic_path.iter().fold(Field::zero(), |parent, &i| {
                let body = &model.bodies[i];
                let motion = model.bodies[i].motion(q);
                let from_parent = parent_motion_at_joint(&parent, body, &motion);
                motion.accelerate(from_parent, &model.rates(i, qd), Some(&model.rates(i, qdd)))
            });
            let axes = Matrix3(pose.rotation).transposed();
            let a = field.a + field.relative_acceleration(Vector3(pose.translation));
            Twist { angular: axes.mul_vector(field.alpha), linear: axes.mul_vector(a) }
        }
    }
}

/// Returns the acceleration of link `frame` relative to the world in world axes, as
/// [`link_acceleration`] does; without `qdd` the bias acceleration.
///
/// The method uses the axes of the bodies in the world and the accelerations of the bodies, as
/// Newton-Euler passes do. Alone it takes more operations, but few beyond the operations of
/// [`jacobian`] and of inverse dynamics.
pub fn link_acceleration_from_world<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    State { q, qd }: State<'_, S>,
    qdd: Option<&[S]>,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let Some(last) = body else { return Twist::zero() };
    kinematic_path::move_to_world(model, last, q, workspace);
    for k in 0..workspace.kinematic_path.len() {
        let i = workspace.kinematic_path[k];
        let from_parent = parent_motion(model, i, workspace);
        let accelerations = qdd.map(|qdd| model.rates(i, qdd));
        let rates = model.rates(i, qd);
        workspace.fields[i] =
            workspace.motions[i].accelerate(from_parent, &rates, accelerations.as_deref());
    }
    let axes = &workspace.axes[last];
    let field = &workspace.fields[last];
    let a = field.a + field.relative_acceleration(Vector3(pose.translation));
    // Gravity is an upward acceleration of the world there.
    Twist { angular: axes.mul_vector(field.alpha), linear: axes.mul_vector(a) + model.gravity }
}

/// Computes the Jacobian J of link `frame` into `columns`, one for each entry of qd: J qd is
/// [`link_velocity`].
///
/// In [`Axes::World`] it is Pinocchio's `LOCAL_WORLD_ALIGNED`, in [`Axes::Link`] Pinocchio's
/// `LOCAL`. The columns of mimic joints are added to the columns of the joints that they follow.
pub fn jacobian<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    q: &[S],
    axes: Axes,
    workspace: &mut Workspace<S>,
    columns: &mut [Twist<S>],
) {
    columns.fill(Twist::zero());
    let BodyFrame { body: last, pose } = model.frames[frame];
    match axes {
        Axes::World => {
            if let Some(last) = last {
                kinematic_path::move_to_world(model, last, q, workspace);
            }
            // The link's origin, as seen from each body on the path.
            let mut point = Vector3(pose.translation);
            for i in kinematic_path::towards_world(model, last) {
                let body = &model.bodies[i];
                let at_joint = workspace.motions[i].point_to_parent(point);
                let lever = if body.elementary_joint.has_axis() { at_joint } else { point };
                add_columns(
                    model,
                    i,
                    &kinematic_path::joint_axes(model, i, workspace),
                    lever,
                    columns,
                );
                point = body.placement.point_to_parent(at_joint);
            }
        }
        Axes::Link => add_columns_of_frame(model, BodyFrame { body: last, pose }, q, columns),
    }
}

/// Adds the columns of the [`jacobian`] of a frame in the frame's axes.
pub(in crate::equations) fn add_columns_of_frame<S: Scalar>(
    model: &Mechanism<S>,
    BodyFrame { body, pose }: BodyFrame<S>,
    q: &[S],
    columns: &mut [Twist<S>],
) {
    let mut seen = LinkInBody::fixed(&pose);
    for i in kinematic_path::towards_world(model, body) {
        add_columns(model, i, &seen.axes, seen.point, columns);
        seen = seen.towards_world(&model.bodies[i], q);
    }
}

/// Computes the time derivative dJ/dt of the [`jacobian`] J of link `frame` into `columns`, one for
/// each entry of qd: dJ/dt qd is [`jacobian_dot_qd`].
///
/// A column of J is fixed to its body, except for the lever to the link's origin. The axes of the
/// components rotate relative to the body: the axes of the world with minus the body's angular
/// velocity, the link's axes with the link's angular velocity relative to the body.
pub fn jacobian_time_derivative<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    State { q, qd }: State<'_, S>,
    axes: Axes,
    workspace: &mut Workspace<S>,
    columns: &mut [Twist<S>],
) {
    columns.fill(Twist::zero());
    let BodyFrame { body: last, pose } = model.frames[frame];
    if let (Axes::World, Some(last)) = (axes, last) {
        kinematic_path::move_to_world(model, last, q, workspace);
        for k in 0..workspace.kinematic_path.len() {
            let i = workspace.kinematic_path[k];
            let body = &model.bodies[i];
            let parent = body.parent.map_or_else(Vector3::zero, |p| workspace.twists[p].angular);
            let angular = body.to_child(&workspace.motions[i], parent);
            workspace.twists[i] = model.add_rates(i, Twist { angular, ..Twist::zero() }, qd);
        }
    }
    let mut seen = LinkInBody::fixed(&pose);
    let mut link = OriginMotion::fixed(Vector3(pose.translation));
    for i in kinematic_path::towards_world(model, last) {
        let (axes, omega) = match axes {
            Axes::World => (workspace.axes[i], workspace.twists[i].angular),
            Axes::Link => (seen.axes, -link.velocity.angular),
        };
        for dof in model.dofs_of(i) {
            let (angular, linear, drift) = match dof.axis() {
                SpatialAxis::Linear(k) => (Vector3::zero(), Vector3::unit(k), Vector3::zero()),
                SpatialAxis::Angular(k) => {
                    let s = Vector3::unit(k);
                    (s, s.cross(link.point), s.cross(link.velocity.linear))
                }
            };
            let along = Twist {
                angular: axes.mul_vector(omega.cross(angular)),
                linear: axes.mul_vector(omega.cross(linear) + drift),
            };
            let column = &mut columns[dof.v];
            *column = *column + dof.multiplier.map_or(along, |multiplier| along.scale(multiplier));
        }
        seen = seen.towards_world(&model.bodies[i], q);
        link = link.towards_world(model, i, State { q, qd }, None);
    }
}

/// Returns the bias acceleration dJ/dt qd of link `frame`: the time derivative of J qd at constant
/// qd.
///
/// In [`Axes::World`] it is [`link_acceleration`] at qdd = 0. In [`Axes::Link`] the components also
/// change because the axes rotate with the link. Its linear part is then the classical acceleration
/// in link axes minus the cross product of the angular and the linear velocity.
pub fn jacobian_dot_qd<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    State { q, qd }: State<'_, S>,
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    velocity_and_bias(model, frame, State { q, qd }, axes, workspace).1
}

/// Returns the velocity J qd and the bias acceleration dJ/dt qd of link `frame`.
fn velocity_and_bias<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    State { q, qd }: State<'_, S>,
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> (Twist<S>, Twist<S>) {
    match axes {
        Axes::World => {
            let motion = in_world_axes(model, frame, State { q, qd }, None);
            (motion.velocity, motion.acceleration)
        }
        Axes::Link => {
            let motion = in_link_axes(model, frame, State { q, qd }, workspace);
            (motion.velocity, motion.rate)
        }
    }
}

/// Computes the motion from the link towards the world, so that no axes have to be rotated for the
/// result.
fn in_world_axes<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    state: State<'_, S>,
    qdd: Option<&[S]>,
) -> OriginMotion<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let link = OriginMotion::fixed(Vector3(pose.translation));
    kinematic_path::towards_world(model, body)
        .fold(link, |link, i| link.towards_world(model, i, state, qdd))
}

/// Computes the motion from the world towards the link, so that no axes have to be rotated for the
/// result.
fn in_link_axes<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    state: State<'_, S>,
    workspace: &mut Workspace<S>,
) -> BodyMotion<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    kinematic_path::from_world(model, body, &mut workspace.kinematic_path);
    let bodies = workspace.kinematic_path.iter();
    bodies.fold(BodyMotion::at_rest(), |motion, &i| motion.to_child(model, i, state)).at(&pose)
}

/// The pose of a link, as seen from a body.
pub(in crate::equations) struct LinkInBody<S> {
    /// The link's axes in the body's frame, as rows. The columns are the body's axes in the link's
    /// frame.
    pub(in crate::equations) axes: Matrix3<S>,
    /// The link's origin in the body's frame.
    pub(in crate::equations) point: Vector3<S>,
}

impl<S: Scalar> LinkInBody<S> {
    /// Returns the pose of a link that is fixed to the body at `pose`.
    pub(in crate::equations) fn fixed(pose: &Pose<S>) -> Self {
        let axes = Matrix3(pose.rotation).transposed();
        Self { axes, point: Vector3(pose.translation) }
    }

    /// Returns the pose as seen from the parent of `body`. `self` is as seen from `body`.
    pub(in crate::equations) fn towards_world(&self, body: &Body<S>, q: &[S]) -> Self {
        let motion = body.motion(q);
        let axes = self.axes.0.map(|axis| body.to_parent(&motion, Vector3(axis)).0);
        let point = body.placement.point_to_parent(motion.point_to_parent(self.point));
        Self { axes: Matrix3(axes), point }
    }
}

/// Returns the velocity that a unit rate in `component`, along `axes` (as columns), gives to a link
/// whose origin is at `lever` in these axes.
pub(in crate::equations) fn column_along<S: Scalar>(
    component: usize,
    axes: &Matrix3<S>,
    lever: Vector3<S>,
) -> Twist<S> {
    match SpatialAxis::of(component) {
        SpatialAxis::Linear(k) => Twist { linear: axes.column(k), angular: Vector3::zero() },
        SpatialAxis::Angular(k) => {
            let linear = Vector3::unit(k).cross(lever);
            Twist { linear: axes.mul_vector(linear), angular: axes.column(k) }
        }
    }
}

/// Adds the columns of body `i`'s degrees of freedom along `axes` (as columns), for a link whose
/// origin is at `lever` in these axes.
pub(in crate::equations) fn add_columns<S: Scalar>(
    model: &Mechanism<S>,
    i: usize,
    axes: &Matrix3<S>,
    lever: Vector3<S>,
    columns: &mut [Twist<S>],
) {
    for dof in model.dofs_of(i) {
        let along = column_along(dof.component, axes, lever);
        let column = &mut columns[dof.v];
        *column = *column + dof.multiplier.map_or(along, |multiplier| along.scale(multiplier));
    }
}
