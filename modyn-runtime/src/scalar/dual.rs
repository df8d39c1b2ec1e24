//! The numbers of num-dual as scalars: results have exact derivatives.
//!
//! Comparisons use the real part.

use num_dual::{DualNum, DualStruct};

use super::Scalar;

macro_rules! scalar {
    ($type:ident $(, $size:ident)?) => {
        impl<T: DualNum + Scalar $(, const $size: usize)?> Scalar for num_dual::$type<T $(, $size)?> {
            #[inline]
            fn from_f64(value: f64) -> Self {
                DualNum::from_re(<T as Scalar>::from_f64(value))
            }

            #[inline]
            fn recip(self) -> Self {
                DualNum::recip(&self)
            }

            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                DualNum::sin_cos(&self)
            }

            #[inline]
            fn atan2(self, x: Self) -> Self {
                // num-dual's atan2 divides by x. Dividing the smaller by the larger argument is
                // finite everywhere.
                let steep = Scalar::abs(self).re() > Scalar::abs(x).re();
                let mut angle =
                    if steep { -DualNum::atan(&(x / self)) } else { DualNum::atan(&(self / x)) };
                angle.re = Scalar::atan2(self.re, x.re);
                angle
            }

            #[inline]
            fn sqrt(self) -> Self {
                DualNum::sqrt(&self)
            }

            #[inline]
            fn ln(self) -> Self {
                DualNum::ln(&self)
            }

            #[inline]
            fn abs(self) -> Self {
                self.select_nonnegative(self, -self)
            }

            #[inline]
            fn max(self, other: Self) -> Self {
                let [a, b] = [self.re(), other.re()];
                // A number that does not compare with itself is NaN.
                if a >= b || b.partial_cmp(&b).is_none() { self } else { other }
            }

            #[inline]
            fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
                if self.re() >= Self::zero().re() { then } else { otherwise }
            }
        }
    };
}

scalar!(Dual);
scalar!(DualSVec, N);
scalar!(Dual2);
scalar!(Dual2SVec, N);
scalar!(Dual3);
scalar!(HyperDual);
scalar!(HyperHyperDual);

#[cfg(test)]
mod tests {
    use num_dual::{
        Dual2_64, Dual3_64, Dual32, Dual64, DualSVec64, DualStruct, HyperDual64, HyperHyperDual64,
    };

    use super::Scalar;

    /// Returns every operation, as a function of one number.
    fn functions<S: Scalar>(t: S) -> [S; 12] {
        let number = S::from_f64;
        let (sin, cos) = t.sin_cos();
        let around = |turn: f64| {
            let (sin, cos) = (t + number(turn)).sin_cos();
            (number(2.0) * sin).atan2(number(0.7) * cos)
        };
        [
            t.recip(),
            sin,
            cos,
            (number(3.0) + t * t).sqrt(),
            (number(3.0) + t * t).ln(),
            (t * t - number(2.0)).abs(),
            sin.max(cos),
            (t - number(1.0)).select_nonnegative(sin * cos, t / cos),
            around(0.0),
            around(1.5),
            around(3.5),
            around(4.7),
        ]
    }

    fn close(number: f64, expected: f64, within: f64, what: &str) {
        assert!(
            (number - expected).abs() <= within * expected.abs().max(1.0),
            "{what}: {number} {expected}"
        );
    }

    /// Compares the first three derivatives of every function with differences of the previous
    /// derivative, and the types for several variables with those for one.
    #[test]
    fn derivatives_are_those_of_the_functions() {
        for t in [-2.9, -1.3, -0.4, 0.3, 0.8, 1.2, 2.6] {
            let third = functions(Dual3_64::from_re(t).derivative());
            let second = functions(Dual2_64::from_re(t).derivative());
            let first = functions(Dual64::from_re(t).derivative());
            let single = functions(Dual32::from_re(t as f32).derivative());
            let mixed = functions(HyperDual64::from_re(t).derivative1().derivative2());
            let thrice =
                functions(HyperHyperDual64::from_re(t).derivative1().derivative2().derivative3());
            let vector = functions(DualSVec64::<2>::from_re(t).derivative(1));
            let h = 1e-5;
            let [above, below] =
                [t + h, t - h].map(|t| functions(Dual2_64::from_re(t).derivative()));
            for (i, value) in functions(t).into_iter().enumerate() {
                let what = |order: &str| std::format!("{order} derivative of function {i} at {t}");
                let slope =
                    |part: fn(&Dual2_64) -> f64| (part(&above[i]) - part(&below[i])) / (2.0 * h);
                close(third[i].re, value, 1e-15, "the value");
                close(third[i].v1, slope(|x| x.re), 1e-8, &what("first"));
                close(third[i].v2, slope(|x| x.v1), 1e-8, &what("second"));
                close(third[i].v3, slope(|x| x.v2), 1e-7, &what("third"));
                for re in [second[i].re, first[i].re, mixed[i].re, thrice[i].re, vector[i].re] {
                    close(re, value, 1e-15, "the value");
                }
                for v1 in [second[i].v1, first[i].eps, mixed[i].eps1, mixed[i].eps2, thrice[i].eps3]
                {
                    close(v1, third[i].v1, 1e-14, &what("first"));
                }
                let gradient: [f64; 2] = vector[i].eps.0.map_or([0.0; 2], Into::into);
                assert_eq!(gradient[0], 0.0);
                close(gradient[1], third[i].v1, 1e-14, &what("first"));
                for v2 in [second[i].v2, mixed[i].eps1eps2, thrice[i].eps1eps3] {
                    close(v2, third[i].v2, 1e-13, &what("second"));
                }
                close(thrice[i].eps1eps2eps3, third[i].v3, 1e-12, &what("third"));
                close(single[i].eps.into(), third[i].v1, 1e-4, &what("first"));
            }
        }
    }

    /// d atan2(y, x) = (x dy - y dx) / (x^2 + y^2) everywhere, on the axes, too.
    #[test]
    fn atan2_has_its_derivative_all_around() {
        let points = [-2.0, -1.0, -0.3, 0.0, 0.3, 1.0, 2.0];
        for (y, x) in points.iter().flat_map(|y| points.map(|x| (*y, x))) {
            if (y, x) == (0.0, 0.0) {
                continue;
            }
            let dy = 0.7;
            let dx = -1.1;
            let derivative = Scalar::atan2(Dual64::new(y, dy), Dual64::new(x, dx));
            assert_eq!(derivative.re, Scalar::atan2(y, x));
            close(derivative.eps, (x * dy - y * dx) / (x * x + y * y), 1e-15, "the slope");
        }
    }

    #[test]
    fn comparisons_go_by_the_real_part() {
        let number = |re| Dual64::new(re, 3.0);
        assert_eq!((number(-2.0).abs().eps, number(2.0).abs().eps), (-3.0, 3.0));
        assert_eq!((number(-2.0).abs().re(), number(2.0).abs().re()), (2.0, 2.0));
        let other = Dual64::new(1.0, 9.0);
        for (re, expected) in [(2.0, 3.0), (0.5, 9.0), (f64::NAN, 9.0)] {
            assert_eq!(Scalar::max(number(re), other).eps, expected);
            assert_eq!(Scalar::max(other, number(re)).eps, expected);
        }
        let then = number(1.0);
        let otherwise = number(2.0);
        for (re, expected) in [(0.0, 1.0), (-0.0, 1.0), (4.0, 1.0), (-1e-9, 2.0), (f64::NAN, 2.0)] {
            assert_eq!(number(re).select_nonnegative(then, otherwise).re, expected);
        }
    }
}
