//! Computation without rounding on parameters that are rounded.

use core::marker::PhantomData;

use modyn_runtime::Scalar;

use super::{DoubleDouble, Number, operators};

/// A double-double number whose parameters are rounded to `S`: results differ from `S`'s by the rounding of operations
/// alone, not by that of the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Exact<S>(DoubleDouble, PhantomData<S>);

impl<S> Exact<S> {
    fn new(number: DoubleDouble) -> Self {
        Self(number, PhantomData)
    }
}

operators! {
    [S: Number] Exact<S>,
    add: |a: Self, b: Self| Self::new(a.0 + b.0),
    sub: |a: Self, b: Self| Self::new(a.0 - b.0),
    mul: |a: Self, b: Self| Self::new(a.0 * b.0),
    div: |a: Self, b: Self| Self::new(a.0 / b.0),
    neg: |a: Self| Self::new(-a.0)
}

impl<S: Number> Scalar for Exact<S> {
    fn from_f64(value: f64) -> Self {
        Self::new(S::from_f64(value).to_double_double())
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self::new(sin), Self::new(cos))
    }

    fn atan2(self, x: Self) -> Self {
        Self::new(self.0.atan2(x.0))
    }

    fn sqrt(self) -> Self {
        Self::new(self.0.sqrt())
    }

    fn ln(self) -> Self {
        Self::new(self.0.ln())
    }

    fn abs(self) -> Self {
        Self::new(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        Self::new(self.0.max(other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self.0.to_f64() >= 0.0 { then } else { otherwise }
    }
}

impl<S: Number> Number for Exact<S> {
    fn to_f64(self) -> f64 {
        self.0.to_f64()
    }

    fn to_double_double(self) -> DoubleDouble {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Scalar;

    use super::Exact;
    use crate::scalar::{Decimal, Number};

    #[test]
    fn parameters_are_rounded_and_results_are_not() {
        let number = Exact::<Decimal<2>>::from_f64;
        assert_eq!(number(0.126).to_f64(), 0.13);
        let third = number(1.0) / number(3.0);
        assert_eq!(third.to_f64(), 1.0 / 3.0);
        assert_eq!((third * number(3.0) - number(1.0)).to_f64().abs().max(1e-30), 1e-30);
    }
}
