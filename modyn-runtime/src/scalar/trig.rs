//! Sine and cosine without a branch for common angles, and without a system library.
//!
//! The angle is reduced modulo pi to [-pi/2, pi/2] by Cody and Waite's method. pi is the sum of
//! several parts. All but the last are so short that their products with the multiple are exact.
//! Sines close to multiples of pi therefore keep their digits, with fused products or without. Sine
//! and cosine of the reduced angle are polynomials (near-minimax, Taylor-like coefficients). An odd
//! multiple flips both signs by a bit operation. Angles beyond a limit, NaN and infinities are
//! reduced with integers: the only branch on a value here. That reduction takes a fixed number of
//! steps for any angle. `f32` is never converted to `f64`.

#![allow(clippy::excessive_precision, clippy::unreadable_literal, clippy::cast_possible_truncation)]
#![allow(clippy::cast_possible_wrap, clippy::cast_precision_loss, clippy::cast_sign_loss)]

use super::Scalar;

/// The bit operation that the reduction needs besides arithmetic.
pub(crate) trait FlipSign: Scalar {
    /// Returns -self if the lowest bit of `by` is set, else self.
    #[must_use]
    fn flip_sign(self, by: Self) -> Self;
}

/// A floating-point type with the polynomials of its precision, which serve its vectors, too.
pub(crate) trait Precision: FlipSign + PartialOrd {
    /// The exclusive bound of angles for the fast reduction, rad.
    const LIMIT: Self;

    /// Returns, for x below the limit, the angle in [-pi/2, pi/2] that differs from x by a multiple
    /// of pi, and a number whose lowest bit is the multiple's lowest bit.
    fn reduce_small<S: FlipSign>(x: S) -> (S, S);

    /// Returns sine and cosine of any other x; NaN if x is not finite.
    fn reduce_large(self) -> (Self, Self);

    /// Returns sin and cos of an angle in [-pi/2, pi/2]; the lowest bit of `turns` flips both
    /// signs.
    fn polynomials<S: FlipSign>(r: S, turns: S) -> (S, S);

    /// Returns sin and cos of an angle below the limit.
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    #[inline(always)]
    fn reduced<S: FlipSign>(x: S) -> (S, S) {
        let (r, turns) = Self::reduce_small(x);
        Self::polynomials(r, turns)
    }

    /// Returns sin and cos of any other angle.
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    #[inline]
    fn unreduced(self) -> (Self, Self) {
        let (r, turns) = self.reduce_large();
        Self::polynomials(r, turns)
    }
}

/// Returns sin and cos of `x` in rad. Absolute error: at most 3e-16 in double precision, 1.5e-7 in
/// single precision. Relative error of the sine: at most 3.5e-16 and 2e-7; the cosine has no such
/// bound close to its zeros.
#[inline]
pub(crate) fn sin_cos<F: Precision>(x: F) -> (F, F) {
    // `<` is false for NaN.
    let (r, turns) = if x.abs() < F::LIMIT { F::reduce_small(x) } else { x.reduce_large() };
    F::polynomials(r, turns)
}

/// Returns sin and cos of several angles, without a branch between them.
#[inline]
pub(crate) fn sin_cos_all<F: Precision, const N: usize>(angles: [F; N]) -> [(F, F); N] {
    let small = angles.iter().fold(true, |all, x| all & (x.abs() < F::LIMIT));
    let reduced = if small { angles.map(F::reduce_small) } else { reduce_any(angles) };
    reduced.map(|(r, turns)| F::polynomials(r, turns))
}

/// Returns sin and cos of several angles, some of which are beyond the limit.
#[cold]
#[inline(never)]
fn reduce_any<F: Precision, const N: usize>(angles: [F; N]) -> [(F, F); N] {
    angles.map(|x| if x.abs() < F::LIMIT { F::reduce_small(x) } else { x.reduce_large() })
}

/// Corrects the results of the fast reduction for angles beyond the limit, lane by lane.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))] // Others have no lanes.
#[cold]
#[inline(never)]
pub(crate) fn correct<F: Precision>(angles: &[F], sines: &mut [F], cosines: &mut [F]) {
    for ((x, sin), cos) in angles.iter().zip(sines).zip(cosines) {
        let small = x.abs() < F::LIMIT;
        if !small {
            (*sin, *cos) = x.unreduced();
        }
    }
}

/// Returns the value of a polynomial; the highest coefficient comes first.
#[inline(always)]
fn polynomial<S: Scalar, const N: usize>(z: S, coefficients: [S; N]) -> S {
    let mut sum = coefficients[0];
    let mut i = 1;
    // No iterator: code that is not inlined is compiled without the caller's instruction set.
    while i < N {
        sum = z.mul_add(sum, coefficients[i]);
        i += 1;
    }
    sum
}

