//! The units of the entries of joint vectors.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;

/// The kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An angle, or a rotation about an axis.
    Angle,
    /// A displacement along an axis.
    Displacement,
    /// A component of a unit quaternion.
    Quaternion,
}

impl Kind {
    /// Returns the unit of the coordinate.
    pub fn coordinate(self) -> &'static str {
        match self {
            Self::Angle => "rad",
            Self::Displacement => "m",
            Self::Quaternion => "1",
        }
    }

    /// Returns the unit of the velocity.
    pub fn velocity(self) -> &'static str {
        if self == Self::Displacement { "m/s" } else { "rad/s" }
    }

    /// Returns the unit of the joint force.
    pub fn torque(self) -> &'static str {
        if self == Self::Displacement { "N" } else { "N m" }
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

fn kinds(model: &Model, components: fn(JointType) -> &'static [&'static str]) -> Vec<Kind> {
    let independent =
        model.moving_links().iter().map(|link| &link.joint).filter(|joint| joint.mimic.is_none());
    let kind = |joint_type, component: &&str| match *component {
        "" if joint_type == JointType::Prismatic => Kind::Displacement,
        "x" | "y" | "z" | "vx" | "vy" | "vz" => Kind::Displacement,
        "qx" | "qy" | "qz" | "qw" => Kind::Quaternion,
        _ => Kind::Angle,
    };
    independent
        .flat_map(|joint| {
            components(joint.joint_type)
                .iter()
                .map(move |component| kind(joint.joint_type, component))
        })
        .collect()
}
