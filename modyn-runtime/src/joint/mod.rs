//! Joints: the contribution of each joint type to the equations, one file for each type.
//!
//! In the equations every joint axis is the z axis of its link's frame (`mechanism` rotates the
//! frames). A joint type is therefore described by its effect on spatial quantities about z.

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

/// The type of a joint: the motion that it allows.
///
/// A `match` that treats all types does not compile after another one is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointType {
    /// Rotation about the axis; the coordinate is the angle in rad.
    Revolute,
    /// Rotation about the axis without limits; the coordinate is the angle in rad.
    Continuous,
    /// Translation along the axis; the coordinate is the displacement in m.
    Prismatic,
    /// Rotation about the axis, then about the second axis, which rotates with the first. The
    /// coordinates are the two angles in rad, the velocities their rates.
    Universal,
    /// Translation along x and y of the plane normal to the axis, then rotation about the axis. The
    /// coordinates are x, y (m) and the angle (rad), the velocities their rates. x and y are the
    /// joint frame's axes, rotated by the smallest rotation from z to the axis.
    Planar,
    /// Any rotation. The coordinates are a unit quaternion x, y, z, w, which rotates vectors from
    /// the link's frame into the joint's frame. The velocity is the angular velocity in the link's
    /// own axes (rad/s).
    Spherical,
    /// Any motion. The coordinates are the position x, y, z in the joint's frame (m) and a unit
    /// quaternion x, y, z, w. The velocities are the linear velocity of the link's origin (m/s),
    /// then the angular velocity (rad/s), both in the link's own axes. The accelerations are the
    /// time derivatives of these six components: the spatial acceleration, not the classical one.
    Floating,
}

impl JointType {
    /// All types.
    pub const ALL: [Self; 7] = [
        Self::Revolute,
        Self::Continuous,
        Self::Prismatic,
        Self::Universal,
        Self::Planar,
        Self::Spherical,
        Self::Floating,
    ];

    /// Returns the type's name in URDF.
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

    /// Returns the number of coordinates.
    #[must_use]
    pub fn nq(self) -> usize {
        self.coordinates().len()
    }

    /// Returns the number of degrees of freedom.
    #[must_use]
    pub fn nv(self) -> usize {
        self.velocities().len()
    }

    /// Returns the names of the coordinates; empty for a single coordinate.
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

    /// Returns the names of the velocities; empty for a single velocity.
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
    fn names_are_the_names_in_urdf() {
        let types = [JointType::Revolute, JointType::Continuous, JointType::Prismatic];
        assert_eq!(types.map(JointType::name), ["revolute", "continuous", "prismatic"]);
        let types =
            [JointType::Universal, JointType::Planar, JointType::Spherical, JointType::Floating];
        assert_eq!(types.map(JointType::name), ["universal", "planar", "spherical", "floating"]);
        assert_eq!(types.map(|t| (t.nq(), t.nv())), [(2, 2), (3, 3), (4, 3), (7, 6)]);
    }
}
