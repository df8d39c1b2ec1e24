//! Numbers that are the same on every host.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::Scalar;

/// An `f64` whose operations give the same bits on every host. Products are never fused into sums;
/// sines, cosines, arctangents and logarithms are libm's.
///
/// The sine of an `f64` uses fused products if the target has them, so its last bits depend on the
/// host. Numbers that become part of generated text are therefore computed with this type.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Portable(pub f64);

macro_rules! operator {
    ($($trait:ident $function:ident)*) => {$(
        impl $trait for Portable {
            type Output = Self;
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operator!(Add add Sub sub Mul mul Div div);

impl Neg for Portable {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Portable {
    fn from_f64(value: f64) -> Self {
        Self(value)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.0);
        (Self(sin), Self(cos))
    }

    fn atan2(self, x: Self) -> Self {
        Self(libm::atan2(self.0, x.0))
    }

    fn sqrt(self) -> Self {
        Self(libm::sqrt(self.0))
    }

    fn ln(self) -> Self {
        Self(libm::log(self.0))
    }

    fn abs(self) -> Self {
        Self(f64::abs(self.0))
    }

    fn max(self, other: Self) -> Self {
        Self(f64::max(self.0, other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self.0 >= 0.0 { then } else { otherwise }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the bits of sines and cosines with those computed on an x86-64 host without fused
    /// products.
    #[test]
    fn numbers_are_the_same_on_every_host() {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |x: f64| {
            for byte in x.to_bits().to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        for i in 0..10_000 {
            let x = f64::from(i) * 1.234e-3 - 6.0;
            let (sin, cos) = Portable(x).sin_cos();
            // A fused product would be rounded once.
            let product = sin.mul_add(cos, Portable(0.1));
            assert_eq!(product, sin * cos + Portable(0.1));
            add(sin.0);
            add(cos.0);
            add(product.0);
            add(sin.atan2(cos).0);
            add((cos * cos + Portable(1.0)).ln().0);
        }
        assert_eq!(hash, HASH);
    }

    #[test]
    fn zero_selects_as_a_positive_number() {
        for (x, positive) in [(2.0, true), (0.0, true), (-0.0, true), (-3.0, false)] {
            let expected = if positive { 1.0 } else { -5.0 };
            assert_eq!(Portable(x).select_nonnegative(Portable(1.0), Portable(-5.0)).0, expected);
        }
    }

    const HASH: u64 = 1_007_425_247_158_569_783;
}
