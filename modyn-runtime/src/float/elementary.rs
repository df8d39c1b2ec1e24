//! Logarithm and arctangent on `core` alone, each precision in its own arithmetic: series on a
//! short interval.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_precision_loss)]
#![allow(clippy::cast_sign_loss, clippy::excessive_precision)]

/// The constants of logarithm and arctangent in one precision. The runtime, generated C and WGSL
/// use the same constants.
///
/// A coefficient is a numerator and a denominator, since their quotient depends on the precision.
#[derive(Clone, Copy, Debug)]
pub struct ElementaryNumbers<const L: usize, const A: usize> {
    /// The coefficients of (2 artanh s - 2 s) / s^3 in powers of s^2; the lowest comes first.
    pub logarithm: [(f64, f64); L],
    /// The coefficients of (atan t - t) / t^3 in powers of t^2; the lowest comes first.
    pub arctangent: [(f64, f64); A],
    /// The logarithm of 2 as a sum of two parts. Products of the first part with an exponent are
    /// exact.
    pub ln_2: (f64, f64),
    /// The power of two that scales subnormal numbers.
    pub two_up: f64,
    /// The smallest number that is not subnormal.
    pub min_positive: f64,
    /// The bits of the square root of 1/2.
    pub root_half_bits: u64,
    /// The square root of 3.
    pub root_3: f64,
    /// The tangent of 15 degrees.
    pub tan_15: f64,
    /// The number of this precision that is nearest to pi, and the difference of pi from it.
    pub pi: (f64, f64),
    /// The number of this precision that is nearest to pi / 2, and the difference of pi / 2 from
    /// it.
    pub half_pi: (f64, f64),
    /// The number of this precision that is nearest to pi / 6, and the difference of pi / 6 from
    /// it.
    pub sixth_pi: (f64, f64),
}

