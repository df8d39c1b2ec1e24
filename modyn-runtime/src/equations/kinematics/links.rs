//! Where the links stand and how they move.

use super::acceleration::carried_by;
use super::kinematic_path::{self, Own, Relative};
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, BodyFrame, Mechanism};
use crate::spatial::{Field, Matrix3, Pose, Twist, Vector3};

/// The poses of all links of the description in the world, in the description's order.
pub fn link_poses<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    workspace: &mut Workspace<S>,
    body_poses: &mut [Pose<S>],
    poses: &mut [Pose<S>],
) {
    workspace.move_to(model, q);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let parent = body.parent.map_or_else(Pose::identity, |p| body_poses[p]);
        let (axes, origin) = (Matrix3(parent.rotation), Vector3(parent.translation));
        let at_joint = body.placement.turn_axes(&axes);
        let mut origin = origin + axes.mul_vector(body.placement.origin());
        if let Some(displacement) = motion.displacement() {
            origin += at_joint.mul_vector(displacement);
        }
        let rotation = motion.turn_axes(&at_joint).0;
        body_poses[i] = Pose { rotation, translation: origin.0 };
    }
    for (pose, frame) in poses.iter_mut().zip(&model.frames) {
        *pose = frame.body.map_or(frame.pose, |body| body_poses[body].compose(&frame.pose));
    }
}

/// The axes that a link's motion is given in; it is that of the link's origin in either case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axes {
    /// The world's, at the link's origin.
    World,
    /// The link's own.
    Link,
}

/// The pose of link `frame` (an index of the description's links) in the world.
///
/// Like every quantity of one link here it visits that link's chain alone.
pub fn link_pose<S: Scalar>(model: &Mechanism<S>, frame: usize, q: &[S]) -> Pose<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let mut seen = Seen::fixed(&pose);
    for i in kinematic_path::towards_world(model, body) {
        seen = seen.towards_world(&model.bodies[i], q);
    }
    Pose { rotation: seen.axes.transposed().0, translation: seen.point.0 }
}

/// The velocity of link `frame` in the world: angular, and linear of its origin.
pub fn link_velocity<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    (q, qd): (&[S], &[S]),
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    match axes {
        Axes::World => in_world_axes(model, frame, (q, qd, None)).velocity,
        Axes::Link => in_link_axes(model, frame, (q, qd), workspace).velocity,
    }
}

/// The acceleration of link `frame` in the world: angular, and the classical one of its origin.
/// Gravity has no part in it: a link at rest is not accelerated.
pub fn link_acceleration<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    (q, qd, qdd): (&[S], &[S], &[S]),
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    match axes {
        Axes::World => in_world_axes(model, frame, (q, qd, Some(qdd))).acceleration,
        Axes::Link => {
            let BodyFrame { body, pose } = model.frames[frame];
            kinematic_path::from_world(model, body, &mut workspace.kinematic_path);
            let field = workspace.kinematic_path.iter().fold(Field::zero(), |parent, &i| {
                let (body, motion) = (&model.bodies[i], model.bodies[i].motion(q));
                let carried = carried_by(&parent, body, &motion);
                motion.accelerate(carried, &model.rates(i, qd), Some(&model.rates(i, qdd)))
            });
            let axes = Matrix3(pose.rotation).transposed();
            let a = field.a + field.over_origin(Vector3(pose.translation));
            Twist { angular: axes.mul_vector(field.alpha), linear: axes.mul_vector(a) }
        }
    }
}

