/* The larger of two numbers; the other one where one is NaN. */
static REAL modyn_maximum(REAL a, REAL b)
{
    return ((a >= b) || (b != b)) ? a : b;
}

