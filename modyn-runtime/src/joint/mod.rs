//! Joints: what each type contributes to the equations, one file a type.
//!
//! The equations see every joint along the z axis of its link's frame (`model::prepare` turns the
//! frames), so a joint type is described by what it does to spatial quantities about z.

#[cfg(feature = "alloc")]
mod motion;
#[cfg(feature = "alloc")]
mod prismatic;
#[cfg(feature = "alloc")]
mod revolute;

#[cfg(feature = "alloc")]
pub use motion::{Carried, Motion};

/// What motion a joint allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum JointType {
    /// Rotation about the axis; the coordinate is the angle in rad.
    Revolute,
    /// Rotation about the axis without limits; the coordinate is the angle in rad.
    Continuous,
    /// Translation along the axis; the coordinate is the displacement in m.
    Prismatic,
}

impl JointType {
    /// The name that URDF has for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::JointType;

    #[test]
    fn names_are_those_of_urdf() {
        let types = [JointType::Revolute, JointType::Continuous, JointType::Prismatic];
        assert_eq!(types.map(JointType::name), ["revolute", "continuous", "prismatic"]);
    }
}
