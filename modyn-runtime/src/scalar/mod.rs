//! The numbers that the equations and the generated code run on.

mod float;
mod trig;

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A real number as the equations need it.
///
/// Implemented for `f64` and `f32`, and by the compiler for its expressions, which is how one
/// text of an equation is both interpreted and compiled. There is no comparison: an equation
/// may not branch on a value, only [select](Scalar::select_nonnegative) between two.
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

    /// Sine and cosine of an angle in rad.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

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
}
