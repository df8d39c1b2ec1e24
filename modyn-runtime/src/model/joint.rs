//! Joints: type, axis, limits, coupling to other joints, rotor, damping and friction.

use alloc::string::String;

use crate::joint::JointType;
use crate::spatial::Pose;

/// A joint: how a link moves against its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// The joint's name in the description.
    pub name: String,
    /// What motion it allows.
    pub joint_type: JointType,
    /// The axis, a unit vector in the joint's (and so the link's) frame; without meaning for
    /// spherical and floating joints.
    pub axis: [f64; 3],
    /// A universal joint's second axis, a unit vector in the frame behind the first rotation;
    /// without meaning for other types.
    pub second_axis: [f64; 3],
    /// The joint's frame at coordinate zero, in the frame of the parent link (or of the world).
    pub origin: Pose<f64>,
    /// Limits, where the description states them.
    pub limits: Option<Limits>,
    /// The joint that it follows; it then has no coordinate of its own.
    pub mimic: Option<Mimic>,
    /// What its drive and bearing add.
    pub drive: JointDynamics,
}

impl Joint {
    /// A joint of its own along `axis`, without limits, rotor or friction.
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
            drive: JointDynamics::default(),
        }
    }
}

/// How a joint of one coordinate follows another: q = multiplier q(leader) + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mimic {
    /// The link, as an index, whose joint is followed; that one may follow another in turn.
    pub leader: usize,
    /// The ratio of the velocities.
    pub multiplier: f64,
    /// The coordinate where the leader's is zero.
    pub offset: f64,
}

/// What a joint's drive and bearing add to each of its degrees of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointDynamics {
    /// The rotor's inertia as the joint feels it, gear ratio squared times rotor inertia: kg m^2,
    /// or kg for a joint that slides.
    pub armature: f64,
    /// Viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Coulomb friction, N m or N.
    pub friction: f64,
}

/// Limits of a joint, as the description states them: rad or m, rad/s or m/s, N m or N.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Smallest coordinate; `None` where there is no such limit (a continuous joint).
    pub lower: Option<f64>,
    /// Largest coordinate; `None` where there is no such limit (a continuous joint).
    pub upper: Option<f64>,
    /// Largest speed; `None` where it is not stated.
    pub velocity: Option<f64>,
    /// Largest effort; `None` where it is not stated.
    pub effort: Option<f64>,
}

/// Which of [`JointDynamics`]' torques act against the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Friction {
    /// None; damping and friction are figures only.
    #[default]
    None,
    /// Damping.
    Viscous,
    /// Damping, and Coulomb friction: its sign jumps at rest, where it is zero.
    Coulomb,
    /// Damping, and Coulomb friction times v / sqrt(v^2 + w^2) with this w: without a jump. In
    /// rad/s or m/s, positive.
    Smooth(f64),
}
