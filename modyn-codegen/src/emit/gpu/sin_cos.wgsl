// The upper 32 bits of a product.
fn modyn_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u);
}

// The angle in [-pi/2, pi/2] that differs from x by a multiple of pi, and 1 where the multiple is odd, for angles beyond
// the fast reduction: after Payne and Hanek 1983, "Radian reduction for trigonometric functions".
fn modyn_far(x: f32) -> vec2<f32> {
    // 1 / pi in binary, after 64 zeros.
    var words = array<u32, $LIMBS$>(
        $FRAC_1_PI_BITS$
    );
    let bits = bitcast<u32>(x);
    let exponent = (bits >> 23u) & 0xffu;
    if (exponent == 0xffu) {
        return vec2<f32>(bitcast<f32>(modyn_nan_bits), 0.0f);
    }
    let m = (bits & 0x7fffffu) | 0x800000u;
    // x = m 2^(exponent - 150): the bit of 1 / pi whose product with m is an odd multiple.
    let start = exponent - 87u;
    let word = start / 32u;
    let shift = start % 32u;
    let first = (words[word] << shift) | ((words[word + 1u] >> 1u) >> (31u - shift));
    let second = (words[word + 1u] << shift) | ((words[word + 2u] >> 1u) >> (31u - shift));
    let third = (words[word + 2u] << shift) | ((words[word + 3u] >> 1u) >> (31u - shift));
    let carried = modyn_high(m, third);
    let middle = m * second + carried;
    let high = m * first + modyn_high(m, second) + select(0u, 1u, middle < carried);
    // The fraction, of 64 bits; from 1/2 on the next multiple is nearer.
    var upper = (high << 1u) | (middle >> 31u);
    var lower = (middle << 1u) | ((m * third) >> 31u);
    let negative = upper >> 31u;
    let odd = (high >> 31u) ^ negative;
    if (negative != 0u) {
        lower = ~lower + 1u;
        upper = ~upper + select(0u, 1u, lower == 0u);
    }
    var zeros = countLeadingZeros(upper);
    if (zeros >= 32u) {
        zeros = 32u + min(countLeadingZeros(lower), 29u);
        upper = lower << (zeros - 32u);
    } else if (zeros > 0u) {
        upper = (upper << zeros) | (lower >> (32u - zeros));
    }
    // The factor is pi 2^30.
    let r = f32(modyn_high(upper, $PI_BITS$)) * bitcast<f32>((97u - zeros) << 23u);
    return vec2<f32>(bitcast<f32>(bitcast<u32>(r) ^ (negative << 31u) ^ (bits & 0x80000000u)), f32(odd));
}

// Sine and cosine of x in rad; absolute error at most 4e-7.
fn modyn_sin_cos(x: f32) -> vec2<f32> {
    var r: f32;
    var odd: u32;
    if (abs(x) < $LIMIT$) {
        let n = round(x * $FRAC_1_PI$);
        r = $REDUCTION$;
        odd = u32(i32(n)) & 1u;
    } else {
        let far = modyn_far(x);
        r = far.x;
        odd = u32(far.y);
    }
    let z = r * r;
    let sine = fma(r * z, $SINE$, r);
    let cosine = fma(z * z, $COSINE$, fma(z, -0.5f, 1.0f));
    let flip = odd << 31u;
    return vec2<f32>(bitcast<f32>(bitcast<u32>(sine) ^ flip), bitcast<f32>(bitcast<u32>(cosine) ^ flip));
}