/// Returns sin and cos of r, from the coefficients of (sin r / r - 1) / z and of (cos r - 1 +
/// z / 2) / z^2 in z = r^2; the lowest bit of `turns` flips both signs.
#[inline(always)]
fn sine_and_cosine<S: FlipSign, const M: usize, const N: usize>(
    r: S,
    turns: S,
    sine: [S; M],
    cosine: [S; N],
) -> (S, S) {
    let z = r * r;
    let sin = (r * z).mul_add(polynomial(z, sine), r);
    let cos = (z * z).mul_add(polynomial(z, cosine), z.mul_add(S::from_f64(-0.5), S::one()));
    (sin.flip_sign(turns), cos.flip_sign(turns))
}

/// The constants of sine and cosine in one precision. The runtime, generated C and WGSL use the
/// same constants.
#[derive(Clone, Copy, Debug)]
pub struct SinCosNumbers<const P: usize, const M: usize, const N: usize> {
    /// The exclusive bound of angles for the fast reduction, rad.
    pub limit: f64,
    /// A number whose addition rounds to the nearest integer; the lowest bit of the sum is then the
    /// integer's lowest bit.
    pub round: f64,
    /// -pi as a sum of parts. All parts but the last are so short that their products with the
    /// multiple are exact.
    pub minus_pi: [f64; P],
    /// The coefficients of (sin r / r - 1) / r^2 in powers of r^2; the highest comes first.
    pub sine: [f64; M],
    /// The coefficients of (cos r - 1 + r^2 / 2) / r^4 in powers of r^2; the highest comes first.
    pub cosine: [f64; N],
}

/// The constants of sine and cosine in double precision. The multiple of pi has at most 17 bits;
/// the first two parts of pi have 36 bits.
pub const SIN_COS_F64: SinCosNumbers<3, 8, 7> = SinCosNumbers {
    limit: 262_144.0,
    round: 6755399441055744.0,
    minus_pi: [-3.1415926535846666, -5.1266883031679116e-12, -2.1125998133974855e-23],
    sine: [
        2.731444766828598e-15,
        -7.643970296785917e-13,
        1.6058977312463691e-10,
        -2.5052107616996175e-08,
        2.7557319219163234e-06,
        -0.00019841269841254974,
        0.008333333333333316,
        -0.16666666666666666,
    ],
    cosine: [
        4.646435958850054e-14,
        -1.1466252259700669e-11,
        2.087668155886695e-09,
        -2.755731857336617e-07,
        2.480158729891355e-05,
        -0.0013888888888884767,
        0.04166666666666666,
    ],
};

/// The constants of sine and cosine in single precision. The multiple of pi has at most 11 bits;
/// the first three parts of pi have 13 bits.
pub const SIN_COS_F32: SinCosNumbers<4, 4, 4> = SinCosNumbers {
    limit: 4096.0,
    round: 12582912.0,
    minus_pi: [
        -3.14111328125,
        -0.0004793405532836914,
        -3.1781382858753204e-8,
        -5.126688136514179e-12,
    ],
    sine: [
        2.6347563915750605e-06,
        -0.00019822739488558033,
        0.008333242135096397,
        -0.1666666596382118,
    ],
    cosine: [
        -2.6546065803427757e-07,
        2.4786082439888205e-05,
        -0.001388881255124653,
        0.04166666607830637,
    ],
};

impl FlipSign for f64 {
    #[inline(always)]
    fn flip_sign(self, by: Self) -> Self {
        Self::from_bits(self.to_bits() ^ (by.to_bits() << 63))
    }
}

impl Precision for f64 {
    /// At this limit the multiple of pi has at most 17 bits.
    const LIMIT: Self = SIN_COS_F64.limit;

    #[inline(always)]
    fn reduce_small<S: FlipSign>(x: S) -> (S, S) {
        let k = S::from_f64;
        // Adding 1.5 * 2^52 rounds to the nearest integer; its lowest bit is then the lowest bit of
        // the sum.
        let round = k(SIN_COS_F64.round);
        let shifted = x.mul_add(k(core::f64::consts::FRAC_1_PI), round);
        let n = shifted - round;
        let [first, second, third] = SIN_COS_F64.minus_pi;
        // pi in three parts, the first two with 36 bits.
        let high = n.mul_add(k(first), x);
        let r = n.mul_add(k(second), high);
        (n.mul_add(k(third), r), shifted)
    }