macro_rules! elementary {
    (
        $ln:ident, $atan2:ident, $float:ident, $bits:ty, $(#[$docs:meta])* $numbers:ident,
        terms: $ln_terms:literal $atan_terms:literal,
        ln_2: $ln_2:literal + $ln_2_rest:literal, two_up: $two_up:literal,
        rests of pi: $pi:literal $half:literal $sixth:literal
    ) => {
        $(#[$docs])*
        pub const $numbers: ElementaryNumbers<$ln_terms, $atan_terms> = ElementaryNumbers {
            logarithm: {
                let mut series = [(2.0, 3.0); $ln_terms];
                let mut i = 1;
                while i < $ln_terms {
                    series[i].1 = (2 * i + 3) as f64;
                    i += 1;
                }
                series
            },
            arctangent: {
                let mut series = [(-1.0, 3.0); $atan_terms];
                let mut i = 1;
                while i < $atan_terms {
                    series[i] = (if i % 2 == 0 { -1.0 } else { 1.0 }, (2 * i + 3) as f64);
                    i += 1;
                }
                series
            },
            ln_2: ($ln_2, $ln_2_rest),
            two_up: $two_up,
            min_positive: $float::MIN_POSITIVE as f64,
            root_half_bits: core::$float::consts::FRAC_1_SQRT_2.to_bits() as u64,
            root_3: 1.732_050_807_568_877_293_53,
            tan_15: 0.267_949_192_431_122_706_47,
            pi: (core::$float::consts::PI as f64, $pi),
            half_pi: (core::$float::consts::FRAC_PI_2 as f64, $half),
            sixth_pi: (core::$float::consts::FRAC_PI_6 as f64, $sixth),
        };

        /// Returns the natural logarithm, to 2 units in the last place.
        ///
        /// x = m 2^k with m between the square roots of 1/2 and 2. With f = m - 1 and s = f / (2 +
        /// f), ln m = 2 artanh s = f - f^2 / 2 + s (f^2 / 2 + R), where R is the series after its
        /// first term.
        pub(super) fn $ln(x: $float) -> $float {
            const LN_2: $float = $numbers.ln_2.0 as $float;
            const LN_2_REST: $float = $numbers.ln_2.1 as $float;
            const MANTISSA: u32 = $float::MANTISSA_DIGITS - 1;
            const SERIES: [$float; $ln_terms] = {
                let mut series = [0.0; $ln_terms];
                let mut i = 0;
                while i < $ln_terms {
                    let (over, under) = $numbers.logarithm[i];
                    series[i] = over as $float / under as $float;
                    i += 1;
                }
                series
            };
            if x == 0.0 {
                return -$float::INFINITY;
            }
            if x.is_nan() || x < 0.0 {
                return $float::NAN;
            }
            if x == $float::INFINITY {
                return x;
            }
            let subnormal = x < $numbers.min_positive as $float;
            let (x, up) = if subnormal { (x * $numbers.two_up as $float, $float::MANTISSA_DIGITS) } else { (x, 0) };
            // Relative to the square root of 1/2, the exponent changes where m jumps.
            let root = $numbers.root_half_bits as $bits;
            let shifted = x.to_bits().wrapping_sub(root);
            let k = (shifted as <$bits as Signed>::Type >> MANTISSA) as i32;
            let m = $float::from_bits((shifted & ((1 << MANTISSA) - 1)) + root);
            let k = (k - up as i32) as $float;
            let f = m - 1.0;
            let s = f / (2.0 + f);
            let z = s * s;
            let rest = z * SERIES.iter().rev().fold(0.0, |sum, c| c + z * sum);
            let half = 0.5 * f * f;
            s * (half + rest) + k * LN_2_REST - half + f + k * LN_2
        }

        /// Returns the angle from the x axis to (x, y), to 3 units in the last place. Zeros and
        /// infinities are treated as in IEEE 754.
        ///
        /// The smaller coordinate divided by the larger is a tangent t of at most 1. Above tan 15
        /// deg, atan t = 30 deg + atan((t sqrt 3 - 1) / (t + sqrt 3)).
        pub(super) fn $atan2(y: $float, x: $float) -> $float {
            const PI: $float = $numbers.pi.0 as $float;
            const PI_REST: $float = $numbers.pi.1 as $float;
            const HALF_PI: $float = $numbers.half_pi.0 as $float;
            const HALF_REST: $float = $numbers.half_pi.1 as $float;
            const SIXTH_PI: $float = $numbers.sixth_pi.0 as $float;
            const SIXTH_REST: $float = $numbers.sixth_pi.1 as $float;
            const ROOT_3: $float = $numbers.root_3 as $float;
            const TAN_15: $float = $numbers.tan_15 as $float;
            const SERIES: [$float; $atan_terms] = {
                let mut series = [0.0; $atan_terms];
                let mut i = 0;
                while i < $atan_terms {
                    let (over, under) = $numbers.arctangent[i];
                    series[i] = over as $float / under as $float;
                    i += 1;
                }
                series
            };
            if x.is_nan() || y.is_nan() {
                return $float::NAN;
            }
            let (width, height) = (x.abs(), y.abs());
            let steep = height > width;
            let (short, long) = if steep { (width, height) } else { (height, width) };
            let t = if short == $float::INFINITY {
                1.0
            } else if long == 0.0 {
                0.0
            } else {
                short / long
            };
            let beyond = t > TAN_15;
            let u = if beyond { (t * ROOT_3 - 1.0) / (t + ROOT_3) } else { t };
            let z = u * u;
            let rest = u * z * SERIES.iter().rev().fold(0.0, |sum, c| c + z * sum);
            // Angles are added with the rounding errors of their constants.
            let (angle, rest) = if beyond { (SIXTH_PI, u + (rest + SIXTH_REST)) } else { (u, rest) };
            let angle = if steep { HALF_PI - (angle - (HALF_REST - rest)) } else { angle + rest };
            let angle = if x.is_sign_negative() { PI - (angle - PI_REST) } else { angle };
            if y.is_sign_negative() { -angle } else { angle }
        }
    };
}

/// The signed integer type of the same length.
trait Signed {
    type Type;
}

impl Signed for u64 {
    type Type = i64;
}

impl Signed for u32 {
    type Type = i32;
}

elementary!(ln_f64, atan2_f64, f64, u64,
    /// The constants of logarithm and arctangent in double precision.
    ELEMENTARY_F64, terms: 9 14, ln_2: 0.6931471801362932 + 4.236521365809284e-10,
    two_up: 9007199254740992.0, rests of pi: 1.2246467991473532e-16 6.123233995736766e-17 -5.360408832255455e-17);
elementary!(ln_f32, atan2_f32, f32, u32,
    /// The constants of logarithm and arctangent in single precision.
    ELEMENTARY_F32, terms: 4 6, ln_2: 0.693145751953125 + 1.428606765330187e-06,
    two_up: 16777216.0, rests of pi: -8.742277657347586e-08 -4.371138828673793e-08 -1.457046305830545e-08);

#[cfg(test)]
mod tests {
    use super::{atan2_f32, atan2_f64, ln_f32, ln_f64};

    /// Returns the distance in units in the last place of `expected`.
    fn ulps(number: f64, expected: f64) -> f64 {
        if number.to_bits() == expected.to_bits() || number.is_nan() && expected.is_nan() {
            return 0.0;
        }
        (number - expected).abs()
            / (libm::nextafter(expected.abs(), f64::INFINITY) - expected.abs())
    }

    fn ulps_f32(number: f32, expected: f64) -> f64 {
        let nearest = expected as f32;
        if number.to_bits() == nearest.to_bits() || number.is_nan() && expected.is_nan() {
            return 0.0;
        }
        let unit = libm::nextafterf(nearest.abs(), f32::INFINITY) - nearest.abs();
        (f64::from(number) - expected).abs() / f64::from(unit)
    }

    #[test]
    fn logarithms_are_within_their_bound() {
        let mut worst: f64 = 0.0;
        let mut worst_f32: f64 = 0.0;
        for i in 0..400_000u64 {
            let bits = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            for x in [f64::from_bits(bits), 0.5 + i as f64 / 2e5] {
                worst = worst.max(ulps(ln_f64(x), libm::log(x)));
            }
            for x in [f32::from_bits((bits >> 32) as u32), 0.5 + i as f32 / 2e5] {
                worst_f32 = worst_f32.max(ulps_f32(ln_f32(x), libm::log(x.into())));
            }
        }
        assert!(worst <= 2.0 && worst_f32 <= 2.0, "{worst} {worst_f32}");
        for x in [0.0, -0.0, -1.0, f64::INFINITY, f64::NAN, f64::from_bits(1), 1.0] {
            assert!(ulps(ln_f64(x), libm::log(x)) <= 1.0, "{x}");
            assert!(ulps_f32(ln_f32(x as f32), libm::log((x as f32).into())) <= 1.0, "{x}");
        }
    }

    #[test]
    fn arctangents_are_within_their_bound() {
        let mut worst: f64 = 0.0;
        let mut worst_f32: f64 = 0.0;
        let mut compare = |y: f64, x: f64| {
            worst = worst.max(ulps(atan2_f64(y, x), libm::atan2(y, x)));
            let y = y as f32;
            let x = x as f32;
            worst_f32 = worst_f32.max(ulps_f32(atan2_f32(y, x), libm::atan2(y.into(), x.into())));
        };
        for i in 0..400_000 {
            let (sin, cos) = libm::sincos(f64::from(i) * 7e-5 - 10.0);
            compare(sin, cos);
            compare(3.0 * sin * sin * sin, cos);
        }
        let special = [0.0, 1.0, 1e-30, 1e30, f64::INFINITY, f64::NAN];
        for y in special.into_iter().flat_map(|y| [y, -y]) {
            for x in special.into_iter().flat_map(|x| [x, -x]) {
                compare(y, x);
            }
        }
        assert!(worst <= 3.0 && worst_f32 <= 3.0, "{worst} {worst_f32}");
    }
}
