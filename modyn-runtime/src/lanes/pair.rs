//! Two vectors as one vector with twice the lanes.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::Scalar;
use crate::scalar::Pack;

/// The first and the second half of the lanes.
#[derive(Clone, Copy)]
pub struct Pair<V>(V, V);

macro_rules! operator {
    ($($trait:ident $function:ident)*) => {$(
        impl<V: Scalar> $trait for Pair<V> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0), self.1.$function(other.1))
            }
        }
    )*};
}

operator!(Add add Sub sub Mul mul Div div);

impl<V: Scalar> Neg for Pair<V> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<V: Scalar> Scalar for Pair<V> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self(V::from_f64(value), V::from_f64(value))
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self(self.0.recip(), self.1.recip())
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0), self.1.mul_add(factor.1, term.1))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let [(s, c), (t, d)] = V::sin_cos_all([self.0, self.1]);
        (Self(s, t), Self(c, d))
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0), self.1.atan2(x.1))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Self(self.0.ln(), self.1.ln())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }

    #[inline(always)]
    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self(
            self.0.select_nonnegative(then.0, otherwise.0),
            self.1.select_nonnegative(then.1, otherwise.1),
        )
    }
}

macro_rules! pack {
    ($($half:literal $whole:literal: [$($first:literal)*] [$($second:literal)*]),*) => {$(
        impl<One: Scalar, V: Pack<One, $half>> Pack<One, $whole> for Pair<V> {
            #[inline(always)]
            fn broadcast(number: One) -> Self {
                Self(V::broadcast(number), V::broadcast(number))
            }

            #[inline(always)]
            fn pack(numbers: [One; $whole]) -> Self {
                Self(V::pack([$(numbers[$first]),*]), V::pack([$(numbers[$second]),*]))
            }

            #[inline(always)]
            fn constants(numbers: [f64; $whole]) -> Self {
                Self(V::constants([$(numbers[$first]),*]), V::constants([$(numbers[$second]),*]))
            }

            #[inline(always)]
            fn unpack(self) -> [One; $whole] {
                let halves = [self.0.unpack(), self.1.unpack()];
                [$(halves[0][$first]),*, $(halves[1][$second - $half]),*]
            }
        }
    )*};
}

pack!(2 4: [0 1] [2 3], 4 8: [0 1 2 3] [4 5 6 7]);
