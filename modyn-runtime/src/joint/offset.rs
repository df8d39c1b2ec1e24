//! The offset between a joint's coordinate and the angle in its rotated frame.

use crate::Scalar;
use crate::spatial::AxisRotation;

/// The angle of a joint's rotated frame at coordinate zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointOffset<S> {
    /// This many quarter turns.
    Quarters(u8),
    /// This angle, rad.
    Angle(S),
}

impl<S: Scalar> JointOffset<S> {
    /// Returns the rotation by the offset.
    #[must_use]
    pub fn rotation(self) -> AxisRotation<S> {
        match self {
            Self::Quarters(n) => AxisRotation::Quarters(n),
            Self::Angle(angle) => {
                let (sin, cos) = angle.sin_cos();
                AxisRotation::Angle { cos, sin }
            }
        }
    }

    /// Returns the offset with `f` applied to its numbers.
    pub fn map<T>(self, f: impl FnOnce(S) -> T) -> JointOffset<T> {
        match self {
            Self::Quarters(n) => JointOffset::Quarters(n),
            Self::Angle(angle) => JointOffset::Angle(f(angle)),
        }
    }
}
