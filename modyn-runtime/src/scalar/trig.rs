//! Sine and cosine without a branch on the common path and without a system library.
//!
//! The angle is reduced modulo pi to [-pi/2, pi/2] by Cody and Waite's method (pi in two parts,
//! the first short enough that its product with the multiple is exact), both functions are
//! polynomials there (near-minimax, Taylor-like coefficients), and an odd multiple flips both
//! signs by a bit operation. Beyond [`LIMIT_F64`] (or where the argument is NaN or infinite)
//! `libm` takes over: the one data-dependent branch of generated code.

#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use core::f64::consts::FRAC_1_PI;

/// Largest argument of the fast reduction: the multiple of pi has at most 17 bits there.
const LIMIT_F64: f64 = 262_144.0;

/// The same for `f32`, with a multiple of at most 11 bits.
const LIMIT_F32: f32 = 4096.0;

/// sin and cos of `x` in rad; absolute error at most 3e-16 for |x| < 262,144.
#[inline]
pub(super) fn sin_cos_f64(x: f64) -> (f64, f64) {
    // `<` is false for NaN.
    if x.abs() < LIMIT_F64 { reduced_f64(x) } else { libm::sincos(x) }
}

#[inline]
fn reduced_f64(x: f64) -> (f64, f64) {
    // Adding 1.5 * 2^52 rounds to the nearest integer, whose lowest bit is then the lowest of the sum.
    const ROUND: f64 = 6755399441055744.0;
    // pi = A + B: A has 33 significant bits.
    const A: f64 = 3.14159265346825122833;
    const B: f64 = 1.21542010130123852e-10;
    let shifted = x * FRAC_1_PI + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * A) - n * B;
    let z = r * r;
    let s = -7.643970296785917e-13 + z * 2.731444766828598e-15;
    let s = 1.6058977312463691e-10 + z * s;
    let s = -2.5052107616996175e-08 + z * s;
    let s = 2.7557319219163234e-06 + z * s;
    let s = -0.00019841269841254974 + z * s;
    let s = 0.008333333333333316 + z * s;
    let s = -0.16666666666666666 + z * s;
    let sin = r + (r * z) * s;
    let c = -1.1466252259700669e-11 + z * 4.646435958850054e-14;
    let c = 2.087668155886695e-09 + z * c;
    let c = -2.755731857336617e-07 + z * c;
    let c = 2.480158729891355e-05 + z * c;
    let c = -0.0013888888888884767 + z * c;
    let c = 0.04166666666666666 + z * c;
    let cos = (1.0 - 0.5 * z) + (z * z) * c;
    let sign = shifted.to_bits() << 63;
    (f64::from_bits(sin.to_bits() ^ sign), f64::from_bits(cos.to_bits() ^ sign))
}

/// sin and cos of `x` in rad, in single precision throughout; absolute error at most 1.5e-7 for
/// |x| < 4096.
#[inline]
pub(super) fn sin_cos_f32(x: f32) -> (f32, f32) {
    if x.abs() < LIMIT_F32 { reduced_f32(x) } else { libm::sincosf(x) }
}

#[inline]
fn reduced_f32(x: f32) -> (f32, f32) {
    const ROUND: f32 = 12582912.0;
    // pi = A + B + C, A and B with few enough bits that their products with the multiple are exact.
    const A: f32 = 3.140625;
    const B: f32 = 0.0009670257568359375;
    const C: f32 = 6.2783295730096264e-7;
    let shifted = x * core::f32::consts::FRAC_1_PI + ROUND;
    let n = shifted - ROUND;
    let r = ((x - n * A) - n * B) - n * C;
    let z = r * r;
    let s = -0.00019822739488558033 + z * 2.6347563915750605e-06;
    let s = 0.008333242135096397 + z * s;
    let s = -0.1666666596382118 + z * s;
    let sin = r + (r * z) * s;
    let c = 2.4786082439888205e-05 + z * -2.6546065803427757e-07;
    let c = -0.001388881255124653 + z * c;
    let c = 0.04166666607830637 + z * c;
    let cos = (1.0 - 0.5 * z) + (z * z) * c;
    let sign = shifted.to_bits() << 31;
    (f32::from_bits(sin.to_bits() ^ sign), f32::from_bits(cos.to_bits() ^ sign))
}

#[cfg(test)]
mod tests {
    use super::{LIMIT_F32, LIMIT_F64, reduced_f32, reduced_f64, sin_cos_f32, sin_cos_f64};

    /// Evenly and unevenly spread angles within `limit`, both signs.
    fn angles(limit: f64) -> impl Iterator<Item = f64> {
        (0..200_000u32).flat_map(move |i| {
            let t = f64::from(i) / 200_000.0;
            [t * limit, -t * limit, t * t * t * limit, t * 7.0 - 3.5]
        })
    }

    #[test]
    fn f64_is_within_its_bound() {
        let mut worst: f64 = 0.0;
        for x in angles(3e5) {
            let (s, c) = sin_cos_f64(x);
            worst = worst.max((s - libm::sin(x)).abs()).max((c - libm::cos(x)).abs());
        }
        assert!(worst <= 3e-16, "{worst:e}");
    }

    #[test]
    #[allow(clippy::cast_possible_truncation)]
    fn f32_is_within_its_bound() {
        let mut worst: f64 = 0.0;
        for x in angles(4.2e3) {
            let x = x as f32;
            let (s, c) = sin_cos_f32(x);
            let (s, c) = (f64::from(s), f64::from(c));
            worst = worst.max((s - libm::sin(x.into())).abs()).max((c - libm::cos(x.into())).abs());
        }
        assert!(worst <= 1.5e-7, "{worst:e}");
    }

    #[test]
    fn the_limits_part_the_two_ways() {
        for x in [0.3, -2.0, 1e5, LIMIT_F64 - 1.0, -LIMIT_F64 + 1.0] {
            assert_eq!(sin_cos_f64(x), reduced_f64(x));
        }
        for x in [LIMIT_F64, -LIMIT_F64, 1e9, 1e15, -1e300] {
            assert_eq!(sin_cos_f64(x), libm::sincos(x));
        }
        for x in [0.3, -2.0, 1e3, LIMIT_F32 - 1.0, -LIMIT_F32 + 1.0] {
            assert_eq!(sin_cos_f32(x), reduced_f32(x));
        }
        for x in [LIMIT_F32, -LIMIT_F32, 1e6, -1e30] {
            assert_eq!(sin_cos_f32(x), libm::sincosf(x));
        }
    }

    #[test]
    fn no_angle_gives_not_a_number() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (s, c) = sin_cos_f64(x);
            assert!(s.is_nan() && c.is_nan());
        }
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (s, c) = sin_cos_f32(x);
            assert!(s.is_nan() && c.is_nan());
        }
    }
}
