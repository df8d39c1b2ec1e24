//! Frames that close loops, on the bodies that carry them.

use alloc::vec::Vec;

use super::BodyFrame;
use super::snapping::snap;
use crate::Scalar;
use crate::model::{Closure, ClosureKind};
use crate::spatial::Vector3;

/// Two frames that are held together.
#[derive(Clone, Debug)]
pub struct HeldFrames<S> {
    /// The first frame, whose axes what is held is given in, and the second.
    pub ends: [BodyFrame<S>; 2],
    /// The axis that the frames have in common, if one is held.
    pub hinge: Option<Vector3<S>>,
    /// What is held, a row of the constraint Jacobian each.
    pub rows: Vec<HeldRow<S>>,
}

/// What a closure holds in one direction.
#[derive(Clone, Copy, Debug)]
pub struct HeldRow<S> {
    /// Whether it is a rotation about the direction, not a displacement along it.
    pub angular: bool,
    /// A unit vector in the first frame's axes.
    pub direction: Vector3<S>,
}

impl<S: Scalar> HeldFrames<S> {
    /// Each number through `f`.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T) -> HeldFrames<T> {
        let vector = |v: Vector3<S>| Vector3(v.0.map(&f));
        let row =
            |row: &HeldRow<S>| HeldRow { angular: row.angular, direction: vector(row.direction) };
        HeldFrames {
            ends: self.ends.map(|end| end.map(&f)),
            hinge: self.hinge.map(vector),
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// The frames and rows that `closure` holds, on the bodies that carry the description's `frames`.
pub(super) fn held(frames: &[BodyFrame<f64>], closure: &Closure) -> HeldFrames<f64> {
    let ends = closure.ends.each_ref().map(|end| {
        let BodyFrame { body, pose } = frames[end.frame];
        BodyFrame { body, pose: pose.compose(&end.pose).map(snap) }
    });
    let hinge = match closure.kind {
        ClosureKind::Revolute(axis) => Some(Vector3(axis.map(snap))),
        _ => None,
    };
    let row = |angular| move |d: [f64; 3]| HeldRow { angular, direction: Vector3(d.map(snap)) };
    let [angular, linear] = closure.kind.held();
    let rows = angular.into_iter().map(row(true)).chain(linear.into_iter().map(row(false)));
    HeldFrames { ends, hinge, rows: rows.collect() }
}
