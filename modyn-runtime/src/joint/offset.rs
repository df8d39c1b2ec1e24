//! The zero of a joint's turned frame.

use crate::Scalar;
use crate::spatial::Turn;

/// Where a revolute joint's turned frame has its zero, against the coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zero<S> {
    /// That many quarter turns ahead.
    Quarters(u8),
    /// So many rad ahead.
    Angle(S),
}

impl<S: Scalar> Zero<S> {
    /// The turn by it.
    #[must_use]
    pub fn turn(self) -> Turn<S> {
        match self {
            Self::Quarters(n) => Turn::Quarters(n),
            Self::Angle(angle) => {
                let (sin, cos) = angle.sin_cos();
                Turn::Angle { cos, sin }
            }
        }
    }

    /// Each number through `f`.
    pub fn map<T>(self, f: impl FnOnce(S) -> T) -> Zero<T> {
        match self {
            Self::Quarters(n) => Zero::Quarters(n),
            Self::Angle(angle) => Zero::Angle(f(angle)),
        }
    }
}
