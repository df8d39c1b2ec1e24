//! Loop constraints: the joints that close loops of a tree of joints.

use alloc::{string::String, vec, vec::Vec};

use super::Model;
use crate::inertial::Inertial;
use crate::joint::planar;
use crate::spatial::Pose;

/// A joint that closes a loop: two frames that are held together.
///
/// Joints make a tree; a loop is cut at one of its joints, and the motion that this joint allows is a loop
/// constraint. [`constrained_forward_dynamics`](crate::Interpreter::constrained_forward_dynamics) and
/// [`project_constraints`](crate::Interpreter::project_constraints) meet it; all other quantities are
/// those of the tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopConstraint {
    /// Its name.
    pub name: String,
    /// The motion that is allowed.
    pub kind: LoopConstraintKind,
    /// The two frames, of links that move against each other.
    pub ends: [LoopConstraintEnd; 2],
}

/// A frame that a [`LoopConstraint`] holds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopConstraintEnd {
    /// The link of the description, as an index into [`Model::frames`](super::Model::frames).
    pub frame: usize,
    /// Where the frame stands on the link.
    pub pose: Pose<f64>,
}

/// The motion that a [`LoopConstraint`] allows: that of the joint which was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LoopConstraintKind {
    /// The frames' origins: a ball and socket (URDF's way: `spherical`).
    Point,
    /// The frames: a weld (`fixed`).
    Rigid,
    /// The origins and an axis, a unit vector that is the same in both frames: a hinge (`revolute`).
    Revolute([f64; 3]),
    /// All but the place along an axis, a unit vector in the first frame: a slide (`prismatic`).
    Prismatic([f64; 3]),
}

/// Unit vectors of rotations, then of displacements.
type Directions = [Vec<[f64; 3]>; 2];

impl LoopConstraintKind {
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

    /// The number of constraint rows.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            Self::Point => 3,
            Self::Rigid => 6,
            Self::Revolute(_) | Self::Prismatic(_) => 5,
        }
    }

    /// The constrained and the free directions, unit vectors in the first frame: of each the rotations,
    /// then the displacements.
    pub(crate) fn directions(self) -> (Directions, Directions) {
        let across = |axis| {
            let plane = planar::plane(axis);
            vec![plane.map(|row| row[0]), plane.map(|row| row[1])]
        };
        let all = || Pose::identity().rotation.to_vec();
        match self {
            Self::Point => ([vec![], all()], [all(), vec![]]),
            Self::Rigid => ([all(), all()], [vec![], vec![]]),
            Self::Revolute(axis) => ([across(axis), all()], [vec![axis], vec![]]),
            Self::Prismatic(axis) => ([all(), across(axis)], [vec![], vec![axis]]),
        }
    }
}

impl Model {
    /// The characteristic length of a loop, m: what a rotation of the loop constraint of that index is
    /// multiplied by to be compared with a displacement.
    ///
    /// For each link that moves one of the two frames relative to the other, it adds up the distance from
    /// the link's joint to the next joint (or the frame) of the loop, and the link's radius of gyration
    /// about its joint, sqrt(|c|^2 + (Ixx + Iyy + Izz) / 2m) with the centre of mass c. The link that
    /// carries both sides of the loop adds the distance between their first joints. It is 1 m where all of
    /// these are zero, and does not depend on the coordinates, nor on inertias that are set at run time.
    ///
    /// # Panics
    ///
    /// If there is no loop constraint of that index.
    #[must_use]
    pub fn characteristic_length(&self, constraint: usize) -> f64 {
        let frames = self.loop_constraints[constraint].ends.each_ref().map(|end| {
            let frame = &self.frames[end.frame];
            (frame.link, frame.pose.transform_point(end.pose.translation))
        });
        let [mut first, mut second] = frames;
        let mut length = 0.0;
        while first.0 != second.0 {
            // Parents come before their children, and the world before all.
            let later = if first.0 > second.0 { &mut first } else { &mut second };
            if let Some(i) = later.0 {
                length += self.length_of_link(i, later.1);
                *later = (self.links[i].parent, self.links[i].joint.origin.translation);
            }
        }
        length += distance(first.1, second.1);
        if length > 0.0 { length } else { 1.0 }
    }

    /// The share of link `i`, with the next joint or frame at `point` on it, in the characteristic length of a
    /// constraint, m: the distance of the point from the link's joint, and the link's radius of gyration.
    pub(super) fn length_of_link(&self, i: usize, point: [f64; 3]) -> f64 {
        distance(point, [0.0; 3]) + radius_of_gyration(&self.links[i].inertial)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt(a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum())
}

/// About the link's origin, m; zero without mass.
fn radius_of_gyration(inertial: &Inertial) -> f64 {
    let [xx, _, _, yy, _, zz] = inertial.inertia;
    let [x, y, z] = inertial.center_of_mass;
    if inertial.mass > 0.0 {
        libm::sqrt(x * x + y * y + z * z + 0.5 * (xx + yy + zz).max(0.0) / inertial.mass)
    } else {
        0.0
    }
}
