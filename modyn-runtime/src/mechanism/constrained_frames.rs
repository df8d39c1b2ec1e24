//! The frames of loop constraints, on the bodies that carry them.

use alloc::vec::Vec;

use super::BodyFrame;
use super::snapping::snap;
use crate::Scalar;
use crate::model::{LoopConstraint, LoopConstraintKind};
use crate::spatial::Vector3;

/// A loop constraint between two frames of bodies.
#[derive(Clone, Debug)]
pub struct ConstrainedFrames<S> {
    /// The first frame, in whose axes the relative twist is expressed, and the second.
    pub ends: [BodyFrame<S>; 2],
    /// The common axis of a hinge; `None` for other constraints.
    pub hinge: Option<Vector3<S>>,
    /// The constrained directions, one for each row of the constraint Jacobian.
    pub rows: Vec<ConstraintRow<S>>,
    /// The free directions. Together with `rows` they are an orthonormal basis of rotations and displacements.
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
            hinge: self.hinge.map(vector),
            rows: self.rows.iter().map(row).collect(),
            free: self.free.iter().map(row).collect(),
            length: f(self.length),
        }
    }
}

/// Returns `constraint`, of characteristic length `length`, on the bodies that carry the description's `frames`.
pub(super) fn constrained(
    frames: &[BodyFrame<f64>],
    constraint: &LoopConstraint,
    length: f64,
) -> ConstrainedFrames<f64> {
    let ends = constraint.ends.each_ref().map(|end| {
        let BodyFrame { body, pose } = frames[end.frame];
        BodyFrame { body, pose: pose.compose(&end.pose).map(snap) }
    });
    let hinge = match constraint.kind {
        LoopConstraintKind::Revolute(axis) => Some(Vector3(axis.map(snap))),
        _ => None,
    };
    let row =
        |angular| move |d: [f64; 3]| ConstraintRow { angular, direction: Vector3(d.map(snap)) };
    let rows = |[angular, linear]: [Vec<[f64; 3]>; 2]| {
        angular.into_iter().map(row(true)).chain(linear.into_iter().map(row(false))).collect()
    };
    let (constrained, free) = constraint.kind.directions();
    ConstrainedFrames { ends, hinge, rows: rows(constrained), free: rows(free), length }
}
