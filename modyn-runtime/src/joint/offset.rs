//! The zero of a joint's turned frame.

use crate::Scalar;
use crate::spatial::AxisRotation;

/// Where a revolute joint's turned frame has its zero, against the coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointOffset<S> {
    /// That many quarter turns ahead.
    Quarters(u8),
    /// So many rad ahead.
    Angle(S),
}

impl<S: Scalar> JointOffset<S> {
    /// The turn by it.
    #[must_use]
    pub fn turn(self) -> AxisRotation<S> {
        match self {
            Self::Quarters(n) => AxisRotation::Quarters(n),
            Self::Angle(angle) => {
                let (sin, cos) = angle.sin_cos();
                AxisRotation::Angle { cos, sin }
            }
        }
    }

    /// Each number through `f`.
    pub fn map<T>(self, f: impl FnOnce(S) -> T) -> JointOffset<T> {
        match self {
            Self::Quarters(n) => JointOffset::Quarters(n),
            Self::Angle(angle) => JointOffset::Angle(f(angle)),
        }
    }
}
