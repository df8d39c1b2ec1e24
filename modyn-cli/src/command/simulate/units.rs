//! What the entries of the joint vectors are measured in.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;

/// What an entry is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An angle, or about an axis.
    Turn,
    /// A displacement, or along an axis.
    Shift,
    /// Of a unit quaternion.
    Quaternion,
}

impl Kind {
    /// Of a coordinate.
    pub fn coordinate(self) -> &'static str {
        match self {
            Self::Turn => "rad",
            Self::Shift => "m",
            Self::Quaternion => "1",
        }
    }

    /// Of its rate.
    pub fn velocity(self) -> &'static str {
        if self == Self::Shift { "m/s" } else { "rad/s" }
    }

    /// Of what drives it.
    pub fn torque(self) -> &'static str {
        if self == Self::Shift { "N" } else { "N m" }
    }
}

/// By coordinate.
pub fn coordinates(model: &Model) -> Vec<Kind> {
    kinds(model, JointType::coordinates)
}

/// By velocity.
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
