//! `f64` and `f32` as scalars.

use super::{Scalar, trig};

impl Scalar for f64 {
    #[inline]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        trig::sin_cos_f64(self)
    }

    #[inline]
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    #[inline]
    fn ln(self) -> Self {
        libm::log(self)
    }

    #[inline]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        f64::max(self, other)
    }

    #[inline]
    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self >= 0.0 { then } else { otherwise }
    }
}

impl Scalar for f32 {
    #[inline]
    #[allow(clippy::cast_possible_truncation)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        trig::sin_cos_f32(self)
    }

    #[inline]
    fn sqrt(self) -> Self {
        libm::sqrtf(self)
    }

    #[inline]
    fn ln(self) -> Self {
        libm::logf(self)
    }

    #[inline]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        f32::max(self, other)
    }

    #[inline]
    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self >= 0.0 { then } else { otherwise }
    }
}
