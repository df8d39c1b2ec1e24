//! The points of shapes that can touch the ground.

use alloc::{vec, vec::Vec};

use super::rows::{BodyState, ContactOptions, ContactRows, SoftModel, body_twists};
use crate::equations::kinematics::links::compute_body_poses;
use crate::equations::{State, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{Matrix3, Pose, Vector3};
use crate::{ContactSurface, Scalar, StepSettings};

/// A point of a shape that can touch the ground, at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchingPoint<S> {
    /// The index of the shape.
    pub shape: usize,
    /// The place in the world, m: in the middle between the shape and the ground.
    pub place: Vector3<S>,
    /// The height of the shape above the ground at this point, m; negative in the ground.
    pub gap: S,
    /// The velocity of the link at the place, along the x and y axes of the plane, then along the
    /// normal, m/s.
    pub velocity: Vector3<S>,
}

/// Returns the points in the order of the forces of a step.
pub fn touching_points<S: Scalar>(
    mechanism: &Mechanism<S>,
    soft: &SoftModel<S>,
    settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
) -> Vec<TouchingPoint<S>> {
    workspace.move_to(mechanism, q);
    let mut poses = vec![Pose::identity(); mechanism.bodies.len()];
    compute_body_poses(mechanism, workspace, &mut poses);
    body_twists(mechanism, qd, workspace);
    // The laws of the rows, which depend on the time, are not used.
    let one = S::one();
    let options = ContactOptions { cone: soft.cone, ratio: one, coulomb: one, dt: one };
    let shapes = soft.contacts.iter().zip(settings.surfaces.as_ref());
    let points = shapes.enumerate().flat_map(|(shape, (parameters, surface))| {
        let pose = poses[parameters.body];
        let velocity = workspace.twists[parameters.body];
        let state = BodyState { pose, velocity, fall: Vector3::zero() };
        let rows = ContactRows::of_shape(parameters, &state, surface, options).into_iter();
        rows.map(move |rows| TouchingPoint {
            shape,
            place: Vector3(pose.translation) + Matrix3(pose.rotation).mul_vector(rows.place),
            gap: rows.gap,
            velocity: Vector3(rows.velocity(&velocity)),
        })
    });
    points.collect()
}
