//! Numbers with other rounding than the processor's: the equations run on them unchanged.

mod decimal;
mod double_double;
mod exact;
mod fixed;

pub use {decimal::Decimal, double_double::DoubleDouble, exact::Exact, fixed::Fixed};

use modyn_runtime::Scalar;

/// A number that can be compared with others.
pub trait Number: Scalar {
    /// Returns the nearest double.
    fn to_f64(self) -> f64;

    /// Returns the same number with all its digits.
    fn to_double_double(self) -> DoubleDouble {
        DoubleDouble::from_f64(self.to_f64())
    }
}

impl Number for f64 {
    fn to_f64(self) -> f64 {
        self
    }
}

impl Number for f32 {
    fn to_f64(self) -> f64 {
        self.into()
    }
}

/// Defines the operators of a type by functions of two numbers.
macro_rules! operators {
    ([$($generics:tt)*] $type:ty, add: $add:expr, sub: $sub:expr, mul: $mul:expr, div: $div:expr, neg: $neg:expr) => {
        operators!(@ [$($generics)*] $type, Add, add, $add);
        operators!(@ [$($generics)*] $type, Sub, sub, $sub);
        operators!(@ [$($generics)*] $type, Mul, mul, $mul);
        operators!(@ [$($generics)*] $type, Div, div, $div);
        impl<$($generics)*> core::ops::Neg for $type {
            type Output = Self;
            fn neg(self) -> Self {
                ($neg)(self)
            }
        }
    };
    (@ [$($generics:tt)*] $type:ty, $trait:ident, $name:ident, $function:expr) => {
        impl<$($generics)*> core::ops::$trait for $type {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                ($function)(self, other)
            }
        }
    };
}
use operators;
