//! The paper's "floating-point accuracy 10^-d": every result is rounded to d decimals.

use modyn_runtime::Scalar;

use super::{Number, operators};

/// A number with `D` decimals; halves are rounded away from zero.
///
/// This is fixed-point rounding. Rounding to D significant digits would give errors a hundred times smaller than those
/// in Table 4.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Decimal<const D: usize>(f64);

impl<const D: usize> Decimal<D> {
    const UNITS: f64 = {
        let (mut units, mut d) = (1.0, 0);
        while d < D {
            units *= 10.0;
            d += 1;
        }
        units
    };

    fn round(x: f64) -> Self {
        Self((x * Self::UNITS).round() / Self::UNITS)
    }
}

operators! {
    [const D: usize] Decimal<D>,
    add: |a: Self, b: Self| Self::round(a.0 + b.0),
    sub: |a: Self, b: Self| Self::round(a.0 - b.0),
    mul: |a: Self, b: Self| Self::round(a.0 * b.0),
    div: |a: Self, b: Self| Self::round(a.0 / b.0),
    neg: |a: Self| Self(-a.0)
}

impl<const D: usize> Scalar for Decimal<D> {
    fn from_f64(value: f64) -> Self {
        Self::round(value)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self::round(sin), Self::round(cos))
    }

    fn atan2(self, x: Self) -> Self {
        Self::round(self.0.atan2(x.0))
    }

    fn sqrt(self) -> Self {
        Self::round(self.0.sqrt())
    }

    fn ln(self) -> Self {
        Self::round(self.0.ln())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self.0 >= 0.0 { then } else { otherwise }
    }
}

impl<const D: usize> Number for Decimal<D> {
    fn to_f64(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Scalar;

    use super::Decimal;

    #[test]
    fn every_result_is_rounded() {
        let number = Decimal::<4>::from_f64;
        assert_eq!(number(0.123_45).0, 0.1235);
        assert_eq!(number(-0.123_45).0, -0.1235);
        assert_eq!((number(1.0) / number(3.0)).0, 0.3333);
        assert_eq!((number(0.01) * number(0.01)).0, 0.0001);
        assert_eq!((number(0.001) * number(0.01)).0, 0.0);
        assert_eq!(number(3.0).sqrt().0, 1.7321);
    }
}
