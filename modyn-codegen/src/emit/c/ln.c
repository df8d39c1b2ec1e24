/* The natural logarithm, to 2 units in the last place. */
FUNCTION REAL modyn_ln(REAL x)
{
    static const REAL series[LN_TERMS] = { LN_SERIES };
    const BITS one = 1U;
    const int subnormal = (x < R(MIN_POSITIVE)) ? 1 : 0;
    BITS shifted;
    REAL f;
    REAL half;
    REAL k;
    REAL s;
    REAL sum = R(0.0);
    int exponent;
    int i;
    if (x == R(0.0)) {
        return -(REAL)INFINITY;
    }
    if (!(x > R(0.0))) {
        return (REAL)NAN;
    }
    if (x == (REAL)INFINITY) {
        return x;
    }
    /* Counted from the root of 1/2, the exponent changes where the mantissa does. */
    shifted = modyn_bits((subnormal != 0) ? (x * R(TWO_UP)) : x) - (BITS)ROOT_HALF;
    exponent = (int)(shifted >> MANTISSA);
    if ((shifted >> SIGN) != 0U) {
        exponent -= (EXPONENTS + 1) * 2;
    }
    k = (REAL)(exponent - ((subnormal != 0) ? DIGITS : 0));
    f = modyn_from_bits((shifted & ((one << MANTISSA) - one)) + (BITS)ROOT_HALF) - R(1.0);
    s = f / (R(2.0) + f);
    for (i = LN_TERMS; i > 0; --i) {
        sum = series[i - 1] + ((s * s) * sum);
    }
    half = (R(0.5) * f) * f;
    return ((((s * (half + ((s * s) * sum))) + (k * R(LN_2_REST))) - half) + f) + (k * R(LN_2));
}

