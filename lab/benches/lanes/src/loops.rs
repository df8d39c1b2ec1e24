//! Several numbers as an array with plain loops, which the compiler may or may not vectorize.

use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn::Scalar;

/// An array of lanes.
#[derive(Clone, Copy)]
pub struct Loop<const N: usize>(pub [f64; N]);

impl<const N: usize> Loop<N> {
    #[inline(always)]
    fn each(mut self, f: impl Fn(f64) -> f64) -> Self {
        for x in &mut self.0 {
            *x = f(*x);
        }
        self
    }

    #[inline(always)]
    fn both(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for i in 0..N {
            self.0[i] = f(self.0[i], other.0[i]);
        }
        self
    }
}

macro_rules! operator {
    ($($trait:ident $function:ident)*) => {$(
        impl<const N: usize> $trait for Loop<N> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                self.both(other, $trait::$function)
            }
        }
    )*};
}

operator!(Add add Sub sub Mul mul Div div);

impl<const N: usize> Neg for Loop<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(Neg::neg)
    }
}

impl<const N: usize> Scalar for Loop<N> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self([value; N])
    }

    #[inline(always)]
    fn mul_add(mut self, factor: Self, term: Self) -> Self {
        for i in 0..N {
            self.0[i] = Scalar::mul_add(self.0[i], factor.0[i], term.0[i]);
        }
        self
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        // The runtime's own polynomials, without a branch for each number.
        let both = f64::sin_cos_all(self.0);
        (Self(both.map(|(sin, _)| sin)), Self(both.map(|(_, cos)| cos)))
    }

    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        self.both(x, Scalar::atan2)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(Scalar::sqrt)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.each(Scalar::ln)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.each(Scalar::abs)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.both(other, Scalar::max)
    }

    #[inline(always)]
    fn select_nonnegative(mut self, then: Self, otherwise: Self) -> Self {
        for i in 0..N {
            self.0[i] = if self.0[i] >= 0.0 { then.0[i] } else { otherwise.0[i] };
        }
        self
    }
}
