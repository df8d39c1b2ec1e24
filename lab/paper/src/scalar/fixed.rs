//! Fixed-point numbers, as on small processors.

use modyn_runtime::Scalar;

use super::{Number, operators};

/// Q16.16: 16 bits before the binary point and 16 after it, rounded to nearest, saturating.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(i32);

const BITS: u32 = 16;
const HALF: i64 = 1 << (BITS - 1);

impl Fixed {
    fn saturated(x: i64) -> Self {
        Self(i32::try_from(x).unwrap_or(if x < 0 { i32::MIN } else { i32::MAX }))
    }

    fn quotient(self, other: Self) -> Self {
        let (a, b) = (i64::from(self.0) << BITS, i64::from(other.0));
        if b == 0 {
            return Self(if a < 0 { i32::MIN } else { i32::MAX });
        }
        // Half of the divisor, with the sign of the dividend.
        let half = b.abs() / 2 * a.signum();
        Self::saturated((a + half) / b)
    }
}

operators! {
    [] Fixed,
    add: |a: Self, b: Self| Self(a.0.saturating_add(b.0)),
    sub: |a: Self, b: Self| Self(a.0.saturating_sub(b.0)),
    mul: |a: Self, b: Self| Self::saturated((i64::from(a.0) * i64::from(b.0) + HALF) >> BITS),
    div: Self::quotient,
    neg: |a: Self| Self(a.0.saturating_neg())
}

impl Scalar for Fixed {
    #[allow(clippy::cast_possible_truncation)] // Casts of floats saturate.
    fn from_f64(value: f64) -> Self {
        Self((value * f64::from(1 << BITS)).round() as i32)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.to_f64().sin_cos();
        (Self::from_f64(sin), Self::from_f64(cos))
    }

    fn atan2(self, x: Self) -> Self {
        Self::from_f64(self.to_f64().atan2(x.to_f64()))
    }

    fn sqrt(self) -> Self {
        Self::from_f64(self.to_f64().sqrt())
    }

    fn ln(self) -> Self {
        Self::from_f64(self.to_f64().ln())
    }

    fn abs(self) -> Self {
        Self(self.0.saturating_abs())
    }

    fn max(self, other: Self) -> Self {
        Ord::max(self, other)
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self.0 >= 0 { then } else { otherwise }
    }
}

impl Number for Fixed {
    fn to_f64(self) -> f64 {
        f64::from(self.0) / f64::from(1 << BITS)
    }
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Scalar;

    use super::{Fixed, Number};

    #[test]
    fn results_are_the_nearest_and_saturate() {
        let unit = 1.0 / 65536.0;
        for (a, b) in [(1.5, 2.25), (-1.5, 2.25), (0.1, -0.3), (-7.0, -0.7), (100.0, 0.01)] {
            let (x, y) = (Fixed::from_f64(a), Fixed::from_f64(b));
            let (a, b) = (x.to_f64(), y.to_f64());
            assert!(((x * y).to_f64() - a * b).abs() <= 0.5 * unit, "{a} * {b}");
            assert!(((x / y).to_f64() - a / b).abs() <= 0.5 * unit, "{a} / {b}");
            assert_eq!((x + y).to_f64(), a + b);
        }
        let large = Fixed::from_f64(30000.0);
        let (most, least) = (Fixed(i32::MAX), Fixed(i32::MIN));
        assert_eq!([large * large, large + large, large / Fixed::zero()], [most; 3]);
        assert_eq!([-large * large, -large - large, -large / Fixed::zero()], [least; 3]);
    }
}
