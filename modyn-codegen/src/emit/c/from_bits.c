FUNCTION REAL modyn_from_bits(BITS bits)
{
    modyn_number both;
    both.bits = bits;
    return both.number;
}

