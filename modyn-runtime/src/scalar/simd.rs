//! Several numbers of one state side by side, such as the angles of equal limbs.
//!
//! The compiler writes a function once over [`SimdBackend`]; a number that has vector instructions runs it
//! on those ([`Scalar::run_simd`]), any other one computes the limbs one after the other.

use super::Scalar;

/// A set of vector instructions: numbers alone, and two, four and eight abreast.
pub trait SimdBackend: 'static {
    /// What they are vectors of.
    type Number;
    /// A number, to compute with.
    type One: Scalar;
    /// Two abreast.
    type Two: Pack<Self::One, 2>;
    /// Four abreast.
    type Four: Pack<Self::One, 4>;
    /// Eight abreast.
    type Eight: Pack<Self::One, 8>;

    /// A number as one.
    fn one(number: Self::Number) -> Self::One;

    /// And back.
    fn number(one: Self::One) -> Self::Number;

    /// Does part of the work in a function of its own, compiled for the same instructions: what is too
    /// long for one takes the compiler more than linear time.
    fn outlined<P: Chunk>(part: P) -> P::Output;
}

/// Numbers side by side.
pub trait Pack<One, const LANES: usize>: Scalar {
    /// The same number in all lanes.
    #[must_use]
    fn broadcast(number: One) -> Self;

    /// These.
    #[must_use]
    fn pack(numbers: [One; LANES]) -> Self;

    /// These constants.
    #[must_use]
    fn constants(numbers: [f64; LANES]) -> Self;

    /// Each of them.
    #[must_use]
    fn unpack(self) -> [One; LANES];
}

/// What can be done with numbers abreast, such as those of equal limbs, or one after the other. `vectorized` must be
/// `#[inline(always)]`, and all that it calls.
pub trait SimdTask<F> {
    /// What it comes to.
    type Output;

    /// Whether some numbers stand side by side; else all are alone, and vectors just have them fuse
    /// products into sums.
    const HAS_PACKS: bool;

    /// Does it on vectors.
    fn vectorized<V: SimdBackend<Number = F>>(self) -> Self::Output;

    /// Does it number by number.
    fn scalar(self) -> Self::Output;
}

/// A part of the work on vectors. Its `run` must be `#[inline(always)]`, and all that it calls.
pub trait Chunk {
    /// What it comes to.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}