    #[cold]
    #[inline(never)]
    fn reduce_large(self) -> (Self, Self) {
        if !self.is_finite() {
            return (Self::NAN, 0.0);
        }
        let bits = self.to_bits();
        let fraction = bits & ((1 << 52) - 1);
        let exponent = (bits >> 52) & 0x7ff;
        let Reduced { odd, negative, angle, zeros } =
            reduce(fraction | (1 << 52), exponent as i32 - 1075);
        let r = angle as Self * Self::from_bits(u64::from(1023 - 62 - zeros) << 52);
        let sign = Self::from_bits(u64::from(negative) ^ (bits >> 63));
        (r.flip_sign(sign), Self::from_bits(odd.into()))
    }

    #[inline(always)]
    fn polynomials<S: FlipSign>(r: S, turns: S) -> (S, S) {
        // Each constant is converted by name; a loop would convert them at run time.
        let k = S::from_f64;
        let [a, b, c, d, e, f, g, h] = SIN_COS_F64.sine;
        let sine = [k(a), k(b), k(c), k(d), k(e), k(f), k(g), k(h)];
        let [a, b, c, d, e, f, g] = SIN_COS_F64.cosine;
        sine_and_cosine(r, turns, sine, [k(a), k(b), k(c), k(d), k(e), k(f), k(g)])
    }
}

impl FlipSign for f32 {
    #[inline(always)]
    fn flip_sign(self, by: Self) -> Self {
        Self::from_bits(self.to_bits() ^ (by.to_bits() << 31))
    }
}

impl Precision for f32 {
    /// At this limit the multiple of pi has at most 11 bits.
    const LIMIT: Self = SIN_COS_F32.limit as Self;

    #[inline(always)]
    fn reduce_small<S: FlipSign>(x: S) -> (S, S) {
        let k = S::from_f64;
        let round = k(SIN_COS_F32.round);
        let shifted = x.mul_add(k(core::f32::consts::FRAC_1_PI.into()), round);
        let n = shifted - round;
        let [first, second, third, fourth] = SIN_COS_F32.minus_pi;
        // pi in four parts, the first three with 13 bits.
        let r = n.mul_add(k(first), x);
        let middle = n.mul_add(k(second), r);
        let r = n.mul_add(k(third), middle);
        (n.mul_add(k(fourth), r), shifted)
    }

    #[cold]
    #[inline(never)]
    fn reduce_large(self) -> (Self, Self) {
        if !self.is_finite() {
            return (Self::NAN, 0.0);
        }
        let bits = self.to_bits();
        let fraction = bits & ((1 << 23) - 1);
        let exponent = (bits >> 23) & 0xff;
        let Reduced { odd, negative, angle, zeros } =
            reduce((fraction | (1 << 23)).into(), exponent as i32 - 150);
        // The upper half of `angle` has more bits than the result.
        let r = (angle >> 32) as u32 as Self * Self::from_bits((127 - 30 - zeros) << 23);
        let sign = Self::from_bits(u32::from(negative) ^ (bits >> 31));
        (r.flip_sign(sign), Self::from_bits(odd.into()))
    }

    #[inline(always)]
    fn polynomials<S: FlipSign>(r: S, turns: S) -> (S, S) {
        // Each constant is converted by name; a loop would convert them at run time.
        let k = S::from_f64;
        let [a, b, c, d] = SIN_COS_F32.sine;
        let sine = [k(a), k(b), k(c), k(d)];
        let [a, b, c, d] = SIN_COS_F32.cosine;
        sine_and_cosine(r, turns, sine, [k(a), k(b), k(c), k(d)])
    }
}

/// A reduced angle: the angle is `odd` times pi (plus even multiples), plus or minus `angle`
/// 2^-(62 + zeros), which is at most pi/2.
struct Reduced {
    odd: bool,
    negative: bool,
    angle: u64,
    zeros: u32,
}

/// The bits of 1 / pi, after 64 zeros. The runtime, generated C and WGSL use the same bits.
pub const FRAC_1_PI_BITS: [u64; 20] = [
    0x0000000000000000,
    0x517cc1b727220a94,
    0xfe13abe8fa9a6ee0,
    0x6db14acc9e21c820,
    0xff28b1d5ef5de2b0,
    0xdb92371d2126e970,
    0x0324977504e8c90e,
    0x7f0ef58e5894d39f,
    0x74411afa975da242,
    0x74ce38135a2fbf20,
    0x9cc8eb1cc1a99cfa,
    0x4e422fc5defc941d,
    0x8ffc4bffef02cc07,
    0xf79788c5ad05368f,
    0xb69b3f6793e584db,
    0xa7a31fb34f2ff516,
    0xba93dd63f5f2f8bd,
    0x9e839cfbc5294975,
    0x35fdafd88fc6ae84,
    0x2b0198237e3db5d5,
];

