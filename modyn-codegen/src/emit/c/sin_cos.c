/* What is left of an angle: it is odd pi (and even multiples) plus or minus angle 2^-(62 + zeros), at most pi / 2. */
typedef struct {
    unsigned int odd;
    unsigned int negative;
    unsigned int zeros;
    unsigned long long angle;
} modyn_reduced;

/* The upper 64 bits of a product. */
FUNCTION unsigned long long modyn_high(unsigned long long a, unsigned long long b)
{
    const unsigned long long mask = 0xffffffffULL;
    const unsigned long long low = (a & mask) * (b & mask);
    const unsigned long long middle = ((a >> 32) * (b & mask)) + (low >> 32);
    const unsigned long long other = ((a & mask) * (b >> 32)) + (middle & mask);
    return ((a >> 32) * (b >> 32)) + (middle >> 32) + (other >> 32);
}

/* 64 bits of 1 / pi, from bit 64 i after start on. */
FUNCTION unsigned long long modyn_limb(unsigned int start, unsigned int i)
{
    /* 1 / pi in binary, after 64 zeros. */
    static const unsigned long long words[LIMBS] = {
        FRAC_1_PI_BITS
    };
    const unsigned int word = (start / 64U) + i;
    const unsigned int shift = start % 64U;
    if (word > LAST_LIMB) {
        return 0ULL;
    }
    return (words[word] << shift) | ((words[word + 1U] >> 1) >> (63U - shift));
}

/* Reduces m 2^e (m below 2^53, -62 < e < 972) modulo pi after Payne and Hanek 1983, "Radian reduction for
   trigonometric functions". */
FUNCTION modyn_reduced modyn_reduce(unsigned long long m, int e)
{
    const unsigned int start = (unsigned int)(e + 63);
    const unsigned long long first = modyn_limb(start, 0U);
    const unsigned long long second = modyn_limb(start, 1U);
    const unsigned long long third = modyn_limb(start, 2U);
    const unsigned long long low = m * third;
    const unsigned long long carried = modyn_high(m, third);
    const unsigned long long middle = (m * second) + carried;
    const unsigned long long carry = (middle < carried) ? 1ULL : 0ULL;
    const unsigned long long high = (m * first) + modyn_high(m, second) + carry;
    /* The fraction, of 128 bits; from 1/2 on it is the next multiple, less something. */
    unsigned long long upper = (high << 1) | (middle >> 63);
    unsigned long long lower = (middle << 1) | (low >> 63);
    unsigned long long leading;
    modyn_reduced reduced;
    reduced.negative = (unsigned int)(upper >> 63);
    reduced.odd = ((unsigned int)(high >> 63)) ^ reduced.negative;
    if (reduced.negative != 0U) {
        lower = ~lower + 1ULL;
        upper = ~upper + ((lower == 0ULL) ? 1ULL : 0ULL);
    }
    reduced.zeros = 0U;
    while ((reduced.zeros < 62U) && ((upper >> 63) == 0ULL)) {
        upper = (upper << 1) | (lower >> 63);
        lower = lower << 1;
        reduced.zeros += 1U;
    }
    leading = upper;
    /* pi 2^62 */
    reduced.angle = modyn_high(leading, PI_BITS);
    return reduced;
}

/* Minus x where the lowest bit is set. */
FUNCTION REAL modyn_flip_sign(REAL x, BITS by)
{
    return modyn_from_bits(modyn_bits(x) ^ (by << SIGN));
}

/* Such angles are rare: their code stays apart from the code of the others. */
#ifdef __GNUC__
#define MODYN_RARE __attribute__((cold, noinline))
#else
#define MODYN_RARE
#endif

/* The angle in [-pi/2, pi/2] that differs from x by a multiple of pi, where the fast reduction is not exact. */
RARE_FUNCTION REAL modyn_far(REAL x, BITS *turns)
{
    const BITS bits = modyn_bits(x);
    const BITS one = 1U;
    const int exponent = (int)((bits >> MANTISSA) & EXPONENTS);
    const BITS fraction = bits & ((one << MANTISSA) - one);
    modyn_reduced reduced;
    REAL r;
    if (exponent == EXPONENTS) {
        *turns = 0U;
        return (REAL)NAN;
    }
    reduced = modyn_reduce((unsigned long long)(fraction | (one << MANTISSA)), exponent - (BIAS + MANTISSA));
    *turns = (BITS)reduced.odd;
    r = ANGLE * modyn_from_bits(((BITS)SCALE - (BITS)reduced.zeros) << MANTISSA);
    return modyn_flip_sign(r, (BITS)reduced.negative ^ (bits >> SIGN));
}

/* Sine and cosine of x in rad; absolute error at most ERROR. */
FUNCTION void modyn_sin_cos(REAL x, REAL *sine, REAL *cosine)
{
    static const REAL sines[SINES] = { SINE_COEFFICIENTS };
    static const REAL cosines[COSINES] = { COSINE_COEFFICIENTS };
    BITS turns;
    REAL r;
    REAL z;
    REAL s = sines[0];
    REAL c = cosines[0];
    int i;
    if (ABS(x) < R(LIMIT)) {
        /* Adding this rounds to the nearest integer, whose lowest bit is then the lowest of the sum. */
        const REAL shifted = (x * R(ONE_OVER_PI)) + R(ROUND);
        const REAL n = shifted - R(ROUND);
        r = REDUCTION;
        turns = modyn_bits(shifted);
    } else {
        r = modyn_far(x, &turns);
    }
    z = r * r;
    for (i = 1; i < SINES; ++i) {
        s = (z * s) + sines[i];
    }
    for (i = 1; i < COSINES; ++i) {
        c = (z * c) + cosines[i];
    }
    *sine = modyn_flip_sign(((r * z) * s) + r, turns);
    *cosine = modyn_flip_sign(((z * z) * c) + ((z * R(-0.5)) + R(1.0)), turns);
}

