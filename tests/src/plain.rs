//! Numbers without vector instructions: generated code computes equal limbs one after the other, and rounds each
//! product.

use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn_runtime::Scalar;

/// A number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plain<T>(pub T);

/// Returns plain numbers as this type.
#[must_use]
pub fn plain<T: Copy, const N: usize>(numbers: &[T; N]) -> [Plain<T>; N] {
    numbers.map(Plain)
}

/// Returns numbers of this type as plain numbers.
#[must_use]
pub fn number<T: Copy, const N: usize>(numbers: [Plain<T>; N]) -> [T; N] {
    numbers.map(|plain| plain.0)
}

macro_rules! operator {
    ($($trait:ident $function:ident)*) => {$(
        impl<T: Scalar> $trait for Plain<T> {
            type Output = Self;
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operator!(Add add Sub sub Mul mul Div div);

impl<T: Scalar> Neg for Plain<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<T: Scalar> Scalar for Plain<T> {
    fn from_f64(value: f64) -> Self {
        Self(T::from_f64(value))
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self(sin), Self(cos))
    }

    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
        T::sin_cos_all(number(angles)).map(|(sin, cos)| (Self(sin), Self(cos)))
    }

    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }

    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self(self.0.select_nonnegative(then.0, otherwise.0))
    }
}
