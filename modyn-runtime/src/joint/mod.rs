//! Joints: what each type contributes to the equations, one file a type.
//!
//! The equations see every joint along the z axis of its link's frame (`mechanism` turns the
//! frames), so a joint type is described by what it does to spatial quantities about z.

#[cfg(feature = "alloc")]
mod elementary;
#[cfg(feature = "alloc")]
mod floating;
#[cfg(feature = "alloc")]
mod offset;
#[cfg(feature = "alloc")]
mod parent_motion;
pub mod planar;
#[cfg(feature = "alloc")]
mod prismatic;
#[cfg(feature = "alloc")]
mod revolute;
#[cfg(feature = "alloc")]
mod rotated;
#[cfg(feature = "alloc")]
mod spherical;
#[cfg(feature = "alloc")]
mod transform;

#[cfg(feature = "alloc")]
pub use {
    elementary::ElementaryJoint, offset::JointOffset, parent_motion::ParentMotion,
    transform::JointTransform,
};

/// What motion a joint allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum JointType {
    /// Rotation about the axis; the coordinate is the angle in rad.
    Revolute,
    /// Rotation about the axis without limits; the coordinate is the angle in rad.
    Continuous,
    /// Translation along the axis; the coordinate is the displacement in m.
    Prismatic,
    /// Rotation about the axis, then about the second axis, which turns along; the coordinates are
    /// the two angles in rad, the velocities their rates.
    Universal,
    /// Translation along x and y of the plane that the axis is normal to, then rotation about the
    /// axis. Coordinates x, y (m) and the angle (rad), velocities their rates; x and y are the
    /// joint's axes turned by the smallest rotation from z to the axis.
    Planar,
    /// Any rotation. The coordinates are a unit quaternion x, y, z, w from the link to the joint's
    /// frame, the velocities the angular velocity in the link's own axes (rad/s).
    Spherical,
    /// Any motion. The coordinates are the position x, y, z in the joint's frame (m) and a unit
    /// quaternion x, y, z, w; the velocities the linear one of the link's origin (m/s), then the
    /// angular one (rad/s), both in the link's own axes; accelerations are the rates of these
    /// numbers (the spatial acceleration, not the classical one).
    Floating,
}

impl JointType {
    /// The name that URDF has for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Universal => "universal",
            Self::Planar => "planar",
            Self::Spherical => "spherical",
            Self::Floating => "floating",
        }
    }

    /// How many coordinates it has.
    #[must_use]
    pub fn nq(self) -> usize {
        self.coordinates().len()
    }

    /// How many degrees of freedom it has.
    #[must_use]
    pub fn nv(self) -> usize {
        self.velocities().len()
    }

    /// What its coordinates are called; nothing where there is one alone.
    #[must_use]
    pub fn coordinates(self) -> &'static [&'static str] {
        match self {
            Self::Revolute | Self::Continuous | Self::Prismatic => &[""],
            Self::Universal => &["first", "second"],
            Self::Planar => &["x", "y", "angle"],
            Self::Spherical => &["qx", "qy", "qz", "qw"],
            Self::Floating => &["x", "y", "z", "qx", "qy", "qz", "qw"],
        }
    }

    /// What its velocities are called; nothing where there is one alone.
    #[must_use]
    pub fn velocities(self) -> &'static [&'static str] {
        match self {
            Self::Spherical => &["wx", "wy", "wz"],
            Self::Floating => &["vx", "vy", "vz", "wx", "wy", "wz"],
            _ => self.coordinates(),
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
        let types =
            [JointType::Universal, JointType::Planar, JointType::Spherical, JointType::Floating];
        assert_eq!(types.map(JointType::name), ["universal", "planar", "spherical", "floating"]);
        assert_eq!(types.map(|t| (t.nq(), t.nv())), [(2, 2), (3, 3), (4, 3), (7, 6)]);
    }
}
