//! Loop constraints: the joints that close loops of a tree of joints.

use alloc::{string::String, vec, vec::Vec};

use super::Model;
use crate::inertial::Inertial;
use crate::joint::planar;
use crate::spatial::Pose;

/// A joint that closes a loop: a constraint between two frames.
///
/// The joints of a model form a tree. A loop is cut at one of its joints, which becomes a loop
/// constraint. [`constrained_forward_dynamics`](crate::Interpreter::constrained_forward_dynamics)
/// and [`project_constraints`](crate::Interpreter::project_constraints) satisfy it. All other
/// functions ignore it: they compute quantities of the tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopConstraint {
    /// The constraint's name.
    pub name: String,
    /// The relative motion that is allowed.
    pub kind: LoopConstraintKind,
    /// The two frames, on links that move relative to each other.
    pub ends: [LoopConstraintEnd; 2],
}

/// A frame of a [`LoopConstraint`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopConstraintEnd {
    /// The link of the description, as an index into [`Model::links`](super::Model::links).
    pub link: usize,
    /// The pose of the frame in the link's frame.
    pub pose: Pose<f64>,
}

/// The relative motion that a [`LoopConstraint`] allows: the motion of the joint at which the loop
/// was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LoopConstraintKind {
    /// The origins coincide: a ball and socket joint (`spherical` in URDF).
    Point,
    /// The frames coincide: a weld (`fixed`).
    Rigid,
    /// The origins and an axis coincide: a hinge (`revolute`). The axis is a unit vector in both
    /// frames.
    Revolute([f64; 3]),
    /// The frames coincide but for a translation along an axis, a unit vector in the first frame: a
    /// slider (`prismatic`).
    Prismatic([f64; 3]),
}

/// Unit vectors of displacements, then of rotations.
type Directions = [Vec<[f64; 3]>; 2];

impl LoopConstraintKind {
    /// Returns the constraint of a joint type (`spherical`, `fixed`, `revolute`, `continuous`,
    /// `prismatic`); the last three use `axis`. Returns `None` for other types.
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

    /// Returns the type's name of the joint at which the loop was cut.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "spherical",
            Self::Rigid => "fixed",
            Self::Revolute(_) => "revolute",
            Self::Prismatic(_) => "prismatic",
        }
    }

    /// Returns the axis; `None` for constraints without an axis.
    #[must_use]
    pub fn axis(self) -> Option<[f64; 3]> {
        match self {
            Self::Point | Self::Rigid => None,
            Self::Revolute(axis) | Self::Prismatic(axis) => Some(axis),
        }
    }

    /// Returns the number of constraint rows.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            Self::Point => 3,
            Self::Rigid => 6,
            Self::Revolute(_) | Self::Prismatic(_) => 5,
        }
    }

    /// Returns the constrained and the free directions, unit vectors in the first frame;
    /// displacements come before rotations in each.
    pub(crate) fn directions(self) -> (Directions, Directions) {
        let across = |axis| {
            let plane = planar::plane(axis);
            vec![plane.map(|row| row[0]), plane.map(|row| row[1])]
        };
        let all = || Pose::identity().rotation.to_vec();
        match self {
            Self::Point => ([all(), vec![]], [vec![], all()]),
            Self::Rigid => ([all(), all()], [vec![], vec![]]),
            Self::Revolute(axis) => ([all(), across(axis)], [vec![], vec![axis]]),
            Self::Prismatic(axis) => ([across(axis), all()], [vec![axis], vec![]]),
        }
    }
}

impl Model {
    /// Returns the characteristic length of the loop constraint with index `constraint`, m: the
    /// factor that makes a rotation comparable to a displacement.
    ///
    /// It is a sum over the links that move one of the two frames relative to the other. Each adds
    /// the distance from its joint to the next joint (or the frame) of the loop, and its radius of
    /// gyration about its joint, sqrt(|c|^2 + (Ixx + Iyy + Izz) / 2m) with the centre of mass c.
    /// The link that carries both sides of the loop adds the distance between their first joints.
    /// If all of these are zero, the length is 1 m. It does not depend on the coordinates, nor on
    /// inertias that are set at run time.
    ///
    /// # Panics
    /// If there is no loop constraint with this index.
    #[must_use]
    pub fn characteristic_length(&self, constraint: usize) -> f64 {
        let frames = self.loop_constraints[constraint].ends.each_ref().map(|end| {
            let link = &self.links[end.link];
            (link.moving_link, link.pose.transform_point(end.pose.translation))
        });
        let [mut first, mut second] = frames;
        let mut length = 0.0;
        while first.0 != second.0 {
            // Parents come before their children, and `None` (the world) before all.
            let later = if first.0 > second.0 { &mut first } else { &mut second };
            if let Some(i) = later.0 {
                length += self.length_of_link(i, later.1);
                *later =
                    (self.moving_links[i].parent, self.moving_links[i].joint.origin.translation);
            }
        }
        length += distance(first.1, second.1);
        if length > 0.0 { length } else { 1.0 }
    }

    /// The share of link `i`, with the next joint or frame at `point` on it, in the characteristic
    /// length of a constraint, m: the distance of the point from the link's joint, and the link's
    /// radius of gyration.
    pub(super) fn length_of_link(&self, i: usize, point: [f64; 3]) -> f64 {
        distance(point, [0.0; 3]) + radius_of_gyration(&self.moving_links[i].inertial)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt(a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum())
}

/// Returns the radius of gyration about the link's origin, m; zero for a link without mass.
pub(crate) fn radius_of_gyration(inertial: &Inertial) -> f64 {
    let [xx, _, _, yy, _, zz] = inertial.inertia;
    let [x, y, z] = inertial.center_of_mass;
    if inertial.mass > 0.0 {
        libm::sqrt(x * x + y * y + z * z + 0.5 * (xx + yy + zz).max(0.0) / inertial.mass)
    } else {
        0.0
    }
}
