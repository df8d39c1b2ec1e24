//! Double-double numbers: about 31 digits, for reference solutions.
//!
//! Sums and products by error-free transformations (Dekker 1971; Knuth, TAOCP 2, 4.2.2; Joldes,
//! Muller and Popescu 2017). The crate `twofloat` 0.8.4 was tried and is not used: its sine keeps 21
//! digits, its root or quotient 16.

use modyn_runtime::Scalar;

use super::{Number, operators};

/// The unevaluated sum of two doubles, the second below half a unit of the first's last place.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

const HALF_PI: DoubleDouble =
    DoubleDouble { high: std::f64::consts::FRAC_PI_2, low: 6.123_233_995_736_766e-17 };

impl DoubleDouble {
    /// Returns the sum of two numbers, of which the first is the larger.
    fn joined(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }

    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self { high: sum, low: (a - (sum - part)) + (b - part) }
    }

    fn plus(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.high, other.high), Self::sum(self.low, other.low));
        let sum = Self::joined(high.high, high.low + low.high);
        Self::joined(sum.high, sum.low + low.low)
    }

    fn times(self, other: Self) -> Self {
        let product = self.high * other.high;
        let rest = self.high.mul_add(other.high, -product);
        Self::joined(product, rest + (self.high * other.low + self.low * other.high))
    }

    fn over(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other.times(Self::from_f64(first));
        let second = rest.high / other.high;
        let rest = rest - other.times(Self::from_f64(second));
        Self::joined(first, second).plus(Self::from_f64(rest.high / other.high))
    }

    /// Returns the sum of x^k / k! over k = `first`, `first` + `step`, ..., with alternating signs or not.
    fn series(self, first: u32, step: u32, alternating: bool) -> Self {
        let (mut term, mut sum) = (Self::one(), Self::zero());
        for k in 0..40 {
            if k % step == first {
                let negative = alternating && (k / step) % 2 == 1;
                sum = if negative { sum - term } else { sum + term };
            }
            term = term * self / Self::from_f64(f64::from(k + 1));
        }
        sum
    }

    fn exp(self) -> Self {
        // The argument is halved until the series is short, and the result is squared as many times.
        let mut power = (self * Self::from_f64(1.0 / 1024.0)).series(0, 1, false);
        for _ in 0..10 {
            power = power * power;
        }
        power
    }
}

operators! {
    [] DoubleDouble,
    add: Self::plus,
    sub: |a: Self, b: Self| a.plus(-b),
    mul: Self::times,
    div: Self::over,
    neg: |a: Self| Self { high: -a.high, low: -a.low }
}

impl Scalar for DoubleDouble {
    fn from_f64(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    fn sin_cos(self) -> (Self, Self) {
        let quarters = (self.high / HALF_PI.high).round();
        let rest = self - HALF_PI * Self::from_f64(quarters);
        let (sin, cos) = (rest.series(1, 2, true), rest.series(0, 2, true));
        match quarters.rem_euclid(4.0) {
            0.0 => (sin, cos),
            1.0 => (cos, -sin),
            2.0 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    fn atan2(self, x: Self) -> Self {
        // Newton's step from the double: the angle between the two directions is small.
        let near = Self::from_f64(self.high.atan2(x.high));
        let (sin, cos) = near.sin_cos();
        let radius = (self * self + x * x).sqrt();
        if radius.high == 0.0 { near } else { near + (self * cos - x * sin) / radius }
    }

    fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::from_f64(self.high.sqrt());
        }
        let near = Self::from_f64(self.high.sqrt());
        near + (self - near * near) / (near + near)
    }

    fn ln(self) -> Self {
        let near = Self::from_f64(self.high.ln());
        if near.high.is_finite() { near + self * (-near).exp() - Self::one() } else { near }
    }

    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    fn max(self, other: Self) -> Self {
        if self >= other || other.high.is_nan() { self } else { other }
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        if self.high >= 0.0 { then } else { otherwise }
    }
}

impl Number for DoubleDouble {
    fn to_f64(self) -> f64 {
        self.high
    }

    fn to_double_double(self) -> Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Scalar;

    use super::DoubleDouble;

    fn number(x: f64) -> DoubleDouble {
        DoubleDouble::from_f64(x)
    }

    fn assert_zero(what: &str, x: DoubleDouble, scale: f64) {
        assert!(x.high.abs() <= 1e-29 * scale, "{what}: {:e}", x.high);
    }

    #[test]
    fn thirty_digits_are_kept() {
        for k in -200..200 {
            let x = number(0.37 * f64::from(k) + 0.1) / number(7.0);
            assert_zero("x / 7 * 7", x * number(7.0) - number(0.37 * f64::from(k) + 0.1), 100.0);
            let (sin, cos) = x.sin_cos();
            assert_zero("sin^2 + cos^2", sin * sin + cos * cos - number(1.0), 1.0);
            let (double, _) = (x + x).sin_cos();
            assert_zero("sin 2x", double - (sin * cos + sin * cos), 10.0);
            let root = x.abs().sqrt();
            assert_zero("root", root * root - x.abs(), 100.0);
            let (sin, cos) = sin.atan2(cos).sin_cos();
            assert_zero("atan2", sin - x.sin_cos().0, 1.0);
            assert_zero("atan2", cos - x.sin_cos().1, 1.0);
            let log = x.abs().ln();
            assert_zero("ln", (x * x).ln() - (log + log), 100.0);
        }
    }
}