/// The bits of pi: pi 2^62. The runtime, generated C and WGSL use the same bits.
pub const PI_BITS: u64 = 0xc90fdaa22168c235;

/// Reduces m 2^e (m below 2^53, -62 < e < 972) modulo pi, as in Payne and Hanek 1983, "Radian
/// reduction for trigonometric functions". In m 2^e / pi, the bits of 1 / pi that contribute even
/// integers are omitted, and so are bits that are too small to matter.
fn reduce(m: u64, e: i32) -> Reduced {
    // From the bit of 1 / pi that m 2^e scales to 1: 192 bits.
    let start = (e + 63) as u32;
    let limb = |i: u32| {
        let at = |i: u32| FRAC_1_PI_BITS.get(i as usize).copied().unwrap_or_default();
        let word = start / 64 + i;
        let shift = start % 64;
        at(word) << shift | at(word + 1) >> 1 >> (63 - shift)
    };
    // The product with m: its uppermost bit counts ones, the other bits are the fraction.
    let wide = |i: u32| u128::from(m) * u128::from(limb(i));
    let low = wide(2);
    let middle = wide(1) + (low >> 64);
    let high = m.wrapping_mul(limb(0)).wrapping_add((middle >> 64) as u64);
    let fraction =
        u128::from(high) << 65 | (middle as u64 as u128) << 1 | (low as u64 >> 63) as u128;
    // A fraction of at least 1/2 is the next multiple minus a remainder.
    let nearest = fraction as i128;
    let magnitude = nearest.unsigned_abs();
    let zeros = magnitude.leading_zeros().min(62);
    let leading = ((magnitude << zeros) >> 64) as u64;
    Reduced {
        odd: (high >> 63 == 1) != (nearest < 0),
        negative: nearest < 0,
        angle: ((u128::from(leading) * u128::from(PI_BITS)) >> 64) as u64,
        zeros,
    }
}

#[cfg(test)]
mod tests {
    use super::super::near_pi;
    use super::{Precision, sin_cos};

    const LIMIT_F64: f64 = <f64 as Precision>::LIMIT;
    const LIMIT_F32: f32 = <f32 as Precision>::LIMIT;

    /// Returns evenly and unevenly spread angles within `limit`, of both signs.
    fn angles(limit: f64) -> impl Iterator<Item = f64> {
        (0..200_000u32).flat_map(move |i| {
            let t = f64::from(i) / 200_000.0;
            [t * limit, -t * limit, t * t * t * limit, t * 7.0 - 3.5]
        })
    }

    /// Returns numbers of all sizes from `limit` on, and some that are very close to multiples of
    /// pi/2.
    fn reduce_large(limit: f64, largest: f64) -> impl Iterator<Item = f64> {
        let steps = 200_000;
        let factor = libm::exp(libm::log(largest / limit) / f64::from(steps));
        let spread = (0..steps).map(move |i| limit * libm::pow(factor, f64::from(i)));
        // 6381956970095103 * 2^797 is the double closest to a multiple, within 5e-19.
        let near =
            [6381956970095103.0 * libm::pow(2.0, 797.0), 355.0, 5_419_351.0, 1_725_033.0 * 1e6];
        let pi = |k: u32| f64::from(k) * core::f64::consts::FRAC_PI_2;
        let multiples = (0..100_000).map(move |k| pi(4_200_000_000 - 41_777 * k));
        spread
            .chain(near)
            .chain(multiples)
            .flat_map(|x| [x, -x])
            .filter(move |x| (limit..=largest).contains(&x.abs()))
    }

    #[test]
    fn f64_is_within_its_bound() {
        let mut worst: f64 = 0.0;
        for x in angles(3e5).chain(reduce_large(LIMIT_F64, f64::MAX)) {
            let (s, c) = sin_cos(x);
            worst = worst.max((s - libm::sin(x)).abs()).max((c - libm::cos(x)).abs());
        }
        assert!(worst <= 3e-16, "{worst:e}");
    }

    #[test]
    fn f32_is_within_its_bound() {
        let mut worst: f64 = 0.0;
        for x in angles(4.2e3).chain(reduce_large(LIMIT_F32.into(), f32::MAX.into())) {
            let x = x as f32;
            let (s, c) = sin_cos(x);
            let s = f64::from(s);
            let c = f64::from(c);
            worst = worst.max((s - libm::sin(x.into())).abs()).max((c - libm::cos(x.into())).abs());
        }
        assert!(worst <= 1.5e-7, "{worst:e}");
    }

