//! Numbers without vector instructions: equal limbs are computed one after the other.

use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn::Scalar;

/// A number.
#[derive(Clone, Copy)]
pub struct ScalarOnly(pub f64);

macro_rules! operator {
    ($($trait:ident $function:ident)*) => {$(
        impl $trait for ScalarOnly {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operator!(Add add Sub sub Mul mul Div div);

impl Neg for ScalarOnly {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for ScalarOnly {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self(value)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(Scalar::mul_add(self.0, factor.0, term.0))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.0);
        (Self(sin), Self(cos))
    }

    #[inline(always)]
    fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
        f64::sin_cos_all(angles.map(|angle| angle.0)).map(|(sin, cos)| (Self(sin), Self(cos)))
    }

    fn atan2(self, x: Self) -> Self {
        Self(Scalar::atan2(self.0, x.0))
    }

    fn sqrt(self) -> Self {
        Self(Scalar::sqrt(self.0))
    }

    fn ln(self) -> Self {
        Self(Scalar::ln(self.0))
    }

    fn abs(self) -> Self {
        Self(Scalar::abs(self.0))
    }

    fn max(self, other: Self) -> Self {
        Self(Scalar::max(self.0, other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self(self.0.select_nonnegative(then.0, otherwise.0))
    }
}
