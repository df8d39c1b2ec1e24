//! Correctly rounded square roots by integer arithmetic, for processors without an instruction, or
//! where stable `core` has no function.

#![allow(clippy::cast_possible_truncation)]

macro_rules! square_root {
    ($name:ident, $float:ty, $bits:ty, $wide:ty) => {
        /// Returns the square root, correctly rounded to nearest.
        pub(super) fn $name(x: $float) -> $float {
            const MANTISSA: u32 = <$float>::MANTISSA_DIGITS - 1;
            const BIAS: $bits = <$float>::MAX_EXP as $bits - 1;
            // Zeros of both signs, infinity and NaN are their own square roots.
            if x == 0.0 || x.is_nan() || x == <$float>::INFINITY {
                return x;
            }
            if x < 0.0 {
                return <$float>::NAN;
            }
            // x = m 2^(e - BIAS - MANTISSA), with m of full length; subnormal numbers are shifted
            // up.
            let (field, fraction) = (x.to_bits() >> MANTISSA, x.to_bits() & ((1 << MANTISSA) - 1));
            let up = if field == 0 {
                fraction.leading_zeros() - (<$bits>::BITS - 1 - MANTISSA)
            } else {
                0
            };
            let m = if field == 0 { fraction << up } else { fraction | 1 << MANTISSA };
            let e = field.max(1) as i32 - BIAS as i32 - up as i32;
            // An even exponent, and twice the mantissa's length: the root has one bit more than is
            // kept. No root lies halfway between two numbers, so this bit decides the rounding.
            let odd = e & 1;
            let root = ((m as $wide) << (MANTISSA + 2 + odd as u32)).isqrt() as $bits;
            let rounded = (root + 1) >> 1;
            let exponent = ((e - odd) / 2 + BIAS as i32) as $bits;
            // The leading one of `rounded` adds to the exponent.
            <$float>::from_bits(((exponent - 1) << MANTISSA) + rounded)
        }
    };
}

square_root!(sqrt_f64, f64, u64, u128);
square_root!(sqrt_f32, f32, u32, u64);

#[cfg(test)]
mod tests {
    use super::{sqrt_f32, sqrt_f64};

    /// Returns the bits, or one pattern for all NaNs.
    fn f64_bits(x: f64) -> u64 {
        if x.is_nan() { u64::MAX } else { x.to_bits() }
    }

    fn f32_bits(x: f32) -> u32 {
        if x.is_nan() { u32::MAX } else { x.to_bits() }
    }

    #[test]
    fn roots_are_correctly_rounded() {
        // All exponents, both signs, random mantissas.
        let random = (0..400_000u64).map(|i| i.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (i << 40));
        let special = [0.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX, 4.0, f64::NAN];
        let smallest = [1, 2, 3].map(f64::from_bits);
        for x in random.clone().map(f64::from_bits).chain(special).chain(smallest) {
            assert_eq!(f64_bits(sqrt_f64(x)), f64_bits(libm::sqrt(x)), "{x:e}");
        }
        let smallest = [1, 2, 3].map(f32::from_bits);
        let random = random.map(|bits| f32::from_bits((bits >> 32) as u32));
        for x in random.chain(special.map(|x| x as f32)).chain(smallest) {
            assert_eq!(f32_bits(sqrt_f32(x)), f32_bits(libm::sqrtf(x)), "{x:e}");
        }
    }
}
