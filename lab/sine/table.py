"""Prints modyn-runtime/src/scalar/near_pi.rs: sines of numbers close to multiples of pi.

    python3 -m venv VENV && VENV/bin/pip install mpmath==1.4.1 numpy==2.4.6
    VENV/bin/python lab/sine/table.py > modyn-runtime/src/scalar/near_pi.rs
"""

import mpmath
import numpy

mpmath.mp.prec = 300
#: Rows of a precision: so many that are nearest to a multiple, and so many spread over the range.
NEAREST, SPREAD = 24, 16


def rows(kind, limit):
    """The number next to each multiple of pi below the limit."""
    found = []
    for k in range(1, int(limit / mpmath.pi) + 1):
        x = kind(float(k * mpmath.pi)) if kind is numpy.float32 else float(k * mpmath.pi)
        if x < limit:
            found.append((abs(mpmath.sin(mpmath.mpf(float(x)))), k, float(x)))
    found.sort()
    nearest, rest = found[:NEAREST], sorted(found[NEAREST:], key=lambda row: row[1])
    spread = [rest[i * (len(rest) - 1) // (SPREAD - 1)] for i in range(SPREAD)]
    return sorted((x, float(mpmath.sin(mpmath.mpf(x)))) for _, _, x in nearest + spread)


def denominators(x, largest):
    """The denominators, up to the largest, of the best rational approximations of x (its convergents)."""
    found, before, last = [], 1, 0
    while last <= largest:
        whole = int(mpmath.floor(x))
        before, last = last, whole * last + before
        found.append(last)
        x = 1 / (x - whole)
    return found[1:-1]


def far_rows(digits, exponents):
    """The numbers m 2^e, where m has so many binary digits, that are nearest to multiples of pi.

    m 2^e / pi is nearly an integer where m is the denominator of a convergent of 2^e / pi, or a multiple of it.
    """
    found = {}
    for e in exponents:
        x = mpmath.ldexp(1, e) / mpmath.pi
        for denominator in denominators(x - mpmath.floor(x), 2**digits - 1)[-3:]:
            odd = denominator >> ((denominator & -denominator).bit_length() - 1)
            m = denominator * ((2**digits - 1) // denominator)
            for m in (m, denominator):
                if m >= 2 ** (digits - 1):
                    angle = mpmath.ldexp(m, e)
                    sine = mpmath.sin(angle)
                    # Doubling the angle doubles the distance, so each is listed once.
                    row = (abs(sine), float(angle), float(sine))
                    found[odd] = min(found.get(odd, row), row)
    return sorted(row[1:] for row in sorted(found.values())[:NEAREST])


def show(name, documentation, table):
    print(f"\n/// {documentation}, and their sines rounded to double precision.")
    print("#[rustfmt::skip]")
    print("#[allow(clippy::unreadable_literal, clippy::approx_constant)]")
    print(f"pub(crate) const {name}: [(f64, f64); {len(table)}] = [")
    for x, sine in table:
        print(f"    ({x!r}, {sine!r}),")
    print("];")


def main():
    print("//! Angles close to multiples of pi, and their sines.")
    print("//!")
    print("//! Generated with mpmath by `lab/sine/table.py`.")
    for name, kind, limit in (("F64", float, 262_144), ("F32", numpy.float32, 4096)):
        exact = f"Angles that are exact in `{name.lower()}`"
        show(name, f"{exact}, within the range of the fast argument reduction", rows(kind, limit))
    # With the bits of 1 / pi up to the last one that the largest angle needs.
    mpmath.mp.prec = 1400
    for name, digits, exponents in (("F64", 53, range(-34, 972)), ("F32", 24, range(-11, 105))):
        exact = f"Angles that are exact in `{name.lower()}`"
        show(f"FAR_{name}", f"{exact}, beyond the range of the fast argument reduction", far_rows(digits, exponents))


if __name__ == "__main__":
    main()
