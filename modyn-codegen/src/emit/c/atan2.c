/* The angle from the x axis to (x, y), to 3 units in the last place; conventions for zeros and infinities as in
   IEEE 754. */
FUNCTION REAL modyn_atan2(REAL y, REAL x)
{
    static const REAL series[ATAN_TERMS] = { ATAN_SERIES };
    const REAL width = ABS(x);
    const REAL height = ABS(y);
    const int steep = (height > width) ? 1 : 0;
    const REAL small = (steep != 0) ? width : height;
    const REAL large = (steep != 0) ? height : width;
    int beyond;
    int i;
    REAL angle;
    REAL rest;
    REAL sum = R(0.0);
    REAL t;
    REAL u;
    if ((x != x) || (y != y)) {
        return (REAL)NAN;
    }
    if (small == (REAL)INFINITY) {
        t = R(1.0);
    } else if (large == R(0.0)) {
        t = R(0.0);
    } else {
        t = small / large;
    }
    beyond = (t > R(TAN_15)) ? 1 : 0;
    u = (beyond != 0) ? (((t * R(ROOT_3)) - R(1.0)) / (t + R(ROOT_3))) : t;
    for (i = ATAN_TERMS; i > 0; --i) {
        sum = series[i - 1] + ((u * u) * sum);
    }
    rest = (u * (u * u)) * sum;
    angle = u;
    if (beyond != 0) {
        angle = R(SIXTH_PI);
        rest = u + (rest + R(SIXTH_REST));
    }
    angle = (steep != 0) ? (R(HALF_PI) - (angle - (R(HALF_REST) - rest))) : (angle + rest);
    if ((modyn_bits(x) >> SIGN) != 0U) {
        angle = R(PI) - (angle - R(PI_REST));
    }
    return ((modyn_bits(y) >> SIGN) != 0U) ? -angle : angle;
}

