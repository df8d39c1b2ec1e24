//! Springs of joints.

use alloc::vec::Vec;

/// A spring at a joint, which acts always: it pulls the joint's coordinates towards a reference.
///
/// The force along a coordinate that is a number is -`stiffness` times the displacement from the
/// reference. A spherical joint's spring acts along the rotation vector from the reference to the
/// joint's rotation, and a floating joint's spring along that vector and along the displacement of
/// the link's origin. The potential energy is half of `stiffness` times the sum of squares of these
/// displacements.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spring {
    /// The moving link whose joint has the spring: an index into
    /// [`Model::links`](super::Model::links).
    pub link: usize,
    /// The stiffness, at least 0: N m/rad for rotations, N/m for displacements.
    pub stiffness: f64,
    /// The joint's own coordinates at which the spring exerts no force, also of a mimic joint; rad,
    /// m and unit quaternions.
    pub reference: Vec<f64>,
}
