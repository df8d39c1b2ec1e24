//! `f64` and `f32` as scalars.

use super::{elementary, native};
use crate::scalar::SimdTask;
use crate::scalar::{Scalar, trig};

macro_rules! implement_scalar {
    ($float:ident: $mul_add:ident, $sqrt:ident, $run_simd:ident, $atan2:ident, $ln:ident) => {
        impl Scalar for $float {
            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn from_f64(value: f64) -> Self {
                value as $float
            }

            #[inline]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                native::$mul_add(self, factor, term)
            }

            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                trig::sin_cos(self)
            }

            #[inline]
            fn sin_cos_all<const N: usize>(angles: [Self; N]) -> [(Self, Self); N] {
                trig::sin_cos_all(angles)
            }

            #[inline]
            fn atan2(self, x: Self) -> Self {
                elementary::$atan2(self, x)
            }

            #[inline]
            fn sqrt(self) -> Self {
                native::$sqrt(self)
            }

            #[inline]
            fn ln(self) -> Self {
                elementary::$ln(self)
            }

            #[inline]
            fn abs(self) -> Self {
                $float::abs(self)
            }

            #[inline]
            fn max(self, other: Self) -> Self {
                $float::max(self, other)
            }

            #[inline]
            fn run_simd<W: SimdTask<Self>>(work: W) -> W::Output {
                native::$run_simd(work)
            }

            #[inline]
            fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
                if self >= 0.0 { then } else { otherwise }
            }

            #[inline]
            fn is_known_nonnegative(self) -> bool {
                self >= 0.0
            }
        }
    };
}

implement_scalar!(f64: mul_add_f64, sqrt_f64, run_simd_f64, atan2_f64, ln_f64);
implement_scalar!(f32: mul_add_f32, sqrt_f32, run_simd_f32, atan2_f32, ln_f32);

#[cfg(test)]
mod tests {
    use super::Scalar;

    /// Checks the operations in any precision.
    fn computes<S: Scalar + PartialEq + core::fmt::Debug>() {
        let number = S::from_f64;
        assert_eq!(Scalar::sqrt(number(6.25)), number(2.5));
        assert_eq!(Scalar::ln(S::one()), S::zero());
        assert_eq!(
            (Scalar::abs(number(-2.0)), Scalar::abs(number(3.0))),
            (number(2.0), number(3.0))
        );
        assert_eq!(Scalar::max(number(-2.0), number(3.0)), number(3.0));
        assert_eq!(Scalar::max(number(f64::NAN), number(3.0)), number(3.0));
        assert_eq!(Scalar::recip(number(4.0)), number(0.25));
        for angle in [0.5, 2.5, -2.5, -0.5, 0.0, core::f64::consts::PI] {
            let y = 3.0 * libm::sin(angle);
            let x = 3.0 * libm::cos(angle);
            let error = Scalar::abs(Scalar::atan2(number(y), number(x)) - number(angle));
            let within = (number(3e-7) - error).select_nonnegative(S::one(), S::zero());
            assert_eq!(within, S::one(), "{angle}");
        }
        let then = number(1.0);
        let otherwise = number(2.0);
        for (x, expected) in
            [(0.0, then), (-0.0, then), (5.0, then), (-1e-9, otherwise), (f64::NAN, otherwise)]
        {
            assert_eq!(number(x).select_nonnegative(then, otherwise), expected, "{x}");
        }
    }

    #[test]
    fn both_precisions_compute() {
        computes::<f64>();
        computes::<f32>();
        assert!((Scalar::ln(core::f64::consts::E) - 1.0).abs() < 1e-15);
        assert!((Scalar::ln(core::f32::consts::E) - 1.0).abs() < 1e-6);
    }
}
