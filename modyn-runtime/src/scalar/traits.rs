//! The traits of numbers: [`Scalar`], and packs of several values of one state, such as the angles
//! of equal limbs.
//!
//! The compiler prints a function once over [`SimdBackend`]. Scalars with vector instructions run
//! it on these ([`Scalar::run_simd`]); other scalars compute the limbs one after the other. A
//! scalar runs tasks on packs, and packs are scalars: the traits define each other, so they are one
//! file.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, with the operations that the equations need.
///
/// It is implemented for `f64` and `f32`, for vectors of them, and, with feature `num-dual`, for
/// the numbers of num-dual. The compiler implements it for its expressions, so that one text of an
/// equation is both interpreted and compiled. There is no comparison: an equation must not branch
/// on a value, only [select](Scalar::select_nonnegative) between two.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Returns the number closest to `value`.
    #[must_use]
    fn from_f64(value: f64) -> Self;

    /// Returns zero.
    #[inline]
    #[must_use]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// Returns one.
    #[inline]
    #[must_use]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// Returns 1 / self.
    #[inline]
    #[must_use]
    fn recip(self) -> Self {
        Self::one() / self
    }

    /// Returns self * factor + term: rounded once if the target has an instruction for it, else
    /// twice.
    #[inline]
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// Returns sine and cosine of an angle in rad.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

    /// Returns sine and cosine of several angles. They may share vector instructions; the values
    /// equal the results of [`sin_cos`](Self::sin_cos).
    #[inline]
    #[must_use]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
        angles.map(Self::sin_cos)
    }

    /// Returns the angle in rad from the x axis to the point (x, self), in [-pi, pi]: `y.atan2(x)`.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Returns the square root; NaN for negative numbers.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Returns the natural logarithm; NaN for negative numbers.
    #[must_use]
    fn ln(self) -> Self;

    /// Returns the absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// Returns the larger of the two numbers; if one is NaN, the other.
    #[must_use]
    fn max(self, other: Self) -> Self;

    /// Returns `then` if `self >= 0`, else `otherwise` (also if `self` is NaN).
    #[must_use]
    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self;

    /// Returns whether the number is the constant zero of an expression: then it is zero for all
    /// inputs. Numbers are not expressions, and not even their zeros are constants.
    #[doc(hidden)]
    #[inline]
    fn is_constant_zero(self) -> bool {
        false
    }

    /// Returns true only if the number, or each number in lanes, is known not to be negative: then
    /// a loop leaves out work that has no effect. Nothing is known of expressions.
    #[doc(hidden)]
    #[inline]
    fn is_known_nonnegative(self) -> bool {
        false
    }

    /// Does `work` on vectors if the scalar has vector types.
    #[doc(hidden)]
    #[inline]
    fn run_simd<W: SimdTask<Self>>(work: W) -> W::Output {
        work.scalar()
    }
}

/// Returns the distance from 1 to the next larger number.
pub(crate) fn epsilon<S: Scalar>() -> S {
    let third = S::from_f64(4.0) / S::from_f64(3.0) - S::one();
    (third + third + third - S::one()).abs()
}

/// Returns the number where it is positive, else zero; NaN for NaN.
#[inline(always)]
pub(crate) fn positive<S: Scalar>(x: S) -> S {
    (-x).select_nonnegative(S::zero(), x)
}

/// Returns the larger of two numbers; NaN if the first is.
#[inline(always)]
pub(crate) fn at_least<S: Scalar>(x: S, least: S) -> S {
    (least - x).select_nonnegative(least, x)
}

/// Returns the smaller of two numbers; NaN if the first is.
#[inline(always)]
pub(crate) fn at_most<S: Scalar>(x: S, most: S) -> S {
    (x - most).select_nonnegative(most, x)
}

/// The types of an instruction set: a single value, and packs of two, four and eight.
pub trait SimdBackend: 'static {
    /// The scalar that is packed.
    type Number: Copy;
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

    /// Runs part of the work in a function of its own, compiled for the same instructions. rustc
    /// takes more than linear time for long functions.
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

/// Work on packed values, such as the values of equal limbs, or on scalars. `vectorized` and
/// everything that it calls must be `#[inline(always)]`.
pub trait SimdTask<F> {
    /// The type of the result.
    type Output;

    /// Whether some values are packed. Otherwise all are single, and vector types are used for
    /// their fused multiply-add only.
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
