//! The trait of scalars that may be packs of lanes.

use core::ops::Range;

use super::Scalar;

/// A scalar that may be a pack of lanes: one for each of several equal limbs, or for each of
/// several columns of a matrix.
///
/// The compiler's expressions implement it. `f64` does not, so a mechanism with merged limbs
/// ([`MergedMechanism`](crate::mechanism::MergedMechanism)) cannot be computed on `f64`.
pub trait LaneScalar: Scalar {
    /// Returns the pack of these lanes.
    #[must_use]
    fn pack(each: &[Self]) -> Self;

    /// Returns one lane of a pack.
    #[must_use]
    fn extract_lane(self, lane: usize) -> Self;

    /// Returns the sum of these lanes of a pack; there must be at least one.
    #[must_use]
    fn sum_lanes(self, lanes: Range<usize>) -> Self;
}
