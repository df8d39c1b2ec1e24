/* A number and its bits. */
typedef union {
    REAL number;
    BITS bits;
} modyn_number;

FUNCTION BITS modyn_bits(REAL x)
{
    modyn_number both;
    both.number = x;
    return both.bits;
}

