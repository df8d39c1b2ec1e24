//! The spaces of the joint coordinates: numbers, rotations, poses.

use alloc::vec::Vec;
use core::f64::consts::PI;

use crate::Scalar;
use crate::joint::JointType;
use crate::model::Model;

/// The space of a group of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoordinateSpace<S> {
    /// A number: an angle or a displacement.
    Line {
        /// The lower limit (rad or m), or the lower end of a default range.
        low: S,
        /// The upper limit, or the upper end of a default range.
        high: S,
    },
    /// A unit quaternion x, y, z, w. Its velocity is the angular velocity in the rotated axes.
    Rotation,
    /// A position and a unit quaternion. The velocities are linear, then angular, in the rotated
    /// axes.
    Pose,
}

/// A group of coordinates that form a number, a rotation or a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates<S> {
    /// The space of the group.
    pub space: CoordinateSpace<S>,
    /// The index in q of the group's first coordinate.
    pub q: usize,
    /// The index in qd of the group's first velocity.
    pub v: usize,
}

impl<S> Coordinates<S> {
    /// Returns the number of the group's velocities.
    #[must_use]
    pub const fn velocities(&self) -> usize {
        match self.space {
            CoordinateSpace::Line { .. } => 1,
            CoordinateSpace::Rotation => 3,
            CoordinateSpace::Pose => 6,
        }
    }

    /// Returns the group with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(&S) -> T) -> Coordinates<T> {
        let space = match &self.space {
            CoordinateSpace::Line { low, high } => {
                CoordinateSpace::Line { low: f(low), high: f(high) }
            }
            CoordinateSpace::Rotation => CoordinateSpace::Rotation,
            CoordinateSpace::Pose => CoordinateSpace::Pose,
        };
        Coordinates { space, q: self.q, v: self.v }
    }
}

/// Returns the entries of a block-diagonal matrix of `nv` columns at the quaternions: a 6 x 6 block
/// by rows for each quaternion. An entry is its index in the matrix by columns. The block of a
/// rotation is the angular part of a block of a pose, whose other entries are zero (`None`).
pub fn quaternion_blocks<S>(
    coordinates: &[Coordinates<S>],
    nv: usize,
) -> impl Iterator<Item = Option<usize>> {
    let firsts = coordinates.iter().filter_map(|group| match group.space {
        CoordinateSpace::Line { .. } => None,
        CoordinateSpace::Rotation => Some((group.v, 3)),
        CoordinateSpace::Pose => Some((group.v, 0)),
    });
    firsts.flat_map(move |(first, skipped)| {
        (0..36).map(move |entry| {
            let row = usize::checked_sub(entry / 6, skipped)?;
            let column = usize::checked_sub(entry % 6, skipped)?;
            Some((first + column) * nv + first + row)
        })
    })
}

/// Returns the coordinates of `model` in their order; mimic joints have none.
pub(super) fn coordinates<S: Scalar>(model: &Model) -> Vec<Coordinates<S>> {
    let mut all = Vec::with_capacity(model.nv());
    for (i, link) in model.moving_links().iter().enumerate() {
        let joint = &link.joint;
        if joint.mimic.is_some() {
            continue;
        }
        let range = model.coordinate_range(i);
        let spaces: &[CoordinateSpace<f64>] = match joint.joint_type {
            JointType::Revolute | JointType::Continuous => &[line(range, PI)],
            JointType::Prismatic => &[line(range, 1.0)],
            JointType::Universal => &[line(range, PI); 2],
            JointType::Planar => &[line(range, 1.0), line(range, 1.0), line(range, PI)],
            JointType::Spherical => &[CoordinateSpace::Rotation],
            JointType::Floating => &[CoordinateSpace::Pose],
        };
        let q = model.q_range(i).start;
        let v = model.v_range(i).start;
        let blocks = spaces.iter().enumerate().map(|(k, space)| {
            Coordinates { space: *space, q: q + k, v: v + k }.map(|x| S::from_f64(*x))
        });
        all.extend(blocks);
    }
    all
}

/// Returns the range of a coordinate. Where a limit is infinite, the range is 2 `half_width` wide.
fn line([lower, upper]: [f64; 2], half_width: f64) -> CoordinateSpace<f64> {
    let (low, high) = match (lower.is_finite(), upper.is_finite()) {
        (true, true) => (lower, upper),
        (true, false) => (lower, lower + 2.0 * half_width),
        (false, true) => (upper - 2.0 * half_width, upper),
        (false, false) => (-half_width, half_width),
    };
    CoordinateSpace::Line { low, high }
}
