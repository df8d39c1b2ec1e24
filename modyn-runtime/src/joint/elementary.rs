//! The elementary joints: the joint types of the equations.

/// An elementary joint: the motion that it allows, in its child frame. All other joint types are
/// composed of elementary joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementaryJoint {
    /// Rotation about z.
    Revolute,
    /// Translation along z.
    Prismatic,
    /// Any rotation.
    Spherical,
    /// Any motion.
    Floating,
}

impl ElementaryJoint {
    /// Returns the number of coordinates.
    #[must_use]
    pub fn nq(self) -> usize {
        match self {
            Self::Revolute | Self::Prismatic => 1,
            Self::Spherical => 4,
            Self::Floating => 7,
        }
    }

    /// Returns whether the joint moves along or about an axis, z. The axis is the same in the
    /// parent frame and in the child frame, so that its degree of freedom may be described in
    /// either frame.
    #[must_use]
    pub fn has_axis(self) -> bool {
        matches!(self, Self::Revolute | Self::Prismatic)
    }

    /// Returns the components of the twist (linear x, y, z, angular x, y, z) that the degrees of
    /// freedom move, one for each: the nonzero entries of the paper's joint-motion propagation
    /// vectors p.
    #[must_use]
    pub fn components(self) -> &'static [usize] {
        match self {
            Self::Revolute => &[5],
            Self::Prismatic => &[2],
            Self::Spherical => &[3, 4, 5],
            Self::Floating => &[0, 1, 2, 3, 4, 5],
        }
    }
}
