//! Joints: type, axis, limits, mimics, armature, damping and friction.

use alloc::string::String;

use crate::joint::JointType;
use crate::spatial::Pose;

/// A joint: how a link moves relative to its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// The joint's name in the description.
    pub name: String,
    /// The motion that the joint allows.
    pub joint_type: JointType,
    /// The axis, a unit vector in the joint's frame, which is also the link's; without meaning for
    /// spherical and floating joints.
    pub axis: [f64; 3],
    /// The second axis of a universal joint, a unit vector in the frame after the first rotation;
    /// without meaning for other types.
    pub second_axis: [f64; 3],
    /// The pose of the joint's frame at coordinate zero, in the frame of the parent link (or of the
    /// world).
    pub origin: Pose<f64>,
    /// The limits; `None` if the description has none.
    pub limits: Option<Limits>,
    /// The joint that a mimic joint follows; a mimic joint has no coordinate of its own.
    pub mimic: Option<Mimic>,
    /// Armature, damping and friction.
    pub dynamics: JointDynamics,
}

impl Joint {
    /// Returns a joint along `axis`, with a coordinate of its own, without limits, armature or
    /// friction.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        joint_type: JointType,
        axis: [f64; 3],
        origin: Pose<f64>,
    ) -> Self {
        Self {
            name: name.into(),
            joint_type,
            axis,
            second_axis: [0.0, 1.0, 0.0],
            origin,
            limits: None,
            mimic: None,
            dynamics: JointDynamics::default(),
        }
    }
}

/// The relation of a mimic joint to its leader: q = multiplier q(leader) + offset. Both have one
/// coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mimic {
    /// The index of the leader's link. The leader may be a mimic joint itself.
    pub leader: usize,
    /// The velocity of the joint divided by the leader's.
    pub multiplier: f64,
    /// The joint's coordinate at the leader's coordinate zero, rad or m.
    pub offset: f64,
}

/// Armature, damping and friction at each degree of freedom of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointDynamics {
    /// The armature: the rotor's inertia times the squared gear ratio, kg m^2, or kg for a
    /// prismatic joint.
    pub armature: f64,
    /// Viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Coulomb friction, N m or N.
    pub friction: f64,
}

/// Limits of a joint, in the description's values: rad or m, rad/s or m/s, N m or N.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// The lower position limit; `None` without a limit (a continuous joint).
    pub lower: Option<f64>,
    /// The upper position limit; `None` without a limit (a continuous joint).
    pub upper: Option<f64>,
    /// The velocity limit; `None` if the description has none.
    pub velocity: Option<f64>,
    /// The effort limit; `None` if the description has none.
    pub effort: Option<f64>,
}

/// The part of [`JointDynamics`] that resists the joints' motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum JointFriction {
    /// None: damping and friction have no effect.
    #[default]
    None,
    /// Viscous damping.
    Viscous,
    /// Viscous damping and Coulomb friction. The sign of friction jumps at rest, where friction is
    /// zero.
    Coulomb,
    /// Viscous damping, and Coulomb friction times v / sqrt(v^2 + w^2) with this transition
    /// velocity w, without a jump. rad/s or m/s, positive.
    Smooth(f64),
}
