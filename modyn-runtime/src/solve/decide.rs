//! Decisions of loops.

use crate::Scalar;

/// A number, or numbers in lanes, on which a loop can decide to end or to leave out work.
///
/// Equations do not branch on values; the number of iterations of a solver may depend on them.
/// Implementations know the sign of each number: they implement `Scalar::is_known_nonnegative`.
pub trait Decide: Scalar {
    /// Returns whether the number is not negative; in lanes, whether none of the numbers is. It is
    /// false for NaN.
    #[inline(always)]
    #[must_use]
    fn all_nonnegative(self) -> bool {
        self.is_known_nonnegative()
    }

    /// Returns whether the number is at most `other`; in lanes, whether all numbers are.
    #[inline(always)]
    #[must_use]
    fn all_at_most(self, other: Self) -> bool {
        (other - self).all_nonnegative()
    }
}

macro_rules! decide {
    ($($float:ty)*) => {
        $(impl Decide for $float {
            #[inline]
            fn all_at_most(self, other: Self) -> bool {
                self <= other
            }
        })*
    };
}

decide!(f32 f64);
