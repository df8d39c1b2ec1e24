//! The trait of numbers.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::simd::SimdTask;

/// A real number as the equations need it.
///
/// Implemented for `f64` and `f32`, for lanes of them, for num-dual's numbers with feature `num-dual`, and by the
/// compiler for its expressions, which is how one text of an equation is both interpreted and
/// compiled. There is no comparison: an equation may not branch on a value, only
/// [select](Scalar::select_nonnegative) between two.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The number nearest to `value`.
    #[must_use]
    fn from_f64(value: f64) -> Self;

    /// Zero.
    #[inline]
    #[must_use]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// One.
    #[inline]
    #[must_use]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// 1 / self.
    #[inline]
    #[must_use]
    fn recip(self) -> Self {
        Self::one() / self
    }

    /// self * factor + term; rounded once where the target has an instruction for it, else twice.
    #[inline]
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// Sine and cosine of an angle in rad.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

    /// Sine and cosine of several angles, which may share vector instructions; the same numbers.
    #[inline]
    #[must_use]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
        angles.map(Self::sin_cos)
    }

    /// The angle in rad from the x axis to the point (x, self), in [-pi, pi]: `y.atan2(x)`.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Square root; NaN for negative numbers.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Natural logarithm; NaN for negative numbers.
    #[must_use]
    fn ln(self) -> Self;

    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;

    /// The larger of the two; the other one where one is NaN.
    #[must_use]
    fn max(self, other: Self) -> Self;

    /// `then` where `self >= 0`, `otherwise` elsewhere (and for NaN).
    #[must_use]
    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self;

    /// Does `work` on vectors if there are some for such numbers.
    #[doc(hidden)]
    #[inline]
    fn run_simd<W: SimdTask<Self>>(work: W) -> W::Output {
        work.scalar()
    }
}

/// The distance from 1 to the next larger number.
pub(crate) fn epsilon<S: Scalar>() -> S {
    let third = S::from_f64(4.0) / S::from_f64(3.0) - S::one();
    (third + third + third - S::one()).abs()
}
