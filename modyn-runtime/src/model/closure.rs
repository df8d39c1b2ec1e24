//! Loop closures: what a tree of joints is cut at.

use alloc::{string::String, vec, vec::Vec};

use crate::joint::planar;
use crate::spatial::Pose;

/// Two frames that are held together, which closes a loop of joints.
///
/// Joints make a tree; a loop is cut at one of its joints, and what that joint holds is a closure.
/// Only what asks for it feels it: [`constrained_forward_dynamics`](crate::Interpreter::constrained_forward_dynamics)
/// does, all other quantities are those of the tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Closure {
    /// Its name.
    pub name: String,
    /// What is held.
    pub kind: ClosureKind,
    /// The two frames, of links that move against each other.
    pub ends: [ClosureEnd; 2],
}

/// A frame that a [`Closure`] holds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosureEnd {
    /// The link of the description, as an index into [`Model::frames`](super::Model::frames).
    pub frame: usize,
    /// Where the frame stands on the link.
    pub pose: Pose<f64>,
}

/// What a [`Closure`] holds: that of the joint which was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ClosureKind {
    /// The frames' origins: a ball and socket (URDF's way: `spherical`).
    Point,
    /// The frames: a weld (`fixed`).
    Rigid,
    /// The origins and an axis, a unit vector that is the same in both frames: a hinge (`revolute`).
    Revolute([f64; 3]),
    /// All but the place along an axis, a unit vector in the first frame: a slide (`prismatic`).
    Prismatic([f64; 3]),
}

impl ClosureKind {
    /// What a cut joint of this type holds (`spherical`, `fixed`, `revolute`, `continuous`,
    /// `prismatic`), the latter three along `axis`; `None` for other types.
    #[must_use]
    pub fn of_joint(joint_type: &str, axis: [f64; 3]) -> Option<Self> {
        Some(match joint_type {
            "spherical" => Self::Point,
            "fixed" => Self::Rigid,
            "revolute" | "continuous" => Self::Revolute(axis),
            "prismatic" => Self::Prismatic(axis),
            _ => return None,
        })
    }

    /// What the joint that was cut is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "spherical",
            Self::Rigid => "fixed",
            Self::Revolute(_) => "revolute",
            Self::Prismatic(_) => "prismatic",
        }
    }

    /// Its axis, if it has one.
    #[must_use]
    pub fn axis(self) -> Option<[f64; 3]> {
        match self {
            Self::Point | Self::Rigid => None,
            Self::Revolute(axis) | Self::Prismatic(axis) => Some(axis),
        }
    }

    /// The directions, unit vectors in the first frame, that the second one cannot turn about, and
    /// those that it cannot move along.
    pub(crate) fn held(self) -> [Vec<[f64; 3]>; 2] {
        let across = |axis| {
            let plane = planar::plane(axis);
            vec![plane.map(|row| row[0]), plane.map(|row| row[1])]
        };
        let all = || Pose::identity().rotation.to_vec();
        match self {
            Self::Point => [vec![], all()],
            Self::Rigid => [all(), all()],
            Self::Revolute(axis) => [across(axis), all()],
            Self::Prismatic(axis) => [all(), across(axis)],
        }
    }
}
