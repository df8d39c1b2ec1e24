//! A number with its derivative in one direction. The interpreter differentiates equations with it.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::Scalar;

/// A number and its derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangent<S> {
    /// The number.
    pub(crate) x: S,
    /// The derivative of the number.
    pub(crate) dx: S,
}

impl<S: Scalar> Tangent<S> {
    /// Returns a number whose derivative is zero.
    pub(crate) fn constant(x: S) -> Self {
        Self { x, dx: S::zero() }
    }

    /// Returns the function of this number with value `x` and derivative `slope`.
    fn chain(self, x: S, slope: S) -> Self {
        Self { x, dx: self.dx * slope }
    }
}

impl<S: Scalar> Add for Tangent<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, dx: self.dx + other.dx }
    }
}

impl<S: Scalar> Sub for Tangent<S> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, dx: self.dx - other.dx }
    }
}

impl<S: Scalar> Mul for Tangent<S> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, dx: self.dx * other.x + self.x * other.dx }
    }
}

impl<S: Scalar> Div for Tangent<S> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let x = self.x / other.x;
        Self { x, dx: (self.dx - x * other.dx) / other.x }
    }
}

impl<S: Scalar> Neg for Tangent<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { x: -self.x, dx: -self.dx }
    }
}

impl<S: Scalar> Scalar for Tangent<S> {
    fn from_f64(value: f64) -> Self {
        Self::constant(S::from_f64(value))
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.x.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn atan2(self, x: Self) -> Self {
        let square = self.x * self.x + x.x * x.x;
        let dx = (x.x * self.dx - self.x * x.dx) / square;
        Self { x: self.x.atan2(x.x), dx }
    }

    fn sqrt(self) -> Self {
        let x = self.x.sqrt();
        self.chain(x, S::from_f64(0.5) / x)
    }

    fn ln(self) -> Self {
        self.chain(self.x.ln(), self.x.recip())
    }

    fn abs(self) -> Self {
        self.select_nonnegative(self, -self)
    }

    fn max(self, other: Self) -> Self {
        let chosen = (self - other).select_nonnegative(self, other);
        Self { x: self.x.max(other.x), dx: chosen.dx }
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self {
            x: self.x.select_nonnegative(then.x, otherwise.x),
            dx: self.x.select_nonnegative(then.dx, otherwise.dx),
        }
    }
}
