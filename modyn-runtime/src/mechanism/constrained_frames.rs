//! The frames of loop constraints and contacts, on the bodies that carry them.

use alloc::vec::Vec;

use super::BodyFrame;
use super::snapping::snap;
use crate::Scalar;
use crate::model::{Contact, ContactKind, LoopConstraint, LoopConstraintEnd, LoopConstraintKind};
use crate::spatial::{Pose, Vector3};

/// A loop constraint between two frames of bodies, or a contact between the world and a frame of a
/// body.
#[derive(Clone, Debug)]
pub struct ConstrainedFrames<S> {
    /// The first frame and the second. The relative twist is expressed in the first frame's axes,
    /// or for a contact in the axes of the first body on the kinematic path from the world to the
    /// second frame.
    pub ends: [BodyFrame<S>; 2],
    /// Whether this is a contact: then the first frame is the world.
    pub contact: bool,
    /// The common axis of a hinge; `None` for other constraints.
    pub hinge: Option<Vector3<S>>,
    /// The constrained directions, one for each row of the constraint Jacobian.
    pub rows: Vec<ConstraintRow<S>>,
    /// The free directions. Together with `rows` they are an orthonormal basis of rotations and
    /// displacements. A contact of a robot with a floating base has none: the origin of its frame
    /// moves in all directions.
    pub free: Vec<ConstraintRow<S>>,
    /// The characteristic length between rotations and displacements, m.
    pub length: S,
}

/// A direction of a constraint's relative twist.
#[derive(Clone, Copy, Debug)]
pub struct ConstraintRow<S> {
    /// Whether the direction is a rotation axis; otherwise it is a displacement.
    pub angular: bool,
    /// A unit vector in the first frame's axes.
    pub direction: Vector3<S>,
}

impl<S: Scalar> ConstrainedFrames<S> {
    /// Returns the constraint with `f` applied to its numbers.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T) -> ConstrainedFrames<T> {
        let vector = |v: Vector3<S>| Vector3(v.0.map(&f));
        let row = |row: &ConstraintRow<S>| ConstraintRow {
            angular: row.angular,
            direction: vector(row.direction),
        };
        ConstrainedFrames {
            ends: self.ends.map(|end| end.map(&f)),
            contact: self.contact,
            hinge: self.hinge.map(vector),
            rows: self.rows.iter().map(row).collect(),
            free: self.free.iter().map(row).collect(),
            length: f(self.length),
        }
    }
}

/// Returns the frame of `end` on the body that carries it.
fn on_body(frames: &[BodyFrame<f64>], end: &LoopConstraintEnd) -> BodyFrame<f64> {
    let BodyFrame { body, pose } = frames[end.link];
    BodyFrame { body, pose: pose.compose(&end.pose).map(snap) }
}

/// Returns the rows of displacements, then of rotations, along these unit vectors.
fn rows([linear, angular]: [Vec<[f64; 3]>; 2]) -> Vec<ConstraintRow<f64>> {
    let row =
        |angular| move |d: [f64; 3]| ConstraintRow { angular, direction: Vector3(d.map(snap)) };
    linear.into_iter().map(row(false)).chain(angular.into_iter().map(row(true))).collect()
}

/// Returns `constraint`, of characteristic length `length`, on the bodies that carry the
/// description's `frames`.
pub(super) fn constrained(
    frames: &[BodyFrame<f64>],
    constraint: &LoopConstraint,
    length: f64,
) -> ConstrainedFrames<f64> {
    let ends = constraint.ends.each_ref().map(|end| on_body(frames, end));
    let hinge = match constraint.kind {
        LoopConstraintKind::Revolute(axis) => Some(Vector3(axis.map(snap))),
        _ => None,
    };
    let (constrained, free) = constraint.kind.directions();
    let free = rows(free);
    let rows = rows(constrained);
    ConstrainedFrames { ends, contact: false, hinge, rows, free, length }
}

/// Returns `contact`, of characteristic length `length`, on the body that carries its link;
/// `floats` is whether the base of that body floats.
pub(super) fn touching(
    frames: &[BodyFrame<f64>],
    contact: &Contact,
    length: f64,
    floats: bool,
) -> ConstrainedFrames<f64> {
    let world = BodyFrame { body: None, pose: Pose::identity() };
    let ends = [world, on_body(frames, &contact.end)];
    let kind = match contact.kind {
        ContactKind::Point => LoopConstraintKind::Point,
        ContactKind::Surface => LoopConstraintKind::Rigid,
    };
    let (constrained, free) = kind.directions();
    let free = if floats { Vec::new() } else { rows(free) };
    let rows = rows(constrained);
    ConstrainedFrames { ends, contact: true, hinge: None, rows, free, length }
}
