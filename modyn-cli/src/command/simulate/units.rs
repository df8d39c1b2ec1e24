//! The units of the entries of joint vectors.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;

/// The kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An angle, or a rotation about an axis.
    Turn,
    /// A displacement along an axis.
    Shift,
    /// A component of a unit quaternion.
    Quaternion,
}

impl Kind {
    /// Returns the unit of the coordinate.
    pub fn coordinate(self) -> &'static str {
        match self {
            Self::Turn => "rad",
            Self::Shift => "m",
            Self::Quaternion => "1",
        }
    }

    /// Returns the unit of the velocity.
    pub fn velocity(self) -> &'static str {
        if self == Self::Shift { "m/s" } else { "rad/s" }
    }

    /// Returns the unit of the joint force.
    pub fn torque(self) -> &'static str {
        if self == Self::Shift { "N" } else { "N m" }
    }
}

/// Returns the kind of each coordinate.
pub fn coordinates(model: &Model) -> Vec<Kind> {
    kinds(model, JointType::coordinates)
}

/// Returns the kind of each velocity.
pub fn velocities(model: &Model) -> Vec<Kind> {
    kinds(model, JointType::velocities)
}

fn kinds(model: &Model, parts: fn(JointType) -> &'static [&'static str]) -> Vec<Kind> {
    let own = model.links().iter().map(|link| &link.joint).filter(|joint| joint.mimic.is_none());
    let kind = |joint_type, part: &&str| match *part {
        "" if joint_type == JointType::Prismatic => Kind::Shift,
        "x" | "y" | "z" | "vx" | "vy" | "vz" => Kind::Shift,
        "qx" | "qy" | "qz" | "qw" => Kind::Quaternion,
        _ => Kind::Turn,
    };
    own.flat_map(|joint| {
        parts(joint.joint_type).iter().map(move |part| kind(joint.joint_type, part))
    })
    .collect()
}
