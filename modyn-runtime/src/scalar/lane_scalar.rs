//! The trait of numbers that may be packs of lanes.

use core::ops::Range;

use super::Scalar;

/// A number that may be a pack of several: one lane for each of several equal limbs, or for each of
/// several columns of a matrix.
///
/// The compiler's expressions are such numbers. `f64` is none: a mechanism whose limbs are merged
/// ([`MergedMechanism`](crate::mechanism::MergedMechanism)) cannot be computed with on it.
pub trait LaneScalar: Scalar {
    /// The pack of these numbers, a lane each.
    #[must_use]
    fn pack(each: &[Self]) -> Self;

    /// The number in one lane of a pack.
    #[must_use]
    fn extract_lane(self, lane: usize) -> Self;

    /// The sum of the numbers in these lanes of a pack, at least one.
    #[must_use]
    fn sum_lanes(self, lanes: Range<usize>) -> Self;
}
