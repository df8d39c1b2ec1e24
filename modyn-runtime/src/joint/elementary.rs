//! The joints that the equations know.

/// An elementary joint: the motion that it allows, in the frame behind it. All other joints are made of these.
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
    /// How many coordinates it takes.
    #[must_use]
    pub fn nq(self) -> usize {
        match self {
            Self::Revolute | Self::Prismatic => 1,
            Self::Spherical => 4,
            Self::Floating => 7,
        }
    }

    /// Whether it moves along an axis, z: the same one seen from in front of the joint and from
    /// behind it, so that its degree of freedom may be described in either frame.
    #[must_use]
    pub fn has_axis(self) -> bool {
        matches!(self, Self::Revolute | Self::Prismatic)
    }

    /// Which of the six components (angular x, y, z, linear x, y, z) its degrees of freedom move,
    /// one each: where the paper's joint-motion propagation vectors p are not zero.
    #[must_use]
    pub fn components(self) -> &'static [usize] {
        match self {
            Self::Revolute => &[2],
            Self::Prismatic => &[5],
            Self::Spherical => &[0, 1, 2],
            Self::Floating => &[3, 4, 5, 0, 1, 2],
        }
    }
}
