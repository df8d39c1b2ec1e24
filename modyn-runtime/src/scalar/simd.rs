//! Several values of one state in a pack, such as the angles of equal limbs.
//!
//! The compiler prints a function once over [`SimdBackend`]. Scalars with vector instructions run it on these
//! ([`Scalar::run_simd`]); other scalars compute the limbs one after the other.

use super::Scalar;

/// The types of an instruction set: a single value, and packs of two, four and eight.
pub trait SimdBackend: 'static {
    /// The scalar that is packed.
    type Number;
    /// A single value.
    type One: Scalar;
    /// A pack of two.
    type Two: Pack<Self::One, 2>;
    /// A pack of four.
    type Four: Pack<Self::One, 4>;
    /// A pack of eight.
    type Eight: Pack<Self::One, 8>;

    /// Returns a scalar as a single value.
    fn one(number: Self::Number) -> Self::One;

    /// Returns a single value as a scalar.
    fn number(one: Self::One) -> Self::Number;

    /// Runs part of the work in a function of its own, compiled for the same instructions. rustc takes more than
    /// linear time for long functions.
    fn outlined<P: Chunk>(part: P) -> P::Output;
}

/// A pack of values.
pub trait Pack<One, const LANES: usize>: Scalar {
    /// Returns the pack with `number` in all lanes.
    #[must_use]
    fn broadcast(number: One) -> Self;

    /// Returns the pack of these values.
    #[must_use]
    fn pack(numbers: [One; LANES]) -> Self;

    /// Returns the pack of these constants.
    #[must_use]
    fn constants(numbers: [f64; LANES]) -> Self;

    /// Returns the lanes.
    #[must_use]
    fn unpack(self) -> [One; LANES];
}

/// Work on packed values, such as those of equal limbs, or on scalars. `vectorized` and everything that it calls must be
/// `#[inline(always)]`.
pub trait SimdTask<F> {
    /// The type of the result.
    type Output;

    /// Whether some values are packed. Otherwise all are single, and vector types are used for their fused
    /// multiply-add only.
    const HAS_PACKS: bool;

    /// Does the work on vectors.
    fn vectorized<V: SimdBackend<Number = F>>(self) -> Self::Output;

    /// Does the work on scalars.
    fn scalar(self) -> Self::Output;
}

/// Part of the work on vectors. `run` and everything that it calls must be `#[inline(always)]`.
pub trait Chunk {
    /// The type of the result.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}