    /// The sine's relative error of the fast reduction: close to every multiple of pi, against
    /// libm, and close to selected ones, against mpmath.
    #[test]
    fn sines_near_multiples_of_pi_keep_their_digits() {
        let mut worst: f64 = 0.0;
        for k in 1..=83_443_u32 {
            let nearest = f64::from(k) * core::f64::consts::PI;
            for x in [nearest.next_down(), nearest, nearest.next_up()] {
                if x < LIMIT_F64 {
                    let expected = libm::sin(x);
                    worst = worst.max(((sin_cos(x).0 - expected) / expected).abs());
                }
            }
        }
        for (x, expected) in near_pi::F64 {
            assert!(x < LIMIT_F64);
            worst = worst.max(((sin_cos(x).0 - expected) / expected).abs());
        }
        assert!(worst <= 3.5e-16, "f64: {worst:e}");

        let mut worst: f64 = 0.0;
        for k in 1..=1_303_u32 {
            let nearest = (f64::from(k) * core::f64::consts::PI) as f32;
            for x in [nearest.next_down(), nearest, nearest.next_up()] {
                if x < LIMIT_F32 {
                    let expected = libm::sin(x.into());
                    worst = worst.max(((f64::from(sin_cos(x).0) - expected) / expected).abs());
                }
            }
        }
        for (x, expected) in near_pi::F32 {
            let x = x as f32;
            assert!(x < LIMIT_F32);
            worst = worst.max(((f64::from(sin_cos(x).0) - expected) / expected).abs());
        }
        assert!(worst <= 2e-7, "f32: {worst:e}");
    }

    /// The sine's relative error at other angles.
    #[test]
    fn sines_have_a_relative_error_of_two_places() {
        let mut worst: [f64; 2] = [0.0; 2];
        for x in angles(LIMIT_F64.next_down()).filter(|&x| x != 0.0) {
            let expected = libm::sin(x);
            worst[0] = worst[0].max(((sin_cos(x).0 - expected) / expected).abs());
        }
        for x in angles(LIMIT_F32.next_down().into()).filter(|&x| x != 0.0) {
            let x = x as f32;
            let expected = libm::sin(x.into());
            worst[1] = worst[1].max(((f64::from(sin_cos(x).0) - expected) / expected).abs());
        }
        let [double, single] = worst;
        assert!(double <= 3.5e-16 && single <= 2e-7, "{double:e}, {single:e}");
    }

    /// The error is small relative to the sine itself, not only relative to 1.
    #[test]
    fn far_angles_near_multiples_of_pi_keep_their_digits() {
        for k in (1..4_000_000_000_u64).step_by(999_983) {
            let x = k as f64 * core::f64::consts::PI * 1e6;
            let number = sin_cos(x).0;
            let expected = libm::sin(x);
            assert!(
                (number - expected).abs() <= 1e-15 * expected.abs(),
                "{x:e}: {number:e} {expected:e}"
            );
        }
        let x = 6381956970095103.0 * libm::pow(2.0, 797.0);
        let number = sin_cos(x).1;
        let expected = libm::cos(x);
        assert!((number - expected).abs() <= 1e-15, "{number:e} {expected:e}");
    }

    /// The sine's relative error at the far angles that are nearest to multiples of pi, against
    /// mpmath. All digits of the reduced angle come from the last of the 192 bits of 1 / pi there.
    #[test]
    fn far_angles_nearest_to_multiples_of_pi_keep_their_digits() {
        for (x, expected) in near_pi::FAR_F64 {
            assert!(x >= LIMIT_F64);
            for (x, expected) in [(x, expected), (-x, -expected)] {
                let number = sin_cos(x).0;
                let error = ((number - expected) / expected).abs();
                assert!(error <= 3.5e-16, "{x:e}: {number:e} {expected:e}");
            }
        }
        for (x, expected) in near_pi::FAR_F32 {
            let x = x as f32;
            assert!(x >= LIMIT_F32);
            for (x, expected) in [(x, expected), (-x, -expected)] {
                let number = f64::from(sin_cos(x).0);
                let error = ((number - expected) / expected).abs();
                assert!(error <= 2e-7, "{x:e}: {number:e} {expected:e}");
            }
        }
    }

    #[test]
    fn no_angle_gives_not_a_number() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (s, c) = sin_cos(x);
            assert!(s.is_nan() && c.is_nan());
        }
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (s, c) = sin_cos(x);
            assert!(s.is_nan() && c.is_nan());
        }
    }
}