/// The Jacobian of link `frame` into `columns`, one an entry of qd: [`link_velocity`] is their sum
/// times qd. In [`Axes::World`] it is Pinocchio's `LOCAL_WORLD_ALIGNED`, in [`Axes::Link`] its
/// `LOCAL`. Where joints follow others their columns add up.
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
            kinematic_path::from_world(model, last, &mut workspace.kinematic_path);
            for k in 0..workspace.kinematic_path.len() {
                let i = workspace.kinematic_path[k];
                workspace.motions[i] = model.bodies[i].motion(q);
                kinematic_path::turn_axes(model, i, workspace);
            }
            // The link's origin, seen from each body in turn.
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
        Axes::Link => {
            let mut seen = Seen::fixed(&pose);
            for i in kinematic_path::towards_world(model, last) {
                add_columns(model, i, &seen.axes, seen.point, columns);
                seen = seen.towards_world(&model.bodies[i], q);
            }
        }
    }
}

/// The time derivative of link `frame`'s Jacobian times qd, that is, the time derivative of J qd
/// while qd does not change.
///
/// In [`Axes::World`] the numbers of the velocity change by the classical acceleration: this is
/// [`link_acceleration`] without qdd. In [`Axes::Link`] they also change since the axes turn with
/// the link: this is less than the classical acceleration in link axes by the angular velocity
/// times (as vectors) the linear one, in the linear part.
pub fn jacobian_rate<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    (q, qd): (&[S], &[S]),
    axes: Axes,
    workspace: &mut Workspace<S>,
) -> Twist<S> {
    match axes {
        Axes::World => in_world_axes(model, frame, (q, qd, None)).acceleration,
        Axes::Link => in_link_axes(model, frame, (q, qd), workspace).rate,
    }
}

/// From the link down to the world: no axes need be turned for the result.
fn in_world_axes<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    motion: (&[S], &[S], Option<&[S]>),
) -> Relative<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    let link = Relative::fixed(Vector3(pose.translation));
    kinematic_path::towards_world(model, body)
        .fold(link, |link, i| link.towards_world(model, i, motion))
}

/// From the world to the link, for the same reason.
fn in_link_axes<S: Scalar>(
    model: &Mechanism<S>,
    frame: usize,
    motion: (&[S], &[S]),
    workspace: &mut Workspace<S>,
) -> Own<S> {
    let BodyFrame { body, pose } = model.frames[frame];
    kinematic_path::from_world(model, body, &mut workspace.kinematic_path);
    let bodies = workspace.kinematic_path.iter();
    bodies.fold(Own::at_rest(), |own, &i| own.carried_to(model, i, motion)).at(&pose)
}

/// Where a link stands, seen from a body.
pub(in crate::equations) struct Seen<S> {
    /// The link's axes, as rows: as columns, the body's axes seen from the link.
    pub(in crate::equations) axes: Matrix3<S>,
    /// The link's origin.
    pub(in crate::equations) point: Vector3<S>,
}

impl<S: Scalar> Seen<S> {
    /// A link that is fixed to the body.
    pub(in crate::equations) fn fixed(pose: &Pose<S>) -> Self {
        let axes = Matrix3(pose.rotation).transposed();
        Self { axes, point: Vector3(pose.translation) }
    }

    /// Seen from the parent, if it was seen from `body`.
    pub(in crate::equations) fn towards_world(&self, body: &Body<S>, q: &[S]) -> Self {
        let motion = body.motion(q);
        let axes = self.axes.0.map(|axis| body.to_parent(&motion, Vector3(axis)).0);
        let point = body.placement.point_to_parent(motion.point_to_parent(self.point));
        Self { axes: Matrix3(axes), point }
    }
}

/// The velocity that a unit rate in `component` gives, along `axes` (as columns), to a link whose origin stands at `lever`
/// in them.
pub(in crate::equations) fn column_along<S: Scalar>(
    component: usize,
    axes: &Matrix3<S>,
    lever: Vector3<S>,
) -> Twist<S> {
    if component < 3 {
        let linear = Vector3::unit(component).cross(lever);
        Twist { angular: axes.column(component), linear: axes.mul_vector(linear) }
    } else {
        Twist { angular: Vector3::zero(), linear: axes.column(component - 3) }
    }
}

/// Adds the columns of body `i`'s degrees of freedom, along `axes` (as columns), for a link whose
/// origin stands at `lever` in them.
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
