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
    let subnormal = x < 1.1754943508222875e-38f;
    // Counted from the root of 1/2, the exponent changes where the mantissa does.
    let shifted = bitcast<i32>(select(x, x * 16777216.0f, subnormal)) - 0x3f3504f3;
    let k = f32((shifted >> 23u) - select(0, 24, subnormal));
    let f = bitcast<f32>((shifted & 0x7fffff) + 0x3f3504f3) - 1.0f;
    let s = f / (2.0f + f);
    let z = s * s;
    let half = 0.5f * f * f;
    return s * (half + z * $LOGARITHM$) + k * 1.428606765330187e-06f - half + f + k * 0.693145751953125f;
}
