// The natural logarithm.
fn modyn_ln(x: f32) -> f32 {
    if (x == 0.0f) {
        return -bitcast<f32>(modyn_infinity_bits);
    }
    if (!(x > 0.0f)) {
        return bitcast<f32>(modyn_nan_bits);
    }
    if (bitcast<u32>(x) == 0x7f800000u) {
        return x;
    }
    let subnormal = x < $MIN_POSITIVE$;
    // Counted from the root of 1/2, the exponent changes where the mantissa does.
    let shifted = bitcast<i32>(select(x, x * $TWO_UP$, subnormal)) - $ROOT_HALF$;
    let k = f32((shifted >> 23u) - select(0, 24, subnormal));
    let f = bitcast<f32>((shifted & 0x7fffff) + $ROOT_HALF$) - 1.0f;
    let s = f / (2.0f + f);
    let z = s * s;
    let half = 0.5f * f * f;
    return s * (half + z * $LOGARITHM$) + k * $LN_2_REST$ - half + f + k * $LN_2$;
}
