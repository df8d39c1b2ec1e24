/* The larger of two numbers; the other one where one is NaN. */
FUNCTION REAL modyn_maximum(REAL a, REAL b)
{
    return ((a >= b) || (b != b)) ? a : b;
}

